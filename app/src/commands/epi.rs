//! `epi`: one line of the picture in all views of a row or a column.

use anyhow::Result;
use plenoscope::job::{Job, Stage};
use plenoscope::scene::asked::{self, Line};

use super::input;
use super::output::{output, picture};
use crate::cli::Epi;

/// Renders the slice through the reference view's row or column of views and writes it.
pub fn run(args: &Epi, job: &Job) -> Result<()> {
    let output = output(&args.output, &args.input, args.force);
    output.check()?;
    let line = Line::one_of(args.row, args.column)?;
    let scene = input::scene(&args.input, &args.synth, &args.recipe, asked::epi_need(line), job)?;
    let slice = asked::epi(&scene, line, args.scale)?;
    job.advance(Stage::Save, 0, 1)?;
    picture(&output, &slice, None, 8)
}
