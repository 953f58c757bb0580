//! `export`: everything else that a light field can become.

use anyhow::Result;
use plenoscope::io::formats::depth_out::{self, Seen};
use plenoscope::io::formats::{ply, stereo};
use plenoscope::job::{Job, Stage};
use plenoscope::render::cpu;

use super::input::{self, Scene};
use super::{light_field, output, series};
use crate::cli::{Export, ExportKind, FieldFormat};

/// Quality of the JPEG that carries the depth.
const GDEPTH_QUALITY: u8 = 95;

/// Opens, makes a light field where needed, and writes.
pub fn run(args: &Export, job: &Job) -> Result<()> {
    let target = output::Target { file: &args.output, input: &args.input, force: args.force };
    let scene = |job: &Job| input::scene(&args.input, &args.synth, job);
    let field = |format: FieldFormat| {
        let target = light_field::Target::new(&args.output, format, &args.input);
        target.check(args.force)?;
        target.write(&scene(job)?, job)
    };
    match args.kind {
        ExportKind::Views => field(FieldFormat::Views),
        ExportKind::Hci => field(FieldFormat::Hci),
        ExportKind::Eslf => field(FieldFormat::Eslf),
        ExportKind::Stanford => field(FieldFormat::Stanford),
        ExportKind::Quilt => field(FieldFormat::Quilt),
        ExportKind::Anaglyph | ExportKind::SideBySide => {
            target.check()?;
            stereo_pair(args, &scene(job)?, job)
        }
        ExportKind::FocalStack => series::focal_stack(args, job),
        ExportKind::Animation => {
            target.check()?;
            series::animation(args, job)
        }
        ExportKind::Ply => {
            target.check()?;
            let scene = scene(job)?;
            let depths = scene.depths(job)?;
            job.advance(Stage::Save, 0, 1)?;
            let source = plenoscope::io::formats::FieldToWrite {
                depths: Some(&depths),
                ..plenoscope::io::formats::FieldToWrite::new(&scene.field)
            };
            Ok(ply::write(&args.output, &source)?)
        }
        ExportKind::Gdepth => {
            target.check()?;
            let scene = scene(job)?;
            let depths = scene.depths(job)?;
            let map = depths.reference_map();
            job.advance(Stage::Save, 0, 1)?;
            let seen = scene.photo.as_deref().map_or(Seen::View(scene.field.reference()), Seen::Photo);
            Ok(depth_out::write_gdepth(&args.output, seen, &map, GDEPTH_QUALITY)?)
        }
    }
}

/// Both eyes, as far apart as asked for.
fn stereo_pair(args: &Export, scene: &Scene, job: &Job) -> Result<()> {
    let depths = scene.depths(job)?;
    let [left, right] =
        stereo::eyes(args.eyes_apart).map(|eye| cpu::view_with_depths(&scene.field, Some(&depths), eye));
    job.advance(Stage::Save, 0, 1)?;
    match args.kind {
        ExportKind::Anaglyph => Ok(stereo::write_anaglyph(&args.output, &left, &right)?),
        _ => Ok(stereo::write_side_by_side(&args.output, &left, &right)?),
    }
}
