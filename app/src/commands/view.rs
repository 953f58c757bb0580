//! `view`: what an eye between the views sees.

use anyhow::Result;
use plenoscope::field::{ViewOffset, ViewPoint};
use plenoscope::job::{Job, Stage};
use plenoscope::render::cpu;

use super::input;
use super::output::Target;
use crate::cli::View;

/// Renders the view and writes it.
pub fn run(args: &View, job: &Job) -> Result<()> {
    let target = Target { file: &args.output, input: &args.input, force: args.force };
    target.check()?;
    let scene = input::scene(&args.input, &args.synth, job)?;
    let wanted = ViewOffset { du: args.at.0, dv: args.at.1 };
    let inside = scene.field.grid().clamp(wanted);
    if inside != wanted {
        let text = format!("the views end at {},{}: that is what is shown", inside.du, inside.dv);
        job.sink.warning(text);
    }
    let depths = scene.depths(job)?;
    let picture = cpu::view_with_depths(&scene.field, Some(&depths), ViewPoint(inside));
    job.advance(Stage::Save, 0, 1)?;
    target.picture(&picture, scene.photo.as_deref(), 8)
}
