//! Series of pictures into files: the focal stack, a pull of the focus, a ramp of the aperture, a turn of the viewpoint.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{Edit, OutputSize, Scene, SceneError};
use crate::aside::NewFolder;
use crate::field::{FNumber, Picture, Pixels, Samples, ViewGrid, ViewPoint};
use crate::io::save::{self, AnimationOptions, Origin, PictureOptions, SaveError};
use crate::job::{Job, Stage};
use crate::render::lens::{Motion, Region, Space, circle, focal_planes, lenses};

/// What moves in an animation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Movement {
    /// The focus, from the farthest to the nearest.
    #[default]
    Focus,
    /// The aperture, from f/28 to the edit's.
    Aperture,
    /// The viewpoint, once round the reference view.
    Viewpoint,
}

impl Movement {
    /// All of them, in the order of the dialog: the name on the command line, the label, and what it shows.
    pub const ALL: [(Self, &'static str, &'static str, &'static str); 3] = [
        (Self::Focus, "focus-pull", "Focus", "The focus, from far to near"),
        (Self::Aperture, "aperture-ramp", "Aperture", "The aperture, from f/28 to what is set"),
        (Self::Viewpoint, "circle", "Viewpoint", "The eye, once round"),
    ];

    /// The word in the name of a file.
    pub fn word(self) -> &'static str {
        match self {
            Self::Focus => "focus",
            Self::Aperture => "aperture",
            Self::Viewpoint => "circle",
        }
    }

    /// The aperture that it is shown with where nobody asks for one: a turn shows everything sharp.
    pub fn usual_f_number(self) -> FNumber {
        if self == Self::Viewpoint { FNumber::PHOTO } else { FNumber::default() }
    }
}

/// Writes a folder of pictures focused from far to near (`frame_000.png` …), everything sharp (`all_in_focus.png`), and
/// the number of each pixel's sharpest frame (`depth_index.png`). Planes are equally spaced in disparity. The folder is
/// written aside, then put in place.
pub fn focal_stack(
    scene: &Scene,
    edit: &Edit,
    size: OutputSize,
    frames: u16,
    folder: &Path,
    job: &Job,
) -> Result<(), SceneError> {
    let fail = |error: std::io::Error| SaveError::from_io(&error, folder);
    let aside = NewFolder::new(folder).map_err(fail)?;
    stack_into(aside.path(), scene, edit, size, frames, job)?;
    Ok(aside.put(is_of_stack).map_err(fail)?)
}

/// Files that an older stack may have left, and that would not fit this one.
fn is_of_stack(name: &str) -> bool {
    let is_frame = name.strip_prefix("frame_").and_then(|rest| rest.strip_suffix(".png"));
    is_frame.is_some_and(|number| number.bytes().all(|digit| digit.is_ascii_digit()))
        || ["all_in_focus.png", "depth_index.png"].contains(&name)
}

fn stack_into(
    folder: &Path,
    scene: &Scene,
    edit: &Edit,
    size: OutputSize,
    frames: u16,
    job: &Job,
) -> Result<(), SceneError> {
    let range = scene.map().range_px();
    let planes = focal_planes(range, frames.into());
    let rgbd = scene.rgbd()?;
    let prepared = rgbd.prepare(scene.picture_size(size));
    let whole = Region { at: [0; 2], size: prepared.size() };
    let options = PictureOptions { origin: Origin::in_own_space(rgbd.photo()), ..PictureOptions::default() };
    let write = |name: &str, picture: &Picture| save::picture(&folder.join(name), picture, &options);
    let quiet = Job { cancel: job.cancel, sink: &() };
    let steps = u32::from(frames) + 1;
    for (number, lens) in (0..).zip(lenses(&scene.lens(edit), Motion::FocusPull(range), frames.into())) {
        job.advance(Stage::Refocus, number, steps)?;
        write(&format!("frame_{number:03}.png"), &prepared.render(&lens, whole, &quiet)?)?;
    }
    job.advance(Stage::Refocus, steps - 1, steps)?;
    write("all_in_focus.png", &prepared.all_in_focus(&quiet)?)?;
    let index = prepared.depth_index(&planes).into_iter().flat_map(|number| [number; 3]).collect();
    let index = Pixels { size: prepared.size(), samples: Samples::Eight(index) };
    save::pixels(&folder.join("depth_index.png"), &index, &PictureOptions::default())?;
    Ok(job.advance(Stage::Refocus, steps, steps)?)
}

/// Writes an animation; the name's ending says the format (see [`save::animation()`]).
pub fn animation(
    scene: &Scene,
    edit: &Edit,
    movement: Movement,
    size: OutputSize,
    path: &Path,
    options: &AnimationOptions,
    job: &Job,
) -> Result<(), SceneError> {
    let count = options.frames as usize;
    let quiet = Job { cancel: job.cancel, sink: &() };
    let told = |number: u32| job.advance(Stage::Refocus, number, options.frames);
    let motion = match movement {
        Movement::Viewpoint => {
            let radius = scene.views().map_or(ViewGrid::PAPER, |views| views.field.grid()).inner_radius();
            let frame = |(number, viewpoint): (u32, ViewPoint)| {
                told(number)?;
                scene.shown(&Edit { viewpoint, ..edit.clone() }, size, &quiet)
            };
            return save::animation(path, (0..).zip(circle(radius, count)).map(frame), options);
        }
        Movement::Focus => Motion::FocusPull(scene.map().range_px()),
        Movement::Aperture => Motion::ApertureRamp([FNumber::PHOTO.0, edit.f_number.0]),
    };
    let prepared = scene.rgbd()?.in_space(Space::Srgb).prepare(scene.picture_size(size));
    let whole = Region { at: [0; 2], size: prepared.size() };
    let frame = |(number, lens)| -> Result<Picture, SceneError> {
        told(number)?;
        Ok(prepared.render(&lens, whole, &quiet)?)
    };
    save::animation(path, (0..).zip(lenses(&scene.lens(edit), motion, count)).map(frame), options)
}
