//! Bundle adjustment over small motion: poses, a focal length and inverse depths in the reference frame, so that every
//! point is seen where it was seen (Yu and Gallup 2014; with a rolling shutter Im et al. 2015).
//!
//! Levenberg and Marquardt's steps; points are eliminated first (Schur's complement), each being a single number.

use glam::{DVec2, DVec3};

use super::camera::{Focal, Pose};
use super::start::{cost, place_by_point, turned, weight};
use crate::job::{Cancel, Cancelled};

/// Numbers of a pose: rotation, translation, turning.
const OF_POSE: usize = 9;
/// What a residual is divided by: a corner is found to this part of a pixel.
const FOUND_PX: f64 = 0.25;
/// Pixels that a rolling shutter usually moves the picture's edge by.
const TURNING_PX: f64 = 3.0;
/// Steps at most, and the part of the cost whose loss ends them.
const STEPS: usize = 40;
const SETTLED: f64 = 1e-5;

/// Points and where frames see them, in long sides from the middle.
pub struct Tracks {
    /// Places in the reference frame.
    pub points: Vec<DVec2>,
    /// Places in the other frames, `[frame][point]`.
    pub seen: Vec<Vec<Option<DVec2>>>,
    /// A pixel, in long sides.
    pub px: f64,
}

/// What is to be found.
#[derive(Clone, Debug)]
pub struct Bundle {
    /// Of all frames.
    pub focal: Focal,
    /// Of the other frames.
    pub poses: Vec<Pose>,
    /// Of the points.
    pub inverse_depths: Vec<f64>,
}

/// What may vary beside poses and depths.
#[derive(Clone, Copy, Debug)]
pub struct Freedom {
    /// How far off the focal length usually is, as a part of it; none keeps it.
    pub focal: Option<f64>,
    /// Whether rows are read one after the other.
    pub rolling: bool,
}

impl Bundle {
    /// Residual of an observation, in long sides.
    pub fn residual(&self, tracks: &Tracks, frame: usize, point: usize) -> Option<DVec2> {
        let seen = tracks.seen[frame][point]?;
        Some(seen - self.focal.seen(&self.poses[frame], tracks.points[point], self.inverse_depths[point]))
    }

    /// Robust cost of all residuals where `usual_px` is a usual one.
    pub fn cost(&self, tracks: &Tracks, usual_px: f64) -> f64 {
        let usual = usual_px * tracks.px;
        let of =
            |frame: usize, point: usize| self.residual(tracks, frame, point).map_or(0.0, |r| cost(r.length(), usual));
        (0..self.poses.len()).flat_map(|frame| (0..tracks.points.len()).map(move |point| of(frame, point))).sum()
    }

    /// Brings the largest baseline to 1: only ratios are known.
    pub fn normalise(&mut self) {
        let longest = self.poses.iter().map(|pose| pose.translation.length()).fold(0.0, f64::max);
        if longest > 1e-12 {
            self.poses.iter_mut().for_each(|pose| pose.translation /= longest);
            self.inverse_depths.iter_mut().for_each(|rho| *rho *= longest);
        }
    }

    /// The bundle of least cost from here; residuals beyond `usual_px` lose their say.
    ///
    /// # Errors
    /// Stopped.
    pub fn adjusted(
        mut self,
        tracks: &Tracks,
        usual_px: f64,
        freedom: Freedom,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        self.normalise();
        let first_focal = self.focal.0;
        let scale = (usual_px / FOUND_PX).powi(2);
        let total = |bundle: &Self| scale * bundle.cost(tracks, usual_px) + bundle.priors(tracks, freedom, first_focal);
        let (mut damping, mut now) = (1e-3, total(&self));
        for _ in 0..STEPS {
            let normal = Normal::new(&self, tracks, usual_px, freedom, first_focal);
            let mut gained = None;
            for _ in 0..6 {
                cancel.check()?;
                let mut next = normal.step(&self, damping, freedom);
                next.normalise();
                let cost = total(&next);
                if cost.is_finite() && cost < now {
                    gained = Some(now - cost);
                    (self, now) = (next, cost);
                    damping = (damping * 0.2).max(1e-9);
                    break;
                }
                damping *= 8.0;
            }
            if gained.is_none_or(|gained| gained < SETTLED * now) {
                break;
            }
        }
        Ok(self)
    }

    /// The same with poses that fit the points as they are.
    pub fn with_poses_found(mut self, tracks: &Tracks, usual_px: f64) -> Self {
        let freedom = Freedom { focal: None, rolling: false };
        let (mut damping, mut now) = (1e-3, self.cost(tracks, usual_px));
        for _ in 0..STEPS {
            let mut normal = Normal::new(&self, tracks, usual_px, freedom, self.focal.0);
            normal.points.iter_mut().for_each(|point| *point = (0.0, 0.0, vec![0.0; normal.size]));
            let next = normal.step(&self, damping, freedom);
            let cost = next.cost(tracks, usual_px);
            if cost < now {
                let is_settled = now - cost < SETTLED * now;
                (self, now, damping) = (next, cost, damping * 0.2);
                if is_settled {
                    break;
                }
            } else if damping > 1e6 {
                break;
            } else {
                damping *= 8.0;
            }
        }
        self
    }

    fn priors(&self, tracks: &Tracks, freedom: Freedom, first_focal: f64) -> f64 {
        let focal = freedom.focal.map_or(0.0, |usual| ((self.focal.0 / first_focal).ln() / usual).powi(2));
        let turning = self.turning_scale(tracks);
        focal + self.poses.iter().map(|pose| (pose.turning * turning).length_squared()).sum::<f64>()
    }

    /// What a turning is multiplied by to be in usual ones.
    fn turning_scale(&self, tracks: &Tracks) -> f64 {
        self.focal.0 * 0.4 / (TURNING_PX * tracks.px)
    }
}

/// The normal equations with the points eliminated.
struct Normal {
    size: usize,
    /// `[row, column]`, of poses and the focal length.
    matrix: Vec<f64>,
    right: Vec<f64>,
    /// For each point: its own curvature, its right side, and its coupling to each unknown.
    points: Vec<(f64, f64, Vec<f64>)>,
}

impl Normal {
    fn new(bundle: &Bundle, tracks: &Tracks, usual_px: f64, freedom: Freedom, first_focal: f64) -> Self {
        let size = bundle.poses.len() * OF_POSE + 1;
        let mut normal = Self {
            size,
            matrix: vec![0.0; size * size],
            right: vec![0.0; size],
            points: Vec::with_capacity(tracks.points.len()),
        };
        let usual = usual_px * tracks.px;
        for (point, at) in tracks.points.iter().enumerate() {
            let mut own = (0.0, 0.0, vec![0.0; size]);
            for frame in 0..bundle.poses.len() {
                let Some(residual) = bundle.residual(tracks, frame, point) else { continue };
                let weight = weight(residual.length(), usual) / (FOUND_PX * tracks.px).powi(2);
                let rows = jacobian(bundle, frame, *at, bundle.inverse_depths[point], freedom);
                for (row, residual) in rows.iter().zip(residual.to_array()) {
                    normal.add(row, frame * OF_POSE, residual, weight, &mut own);
                }
            }
            normal.points.push(own);
        }
        normal.add_priors(bundle, tracks, freedom, first_focal);
        normal
    }

    fn add(&mut self, row: &Row, first: usize, residual: f64, weight: f64, own: &mut (f64, f64, Vec<f64>)) {
        let (size, last) = (self.size, self.size - 1);
        for i in 0..OF_POSE {
            let (a, at) = (row.pose[i] * weight, (first + i) * size);
            for j in 0..OF_POSE {
                self.matrix[at + first + j] += a * row.pose[j];
            }
            self.matrix[at + last] += a * row.focal;
            self.matrix[last * size + first + i] += a * row.focal;
            self.right[first + i] += a * residual;
            own.2[first + i] += a * row.depth;
        }
        self.matrix[last * size + last] += weight * row.focal * row.focal;
        self.right[last] += weight * row.focal * residual;
        own.2[last] += weight * row.focal * row.depth;
        own.0 += weight * row.depth * row.depth;
        own.1 += weight * row.depth * residual;
    }

    fn add_priors(&mut self, bundle: &Bundle, tracks: &Tracks, freedom: Freedom, first_focal: f64) {
        let (size, last) = (self.size, self.size - 1);
        let focal = freedom.focal.map_or(1e12, |usual| usual.powi(-2));
        self.matrix[last * size + last] += focal;
        self.right[last] -= focal * (bundle.focal.0 / first_focal).ln();
        let turning = if freedom.rolling { bundle.turning_scale(tracks).powi(2) } else { 1e12 };
        for (frame, pose) in bundle.poses.iter().enumerate() {
            for (axis, value) in pose.turning.to_array().into_iter().enumerate() {
                let i = frame * OF_POSE + 6 + axis;
                self.matrix[i * size + i] += turning;
                self.right[i] -= turning * value;
            }
        }
    }

    /// The bundle after one damped step.
    fn step(&self, from: &Bundle, damping: f64, freedom: Freedom) -> Bundle {
        let size = self.size;
        let (mut matrix, mut right) = (self.matrix.clone(), self.right.clone());
        for i in 0..size {
            matrix[i * size + i] = matrix[i * size + i] * (1.0 + damping) + 1e-9;
        }
        for (own, own_right, coupling) in &self.points {
            let own = own * (1.0 + damping) + 1e-9;
            for i in 0..size {
                let share = coupling[i] / own;
                if share != 0.0 {
                    right[i] -= share * own_right;
                    matrix[i * size..(i + 1) * size].iter_mut().zip(coupling).for_each(|(m, c)| *m -= share * c);
                }
            }
        }
        let step = solve(matrix, right, size);
        let mut next = from.clone();
        for (pose, step) in next.poses.iter_mut().zip(step.chunks_exact(OF_POSE)) {
            pose.rotation = turned(pose.rotation, DVec3::new(step[0], step[1], step[2]));
            pose.translation += DVec3::new(step[3], step[4], step[5]);
            if freedom.rolling {
                pose.turning += DVec3::new(step[6], step[7], step[8]);
            }
        }
        if freedom.focal.is_some() {
            next.focal.0 *= step[size - 1].clamp(-0.2, 0.2).exp();
        }
        for ((own, own_right, coupling), rho) in self.points.iter().zip(&mut next.inverse_depths) {
            let coupled: f64 = coupling.iter().zip(&step).map(|(c, s)| c * s).sum();
            *rho += (own_right - coupled) / (own * (1.0 + damping) + 1e-9);
        }
        next
    }
}

/// One row of the Jacobian of a place.
struct Row {
    pose: [f64; OF_POSE],
    focal: f64,
    depth: f64,
}

fn jacobian(bundle: &Bundle, frame: usize, at: DVec2, inverse_depth: f64, freedom: Freedom) -> [Row; 2] {
    let (focal, pose) = (bundle.focal, &bundle.poses[frame]);
    let ray = focal.ray(at);
    let rotated = pose.rotation * ray;
    let point = pose.transform(ray, at.y, inverse_depth);
    // A longer lens makes the ray steeper, and what is seen larger.
    let by_focal = pose.rotation * DVec3::new(-ray.x, -ray.y, 0.0);
    let seen = focal.place(point).to_array();
    let rows = place_by_point(focal, point);
    [0, 1].map(|axis| {
        let row = rows[axis];
        let (by_rotation, by_translation) = (rotated.cross(row), row * inverse_depth);
        let by_turning = if freedom.rolling { by_rotation * at.y } else { DVec3::ZERO };
        let mut all = [0.0; OF_POSE];
        for (three, values) in all.chunks_exact_mut(3).zip([by_rotation, by_translation, by_turning]) {
            three.copy_from_slice(&values.to_array());
        }
        let by_focal = if freedom.focal.is_some() { seen[axis] + row.dot(by_focal) } else { 0.0 };
        Row { pose: all, focal: by_focal, depth: row.dot(pose.translation) }
    })
}

/// Solves a symmetric positive system (Cholesky); what is singular stays 0.
fn solve(mut m: Vec<f64>, mut right: Vec<f64>, n: usize) -> Vec<f64> {
    for j in 0..n {
        let (above, rest) = m.split_at_mut(j * n);
        let _ = above;
        let pivot = rest[j] - rest[..j].iter().map(|v| v * v).sum::<f64>();
        let pivot = if pivot > 1e-12 { pivot.sqrt() } else { f64::INFINITY };
        rest[j] = pivot;
        let (first, below) = rest.split_at_mut(n);
        for row in below.chunks_exact_mut(n) {
            let sum: f64 = row[..j].iter().zip(&first[..j]).map(|(a, b)| a * b).sum();
            row[j] = (row[j] - sum) / pivot;
        }
    }
    for i in 0..n {
        let sum: f64 = (0..i).map(|k| m[i * n + k] * right[k]).sum();
        right[i] = (right[i] - sum) / m[i * n + i];
    }
    for i in (0..n).rev() {
        let sum: f64 = (i + 1..n).map(|k| m[k * n + i] * right[k]).sum();
        right[i] = (right[i] - sum) / m[i * n + i];
    }
    right
}
