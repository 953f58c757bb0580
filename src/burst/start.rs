//! First guesses of poses: each frame's rotation, and from which side one of them looks.
//!
//! The translation of two frames is found by trying all directions. For each, the rotation that brings every point
//! nearest to its epipolar line is a small robust least-squares problem.

use std::f64::consts::PI;

use glam::{DMat3, DQuat, DVec2, DVec3};
use rayon::prelude::*;

use super::camera::{Focal, Pose};

/// A point of the reference frame and where another frame sees it.
pub type Pair = (DVec2, DVec2);

/// Directions of half a sphere that are tried.
const DIRECTIONS: usize = 160;
/// The best of them that are followed up.
const KEPT: usize = 3;
/// Rounds in which a direction is made finer, and the first of their angles.
const ROUNDS: i32 = 5;
const FIRST_ANGLE: f64 = 0.12;
/// Rounds of reweighting.
const REWEIGHTED: usize = 8;

/// Weight of a residual where `usual` is a usual one (Cauchy).
#[inline]
pub fn weight(residual: f64, usual: f64) -> f64 {
    1.0 / (1.0 + (residual / usual).powi(2))
}

/// Cost of a residual (Cauchy), in squares of the usual one.
#[inline]
pub fn cost(residual: f64, usual: f64) -> f64 {
    (residual / usual).powi(2).ln_1p()
}

/// A rotation changed by a small axis · radians.
pub fn turned(rotation: DMat3, by: DVec3) -> DMat3 {
    let turned = DQuat::from_scaled_axis(by) * DQuat::from_mat3(&rotation);
    DMat3::from_quat(turned.normalize())
}

/// How a place moves with its point: the two rows of the Jacobian.
pub fn place_by_point(focal: Focal, point: DVec3) -> [DVec3; 2] {
    let z = point.z.max(1e-3);
    [DVec3::new(1.0, 0.0, -point.x / z), DVec3::new(0.0, 1.0, -point.y / z)].map(|row| row * (focal.0 / z))
}

pub fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The rotation that explains most of what moved, and the median of what it leaves, in long sides.
pub fn rotation(focal: Focal, pairs: &[Pair], px: f64) -> (DMat3, f64) {
    let left = |rotation: DMat3| {
        let mut all: Vec<f64> =
            pairs.iter().map(|(from, to)| (focal.place(rotation * focal.ray(*from)) - *to).length()).collect();
        median(&mut all)
    };
    let mut now = DMat3::IDENTITY;
    for _ in 0..2 * REWEIGHTED {
        let usual = left(now).max(px);
        let (mut normal, mut right) = (DMat3::ZERO, DVec3::ZERO);
        for (from, to) in pairs {
            let point = now * focal.ray(*from);
            let residual = *to - focal.place(point);
            let weight = weight(residual.length(), usual);
            for (row, residual) in place_by_point(focal, point).into_iter().zip(residual.to_array()) {
                // (δ × P) · row = δ · (P × row).
                add(&mut normal, &mut right, point.cross(row), residual, weight);
            }
        }
        now = turned(now, solved(normal, right));
    }
    (now, left(now))
}

fn add(normal: &mut DMat3, right: &mut DVec3, row: DVec3, residual: f64, weight: f64) {
    *normal += DMat3::from_cols(row * row.x, row * row.y, row * row.z) * weight;
    *right += row * (residual * weight);
}

fn solved(normal: DMat3, right: DVec3) -> DVec3 {
    let damped = normal + DMat3::IDENTITY * (1e-9 + 1e-9 * normal.x_axis.x.max(normal.y_axis.y));
    let step = damped.inverse() * right;
    if step.is_finite() { step.clamp_length_max(0.2) } else { DVec3::ZERO }
}

/// Poses of a frame that agree with its points, the likeliest first; translations have length 1.
pub fn poses(focal: Focal, pairs: &[Pair], px: f64) -> Vec<Pose> {
    let (first, _) = rotation(focal, pairs, px);
    let tried = |direction: DVec3, from: DMat3| {
        let rotation = rotation_beside(focal, pairs, px, direction, from);
        (epipolar_cost(focal, pairs, px, direction, rotation), direction, rotation)
    };
    let mut all: Vec<_> = (0..DIRECTIONS).into_par_iter().map(|i| tried(direction(i), first)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut kept: Vec<(f64, DVec3, DMat3)> = Vec::new();
    for one in all {
        if kept.len() < KEPT && kept.iter().all(|other| other.1.dot(one.1).abs() < 0.95) {
            kept.push(one);
        }
    }
    kept.par_iter_mut().for_each(|best| {
        for round in 0..ROUNDS {
            let angle = FIRST_ANGLE / 2f64.powi(round);
            for direction in around(best.1, angle) {
                let other = tried(direction, best.2);
                if other.0 < best.0 {
                    *best = other;
                }
            }
        }
    });
    kept.sort_by(|a, b| a.0.total_cmp(&b.0));
    let pose = |(_, direction, rotation): (f64, DVec3, DMat3)| {
        let pose = Pose { rotation, translation: direction, turning: DVec3::ZERO };
        // Most things lie in front of the camera.
        let mut depths: Vec<f64> =
            pairs.iter().filter_map(|(from, to)| inverse_depth(focal, &pose, *from, *to)).collect();
        if median(&mut depths) < 0.0 { Pose { translation: -direction, ..pose } } else { pose }
    };
    kept.into_iter().map(pose).collect()
}

/// Half a sphere, evenly.
fn direction(i: usize) -> DVec3 {
    let z = (i as f64 + 0.5) / DIRECTIONS as f64;
    let (angle, radius) = (PI * (3.0 - 5f64.sqrt()) * i as f64, (1.0 - z * z).sqrt());
    DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
}

fn around(direction: DVec3, angle: f64) -> impl Iterator<Item = DVec3> {
    let (a, b) = direction.any_orthonormal_pair();
    (0..8).map(move |i| {
        let (sin, cos) = (f64::from(i) * PI / 4.0).sin_cos();
        (direction + (a * cos + b * sin) * angle).normalize()
    })
}

/// Distance of a point from its epipolar line in the other frame, in long sides, and the line's normal.
fn off_line(focal: Focal, rotated: DVec3, to: DVec2, direction: DVec3) -> Option<(f64, f64)> {
    let normal = direction.cross(rotated);
    let length = normal.truncate().length();
    (length > 1e-9).then(|| (focal.ray(to).dot(normal) / length * focal.0, length / focal.0))
}

/// The rotation with which the points lie nearest to their epipolar lines.
fn rotation_beside(focal: Focal, pairs: &[Pair], px: f64, direction: DVec3, from: DMat3) -> DMat3 {
    let mut now = from;
    let mut usual = 4.0 * px;
    for _ in 0..REWEIGHTED {
        let (mut normal, mut right) = (DMat3::ZERO, DVec3::ZERO);
        for (from, to) in pairs {
            let rotated = now * focal.ray(*from);
            let Some((residual, scale)) = off_line(focal, rotated, *to, direction) else { continue };
            let row = rotated.cross(focal.ray(*to).cross(direction)) / scale;
            add(&mut normal, &mut right, row, -residual, weight(residual, usual));
        }
        now = turned(now, solved(normal, right));
        usual = (0.6 * usual).max(px);
    }
    now
}

fn epipolar_cost(focal: Focal, pairs: &[Pair], px: f64, direction: DVec3, rotation: DMat3) -> f64 {
    let off = |(from, to): &Pair| off_line(focal, rotation * focal.ray(*from), *to, direction).map_or(0.0, |o| o.0);
    pairs.iter().map(|pair| cost(off(pair), px)).sum()
}

/// Inverse depth of a point that a frame of known pose sees somewhere; none where it tells nothing.
pub fn inverse_depth(focal: Focal, pose: &Pose, from: DVec2, to: DVec2) -> Option<f64> {
    let rotated = pose.turned(focal.ray(from), from.y);
    let to = to / focal.0;
    let along = pose.translation.truncate() - to * pose.translation.z;
    let moved = to * rotated.z - rotated.truncate();
    let length = along.length_squared();
    (length > 1e-12).then(|| moved.dot(along) / length)
}
