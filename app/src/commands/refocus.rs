//! `refocus`: the picture that another lens would have taken.

use std::sync::Arc;

use anyhow::{Result, bail};
use plenoscope::field::{DisparityMap, FocalPlane, Lens, Photo, View, ViewPoint, fit_long_side};
use plenoscope::io::Opened;
use plenoscope::io::save::{self, Format, Keep, Origin, PictureOptions};
use plenoscope::job::{Job, Stage};
use plenoscope::render::{cpu, lens};

use super::input::{self, Scene};
use super::output::Target;
use super::{Usage, lens_args};
use crate::cli::{Refocus, SynthArgs};
use crate::values::{PictureSize, Size};

/// Renders the picture and writes it.
pub fn run(args: &Refocus, job: &Job) -> Result<()> {
    let target = Target { file: &args.output, input: &args.input, force: args.force };
    target.check()?;
    let format = save::check(&args.output, &PictureOptions { replace_source: true, ..PictureOptions::default() })?;
    match input::open(&args.input, job)? {
        Opened::Photo(file) => match args.size.unwrap_or(PictureSize::Photo) {
            PictureSize::LightField => {
                // A map that is given spares the nets here, all of them.
                let lambertian = args.synth.lambertian || args.synth.disparity.is_some();
                let scene = input::from_photo(&file, &SynthArgs { lambertian, ..args.synth.clone() }, job)?;
                from_views(args, &scene, job)
            }
            size => from_photo(args, photo_scene(args, &file, job)?, size, format, job),
        },
        Opened::LightField(file) => {
            let scene = Scene::from_file(*file);
            match args.size.unwrap_or(PictureSize::LightField) {
                PictureSize::LightField => from_views(args, &scene, job),
                size => from_photo(args, view_scene(&scene, job)?, size, format, job),
            }
        }
    }
}

/// A photo with the ray depth of its light field, or with the map that was given: then no net runs.
fn photo_scene(args: &Refocus, file: &plenoscope::io::PhotoFile, job: &Job) -> Result<lens::Scene> {
    if let Some(map) = input::disparity(&args.synth)? {
        return Ok(lens::Scene::new(Arc::clone(&file.photo), map)?);
    }
    let scene = input::from_photo(file, &args.synth, job)?;
    lens_scene(Arc::clone(&file.photo), &scene, job)
}

/// A light field's reference view as the photo.
fn view_scene(scene: &Scene, job: &Job) -> Result<lens::Scene> {
    let view: &View = scene.field.reference();
    let photo = Photo::from_srgb8(view.size(), view.rgba().to_vec())?;
    lens_scene(Arc::new(photo), scene, job)
}

fn lens_scene(photo: Arc<Photo>, scene: &Scene, job: &Job) -> Result<lens::Scene> {
    let depths = scene.depths(job)?;
    let map = DisparityMap { size: depths.size(), disparity_px: depths.reference().to_vec() };
    Ok(lens::Scene::new(photo, map)?.with_behind(lens::revealed(&scene.field, &depths)))
}

/// At the photo's size or smaller, with the lens renderer.
fn from_photo(args: &Refocus, scene: lens::Scene, size: PictureSize, format: Format, job: &Job) -> Result<()> {
    let photo = Arc::clone(scene.photo());
    let size = match size {
        PictureSize::Custom(size) => inside(photo.size(), size, job)?,
        _ => photo.size(),
    };
    let map = scene.disparity();
    let lens = lens_args::lens(&args.lens, photo.size(), map)?;
    let bits = args.bits.unwrap_or_else(|| if format.has_16_bits() { photo.pixels().bits() } else { 8 });
    let pixels = lens::render_pixels(&scene, &lens, size, bits, job)?;
    job.advance(Stage::Save, 0, 1)?;
    Ok(save::pixels(&args.output, &pixels, &options(args, Origin::in_own_space(&photo), bits))?)
}

/// At the light field's size, as the paper does it: shift the views and add.
fn from_views(args: &Refocus, scene: &Scene, job: &Job) -> Result<()> {
    let depths = scene.depths(job)?;
    let own = DisparityMap { size: depths.size(), disparity_px: depths.reference().to_vec() };
    let photo_size = scene.photo.as_ref().map_or(scene.field.size(), |photo| photo.size());
    let lens = match input::disparity(&args.synth)? {
        // What was typed is in the units of the given map.
        Some(map) => scaled(lens_args::lens(&args.lens, photo_size, &map)?, own.size[0] as f32 / map.size[0] as f32),
        None => lens_args::lens(&args.lens, photo_size, &own)?,
    };
    let center = ViewPoint::default();
    let picture = cpu::refocus_with_depths(&scene.field, Some(&depths), &lens, center);
    job.advance(Stage::Save, 0, 1)?;
    let origin = scene.photo.as_deref().map(Origin::in_srgb).unwrap_or_default();
    Ok(save::picture(&args.output, &picture, &options(args, origin, args.bits.unwrap_or(8)))?)
}

/// The same lens in pixels of another width.
fn scaled(lens: Lens, ratio: f32) -> Lens {
    let focus = FocalPlane {
        disparity_px: lens.focus.disparity_px * ratio,
        tilt_px: lens.focus.tilt_px.map(|tilt| tilt * ratio),
    };
    Lens { focus, keep_sharp_px: lens.keep_sharp_px.map(|end| end * ratio), ..lens }
}

/// The largest size of the photo's shape in what was asked for.
fn inside(photo: [u32; 2], Size(wanted): Size, job: &Job) -> Result<[u32; 2]> {
    if wanted[0] > photo[0] || wanted[1] > photo[1] {
        let [width, height] = photo;
        bail!(Usage(format!(
            "the picture would be larger than the photo — nothing is enlarged — at most {width}x{height}"
        )));
    }
    let scale = (f64::from(wanted[0]) / f64::from(photo[0])).min(f64::from(wanted[1]) / f64::from(photo[1]));
    let long_side = (f64::from(photo[0].max(photo[1])) * scale).round() as u32;
    let fitting = fit_long_side(photo, long_side.max(1));
    if fitting.iter().zip(wanted).all(|(fits, wanted)| fits.abs_diff(wanted) <= 1) {
        return Ok(wanted);
    }
    job.sink.warning(format!("the photo's shape is kept: the picture has {}x{} pixels", fitting[0], fitting[1]));
    Ok(fitting)
}

fn options(args: &Refocus, mut origin: Origin, bits: u8) -> PictureOptions {
    origin.source = Some(args.input.clone());
    let keep = if args.strip_metadata { Keep::Nothing } else { Keep::All };
    let quality = args.quality.unwrap_or(PictureOptions::default().quality);
    PictureOptions { bits, quality, keep, origin, replace_source: args.force, ..PictureOptions::default() }
}
