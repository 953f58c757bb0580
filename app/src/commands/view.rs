//! `view`: what an eye between the views sees.

use anyhow::Result;
use plenoscope::field::{ViewOffset, ViewPoint};
use plenoscope::job::{Job, Stage};
use plenoscope::render::cpu;
use plenoscope::scene::Need;

use super::input;
use super::output::Output;
use crate::cli::View;

/// Renders the view and writes it.
pub fn run(args: &View, job: &Job) -> Result<()> {
    let output = Output { file: &args.output, input: &args.input, force: args.force };
    output.check()?;
    let scene = input::scene(&args.input, &args.synth, &args.recipe, Need::Views, job)?;
    let views = scene.made_views()?;
    let wanted = ViewOffset { du: args.at.0, dv: args.at.1 };
    let inside = views.field.grid().clamp(wanted);
    if inside != wanted {
        let text = format!("the views end at {},{}: that is what is shown", inside.du, inside.dv);
        job.sink.warning(text);
    }
    let picture = cpu::view_with_depths(&views.field, Some(&views.depths), ViewPoint(inside));
    job.advance(Stage::Save, 0, 1)?;
    output.picture(&picture, scene.subject().photo().map(AsRef::as_ref), 8)
}
