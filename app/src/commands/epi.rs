//! `epi`: one line of the picture in all views of a row or a column.

use anyhow::{Result, bail};
use plenoscope::field::{EpiLine, Picture};
use plenoscope::job::{Job, Stage};
use plenoscope::render::cpu;
use plenoscope::scene::Need;

use super::Usage;
use super::input;
use super::output::Output;
use crate::cli::Epi;

/// Renders the slice through the reference view's row or column of views and writes it.
pub fn run(args: &Epi, job: &Job) -> Result<()> {
    let output = Output { file: &args.output, input: &args.input, force: args.force };
    output.check()?;
    let scene = input::scene(&args.input, &args.synth, &args.recipe, Need::Views, job)?;
    let field = &scene.made_views()?.field;
    let reference = field.grid().reference();
    let [width, height] = field.size();
    let picture = match (args.row, args.column) {
        (Some(y), _) => {
            inside("row", y, height)?;
            cpu::epi(field, EpiLine::Row { y, v: reference.v }, args.scale)
        }
        (None, Some(x)) => {
            inside("column", x, width)?;
            transposed(&cpu::epi(field, EpiLine::Column { x, u: reference.u }, args.scale))
        }
        (None, None) => bail!(Usage("a line is missing — give --row or --column".to_owned())),
    };
    job.advance(Stage::Save, 0, 1)?;
    output.picture(&picture, None, 8)
}

fn inside(what: &str, at: u32, end: u32) -> Result<()> {
    if at >= end {
        bail!(Usage(format!("there is no {what} {at} — a view has {end} — name one from 0 to {}", end - 1)));
    }
    Ok(())
}

/// Rows become columns: the window shows a column's slice beside the picture, a file has the views downwards.
fn transposed(picture: &Picture) -> Picture {
    let [width, height] = picture.size;
    Picture::from_fn([height, width], |x, y| picture.pixel(y, x))
}
