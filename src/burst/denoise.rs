//! Less noise for the reference photo: where frames show the same, their mean with it.
//!
//! Each frame is brought over the photo by the depth that was measured. How far both are apart around a pixel (root of the mean
//! square) says whether they show the same: what noise makes of it is the same nearly everywhere, what moves, hides or does
//! not fit is farther apart and counts less, or not at all.

use glam::{DVec2, Vec3};
use rayon::prelude::*;

use super::BurstError;
use super::camera::{Focal, Pose, pixel_of_place, place_of_pixel};
use crate::field::{Raster, Size, View, center_at, ramp, sides};
use crate::job::{Cancel, Job, Stage};

/// Half the side of the window in which both are compared.
const HALF: usize = 2;
/// Mean squares against the usual one from which on a frame counts less, and not at all.
const SAME: [f32; 2] = [1.6, 3.0];
/// Least usual mean square of what has no noise (sRGB 0 … 255).
const LEAST: f32 = 1.0;
/// One in so many pixels tells what is usual.
const SAMPLED: usize = 17;

/// The mean as it grows by one frame after the other.
pub struct Mean<'a> {
    photo: &'a View,
    inverse_depth: &'a Raster<f32>,
    focal: Focal,
    /// Sum of the frames' colours and of their weights.
    sums: Vec<([f32; 3], f32)>,
}

impl<'a> Mean<'a> {
    /// Of a photo of any size alone. `inverse_depth` is the same scene's, of any size.
    pub fn new(photo: &'a View, inverse_depth: &'a Raster<f32>, focal: Focal) -> Self {
        Self { photo, inverse_depth, focal, sums: vec![([0.0; 3], 0.0); photo.pixels().len()] }
    }

    /// Adds a frame of the photo's exposure.
    ///
    /// # Errors
    /// Cancelled.
    pub fn add(&mut self, frame: &View, pose: &Pose, cancel: &Cancel) -> Result<(), BurstError> {
        let brought = self.brought(frame, pose, cancel)?;
        let [w, h] = sides(self.photo.size());
        let apart: Vec<f32> = brought
            .par_iter()
            .zip(self.photo.pixels())
            .map(|(colour, own)| colour.map_or(f32::INFINITY, |colour| square(colour, *own)))
            .collect();
        cancel.check()?;
        let apart = around(&apart, [w, h]);
        cancel.check()?;
        let mut some: Vec<f32> = apart.iter().step_by(SAMPLED).copied().filter(|v| v.is_finite()).collect();
        if some.is_empty() {
            return Ok(());
        }
        let middle = some.len() / 2;
        let usual = some.select_nth_unstable_by(middle, f32::total_cmp).1.max(LEAST);
        self.sums.par_iter_mut().zip(brought).zip(apart).for_each(|(((sum, all), colour), apart)| {
            let weight = 1.0 - ramp(SAME[0], SAME[1], apart / usual);
            if let Some(colour) = colour.filter(|_| weight > 0.0) {
                sum.iter_mut().zip(colour.to_array()).for_each(|(sum, c)| *sum += weight * c);
                *all += weight;
            }
        });
        Ok(())
    }

    /// The frame's colours at the photo's pixels; none beside it.
    fn brought(&self, frame: &View, pose: &Pose, cancel: &Cancel) -> Result<Vec<Option<Vec3>>, BurstError> {
        let size = self.photo.size();
        let [w, h] = sides(size);
        let [rw, rh] = self.inverse_depth.sides();
        let (rx, ry) = (rw as f32 / w as f32, rh as f32 / h as f32);
        let mut out = vec![None; w * h];
        out.par_chunks_exact_mut(w).enumerate().for_each(|(y, row)| {
            if cancel.is_cancelled() {
                return;
            }
            for (x, out) in row.iter_mut().enumerate() {
                let rho = self.inverse_depth.tap(center_at(x, rx), center_at(y, ry));
                let at = place_of_pixel(size, x as f64, y as f64);
                let to = pixel_of_place(frame.size(), self.focal.seen(pose, at, rho.into()));
                *out = cubic(frame, to);
            }
        });
        cancel.check()?;
        Ok(out)
    }

    /// The photo with the frames' mean where they agree.
    ///
    /// # Errors
    /// None of a photo.
    pub fn finish(self) -> Result<View, BurstError> {
        let size: Size = self.photo.size();
        let pixel = |(own, (sum, all)): (&[u8; 4], &([f32; 3], f32))| {
            let mean = |c: usize| ((f32::from(own[c]) + sum[c]) / (1.0 + all)).round().clamp(0.0, 255.0) as u8;
            [mean(0), mean(1), mean(2), own[3]]
        };
        let rgba: Vec<[u8; 4]> = self.photo.pixels().par_iter().zip(&self.sums).map(pixel).collect();
        Ok(View::new(size, rgba.into_flattened())?)
    }
}

/// Tells how many frames were added.
///
/// # Errors
/// Cancelled.
pub fn advance(job: &Job, done: usize, all: usize) -> Result<(), BurstError> {
    Ok(job.advance(Stage::Mean, done as u32, all as u32)?)
}

fn square(colour: Vec3, own: [u8; 4]) -> f32 {
    (colour - Vec3::new(own[0].into(), own[1].into(), own[2].into())).length_squared() / 3.0
}

/// Means over the window; beside the frame infinite.
fn around(values: &[f32], [w, h]: [usize; 2]) -> Vec<f32> {
    let window = |i: usize, n: usize| i.saturating_sub(HALF)..(i + HALF + 1).min(n);
    let mut across = vec![0.0; values.len()];
    across.par_chunks_exact_mut(w).zip(values.par_chunks_exact(w)).for_each(|(out, row)| {
        out.iter_mut().enumerate().for_each(|(x, out)| {
            let window = window(x, w);
            *out = row[window.clone()].iter().sum::<f32>() / window.len() as f32;
        });
    });
    let mut all = vec![0.0; values.len()];
    all.par_chunks_exact_mut(w).enumerate().for_each(|(y, out)| {
        let window = window(y, h);
        let share = 1.0 / window.len() as f32;
        for y in window {
            out.iter_mut().zip(&across[y * w..]).for_each(|(out, value)| *out += value * share);
        }
    });
    all
}

/// A colour between pixels by cubic splines through them (Catmull and Rom), so that detail stays; none near the border.
fn cubic(view: &View, at: DVec2) -> Option<Vec3> {
    let [w, h] = sides(view.size());
    let (x, y) = (at.x.floor(), at.y.floor());
    if x < 1.0 || y < 1.0 || x + 2.0 >= w as f64 || y + 2.0 >= h as f64 {
        return None;
    }
    let weights = |t: f32| {
        let (t2, t3) = (t * t, t * t * t);
        [-t + 2.0 * t2 - t3, 2.0 - 5.0 * t2 + 3.0 * t3, t + 4.0 * t2 - 3.0 * t3, t3 - t2].map(|weight| weight / 2.0)
    };
    let (across, down) = (weights((at.x - x) as f32), weights((at.y - y) as f32));
    let (x, y) = (x as usize - 1, y as usize - 1);
    let mut sum = Vec3::ZERO;
    for (dy, down) in down.into_iter().enumerate() {
        let row = &view.pixels()[(y + dy) * w + x..][..4];
        for (pixel, across) in row.iter().zip(across) {
            sum += Vec3::new(pixel[0].into(), pixel[1].into(), pixel[2].into()) * (across * down);
        }
    }
    Some(sum)
}
