//! Arguments of the commands that write one picture of a light field.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use plenoscope::render::cpu::Colormap;
use plenoscope::scene::{OutputSize, asked, trust};

use super::{EmbedArgs, LensArgs, RecipeArgs, SynthArgs};
use crate::values::{self, Pair};

/// Arguments of `refocus`.
#[derive(Debug, Args)]
pub struct Refocus {
    /// A photo or a light field
    pub input: PathBuf,
    /// The picture to write (PNG, JPEG, TIFF or WebP, by its ending)
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    #[command(flatten)]
    pub lens: LensArgs,
    /// An edit to apply, as the window keeps it; other arguments go before it; "embedded" is the one that the picture
    /// carries, of the photo that it was made of, which is in it or beside it
    #[arg(long, value_name = "FILE.json")]
    pub recipe: Option<PathBuf>,
    /// Where the lens stands: steps from the reference view, fractions allowed, u to the right, v down
    #[arg(long, value_name = "U,V", allow_hyphen_values = true)]
    pub at: Option<Pair>,
    /// photo, light-field, or WxH; by default that of the photo, of a light field that of its views
    #[arg(long, value_name = "SIZE", value_parser = asked::picture_size)]
    pub size: Option<OutputSize>,
    /// Quality of a JPEG, 1 to 100
    #[arg(long, value_name = "Q", value_parser = values::whole(asked::QUALITIES))]
    pub quality: Option<u8>,
    /// Bits of a channel, 8 or 16 (PNG and TIFF); by default those of the photo
    #[arg(long, value_name = "N", value_parser = values::bits)]
    pub bits: Option<u8>,
    /// Leave EXIF and XMP out; the colour profile stays
    #[arg(long, conflicts_with = "embed")]
    pub strip_metadata: bool,
    #[command(flatten)]
    pub embed: EmbedArgs,
    /// Print the lens as a JSON object: what real lens it is, what is in focus and sharp in metres, how wide the blur is
    #[arg(long)]
    pub json: bool,
    /// The sensor that the lens is read on
    #[arg(long, value_name = "FORMAT", default_value = "full-frame", value_parser = values::sensors())]
    pub sensor: usize,
    #[command(flatten)]
    pub synth: SynthArgs,
    /// Write even over the input
    #[arg(long)]
    pub force: bool,
}

/// Arguments of `view`.
#[derive(Debug, Args)]
pub struct View {
    /// A photo or a light field
    pub input: PathBuf,
    /// The picture to write (PNG, JPEG, TIFF or WebP, by its ending)
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Steps from the reference view, fractions allowed: u to the right, v down
    #[arg(long, value_name = "U,V", allow_hyphen_values = true)]
    pub at: Pair,
    #[command(flatten)]
    pub recipe: RecipeArgs,
    #[command(flatten)]
    pub synth: SynthArgs,
    /// Write even over the input
    #[arg(long)]
    pub force: bool,
}

/// Arguments of `epi`.
#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("line").required(true))]
pub struct Epi {
    /// A photo or a light field
    pub input: PathBuf,
    /// The picture to write
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Row of the views that is cut; u goes down the picture
    #[arg(long, value_name = "Y", group = "line")]
    pub row: Option<u32>,
    /// Column of the views that is cut; v goes down the picture
    #[arg(long, value_name = "X", group = "line")]
    pub column: Option<u32>,
    /// Rows of the picture for each view
    #[arg(long, value_name = "N", default_value_t = asked::EPI_SCALE, value_parser = values::whole(asked::EPI_SCALES))]
    pub scale: u32,
    #[command(flatten)]
    pub recipe: RecipeArgs,
    #[command(flatten)]
    pub synth: SynthArgs,
    /// Write even over the input
    #[arg(long)]
    pub force: bool,
}

/// Arguments of `depth`.
#[derive(Debug, Args)]
pub struct Depth {
    /// A photo or a light field
    pub input: PathBuf,
    /// The map to write: .pfm (float), .png (16 bits, or colours with --colormap)
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// The view, row and column; the reference view if not named
    #[arg(long, value_name = "V,U")]
    pub view: Option<Pair>,
    /// Write colours
    #[arg(long, value_name = "MAP")]
    pub colormap: Option<Colors>,
    /// depth; or trust: what was invented, tinted (.png) or 0 to 1 (.pfm), of a view, else of what f/3.5 gathers
    #[arg(long = "as", value_name = "WHAT", default_value = "depth", conflicts_with = "colormap")]
    pub what: DepthKind,
    /// With trust: how much of a picture may be invented, in per cent, where it says how far one can look and open
    #[arg(long, value_name = "PERCENT", default_value_t = 100.0 * trust::USUAL_LIMIT, value_parser = values::percent)]
    pub limit: f32,
    #[command(flatten)]
    pub recipe: RecipeArgs,
    #[command(flatten)]
    pub synth: SynthArgs,
    /// Write even over the input
    #[arg(long)]
    pub force: bool,
}

/// Colours of a depth map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Colors {
    /// Blue far, red near
    Turbo,
    /// Readable for colour-blind people
    Viridis,
    /// White near
    Gray,
}

/// What `depth` writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DepthKind {
    /// The ray depths
    Depth,
    /// What was invented
    Trust,
}

impl From<Colors> for Colormap {
    fn from(colors: Colors) -> Self {
        match colors {
            Colors::Turbo => Self::Turbo,
            Colors::Viridis => Self::Viridis,
            Colors::Gray => Self::Gray,
        }
    }
}
