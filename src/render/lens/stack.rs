//! Series of pictures: the focal stack, and the lens turned from frame to frame.

use super::{LensError, Prepared, Region};
use crate::field::{FNumber, Lens, ViewOffset, ViewPoint};
use crate::job::Job;
use crate::render::Picture;

/// What moves from the first to the last frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// The focal plane, between two disparities.
    FocusPull([f32; 2]),
    /// The aperture, between two f-numbers, evenly in views across.
    ApertureRamp([f32; 2]),
}

/// Disparities of the frames of a focal stack: equally spaced from the far to the near end.
pub fn focal_planes([far, near]: [f32; 2], frames: usize) -> Vec<f32> {
    let last = frames.saturating_sub(1).max(1) as f32;
    (0..frames).map(|i| far + (near - far) * i as f32 / last).collect()
}

/// The lens in every frame.
pub fn lenses(lens: &Lens, motion: Motion, frames: usize) -> Vec<Lens> {
    let with = |value: f32| {
        let mut lens = lens.clone();
        match motion {
            Motion::FocusPull(_) => lens.focus.disparity_px = value,
            Motion::ApertureRamp(_) => lens.f_number = FNumber(28.0 / value),
        }
        lens
    };
    let ends = match motion {
        Motion::FocusPull(ends) => ends,
        Motion::ApertureRamp(ends) => ends.map(|f| FNumber(f).views_across()),
    };
    focal_planes(ends, frames).into_iter().map(with).collect()
}

/// Viewpoints on a circle around the reference view, for light fields; the last frame goes on with the first.
pub fn circle(radius_views: f32, frames: usize) -> Vec<ViewPoint> {
    let place = |i: usize| {
        let angle = i as f32 / frames as f32 * std::f32::consts::TAU;
        ViewPoint(ViewOffset { dv: radius_views * angle.sin(), du: radius_views * angle.cos() })
    };
    (0..frames).map(place).collect()
}

impl Prepared {
    /// Everything sharp: the photo at this size.
    pub fn all_in_focus(&self, job: &Job) -> Result<Picture, LensError> {
        let closed = Lens { f_number: FNumber::PHOTO, ..Lens::default() };
        self.render(&closed, Region { at: [0; 2], size: self.size() }, job)
    }

    /// Number of the frame of a focal stack in which each pixel is sharpest, `[y, x]`; `planes` in rising order.
    pub fn depth_index(&self, planes: &[f32]) -> Vec<u8> {
        let [width, height] = self.size();
        let reader = self.surfaces.reader(0, width as usize, self.size());
        let nearest = |d: f32| {
            let upper = planes.partition_point(|&p| p < d).min(planes.len().saturating_sub(1));
            let lower = upper.saturating_sub(1);
            if (planes[upper] - d).abs() <= (planes[lower] - d).abs() { upper as u8 } else { lower as u8 }
        };
        if planes.is_empty() {
            return vec![0; (width * height) as usize];
        }
        let mut index = Vec::with_capacity((width * height) as usize);
        let mut colors = vec![[0.0; 3]; width as usize];
        for y in 0..height as i32 {
            let row = reader.at_row(y);
            self.light.row(0, y, &mut colors);
            let seen = colors.iter().enumerate().map(|(i, color)| reader.seen(&row, i, color));
            index.extend(seen.map(|seen| nearest(seen.disparity_px())));
        }
        index
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::field::{DisparityMap, Photo};
    use crate::job::Cancel;
    use crate::render::lens::Rgbd;

    #[test]
    fn planes_are_equally_spaced_and_apertures_run_from_end_to_end() {
        assert_eq!(focal_planes([-1.0, 1.0], 5), [-1.0, -0.5, 0.0, 0.5, 1.0]);
        assert_eq!(focal_planes([0.3, 1.0], 1), [0.3]);
        let ramp = lenses(&Lens::default(), Motion::ApertureRamp([28.0, 3.5]), 8);
        assert_eq!((ramp[0].f_number, ramp[7].f_number), (FNumber(28.0), FNumber(3.5)));
        assert!(ramp.windows(2).all(|w| w[1].f_number < w[0].f_number));
        let turn = circle(2.0, 4);
        assert!((turn[1].0.dv - 2.0).abs() < 1e-5 && turn[1].0.du.abs() < 1e-5);
    }

    #[test]
    fn the_index_names_the_sharpest_frame_and_that_frame_is_the_photo_there() {
        let rgba = (0..32 * 16u32).flat_map(|i| [(i * 37 % 251) as u8, (i * 91 % 241) as u8, 7, 255]).collect();
        let photo = Arc::new(Photo::from_srgb8([32, 16], rgba).unwrap());
        let map = DisparityMap::new([32, 16], (0..32 * 16).map(|i| if i % 32 < 16 { 0.0 } else { 1.0 }).collect());
        let scene = Rgbd::new(photo, map.unwrap()).unwrap().prepare([32, 16], &Cancel::default()).unwrap();
        let (cancel, planes) = (Cancel::default(), focal_planes([-1.0, 1.0], 3));
        let job = Job { cancel: &cancel, sink: &() };
        let index = scene.depth_index(&planes);
        assert_eq!((index[2], index[30]), (1, 2));
        let sharp = scene.all_in_focus(&job).unwrap();
        let lenses = lenses(&Lens::default(), Motion::FocusPull([-1.0, 1.0]), 3);
        let whole = Region { at: [0; 2], size: [32, 16] };
        let frames: Vec<Picture> = lenses.iter().map(|lens| scene.render(lens, whole, &job).unwrap()).collect();
        let at = |p: &Picture, x: usize| p.rgb_linear[(8 * 32 + x) * 3];
        assert!((at(&frames[1], 2) - at(&sharp, 2)).abs() < 1e-5);
        assert!((at(&frames[2], 30) - at(&sharp, 30)).abs() < 1e-5);
    }
}
