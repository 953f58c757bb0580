//! Arguments of the commands that write light fields, films and other kinds of files.

use std::path::PathBuf;

use clap::Args;
use plenoscope::scene::export::Kind;
use plenoscope::scene::{Movement, OutputSize, asked};

use super::{EmbedArgs, LensArgs, RecipeArgs, StereoArgs, SynthArgs};
use crate::values;

/// Arguments of `synth`.
#[derive(Debug, Args)]
pub struct Synth {
    /// The photo
    #[arg(required_unless_present = "corners")]
    pub photo: Option<PathBuf>,
    /// Four photos from the corners of a square in place of one: upper left, upper right, lower left, lower right; the
    /// views between them are made from the depth that all four measure
    #[arg(long, value_name = "PHOTO", num_args = 4, conflicts_with_all = ["photo", "disparity", "recipe"])]
    pub corners: Vec<PathBuf>,
    /// Folder for the light field
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// How it is written
    #[arg(long, value_name = "FORMAT", default_value = "views", value_parser = values::field_formats())]
    pub format: Kind,
    #[command(flatten)]
    pub recipe: RecipeArgs,
    #[command(flatten)]
    pub synth: SynthArgs,
}

/// Arguments of `export`.
#[derive(Debug, Args)]
pub struct Export {
    /// A photo or a light field
    pub input: PathBuf,
    /// The file or folder to write
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// What to write
    #[arg(long = "as", value_name = "KIND", value_parser = values::kinds())]
    pub kind: Kind,
    #[command(flatten)]
    pub lens: LensArgs,
    /// Size of the frames of focal-stack, animation, video and frames, of html, and of each eye of anaglyph, side-by-side, mpo
    /// and spatial: photo, light-field, or WxH to fit
    #[arg(long, value_name = "SIZE", value_parser = asked::picture_size)]
    pub size: Option<OutputSize>,
    /// Frames of focal-stack and animation (24), and of video and frames (90); a timeline has its own seconds
    #[arg(long, value_name = "N", value_parser = values::frames())]
    pub frames: Option<u16>,
    /// Frames a second of animation (12) and of video (30)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=50))]
    pub frames_per_second: Option<u16>,
    /// What moves in animation, video and frames: the recipe's timeline, else focus-pull
    #[arg(long, value_name = "MOTION", value_parser = values::movements())]
    pub motion: Option<Movement>,
    #[command(flatten)]
    pub stereo: StereoArgs,
    #[command(flatten)]
    pub embed: EmbedArgs,
    #[command(flatten)]
    pub recipe: RecipeArgs,
    #[command(flatten)]
    pub synth: SynthArgs,
    /// Write even over the input
    #[arg(long)]
    pub force: bool,
}
