//! The command line. Others script against these names: they stay.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use plenoscope::field::{FNumber, LensShape, Strength};
use plenoscope::render::cpu::Colormap;
use plenoscope::scene::export::Kind;
use plenoscope::scene::real::KnownLens;
use plenoscope::scene::{Making, Movement, OutputSize, asked, trust};
use plenoscope::shard::Shard;
use plenoscope::synth::Scale;

use crate::burst_args::Burst;
use crate::embed_args::EmbedArgs;
use crate::stereo_args::StereoArgs;
use crate::values::{self, KeepSharp, KnownLength, Pair, Size};

/// Turns a photo into a light field, to look into and to refocus.
#[derive(Debug, Parser)]
#[command(name = "plenoscope", version, max_term_width = 100, disable_help_subcommand = false)]
#[command(after_help = "Exit codes: 0 done, 1 failed, 2 wrong usage, 130 interrupted.")]
pub struct Cli {
    /// Photos and light fields to open in the window
    #[arg(value_name = "FILE")]
    pub files: Vec<PathBuf>,
    #[command(flatten)]
    pub window: Window,
    #[command(flatten)]
    pub talk: Talk,
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// What the window starts with.
#[derive(Debug, Args)]
#[command(next_help_heading = "Window")]
pub struct Window {
    /// Long side of a view, in pixels; by default what the settings say
    #[arg(long, value_name = "N", value_parser = values::whole(asked::LONG_SIDES))]
    pub long_side: Option<u32>,
    /// Take the nets from this folder instead of those in the program
    #[arg(long, value_name = "DIR")]
    pub models: Option<PathBuf>,
    /// Threads that compute; 0 is one for each core
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = values::whole(asked::THREADS))]
    pub threads: u16,
    /// Do not open the file of the last time
    #[arg(long)]
    pub fresh: bool,
}

/// How much the program says.
#[derive(Debug, Args)]
pub struct Talk {
    /// Say nothing but errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Say more; twice and three times even more
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Make a light field of a photo
    Synth(Synth),
    /// Make a light field of several photos of one subject
    Burst(Burst),
    /// Write a refocused picture
    Refocus(Refocus),
    /// Write the view from a place of the lens
    View(View),
    /// Write an epipolar slice
    Epi(Epi),
    /// Write the ray depths of a view
    Depth(Depth),
    /// Write a light field in another format, or what is made of it
    Export(Export),
    /// Put many photos through one recipe
    Batch(Batch),
    /// Time the nets, stage by stage
    Bench(Bench),
    /// What a file is: format, size, views, depth that came with it
    Info(Info),
    /// Depth nets of other people: add, list, remove, use
    Models(Models),
    /// The lenses that --as-lens knows
    Lenses(Lenses),
    /// Say what the program finds on this machine, and what is wrong with it
    Doctor(Doctor),
    /// Write the built-in sample photo and its disparity
    Sample(Sample),
    /// Print the completions for a shell
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Write the program's icon in all sizes, laid out as desktops look for it
    #[command(hide = true)]
    Icons {
        /// Folder for it, such as /usr/share/icons/hicolor
        #[arg(short, long, value_name = "DIR")]
        output: PathBuf,
    },
    /// Print the man page, or write those of all commands into a folder
    Man {
        /// Folder for the pages of all commands
        #[arg(short, long, value_name = "DIR")]
        output: Option<PathBuf>,
    },
}

/// Arguments of `info`.
#[derive(Debug, Args)]
pub struct Info {
    /// A photo or a light field
    pub file: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `models`.
#[derive(Debug, Args)]
pub struct Models {
    #[command(subcommand)]
    pub what: ModelsCommand,
}

/// What to do with depth nets.
#[derive(Debug, Subcommand)]
pub enum ModelsCommand {
    /// Try an ONNX file on the sample photo, whose depth is known, and keep it as a source of ray depths
    Add {
        /// The net; files with weights of its own are taken from beside it
        #[arg(value_name = "FILE.onnx")]
        file: PathBuf,
        /// Its name, as --source takes it; by default the file's
        #[arg(long, value_name = "NAME")]
        name: Option<String>,
        /// Take it even if it does not find the sample's depth, and in place of one of that name
        #[arg(long)]
        force: bool,
        /// Also write what it says of the sample as a picture
        #[arg(long, value_name = "FILE.png")]
        depth: Option<PathBuf>,
    },
    /// Show the nets there are
    List {
        /// Print one JSON object
        #[arg(long)]
        json: bool,
    },
    /// Take a net away
    Remove {
        /// Its name
        name: String,
    },
    /// Use a net for all photos that have no depth of their own; "network" is the program's own again
    Use {
        /// Its name
        name: String,
    },
}

/// Arguments of `lenses`.
#[derive(Debug, Args)]
pub struct Lenses {
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `doctor`.
#[derive(Debug, Args)]
pub struct Doctor {
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `sample`.
#[derive(Debug, Args)]
pub struct Sample {
    /// Folder for sample.png and sample.pfm
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}

/// Arguments of whatever needs a light field, for when a photo comes in.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "From photo to light field")]
pub struct SynthArgs {
    /// Long side of a view, in pixels; a smaller photo is not enlarged
    #[arg(long, value_name = "N", default_value_t = Making::LONG_SIDE, value_parser = values::whole(asked::LONG_SIDES))]
    pub long_side: u32,
    /// Use this ray depth for the reference view instead of a net's (PFM, pixels per view step at its own width)
    #[arg(long, value_name = "FILE.pfm")]
    pub disparity: Option<PathBuf>,
    /// Where the ray depth comes from: auto (the phone's depth, else the net of `models use`, else our own), network,
    /// phone, fused, or the name of a depth net (such as paper-flowers); with --corners the name of nets between corners
    #[arg(long, value_name = "SOURCE", default_value = "auto", conflicts_with = "disparity")]
    pub source: String,
    /// How far ray depths of a net reach: deep, for refocusing far, or lytro, as the paper's camera would have seen
    #[arg(long, value_name = "SCALE", default_value = "deep")]
    pub depth_scale: Scale,
    /// Take the nets from this folder instead of those in the program
    #[arg(long, value_name = "DIR")]
    pub models: Option<PathBuf>,
    /// Threads that compute; 0 is one for each core
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = values::whole(asked::THREADS))]
    pub threads: u16,
    /// How deep the scene is, 0.2 to 4: the light field's baseline against that of a real camera; by default 1, or what
    /// the recipe says
    #[arg(long, value_name = "S", value_parser = values::strength)]
    pub strength: Option<Strength>,
    /// Leave the occlusion net out
    #[arg(long)]
    pub lambertian: bool,
    /// Neither look for a light field of last time nor keep this one
    #[arg(long)]
    pub no_cache: bool,
}

/// An edit whose depth is used.
#[derive(Clone, Debug, Args)]
pub struct RecipeArgs {
    /// An edit as the window keeps it: where its depth comes from and what was mended of it; other arguments go before it;
    /// "embedded" is the one that the picture carries, of the photo that it was made of
    #[arg(long, value_name = "FILE.json")]
    pub recipe: Option<PathBuf>,
}

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

/// What a person turns on the lens.
#[derive(Debug, Args)]
#[command(next_help_heading = "Lens")]
pub struct LensArgs {
    /// From 28 (the photo as it is) to 1; by default 3.5
    #[arg(long, value_name = "N", value_parser = values::f_number)]
    pub f_number: Option<FNumber>,
    /// A pixel of the upright photo that is to be sharp
    #[arg(long, value_name = "X,Y", conflicts_with = "focus_disparity", allow_hyphen_values = true)]
    pub focus: Option<Pair>,
    /// The disparity that is to be sharp, in pixels per view step; by default 0
    #[arg(long, value_name = "D", allow_hyphen_values = true, value_parser = values::number)]
    pub focus_disparity: Option<f32>,
    /// Shape of the opening: disc, square, blades:5 … blades:9, ring, cat-eye, or picture:FILE, in which white is open; by
    /// default disc
    #[arg(long, value_name = "SHAPE", value_parser = asked::lens_shape)]
    pub lens: Option<LensShape>,
    /// Disparities that stay sharp, from far to near; or up to three pixels of the upright photo: the focal plane goes
    /// through them, and the lens opens as wide as it may, where no --f-number is given
    #[arg(long, value_name = "D0..D1|X,Y", allow_hyphen_values = true)]
    pub keep_sharp: Vec<KeepSharp>,
    /// By how much the sharp disparity grows from left to right and from top to bottom
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    pub tilt: Option<Pair>,
    /// How far away what is in focus is, such as 0.6m or 60cm: with it the lens reads in metres (see --json)
    #[arg(long, value_name = "DISTANCE", value_parser = values::distance)]
    pub distance: Option<f32>,
    /// How long something in the photo is, by the pixels of its ends: 120,80..300,90=20cm. Tells the same as --distance
    #[arg(long, value_name = "X,Y..X,Y=LENGTH", conflicts_with = "distance")]
    pub length: Option<KnownLength>,
    /// Open as wide as this lens does, at --f-number of its own: one that `plenoscope lenses` lists, or a TOML file
    #[arg(long, value_name = "LENS", value_parser = values::known_lens, conflicts_with = "lens")]
    pub as_lens: Option<KnownLens>,
    /// How much clipped lights are brightened before they are blurred, 0 to 1; by default 0
    #[arg(long, value_name = "N", value_parser = values::share)]
    pub highlights: Option<f32>,
    /// Discs taller than wide, as of an anamorphic lens: 0 round to 1 twice as tall
    #[arg(long, value_name = "N", value_parser = values::share)]
    pub anamorphic: Option<f32>,
    /// Spherical aberration: discs behind the focus have a bright rim (to 1) or a bright middle (to -1)
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = values::signed_share)]
    pub spherical: Option<f32>,
    /// Longitudinal colour, 0 to 1: rims green behind the focus, magenta before it
    #[arg(long, value_name = "N", value_parser = values::share)]
    pub fringes: Option<f32>,
    /// Swirl, 0 to 1: discs that the barrel cuts towards the corners, and a curved sharp surface
    #[arg(long, value_name = "N", value_parser = values::share)]
    pub swirl: Option<f32>,
    /// How much of the photo's grain is put back into blurred parts, 0 to 1; by default 0
    #[arg(long, value_name = "N", value_parser = values::share)]
    pub grain: Option<f32>,
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

/// Arguments of `batch`.
#[derive(Debug, Args)]
pub struct Batch {
    /// The photos, or folders of them
    #[arg(required_unless_present = "files_from", value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Take the photos that this list names, one a line; - is the standard input
    #[arg(long, value_name = "LIST", conflicts_with = "inputs")]
    pub files_from: Option<PathBuf>,
    /// The edit, as the window keeps it
    #[arg(long, value_name = "FILE.json")]
    pub recipe: PathBuf,
    /// Folder for the pictures
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Names of the pictures without their ending: {name} is the photo's, {f} the f-number; by default the recipe's
    #[arg(long, value_name = "TEMPLATE")]
    pub name: Option<String>,
    /// Make again what is there already
    #[arg(long)]
    pub force: bool,
    /// Make again of what is there already only what is not whole, or of another recipe or photo
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
    /// Print a line of JSON a photo: path, output, state (made, skipped, met, failed), secs, error
    #[arg(long)]
    pub json: bool,
    /// Write the same lines to a file; with --resume after those that are there
    #[arg(long, value_name = "FILE.jsonl")]
    pub report: Option<PathBuf>,
    #[command(flatten)]
    pub share: BatchShare,
    #[command(flatten)]
    pub synth: SynthArgs,
}

/// What one worker of several takes of the work and of the machine.
#[derive(Debug, Args)]
#[command(next_help_heading = "Several workers")]
pub struct BatchShare {
    /// Do the K-th of N parts of the photos; a photo's part hangs on its file name alone
    #[arg(long, value_name = "K/N", default_value_t)]
    pub shard: Shard,
    /// Photos that are worked on together at most; 0 is one for each core
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    pub jobs: u16,
    /// Memory that these may take together, in MiB
    #[arg(long, value_name = "MIB", default_value_t = 2048, value_parser = clap::value_parser!(u32).range(1..))]
    pub memory: u32,
}

/// Arguments of `bench`.
#[derive(Debug, Args)]
pub struct Bench {
    /// Width and height of the views; may be given more than once; by default 270x187 and 540x372
    #[arg(long, value_name = "WxH")]
    pub size: Vec<Size>,
    /// Time what the program does with this photo, from the file to the light field
    #[arg(long, value_name = "FILE", conflicts_with = "size")]
    pub pipeline: Option<PathBuf>,
    /// Time this net of your own on a picture of --size, by default 518x392 or what the file fixes
    #[arg(long, value_name = "FILE.onnx", conflicts_with_all = ["pipeline", "models"])]
    pub model: Option<PathBuf>,
    /// With --model: say which operations took the time
    #[arg(long, requires = "model")]
    pub profile: bool,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    /// Take the nets from this folder instead of those in the program
    #[arg(long, value_name = "DIR")]
    pub models: Option<PathBuf>,
    /// Threads that compute; 0 is one for each core
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = values::whole(asked::THREADS))]
    pub threads: u16,
    /// Which code does the convolutions
    #[arg(long, value_enum, default_value_t = EnginePath::Auto)]
    pub path: EnginePath,
    /// Convolutions one by one, without Winograd's algorithm
    #[arg(long)]
    pub exact: bool,
    /// Run once and print the peak memory in MiB
    #[arg(long, value_name = "WxH", hide = true)]
    pub once: Option<Size>,
}

/// Code that does the convolutions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EnginePath {
    /// The fastest that this processor has
    Auto,
    /// AVX-512
    Avx512,
    /// AVX2 and FMA
    Avx2,
    /// The same in plain Rust
    Portable,
    /// tract's own
    Stock,
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
