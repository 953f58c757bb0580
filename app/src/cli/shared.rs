//! Arguments that several commands have.

use std::path::PathBuf;

use clap::Args;
use plenoscope::field::{FNumber, LensShape, Strength};
use plenoscope::scene::asked::FocusAsked;
use plenoscope::scene::real::KnownLens;
use plenoscope::scene::{Making, asked};
use plenoscope::synth::Scale;

use crate::values::{self, KeepSharp, KnownLength, Pair};

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

/// What a person turns on the lens.
#[derive(Debug, Args)]
#[command(next_help_heading = "Lens")]
pub struct LensArgs {
    /// From 28 (the photo as it is) to 1; by default 3.5
    #[arg(long, value_name = "N", value_parser = values::f_number)]
    pub f_number: Option<FNumber>,
    /// A pixel of the upright photo that is to be sharp; or "subject", for what the photo most likely is about
    #[arg(long, value_name = "X,Y", conflicts_with = "focus_disparity", allow_hyphen_values = true,
          value_parser = values::focus)]
    pub focus: Option<FocusAsked>,
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
