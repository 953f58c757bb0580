//! The arguments of `burst`.

use std::path::PathBuf;

use clap::Args;
use plenoscope::scene::export::Kind;

use super::{RecipeArgs, SynthArgs};
use crate::values;

/// Arguments of `burst`.
#[derive(Debug, Args)]
pub struct Burst {
    /// Photos that a hand took of one subject, from places a little apart; folders, animations, and stereo pairs (MPO,
    /// spatial HEIC, or both eyes beside each other in NAME_SBS)
    #[arg(required = true, value_name = "IMG")]
    pub photos: Vec<PathBuf>,
    /// Folder for the light field
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Which of the photos becomes the reference view, from 1
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    pub reference: u16,
    /// How much of the baseline that was there lies between the reference view and the outermost ones; by default all of
    /// it, or less where the scene would be deeper than usual
    #[arg(long, value_name = "SHARE", value_parser = values::baseline)]
    pub baseline: Option<f64>,
    /// Replace the reference photo's noise by the photos' mean where they agree; its colours become sRGB
    #[arg(long)]
    pub denoise: bool,
    /// How it is written
    #[arg(long, value_name = "FORMAT", default_value = "views", value_parser = values::field_formats())]
    pub format: Kind,
    /// Print one JSON object: photos used, reprojection, baseline, where the rays come from
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub recipe: RecipeArgs,
    #[command(flatten)]
    pub synth: SynthArgs,
}
