//! A light field as a cloud: one Gaussian for each point that a ray of some view ends at.
//!
//! The reference view's points come first; another view adds what those before it do not show. A ray of view `u` ends
//! where the reference view would see it at `x + u·D` (the sign of [`crate::field`]). Disparity knows no distance of its
//! own: the farthest point is put four times as far as the nearest, as in point clouds.

use std::sync::Arc;

use glam::{Quat, Vec2, Vec3};
use rayon::prelude::*;

use super::raster::Shot;
use super::{Blend, Camera, Cloud, Gaussian, NamedCamera, Rig, SplatError, Stage, harmonics};
use crate::field::{LightField, RayDepths, View, ViewIndex};
use crate::job::{Cancelled, Job, Stage as At};

/// Focal length over the longer side where nobody says it: a phone's main camera.
const FOCAL: f32 = 0.75;
/// Inverse distances of the far and the near end, in units of the nearest point's distance.
const ENDS: [f32; 2] = [0.25, 1.0];
/// Standard deviation of a Gaussian, in pixels of a view: with the low-pass of renderers their sum is even.
const SPREAD_PX: f32 = 0.3;
/// Opacity of every Gaussian: the most that renderers draw.
const OPACITY: f32 = 0.99;
/// Two rays end at one point when their disparities differ by less, in pixels per view step, and their places by less.
const SAME_PX: f32 = 0.12;
const SAME_PLACE_PX: f32 = 0.75;
/// Times that colours are corrected by what the drawn views lack.
const CORRECTIONS: usize = 3;
/// How much of what is lacking is put in at once.
const GAIN: f32 = 0.9;

/// A point that a ray ends at.
struct Point {
    /// Where the reference view sees it, or would, in pixels.
    at: Vec2,
    disparity_px: f32,
    /// The view that it was found in, and its pixel there.
    seen: (ViewIndex, u32),
}

/// Turns a light field into a stage of Gaussians, whose rig has the field's own disparities.
///
/// # Errors
/// Stopped, or disparities beyond all measure.
pub fn from_field(field: &LightField, depths: &RayDepths, focal: Option<f32>, job: &Job) -> Result<Stage, SplatError> {
    let [w, h] = field.size();
    let camera = Camera::at_origin(focal.unwrap_or(FOCAL) * w.max(h) as f32, [w, h]);
    let points = points(field, depths, job)?;
    let (low, high) = points.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), point| {
        (low.min(point.disparity_px), high.max(point.disparity_px))
    });
    // A flat scene lies at the near end.
    let gain_px = ((high - low) / (ENDS[1] - ENDS[0])).max(1e-3);
    let nearness = |disparity_px: f32| ENDS[1] - (high - disparity_px) / gain_px;
    let zero = nearness(0.0);
    let rig = Rig { camera, step: gain_px / camera.focal_px.x, zero, near: 0.05 };
    let mut cloud = Cloud::with_room(0, points.len(), Blend::Encoded);
    for point in &points {
        let near = nearness(point.disparity_px);
        let slope = (point.at - camera.center_px) / camera.focal_px;
        let scale = Vec3::splat(SPREAD_PX / (camera.focal_px.x * near));
        let (center, rotation) = (slope.extend(1.0) / near, Quat::IDENTITY);
        let gaussian = Gaussian { center, scale, rotation, opacity: OPACITY };
        cloud.push(gaussian, &[harmonics::constant(color(field.view(point.seen.0), point.seen.1))]);
    }
    let ends = [nearness(low), nearness(high)];
    let mut stage = Stage { cloud, rig, named: NamedCamera::File, ends, in_metres: false };
    correct(&mut stage, field, &points, job)?;
    Ok(stage)
}

fn color(view: &View, pixel: u32) -> [f32; 3] {
    let [r, g, b, _] = view.pixels()[pixel as usize];
    [r, g, b].map(|value| f32::from(value) / 255.0)
}

/// All points that rays end at, each once, from the reference view outward.
fn points(field: &LightField, depths: &RayDepths, job: &Job) -> Result<Vec<Point>, SplatError> {
    let (grid, [w, h]) = (field.grid(), field.size());
    let mut found = Found::new(field, depths);
    let order = grid.spiral();
    for (done, at) in order.iter().enumerate() {
        job.advance(At::Save, done as u32, 2 * order.len() as u32)?;
        let offset = grid.offset(*at).to_vec2();
        let map = Arc::new(depths.map(*at).resized(field.size())?);
        let rays: Vec<(Vec2, f32)> = (0..w * h)
            .into_par_iter()
            .map(|pixel| {
                let disparity_px = map.disparity_px()[pixel as usize];
                (Vec2::new((pixel % w) as f32, (pixel / w) as f32) + offset * disparity_px, disparity_px)
            })
            .collect();
        for (pixel, (place, disparity_px)) in rays.into_iter().enumerate() {
            found.add(Point { at: place, disparity_px, seen: (*at, pixel as u32) });
        }
    }
    Ok(found.points)
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

/// Gaussians overlap, and so blur what they show. Each gets what its own pixel lacks, some times.
fn correct(stage: &mut Stage, field: &LightField, points: &[Point], job: &Job) -> Result<(), Cancelled> {
    let grid = field.grid();
    let mut views: Vec<ViewIndex> = points.iter().map(|point| point.seen.0).collect();
    views.dedup();
    // Views that found little have little to correct.
    let found = |view: &ViewIndex| points.iter().filter(|point| point.seen.0 == *view).count();
    views.retain(|view| *view == grid.reference() || found(view) * 200 > points.len());
    for round in 0..CORRECTIONS {
        for view in &views {
            job.advance(At::Save, (CORRECTIONS + round) as u32, 2 * CORRECTIONS as u32)?;
            let drawn = stage.taken(&Shot::view(stage.rig, grid.offset(*view).to_vec2()), job)?.rgba;
            let wanted = field.view(*view);
            for (number, point) in points.iter().enumerate().filter(|(_, point)| point.seen.0 == *view) {
                let pixel = point.seen.1 as usize;
                let target = wanted.pixels()[pixel];
                let coefficients = &mut stage.cloud.coefficients_mut(number)[0];
                for c in 0..3 {
                    let lacks = (f32::from(target[c]) - f32::from(drawn[pixel * 4 + c])) / 255.0;
                    coefficients[c] += GAIN * lacks / harmonics::CONSTANT;
                }
            }
        }
    }
    Ok(())
}
