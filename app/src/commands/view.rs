//! `view`: what an eye between the views sees.

use anyhow::Result;
use plenoscope::job::{Job, Stage};
use plenoscope::scene::asked;

use super::input;
use super::output::{output, picture};
use crate::cli::View;

/// Renders the view and writes it.
pub fn run(args: &View, job: &Job) -> Result<()> {
    let output = output(&args.output, &args.input, args.force);
    output.check()?;
    let at = args.at.into();
    let scene = input::scene(&args.input, &args.synth, &args.recipe, asked::view_need(at), job)?;
    let seen = asked::view(&scene, at, job)?;
    job.advance(Stage::Save, 0, 1)?;
    picture(&output, &seen, scene.subject().photo().map(AsRef::as_ref), 8)
}
