//! The points that a light field's rays end at, and where they lie in space.
//!
//! The reference view's points come first; another view adds what those before it do not show. A ray of view `u` ends
//! where the reference view would see it at `x + u·D` (the sign of [`crate::field`]). Disparity knows no distance of its
//! own: the farthest point is put four times as far as the nearest, as in point clouds.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::{Camera, SplatError};
use crate::field::{LightField, RayDepths, Size, ViewIndex};
use crate::job::{Job, Stage as At};

/// Focal length over the longer side where nobody says it: a phone's main camera.
const FOCAL: f32 = 0.75;
/// Inverse distances of the far and the near end, in units of the nearest point's distance.
const ENDS: [f32; 2] = [0.25, 1.0];
/// Two rays end at one point when their disparities differ by less, in pixels per view step, and their places by less.
const SAME_PX: f32 = 0.12;
const SAME_PLACE_PX: f32 = 0.75;

/// A point that a ray ends at.
pub(super) struct Point {
    /// Where the reference view sees it, or would, in pixels.
    pub at: Vec2,
    pub disparity_px: f32,
    /// The view that it was found in, and its pixel there.
    pub seen: (ViewIndex, u32),
}

impl Point {
    /// Its colour, as the view that found it stores it.
    pub fn color(&self, field: &LightField) -> [u8; 3] {
        let [r, g, b, _] = field.view(self.seen.0).pixels()[self.seen.1 as usize];
        [r, g, b]
    }
}

/// From disparities to places before the reference camera.
pub(super) struct Space {
    /// The reference camera, at the origin.
    pub camera: Camera,
    /// Disparity of one inverse unit of distance, in pixels per view step.
    pub gain_px: f32,
    /// Inverse distances of the far and the near end.
    pub ends: [f32; 2],
    /// Disparity of the near end.
    high_px: f32,
}

impl Space {
    /// The space of a light field. `focal`: the camera's focal length over the views' longer side, where it is known.
    pub fn of(depths: &RayDepths, focal: Option<f32>, size: Size) -> Self {
        let camera = Camera::at_origin(focal.unwrap_or(FOCAL) * size[0].max(size[1]) as f32, size);
        let ratio = size[0] as f32 / depths.size()[0] as f32;
        let [low_px, high_px] = depths.range_px().map(|px| px * ratio);
        // A flat scene lies at the near end.
        let gain_px = ((high_px - low_px) / (ENDS[1] - ENDS[0])).max(1e-3);
        let far = ENDS[1] - (high_px - low_px) / gain_px;
        Self { camera, gain_px, ends: [far, ENDS[1]], high_px }
    }

    /// Inverse distance of a disparity.
    pub fn nearness(&self, disparity_px: f32) -> f32 {
        ENDS[1] - (self.high_px - disparity_px) / self.gain_px
    }

    /// Where a point lies.
    pub fn place(&self, point: &Point) -> Vec3 {
        let slope = (point.at - self.camera.center_px) / self.camera.focal_px;
        slope.extend(1.0) / self.nearness(point.disparity_px)
    }
}

/// All points that rays end at, each once, from the reference view outward.
pub(super) fn points(field: &LightField, depths: &RayDepths, job: &Job) -> Result<Vec<Point>, SplatError> {
    let grid = field.grid();
    let mut found = Found::new(field, depths);
    let order = grid.spiral();
    for (done, at) in order.iter().enumerate() {
        job.advance(At::Save, done as u32, 2 * order.len() as u32)?;
        seen_by(field, depths, *at)?.into_iter().for_each(|point| found.add(point));
    }
    Ok(found.points)
}

/// The points that one view's rays end at.
pub(super) fn seen_by(field: &LightField, depths: &RayDepths, at: ViewIndex) -> Result<Vec<Point>, SplatError> {
    let [w, h] = field.size();
    let offset = field.grid().offset(at).to_vec2();
    let map = depths.map(at).resized(field.size())?;
    let point = |pixel: u32| {
        let disparity_px = map.disparity_px()[pixel as usize];
        let place = Vec2::new((pixel % w) as f32, (pixel / w) as f32) + offset * disparity_px;
        Point { at: place, disparity_px, seen: (at, pixel) }
    };
    Ok((0..w * h).into_par_iter().map(point).collect())
}

/// Points by the pixel in which the reference view would see them, with a rim for what it does not.
struct Found {
    points: Vec<Point>,
    /// The last point of each cell, and for each point the one before it in its cell; none is `u32::MAX`.
    last: Vec<u32>,
    before: Vec<u32>,
    rim: f32,
    size: [usize; 2],
}

const NONE: u32 = u32::MAX;

impl Found {
    fn new(field: &LightField, depths: &RayDepths) -> Self {
        let reach = field.grid().rows().max(field.grid().cols()) as f32;
        let [low, high] = depths.range_px();
        let longest = field.size()[0].max(field.size()[1]) as f32;
        let rim = (reach * low.abs().max(high.abs())).min(longest).ceil() + 1.0;
        let size = field.size().map(|side| side as usize + 2 * rim as usize);
        Self { points: Vec::new(), last: vec![NONE; size[0] * size[1]], before: Vec::new(), rim, size }
    }

    fn cell(&self, at: Vec2) -> Option<[usize; 2]> {
        let place = (at + self.rim).round();
        let is_in =
            place.min_element() >= 0.0 && (place.x as usize) < self.size[0] && (place.y as usize) < self.size[1];
        is_in.then_some([place.x as usize, place.y as usize])
    }

    /// Adds a point, unless it is there.
    fn add(&mut self, point: Point) {
        let Some([x, y]) = self.cell(point.at) else { return };
        let columns = x.saturating_sub(1)..(x + 2).min(self.size[0]);
        let rows = y.saturating_sub(1)..(y + 2).min(self.size[1]);
        let is_there = rows.into_iter().any(|y| columns.clone().any(|x| self.has(y * self.size[0] + x, &point)));
        if !is_there {
            let cell = &mut self.last[y * self.size[0] + x];
            self.before.push(*cell);
            *cell = self.points.len() as u32;
            self.points.push(point);
        }
    }

    fn has(&self, cell: usize, point: &Point) -> bool {
        let mut next = self.last[cell];
        while next != NONE {
            let other = &self.points[next as usize];
            let is_near = (other.at - point.at).abs().max_element() <= SAME_PLACE_PX;
            // Points of one view are never one.
            if is_near && (other.disparity_px - point.disparity_px).abs() <= SAME_PX && other.seen.0 != point.seen.0 {
                return true;
            }
            next = self.before[next as usize];
        }
        false
    }
}
