//! From ellipsoids in space to ellipses in a picture (EWA; Zwicker et al., "EWA splatting", 2002).

use glam::{Mat3, Vec2, Vec3};
use rayon::prelude::*;

use super::shot::Shot;
use super::{Blend, Cloud, Gaussian, harmonics};
use crate::field::color::linear_from_srgb;

/// Variance that every ellipse gets, in px²: none is finer than a pixel shows.
const LOW_PASS: f32 = 0.3;
/// Directions beyond this many times the half picture are taken as there when an ellipse's shape is found.
const BESIDE: f32 = 1.3;
/// The least part of a pixel that counts.
pub(super) const LEAST: f32 = 1.0 / 255.0;
/// Gaussians that one task projects.
const CHUNK: usize = 8192;

/// An ellipse in a picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ellipse {
    /// Its middle, in pixels.
    pub(super) at: Vec2,
    /// `[a, b, c]` of `a·x² + 2b·x·y + c·y²`: how many variances a place is away.
    pub(super) shape: [f32; 3],
    /// Half its width and height, as far as it counts.
    pub(super) reach: Vec2,
    /// As many variances away it counts no more.
    pub(super) most: f32,
    pub(super) opacity: f32,
    pub(super) color: [f32; 3],
    /// Inverse distance along the axis.
    pub(super) nearness: f32,
}

/// All ellipses that a picture shows, in the order of the cloud.
pub(super) fn project(cloud: &Cloud, shot: &Shot) -> Vec<Ellipse> {
    let chunks = cloud.gaussians.par_chunks(CHUNK).enumerate();
    let parts: Vec<Vec<Ellipse>> = chunks
        .map(|(number, chunk)| {
            let first = number * CHUNK;
            let each = chunk.iter().enumerate();
            each.filter_map(|(i, gaussian)| ellipse(cloud, first + i, gaussian, shot)).collect()
        })
        .collect();
    parts.concat()
}

/// What a picture shows of a Gaussian, if anything.
fn ellipse(cloud: &Cloud, number: usize, gaussian: &Gaussian, shot: &Shot) -> Option<Ellipse> {
    let camera = &shot.rig.camera;
    let seen = camera.seen(gaussian.center);
    if seen.z < shot.rig.near || gaussian.opacity < LEAST {
        return None;
    }
    let nearness = seen.z.recip();
    let straight = camera.focal_px * seen.truncate() * nearness + camera.center_px;
    let disparity = shot.rig.disparity_px(nearness);
    let away = shot.away_px(disparity, straight);
    let at = straight - shot.middle * disparity - (shot.from - shot.middle) * away;
    // Far outside, before anything dear is computed.
    let size = Vec2::new(camera.size[0] as f32, camera.size[1] as f32);
    let spread = gaussian.scale.max_element() * camera.focal_px.max_element() * nearness + shot.blur * away.abs();
    let widest = 6.0 * spread + 16.0;
    if (at + widest).min_element() < 0.0 || (at - size - widest).max_element() > 0.0 {
        return None;
    }
    let ball = camera.turn * gaussian.ball();
    let [xx, xy, yy] = covariance(&ball, seen, nearness, shot, size);
    let sharp = (xx + LOW_PASS) * (yy + LOW_PASS) - xy * xy;
    let blur = LOW_PASS + (shot.blur * away).powi(2);
    let (xx, yy) = (xx + blur, yy + blur);
    let area = xx * yy - xy * xy;
    // What is spread wider covers less of each pixel.
    let opacity = gaussian.opacity * if shot.blur > 0.0 { (sharp / area).max(0.0).sqrt() } else { 1.0 };
    if !(area > 0.0 && opacity >= LEAST) {
        return None;
    }
    let most = 2.0 * (opacity / LEAST).ln();
    let reach = Vec2::new((most * xx).sqrt(), (most * yy).sqrt());
    if (at + reach).min_element() < 0.0 || (at - reach - size + 1.0).max_element() > 0.0 || !(at + reach).is_finite() {
        return None;
    }
    let direction = (gaussian.center - shot.eye).normalize_or(Vec3::Z);
    let color = harmonics::color(cloud.degree(), cloud.coefficients(number), direction);
    let color = if cloud.blend == Blend::Linear { color.map(linear_from_srgb) } else { color };
    let color = shot.lit(color, away, cloud.blend);
    Some(Ellipse { at, shape: [yy / area, -xy / area, xx / area], reach, most, opacity, color, nearness })
}

/// `[xx, xy, yy]` of a Gaussian in the picture, in px²: its covariance through the derivative of the projection.
fn covariance(ball: &Mat3, seen: Vec3, nearness: f32, shot: &Shot, size: Vec2) -> [f32; 3] {
    let camera = &shot.rig.camera;
    let limit = size / camera.focal_px * (0.5 * BESIDE);
    let middle = (size * 0.5 - 0.5 - camera.center_px) / camera.focal_px;
    let slope = (seen.truncate() * nearness).clamp(middle - limit, middle + limit);
    let across = camera.focal_px * nearness;
    // The eye stands beside the reference camera: a point moves against it as it comes nearer.
    let beside = shot.from * (shot.rig.gain_px() * nearness) / camera.focal_px;
    let along = -across * (slope - beside);
    let rows = ball.transpose();
    let row = |axis: usize| rows.col(axis) * across[axis] + rows.z_axis * along[axis];
    let (x, y) = (row(0), row(1));
    [x.length_squared(), x.dot(y), y.length_squared()]
}
