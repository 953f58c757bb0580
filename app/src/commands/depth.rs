//! `depth`: the ray depths of one view.

use anyhow::{Result, bail};
use plenoscope::field::{DisparityMap, Lens, ViewGrid, ViewIndex, ViewPoint};
use plenoscope::io::formats::depth_out;
use plenoscope::job::{Job, Stage};
use plenoscope::render::cpu;
use plenoscope::scene::trust::{Limits, tinted};
use plenoscope::scene::{Need, Scene};

use super::output::{Output, ending};
use super::{Usage, input};
use crate::cli::{Depth, DepthKind};
use crate::output::say;
use crate::values::Pair;

/// Writes the map as numbers or as colours.
pub fn run(args: &Depth, job: &Job) -> Result<()> {
    let output = Output { file: &args.output, input: &args.input, force: args.force };
    output.check()?;
    let as_numbers = ending(&args.output) == "pfm";
    if as_numbers && args.colormap.is_some() {
        bail!(Usage("a .pfm file holds numbers, not colours — leave --colormap out or write a .png".to_owned()));
    }
    if !as_numbers && args.colormap.is_none() && ending(&args.output) != "png" {
        bail!(Usage("a map is written as .pfm or .png — name such a file or add --colormap".to_owned()));
    }
    if args.what == DepthKind::Trust {
        return trust(args, &output, job);
    }
    let need = if args.view.is_some() { Need::Views } else { Need::Map };
    let scene = input::scene(&args.input, &args.synth, &args.recipe, need, job)?;
    let map = map(&scene, args.view)?;
    job.advance(Stage::Save, 0, 1)?;
    match args.colormap {
        _ if as_numbers => Ok(depth_out::write_pfm(&args.output, &map)?),
        Some(colors) => output.picture(&cpu::depth_map(&map, colors.into()), None, 8),
        None => Ok(depth_out::write_png16(&args.output, &map)?),
    }
}

/// Writes what was invented, and says how far one can go.
fn trust(args: &Depth, output: &Output, job: &Job) -> Result<()> {
    let scene = input::scene(&args.input, &args.synth, &args.recipe, Need::Views, job)?;
    let (trust, field) = (scene.trust()?, &scene.made_views()?.field);
    let (doubt, view) = match args.view {
        Some(at) => {
            let at = index(field.grid(), at)?;
            (trust.of_view(at), field.view(at))
        }
        None => (trust.of_picture(&Lens::default(), ViewPoint::default()), field.reference()),
    };
    job.advance(Stage::Save, 0, 1)?;
    match ending(&args.output).as_str() {
        "pfm" => depth_out::write_pfm(&args.output, &DisparityMap::new(doubt.size(), doubt.into_pixels())?)?,
        _ => output.picture(&tinted(view, &doubt), None, 8)?,
    }
    let Limits { widest, reach } = trust.invented().limits(args.limit / 100.0);
    say(&format!(
        "up to {reach:.1} steps from the reference view and up to f/{:.1} at most {} % of the picture is invented",
        widest.0, args.limit
    ))
}

/// The map of a view; that of the reference view as exact as it is known.
fn map(scene: &Scene, view: Option<Pair>) -> Result<DisparityMap> {
    let (Some(at), Some(views)) = (view, scene.views()) else { return Ok(DisparityMap::clone(scene.map())) };
    let view = index(views.depths.grid(), at)?;
    Ok(DisparityMap::new(views.depths.size(), views.depths.view(view).to_vec())?)
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
