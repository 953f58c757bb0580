//! A light field as a cloud: one Gaussian for each point that a ray of some view ends at.

use glam::{Quat, Vec3};

use super::points::{Point, Space, points};
use super::shot::Shot;
use super::{Blend, Cloud, Gaussian, NamedCamera, Rig, SplatError, Stage, harmonics};
use crate::field::{LightField, RayDepths, ViewIndex};
use crate::job::{Cancelled, Job, Stage as At};

/// Standard deviation of a Gaussian, in pixels of a view: with the low-pass of renderers their sum is even.
const SPREAD_PX: f32 = 0.3;
/// Opacity of every Gaussian: the most that renderers draw.
const OPACITY: f32 = 0.99;
/// Times that colours are corrected by what the drawn views lack.
const CORRECTIONS: usize = 3;
/// How much of what is lacking is put in at once.
const GAIN: f32 = 0.9;

/// Turns a light field into a stage of Gaussians, whose rig has the field's own disparities.
///
/// # Errors
/// Stopped, or disparities beyond all measure.
pub fn from_field(field: &LightField, depths: &RayDepths, focal: Option<f32>, job: &Job) -> Result<Stage, SplatError> {
    let points = points(field, depths, job)?;
    let space = Space::of(depths, focal, field.size());
    let camera = space.camera;
    let rig = Rig { camera, step: space.gain_px / camera.focal_px.x, zero: space.nearness(0.0), near: 0.05 };
    let mut cloud = Cloud::with_room(0, points.len(), Blend::Encoded);
    for point in &points {
        let center = space.place(point);
        let scale = Vec3::splat(SPREAD_PX * center.z / camera.focal_px.x);
        let gaussian = Gaussian { center, scale, rotation: Quat::IDENTITY, opacity: OPACITY };
        let color = point.color(field).map(|value| f32::from(value) / 255.0);
        cloud.push(gaussian, &[harmonics::constant(color)]);
    }
    let mut stage = Stage { cloud, rig, named: NamedCamera::File, ends: space.ends, in_metres: false };
    correct(&mut stage, field, &points, job)?;
    Ok(stage)
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
