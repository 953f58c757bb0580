//! `depth`: the ray depths of one view.

use anyhow::{Result, bail};
use plenoscope::field::{RayDepths, ViewGrid, ViewIndex};
use plenoscope::io::formats::depth_out;
use plenoscope::job::{Job, Stage};
use plenoscope::render::cpu;

use super::output::{Target, ending};
use super::{Usage, input};
use crate::cli::Depth;
use crate::values::Pair;

/// Writes the map as numbers or as colours.
pub fn run(args: &Depth, job: &Job) -> Result<()> {
    let target = Target { file: &args.output, input: &args.input, force: args.force };
    target.check()?;
    let as_numbers = ending(&args.output) == "pfm";
    if as_numbers && args.colormap.is_some() {
        bail!(Usage("a .pfm file holds numbers, not colours — leave --colormap out or write a .png".to_owned()));
    }
    if !as_numbers && args.colormap.is_none() && ending(&args.output) != "png" {
        bail!(Usage("a map is written as .pfm or .png — name such a file or add --colormap".to_owned()));
    }
    let scene = input::scene(&args.input, &args.synth, job)?;
    let depths = scene.depths(job)?;
    let view = match args.view {
        None => depths.grid().reference(),
        Some(at) => index(depths.grid(), at)?,
    };
    job.advance(Stage::Save, 0, 1)?;
    let map = depths.map(view);
    match args.colormap {
        _ if as_numbers => Ok(depth_out::write_pfm(&args.output, &map)?),
        Some(colors) => target.picture(&cpu::depth(&depths, view, range_px(&depths), colors.into()), None, 8),
        None => Ok(depth_out::write_png16(&args.output, &map)?),
    }
}

/// The range of all rays, never empty: near is white, far is black.
fn range_px(depths: &RayDepths) -> [f32; 2] {
    let [far, near] = depths.range_px();
    [far, near.max(far + 1e-3)]
}

fn index(grid: ViewGrid, at: Pair) -> Result<ViewIndex> {
    let whole = |n: f32, end: usize| n.fract() == 0.0 && (0.0..end as f32).contains(&n);
    if !(whole(at.0, grid.rows()) && whole(at.1, grid.cols())) {
        let (rows, cols) = (grid.rows() - 1, grid.cols() - 1);
        bail!(Usage(format!(
            "there is no view {},{} — views go from 0,0 to {rows},{cols} — name one of them",
            at.0, at.1
        )));
    }
    Ok(ViewIndex { v: at.0 as u8, u: at.1 as u8 })
}
