//! Series of pictures into files: the focal stack, a pull of the focus, a ramp of the aperture, a turn of the viewpoint.

use std::path::Path;

use crate::field::{FNumber, Lens};
use crate::io::save::{self, AnimationOptions, Origin, PictureOptions, Pixels, Samples, SaveError};
use crate::job::{Job, Stage};
use crate::render::Picture;
use crate::render::lens::{self, LensError, Motion, Region, Scene, Space, circle, focal_planes, lenses};

/// Why a series was not made.
#[derive(Debug, thiserror::Error)]
pub enum SeriesError {
    /// A picture of it could not be rendered.
    #[error(transparent)]
    Lens(#[from] LensError),
    /// A file of it could not be written.
    #[error(transparent)]
    Save(#[from] SaveError),
}

/// What moves in an animation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Movement {
    /// The focus, from the farthest to the nearest.
    FocusPull,
    /// The aperture, from f/28 to the lens's.
    ApertureRamp,
    /// The viewpoint, once round the reference view at this many view steps from it.
    Circle(f32),
}

/// Writes a folder of pictures focused from far to near (`frame_000.png` …), everything sharp (`all_in_focus.png`), and
/// the number of each pixel's sharpest frame (`depth_index.png`). Planes are equally spaced in disparity.
pub fn focal_stack(
    scene: &Scene,
    lens: &Lens,
    size: [u32; 2],
    frames: u16,
    folder: &Path,
    job: &Job,
) -> Result<(), SeriesError> {
    let range = scene.disparity().range_px();
    let planes = focal_planes(range, frames.into());
    let prepared = scene.prepare(size);
    let whole = Region { at: [0; 2], size: prepared.size() };
    let options = PictureOptions { origin: Origin::in_own_space(scene.photo()), ..PictureOptions::default() };
    std::fs::create_dir_all(folder).map_err(|error| SaveError::from_io(&error, folder))?;
    let write = |name: &str, picture: &Picture| save::picture(&folder.join(name), picture, &options);
    let quiet = Job { cancel: job.cancel, sink: &() };
    let steps = u32::from(frames) + 1;
    for (number, lens) in (0..).zip(lenses(lens, Motion::FocusPull(range), frames.into())) {
        job.advance(Stage::Refocus, number, steps).map_err(LensError::from)?;
        write(&format!("frame_{number:03}.png"), &prepared.render(&lens, whole, &quiet)?)?;
    }
    job.advance(Stage::Refocus, steps - 1, steps).map_err(LensError::from)?;
    write("all_in_focus.png", &prepared.all_in_focus(&quiet)?)?;
    let index = prepared.depth_index(&planes).into_iter().flat_map(|number| [number; 3]).collect();
    let index = Pixels { size: prepared.size(), samples: Samples::Eight(index) };
    save::pixels(&folder.join("depth_index.png"), &index, &PictureOptions::default())?;
    Ok(job.advance(Stage::Refocus, steps, steps).map_err(LensError::from)?)
}

/// Writes an animation; the name's ending says the format (see [`save::animation()`]).
pub fn animation(
    scene: &Scene,
    lens: &Lens,
    movement: Movement,
    size: [u32; 2],
    path: &Path,
    options: &AnimationOptions,
    job: &Job,
) -> Result<(), SeriesError> {
    let scene = scene.clone().in_space(Space::Srgb);
    let count = options.frames as usize;
    let quiet = Job { cancel: job.cancel, sink: &() };
    let told = |number: u32| job.advance(Stage::Refocus, number, options.frames).map_err(LensError::from);
    let motion = match movement {
        Movement::Circle(radius) => {
            let frame = |(number, eye)| {
                told(number)?;
                Ok(lens::render(&scene.seen_from(eye, size, &quiet)?, lens, size, &quiet)?)
            };
            return save::animation(path, (0..).zip(circle(radius, count)).map(frame), options);
        }
        Movement::FocusPull => Motion::FocusPull(scene.disparity().range_px()),
        Movement::ApertureRamp => Motion::ApertureRamp([FNumber::PHOTO.0, lens.f_number.0]),
    };
    let prepared = scene.prepare(size);
    let whole = Region { at: [0; 2], size: prepared.size() };
    let frame = |(number, lens)| {
        told(number)?;
        Ok(prepared.render(&lens, whole, &quiet)?)
    };
    save::animation(path, (0..).zip(lenses(lens, motion, count)).map(frame), options)
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;
    use crate::field::{DisparityMap, Photo};
    use crate::job::{Cancel, Progress, Sink};

    fn scene() -> Scene {
        let rgba = (0..24 * 16u32).flat_map(|i| [(i * 37 % 251) as u8, (i * 91 % 241) as u8, 7, 255]).collect();
        let photo = Photo::from_srgb8([24, 16], rgba).unwrap();
        let map = (0..24 * 16).map(|i| if i % 24 < 12 { -0.5 } else { 1.0 }).collect();
        Scene::new(Arc::new(photo), DisparityMap::new([24, 16], map).unwrap()).unwrap()
    }

    #[derive(Default)]
    struct Told(Mutex<Vec<Progress>>);

    impl Sink for Told {
        fn progress(&self, progress: Progress) {
            self.0.lock().unwrap().push(progress);
        }
    }

    #[test]
    fn a_focal_stack_is_a_folder_of_frames_and_tells_how_far_it_is() {
        let dir = tempfile::tempdir().unwrap();
        let (cancel, sink) = (Cancel::default(), Told::default());
        let job = Job { cancel: &cancel, sink: &sink };
        focal_stack(&scene(), &Lens::default(), [24, 16], 3, &dir.path().join("stack"), &job).unwrap();
        let mut names: Vec<_> = dir.path().join("stack").read_dir().unwrap().map(|e| e.unwrap().file_name()).collect();
        names.sort();
        assert_eq!(names, ["all_in_focus.png", "depth_index.png", "frame_000.png", "frame_001.png", "frame_002.png"]);
        let told = sink.0.lock().unwrap();
        assert!(told.iter().all(|p| p.total == 4) && told.last().unwrap().done == 4);
    }

    #[test]
    fn every_movement_makes_an_animation_and_a_stopped_one_leaves_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let options = AnimationOptions { frames_per_second: 10, frames: 4 };
        let make = |movement, name: &str, cancel: &Cancel| {
            let job = Job { cancel, sink: &() };
            animation(&scene(), &Lens::default(), movement, [12, 8], &dir.path().join(name), &options, &job)
        };
        let moves = [Movement::FocusPull, Movement::ApertureRamp, Movement::Circle(1.5)];
        for (movement, name) in moves.into_iter().zip(["a.gif", "b.png", "c.webp"]) {
            make(movement, name, &Cancel::default()).unwrap();
            assert!(dir.path().join(name).metadata().unwrap().len() > 100);
        }
        let stopped = Cancel::default();
        stopped.cancel();
        assert!(matches!(
            make(Movement::FocusPull, "d.gif", &stopped),
            Err(SeriesError::Lens(LensError::Cancelled(_)))
        ));
        assert!(!dir.path().join("d.gif").exists());
    }
}
