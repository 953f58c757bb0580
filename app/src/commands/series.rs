//! Focal stacks and animations: one lens after the other, or one viewpoint after the other.

use std::sync::Arc;

use anyhow::Result;
use plenoscope::field::{DisparityMap, FNumber, Lens, fit_long_side};
use plenoscope::io::Opened;
use plenoscope::io::save::{self, AnimationOptions, Origin, PictureOptions, Pixels, Samples, SaveError};
use plenoscope::job::{Job, Stage};
use plenoscope::recipe::OutputSize;
use plenoscope::render::lens::{Motion, Region, Space, circle, focal_planes, lenses};
use plenoscope::render::{Picture, cpu, lens};

use super::input::{self, Scene};
use super::{lens_args, refocus};
use crate::cli::{Export, MotionKind};
use crate::values::PictureSize;

/// Long side of an animation whose size was not asked for.
const ANIMATION_LONG_SIDE: u32 = 800;

/// What a series is made of: the lens renderer's scene, and the views where they were made.
struct Source {
    lens: lens::Scene,
    field: Option<Scene>,
}

fn open(args: &Export, job: &Job) -> Result<Source> {
    let needs_views = args.motion == MotionKind::Circle || args.synth.disparity.is_none();
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
    let source = open(args, job)?;
    let scene = &source.lens;
    let lens = lens_of(args, scene)?;
    let planes = focal_planes(scene.disparity().range_px(), args.frames.into());
    let prepared = scene.prepare(size(args, scene, None));
    let whole = Region { at: [0; 2], size: prepared.size() };
    let options = PictureOptions { origin: Origin::in_own_space(scene.photo()), ..PictureOptions::default() };
    let folder = &args.output;
    std::fs::create_dir_all(folder).map_err(|error| SaveError::from_io(&error, folder))?;
    let picture = |name: &str, picture: &Picture| save::picture(&folder.join(name), picture, &options);
    for (number, lens) in lenses(&lens, Motion::FocusPull(ends(&planes)), planes.len()).iter().enumerate() {
        picture(&format!("frame_{number:03}.png"), &prepared.render(lens, whole, job)?)?;
        job.advance(Stage::Save, number as u32 + 1, planes.len() as u32)?;
    }
    picture("all_in_focus.png", &prepared.all_in_focus(job)?)?;
    let index = prepared.depth_index(&planes).into_iter().flat_map(|number| [number; 3]).collect();
    let index = Pixels { size: prepared.size(), samples: Samples::Eight(index) };
    Ok(save::pixels(&folder.join("depth_index.png"), &index, &PictureOptions::default())?)
}

/// A focus pull, an aperture ramp or a circle of viewpoints.
pub fn animation(args: &Export, job: &Job) -> Result<()> {
    let source = open(args, job)?;
    let frames = usize::from(args.frames);
    let options = AnimationOptions { frames_per_second: args.frames_per_second, frames: args.frames.into() };
    let scene = source.lens.clone().in_space(Space::Srgb);
    if let (MotionKind::Circle, Some(views)) = (args.motion, &source.field) {
        let depths = views.depths(job)?;
        let radius = (views.field.grid().rows().min(views.field.grid().cols()) - 1) / 2;
        let eye = |at| job.check().map(|()| cpu::view_with_depths(&views.field, Some(&depths), at));
        let pictures = circle(radius as f32, frames).into_iter().map(|at| eye(at).map_err(anyhow::Error::from));
        return save::animation(&args.output, pictures, &options);
    }
    let lens = lens_of(args, &scene)?;
    let motion = match args.motion {
        MotionKind::ApertureRamp => Motion::ApertureRamp([FNumber::PHOTO.0, lens.f_number.0]),
        _ => Motion::FocusPull(scene.disparity().range_px()),
    };
    let prepared = scene.prepare(size(args, &scene, Some(ANIMATION_LONG_SIDE)));
    let lenses = lenses(&lens, motion, frames);
    save::animation(&args.output, prepared.series(&lenses, job).map(|frame| Ok(frame?)), &options)
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

fn ends(planes: &[f32]) -> [f32; 2] {
    [planes.first().copied().unwrap_or(0.0), planes.last().copied().unwrap_or(0.0)]
}

fn lens_of(args: &Export, scene: &lens::Scene) -> Result<Lens> {
    lens_args::lens(&args.lens, Lens::default(), scene.photo().size(), scene.disparity())
}
