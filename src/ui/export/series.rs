//! Focal stacks and animations of what is open: one lens after the other, or one viewpoint after the other.

use std::path::Path;
use std::sync::Arc;

use super::super::finals::scene_of;
use super::Moving;
use super::work::{AnyError, Request};
use crate::field::{DisparityMap, FNumber, Lens, Photo};
use crate::io::save::{self, AnimationOptions, Keep, Origin, PictureOptions, Pixels, Samples, SaveError};
use crate::job::{Job, Stage};
use crate::render::lens::{LensError, Motion, Region, Scene, Space, circle, focal_planes, lenses};
use crate::render::{Picture, cpu};

/// The lens renderer's scene; for light fields from disk their reference view is the photo.
fn scene(request: &Request) -> Result<Scene, AnyError> {
    let Some(depths) = &request.depths else {
        return Err("a series needs ray depths — they are still being measured — wait for them".into());
    };
    if let Some(photo) = &request.photo {
        return Ok(scene_of(photo, &request.field, depths)?);
    }
    let reference = request.field.reference();
    let photo = Photo::from_srgb8(reference.size(), reference.rgba().to_vec())?;
    let map = DisparityMap { size: depths.size(), disparity_px: depths.reference().to_vec() };
    Ok(Scene::new(Arc::new(photo), map)?)
}

/// A folder of frames from far to near, everything sharp, and the number of each pixel's sharpest frame. The folder is
/// written aside, then renamed.
pub fn focal_stack(target: &Path, request: &Request, job: &Job) -> Result<(), AnyError> {
    let scene = scene(request)?;
    let planes = focal_planes(scene.disparity().range_px(), request.settings.frames.into());
    let prepared = scene.prepare(request.settings.picture.size.of(scene.photo().size()));
    let whole = Region { at: [0; 2], size: prepared.size() };
    let keep = if request.photo.is_some() { request.settings.picture.keep } else { Keep::Nothing };
    let options = PictureOptions { origin: Origin::in_own_space(scene.photo()), keep, ..PictureOptions::default() };
    let parent = target.parent().unwrap_or(Path::new("."));
    let aside = tempfile::Builder::new()
        .prefix(".plenoscope-")
        .tempdir_in(parent)
        .map_err(|error| SaveError::from_io(&error, target))?;
    let picture = |name: &str, picture: &Picture| save::picture(&aside.path().join(name), picture, &options);
    // The renderer tells of each frame's tiles; what is told here is frames.
    let quiet = Job { cancel: job.cancel, sink: &() };
    for (number, &plane) in planes.iter().enumerate() {
        job.advance(Stage::Refocus, number as u32, planes.len() as u32)?;
        let mut lens = request.edit.lens;
        lens.focus.disparity_px = plane;
        picture(&format!("frame_{number:03}.png"), &prepared.render(&lens, whole, &quiet)?)?;
    }
    picture("all_in_focus.png", &prepared.all_in_focus(&quiet)?)?;
    let index = prepared.depth_index(&planes).into_iter().flat_map(|number| [number; 3]).collect();
    let index = Pixels { size: prepared.size(), samples: Samples::Eight(index) };
    save::pixels(&aside.path().join("depth_index.png"), &index, &PictureOptions::default())?;
    put_in_place(aside, target).map_err(|error| SaveError::from_io(&error, target).into())
}

/// Gives a folder its name; an older one of that name, which a person asked to replace, goes only then.
fn put_in_place(aside: tempfile::TempDir, target: &Path) -> std::io::Result<()> {
    #[cfg(unix)]
    std::fs::set_permissions(aside.path(), std::os::unix::fs::PermissionsExt::from_mode(0o755))?;
    if !target.exists() {
        return std::fs::rename(aside.keep(), target);
    }
    // Into a folder that is there go the files alone: a person's other files stay.
    for file in std::fs::read_dir(aside.path())? {
        let file = file?;
        std::fs::rename(file.path(), target.join(file.file_name()))?;
    }
    Ok(())
}

/// A focus pull, an aperture ramp or a circle of viewpoints.
pub fn animation(target: &Path, request: &Request, job: &Job) -> Result<(), AnyError> {
    let settings = &request.settings;
    let frames = usize::from(settings.frames.max(2));
    let options = AnimationOptions { frames_per_second: settings.frames_per_second, frames: frames as u32 };
    let told = |number: usize| job.advance(Stage::Refocus, number as u32, frames as u32);
    let quiet = Job { cancel: job.cancel, sink: &() };
    let field = &request.field;
    if settings.moving == Moving::Viewpoint {
        let radius = (field.grid().rows().min(field.grid().cols()) - 1) / 2;
        let frame = |(number, at)| -> Result<Picture, AnyError> {
            told(number)?;
            Ok(cpu::refocus_with_depths(field, request.depths.as_deref(), &request.edit.lens, at))
        };
        let pictures = circle(radius as f32, frames).into_iter().enumerate().map(frame);
        return save::animation(target, pictures, &options);
    }
    let scene = scene(request)?.in_space(Space::Srgb);
    let motion = match settings.moving {
        Moving::Aperture => Motion::ApertureRamp([FNumber::PHOTO.0, request.edit.lens.f_number.0]),
        _ => Motion::FocusPull(scene.disparity().range_px()),
    };
    let prepared = scene.prepare(settings.animation_size(scene.photo().size()));
    let whole = Region { at: [0; 2], size: prepared.size() };
    let lenses: Vec<Lens> = lenses(&request.edit.lens, motion, frames);
    let frame = |(number, lens): (usize, &Lens)| -> Result<Picture, AnyError> {
        told(number)?;
        prepared.render(lens, whole, &quiet).map_err(|error: LensError| error.into())
    };
    save::animation(target, lenses.iter().enumerate().map(frame), &options)
}
