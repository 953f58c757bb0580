//! Series of pictures into files: the focal stack, films and their frames: a pull of the focus, a ramp of the aperture, a turn of the viewpoint.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::timeline::{Preset, Timeline};
use super::{Edit, Making, Need, OutputSize, Scene, SceneError};
use crate::aside::NewFolder;
use crate::field::{FNumber, Picture, Pixels, Samples, Strength, ViewGrid, ViewPoint};
use crate::io::save::{self, AnimationOptions, Origin, PictureOptions, SaveError};
use crate::job::{Job, Stage};
use crate::render::lens::{Motion, Prepared, Region, Space, circle, focal_planes, lenses};

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
    /// The focus, from what is sharp to the next that is to be, and back.
    Subjects,
    /// The lens, which closes and opens again.
    Breathing,
    /// The strength, around a subject that stays sharp.
    Dolly,
    /// What the recipe's timeline says.
    Timeline,
}

impl Movement {
    /// All of them, in the order of the dialog: the name on the command line, the label, and what it shows.
    pub const ALL: [(Self, &'static str, &'static str, &'static str); 7] = [
        (Self::Focus, "focus-pull", "Focus", "The focus, from far to near"),
        (Self::Aperture, "aperture-ramp", "Aperture", "The aperture, from f/28 to what is set"),
        (Self::Viewpoint, "circle", "Viewpoint", "The eye, once round"),
        (Self::Subjects, "subjects", "Subjects", "The focus, from what is sharp to the next, and back"),
        (Self::Breathing, "breathing", "Breathing", "The lens, which closes and opens again"),
        (Self::Dolly, "dolly", "Dolly", "The strength, around a subject that stays sharp"),
        (Self::Timeline, "timeline", "Timeline", "What the recipe's timeline says"),
    ];

    /// The word in the name of a file.
    pub fn word(self) -> &'static str {
        match self {
            Self::Focus => "focus",
            Self::Aperture => "aperture",
            Self::Viewpoint => "circle",
            Self::Subjects => "subjects",
            Self::Breathing => "breathing",
            Self::Dolly => "dolly",
            Self::Timeline => "film",
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
    let prepared = rgbd.prepare(scene.picture_size(size), job.cancel)?;
    let whole = Region { at: [0; 2], size: prepared.size() };
    let options = PictureOptions { origin: Origin::in_own_space(rgbd.photo()), ..PictureOptions::default() };
    let write = |name: &str, picture: &Picture| save::picture(&folder.join(name), picture, &options);
    let quiet = Job { cancel: job.cancel, sink: &() };
    let steps = u32::from(frames) + 1;
    for (number, lens) in (0..).zip(lenses(&scene.lens(edit), Motion::FocusPull(range), frames.into())) {
        job.advance(Stage::Refocus, number, steps)?;
        write(&frame_name(number, frames.into()), &prepared.render(&lens, whole, &quiet)?)?;
    }
    job.advance(Stage::Refocus, steps - 1, steps)?;
    write("all_in_focus.png", &prepared.all_in_focus(&quiet)?)?;
    let index = prepared.depth_index(&planes).into_iter().flat_map(|number| [number; 3]).collect();
    let index = Pixels { size: prepared.size(), samples: Samples::Eight(index) };
    save::pixels(&folder.join("depth_index.png"), &index, &PictureOptions::default())?;
    Ok(job.advance(Stage::Refocus, steps, steps)?)
}

/// What moves, and by which timeline where a recipe says it.
#[derive(Clone, Copy)]
pub struct Moving<'a> {
    /// What.
    pub movement: Movement,
    /// The recipe's timeline.
    pub timeline: Option<&'a Timeline>,
}

impl Moving<'_> {
    /// The timeline of a scene; none where the movement is one of those that have none.
    fn of(self, scene: &Scene, edit: &Edit) -> Result<Option<Timeline>, SceneError> {
        let preset = match self.movement {
            Movement::Focus | Movement::Aperture | Movement::Viewpoint => return Ok(None),
            Movement::Subjects => Preset::Subjects,
            Movement::Breathing => Preset::Breathing,
            Movement::Dolly => Preset::Dolly,
            Movement::Timeline => {
                let none =
                    "there is no timeline — the recipe says nothing of one — give it keys, or choose another motion";
                let timeline = self.timeline.ok_or_else(|| SceneError::Refused(none.to_owned()))?;
                return Ok(Some(timeline.clone()));
            }
        };
        Ok(Some(preset.timeline(scene, edit)))
    }
}

/// Makes the frames of a timeline, and keeps what does not depend on the lens from one to the next.
struct Frames<'a> {
    scene: &'a Scene,
    size: OutputSize,
    ready: Option<(Strength, Scene, Prepared)>,
}

impl Frames<'_> {
    fn picture(&mut self, edit: &Edit, job: &Job) -> Result<Picture, SceneError> {
        if self.ready.as_ref().is_none_or(|(strength, ..)| *strength != edit.strength) {
            let scene = self.scene.at_strength(edit.strength, &Making::default(), Need::Map, job)?;
            let prepared = scene.rgbd()?.in_space(Space::Srgb).prepare(scene.picture_size(self.size), job.cancel)?;
            self.ready = Some((edit.strength, scene, prepared));
        }
        match &self.ready {
            Some((_, scene, prepared)) if edit.viewpoint == ViewPoint::default() => {
                let whole = Region { at: [0; 2], size: prepared.size() };
                Ok(prepared.render(&scene.lens(edit), whole, job)?)
            }
            Some((_, scene, _)) => scene.shown(edit, self.size, job),
            None => self.scene.shown(edit, self.size, job),
        }
    }
}

/// Writes an animation or a film; the name's ending says the format (see [`save::animation()`]).
pub fn animation(
    scene: &Scene,
    edit: &Edit,
    moving: Moving,
    size: OutputSize,
    path: &Path,
    options: &AnimationOptions,
    job: &Job,
) -> Result<(), SceneError> {
    with_frames(scene, edit, moving, size, options.frames, job, |frames| save::animation(path, frames, options))
}

/// Writes a folder of the frames, `frame_000.png` …, aside and then put in place.
pub fn sequence(
    scene: &Scene,
    edit: &Edit,
    moving: Moving,
    size: OutputSize,
    (folder, count): (&Path, u32),
    job: &Job,
) -> Result<(), SceneError> {
    let fail = |error: std::io::Error| SaveError::from_io(&error, folder);
    let aside = NewFolder::new(folder).map_err(fail)?;
    with_frames(scene, edit, moving, size, count, job, |frames| {
        for (number, picture) in (0..).zip(frames) {
            let file = aside.path().join(frame_name(number, count));
            save::picture(&file, &picture?, &PictureOptions::default()).map_err(|error| error.about(folder))?;
        }
        Ok(())
    })?;
    Ok(aside.put(is_of_stack).map_err(fail)?)
}

/// A picture of a folder of so many, in whose order names are.
fn frame_name(number: u32, count: u32) -> String {
    let digits = if count > 1000 { 4 } else { 3 };
    format!("frame_{number:0digits$}.png")
}

/// Hands the frames over, each made when it is asked for.
fn with_frames(
    scene: &Scene,
    edit: &Edit,
    moving: Moving,
    size: OutputSize,
    count: u32,
    job: &Job,
    take: impl FnOnce(&mut dyn Iterator<Item = Result<Picture, SceneError>>) -> Result<(), SceneError>,
) -> Result<(), SceneError> {
    let quiet = Job { cancel: job.cancel, sink: &() };
    let told = |number: u32| job.advance(Stage::Refocus, number, count);
    if let Some(timeline) = moving.of(scene, edit)? {
        let mut frames = Frames { scene, size, ready: None };
        let frame = |(number, edit): (u32, Edit)| {
            told(number)?;
            frames.picture(&edit, &quiet)
        };
        return take(&mut (0..).zip(scene.frames_of(&timeline, edit, count)).map(frame));
    }
    let motion = match moving.movement {
        Movement::Viewpoint => {
            let radius = scene.views().map_or(ViewGrid::PAPER, |views| views.field.grid()).inner_radius();
            let frame = |(number, viewpoint): (u32, ViewPoint)| {
                told(number)?;
                scene.shown(&Edit { viewpoint, ..edit.clone() }, size, &quiet)
            };
            return take(&mut (0..).zip(circle(radius, count as usize)).map(frame));
        }
        Movement::Focus => Motion::FocusPull(scene.map().range_px()),
        _ => Motion::ApertureRamp([FNumber::PHOTO.0, edit.f_number.0]),
    };
    let prepared = scene.rgbd()?.in_space(Space::Srgb).prepare(scene.picture_size(size), job.cancel)?;
    let whole = Region { at: [0; 2], size: prepared.size() };
    let frame = |(number, lens)| -> Result<Picture, SceneError> {
        told(number)?;
        Ok(prepared.render(&lens, whole, &quiet)?)
    };
    take(&mut (0..).zip(lenses(&scene.lens(edit), motion, count as usize)).map(frame))
}
