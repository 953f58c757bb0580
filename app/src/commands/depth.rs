//! `depth`: the ray depths of one view.

use anyhow::{Result, bail};
use plenoscope::field::{DisparityMap, Lens, ViewPoint};
use plenoscope::io::formats::depth_out;
use plenoscope::job::{Job, Stage};
use plenoscope::render::cpu;
use plenoscope::scene::Need;
use plenoscope::scene::asked::{self, Output};
use plenoscope::scene::trust::{Limits, tinted};

use super::output::{ending, output, picture};
use super::{Usage, input};
use crate::cli::{Depth, DepthKind};
use crate::output::say;

/// Writes the map as numbers or as colours.
pub fn run(args: &Depth, job: &Job) -> Result<()> {
    let output = output(&args.output, &args.input, args.force);
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
    let view = args.view.map(Into::into);
    let scene = input::scene(&args.input, &args.synth, &args.recipe, asked::depth_need(view), job)?;
    let map = asked::depth(&scene, view)?;
    job.advance(Stage::Save, 0, 1)?;
    match args.colormap {
        _ if as_numbers => Ok(depth_out::write_pfm(&args.output, &map)?),
        Some(colors) => picture(&output, &cpu::depth_map(&map, colors.into()), None, 8),
        None => Ok(depth_out::write_png16(&args.output, &map)?),
    }
}

/// Writes what was invented, and says how far one can go.
fn trust(args: &Depth, output: &Output, job: &Job) -> Result<()> {
    let (how, maker) =
        (input::how_of(&args.input, &args.synth, args.recipe.recipe.as_deref(), job)?, input::maker(&args.synth));
    let scene = how.scene(&how.open(&args.input, job)?, &maker, Need::Views, job)?;
    let torn = maker.disagreement(&scene, how.making(), job)?;
    let (trust, field) = (scene.trust()?.with_torn_edges(torn.as_ref()), &scene.made_views()?.field);
    let (doubt, view) = match args.view {
        Some(at) => {
            let at = asked::view_index(field.grid(), at.into())?;
            (trust.of_view(at), field.view(at))
        }
        None => (trust.of_picture(&Lens::default(), ViewPoint::default()), field.reference()),
    };
    job.advance(Stage::Save, 0, 1)?;
    match ending(&args.output).as_str() {
        "pfm" => depth_out::write_pfm(&args.output, &DisparityMap::new(doubt.size(), doubt.into_pixels())?)?,
        _ => picture(output, &tinted(view, &doubt), None, 8)?,
    }
    let Limits { widest, reach } = trust.invented().limits(args.limit / 100.0);
    say(&format!(
        "up to {reach:.1} steps from the reference view and up to f/{:.1} at most {} % of the picture is invented",
        widest.0, args.limit
    ))
}
