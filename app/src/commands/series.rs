//! Focal stacks and animations: one lens after the other, or one viewpoint after the other.

use std::sync::Arc;

use anyhow::Result;
use plenoscope::field::{DisparityMap, FNumber, Lens, fit_long_side};
use plenoscope::io::Opened;
use plenoscope::io::save::{self, AnimationOptions};
use plenoscope::job::Job;
use plenoscope::recipe::OutputSize;
use plenoscope::render::lens::circle;
use plenoscope::render::{cpu, lens};
use plenoscope::series::{self, Movement};

use super::input::{self, Scene};
use super::{lens_args, refocus};
use crate::cli::{Export, MotionKind};
use crate::values::PictureSize;

/// Long side of an animation whose size was not asked for.
const ANIMATION_LONG_SIDE: u32 = 800;
/// View steps by which the viewpoint goes out in a circle: the paper's grid reaches three on every side.
const CIRCLE_VIEWS: f32 = 3.0;

/// What a series is made of: the lens renderer's scene, and the views where they were made.
struct Source {
    lens: lens::Scene,
    field: Option<Scene>,
}

fn open(args: &Export, job: &Job) -> Result<Source> {
    let needs_views = args.synth.disparity.is_none();
    match input::open(&args.input, job)? {
        Opened::Photo(file) if needs_views => {
            let scene = input::from_photo(&file, &args.synth, job)?;
            let lens = refocus::lens_scene(Arc::clone(&file.photo), &scene, job)?;
            Ok(Source { lens, field: Some(scene) })
        }
        Opened::Photo(file) => {
            let map = input::disparity(&args.synth)?.unwrap_or_else(|| DisparityMap::constant([1, 1], 0.0));
            Ok(Source { lens: lens::Scene::new(file.photo, map)?, field: None })
        }
        Opened::LightField(file) => {
            let scene = Scene::from_file(*file);
            Ok(Source { lens: refocus::view_scene(&scene, job)?, field: Some(scene) })
        }
    }
}

/// A folder of frames from far to near, everything sharp, and the number of each pixel's sharpest frame.
pub fn focal_stack(args: &Export, job: &Job) -> Result<()> {
    let scene = open(args, job)?.lens;
    let lens = lens_of(args, &scene)?;
    Ok(series::focal_stack(&scene, &lens, size(args, &scene, None), args.frames, &args.output, job)?)
}

/// A focus pull, an aperture ramp or a circle of viewpoints.
pub fn animation(args: &Export, job: &Job) -> Result<()> {
    let source = open(args, job)?;
    let options = AnimationOptions { frames_per_second: args.frames_per_second, frames: args.frames.into() };
    let scene = &source.lens;
    if let (MotionKind::Circle, Some(views), true) = (args.motion, &source.field, args.size.is_none()) {
        return circle_of_views(args, views, &options, job);
    }
    let lens = lens_of(args, scene)?;
    let (movement, lens) = match args.motion {
        MotionKind::ApertureRamp => (Movement::ApertureRamp, lens),
        MotionKind::FocusPull => (Movement::FocusPull, lens),
        // A turn shows everything sharp, unless a lens is asked for.
        MotionKind::Circle => {
            let f_number = args.lens.f_number.unwrap_or(FNumber::PHOTO);
            (Movement::Circle(CIRCLE_VIEWS), Lens { f_number, ..lens })
        }
    };
    let size = size(args, scene, Some(ANIMATION_LONG_SIDE));
    Ok(series::animation(scene, &lens, movement, size, &args.output, &options, job)?)
}

/// The views themselves, once round.
fn circle_of_views(args: &Export, views: &Scene, options: &AnimationOptions, job: &Job) -> Result<()> {
    let depths = views.depths(job)?;
    let radius = (views.field.grid().rows().min(views.field.grid().cols()) - 1) / 2;
    let eye = |at| job.check().map(|()| cpu::view_with_depths(&views.field, Some(&depths), at));
    let pictures = circle(radius as f32, args.frames.into()).into_iter().map(|at| eye(at).map_err(anyhow::Error::from));
    save::animation(&args.output, pictures, options)
}

/// The size that was asked for, else the photo's with at most `long_side` pixels.
fn size(args: &Export, scene: &lens::Scene, long_side: Option<u32>) -> [u32; 2] {
    let photo = scene.photo().size();
    match args.size {
        Some(PictureSize::Custom(size)) => OutputSize::Within(size.0).of(photo),
        Some(PictureSize::LightField) => fit_long_side(photo, args.synth.long_side),
        Some(PictureSize::Photo) => photo,
        None => long_side.map_or(photo, |side| fit_long_side(photo, side)),
    }
}

fn lens_of(args: &Export, scene: &lens::Scene) -> Result<Lens> {
    lens_args::lens(&args.lens, Lens::default(), scene.photo().size(), scene.disparity())
}
