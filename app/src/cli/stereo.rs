//! For whose eyes: how far they are apart, and the display that a quilt is for.

use clap::Args;
use plenoscope::scene::export::Settings;

use crate::values;

/// Arguments of pictures for several eyes.
#[derive(Debug, Args)]
pub struct StereoArgs {
    /// Distance of the eyes of anaglyph, side-by-side, mpo and spatial, in view steps
    #[arg(long, value_name = "STEPS", default_value_t = Settings::EYES_APART, value_parser = values::eyes_apart)]
    pub eyes_apart: f32,
    /// The display that a quilt is for
    #[arg(long, value_name = "NAME", default_value = "portrait", value_parser = values::displays())]
    pub display: usize,
}
