//! Focal stacks and animations of what is open.

use std::path::Path;
use std::sync::Arc;

use super::super::finals::scene_of;
use super::Moving;
use super::work::{AnyError, Request};
use crate::field::Photo;
use crate::io::save::{self, AnimationOptions};
use crate::job::Job;
use crate::render::lens::{Scene, revealed};
use crate::series::{self, Movement};

/// The lens renderer's scene; for light fields from disk their reference view is the photo, and the other views tell what
/// is behind its edges.
fn scene(request: &Request) -> Result<Scene, AnyError> {
    let Some(depths) = &request.depths else {
        return Err("a series needs ray depths — they are still being measured — wait for them".into());
    };
    if let Some(photo) = &request.photo {
        return Ok(scene_of(photo, depths)?);
    }
    let reference = request.field.reference();
    let photo = Arc::new(Photo::from_srgb8(reference.size(), reference.rgba().to_vec())?);
    Ok(scene_of(&photo, depths)?.with_behind(revealed(&request.field, depths)))
}

/// A folder of frames from far to near, everything sharp, and the number of each pixel's sharpest frame.
pub fn focal_stack(target: &Path, request: &Request, job: &Job) -> Result<(), AnyError> {
    let scene = scene(request)?;
    let size = request.settings.picture.size.of(scene.photo().size());
    save::folder(
        target,
        |_| false,
        |folder| Ok(series::focal_stack(&scene, &request.edit.lens, size, request.settings.frames, folder, job)?),
    )
}

/// A focus pull, an aperture ramp or a circle of viewpoints.
pub fn animation(target: &Path, request: &Request, job: &Job) -> Result<(), AnyError> {
    let settings = &request.settings;
    let frames = u32::from(settings.frames.max(2));
    let options = AnimationOptions { frames_per_second: settings.frames_per_second, frames };
    let grid = request.field.grid();
    let radius = grid.rows().max(grid.cols()).saturating_sub(1) / 2;
    let movement = match settings.moving {
        Moving::Focus => Movement::FocusPull,
        Moving::Aperture => Movement::ApertureRamp,
        Moving::Viewpoint => Movement::Circle(radius as f32),
    };
    let scene = scene(request)?;
    let size = settings.animation_size(scene.photo().size());
    Ok(series::animation(&scene, &request.edit.lens, movement, size, target, &options, job)?)
}
