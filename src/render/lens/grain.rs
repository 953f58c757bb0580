//! The photo's grain put back into blurred parts, so that they do not look smoother than the sharp ones.
//!
//! How strong the grain is at each brightness is measured in the photo's evenest places; blur takes away all but
//! `1 / √area` of it, and that much is added again.

use super::Prepared;
use super::light::Light;
use super::tile::{Optics, Region};
use crate::field::sides;

const BINS: usize = 16;
/// Of all places of one brightness, the part that is taken for even.
const EVEN: f32 = 0.15;
/// Standard deviation of a 3×3 window at that part of many windows, over the true one.
const BIAS: f32 = 0.72;

/// Strength of the grain by brightness.
pub(super) struct Grain {
    /// Standard deviation in √light, by √light; all 0 when it is off.
    sigma: [f32; BINS],
    on: bool,
}

impl Grain {
    pub(super) fn of(light: &Light, strength: f32) -> Self {
        if strength <= 0.0 {
            return Self { sigma: [0.0; BINS], on: false };
        }
        let [width, height] = sides(light.size());
        let step = ((width * height) as f32 / 40_000.0).sqrt().max(3.0) as usize;
        let mut bins: Vec<Vec<f32>> = vec![Vec::new(); BINS];
        for y in (1..height.saturating_sub(1)).step_by(step) {
            for x in (1..width.saturating_sub(1)).step_by(step) {
                let [mean, deviation] = window(light, x, y);
                bins[bin(mean)].push(deviation);
            }
        }
        let mut sigma = [0.0; BINS];
        for (sigma, bin) in sigma.iter_mut().zip(&mut bins) {
            bin.sort_by(f32::total_cmp);
            let even = bin.get((bin.len() as f32 * EVEN) as usize).copied().unwrap_or(0.0);
            *sigma = if bin.len() >= 12 { strength.min(1.0) * even / BIAS } else { 0.0 };
        }
        Self { sigma, on: true }
    }

    /// Adds grain to a tile.
    pub(super) fn add(&self, picture: &Prepared, optics: &Optics, tile: Region, out: &mut [f32]) {
        if !self.on {
            return;
        }
        let [x0, y0] = tile.at.map(|at| at as i32);
        let width = tile.size[0] as usize;
        let reader = picture.surfaces.reader(x0, width, picture.size);
        for (y, row) in out.chunks_exact_mut(width * 3).enumerate() {
            let at = reader.at_row(y0 + y as i32);
            for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                let place = [x0 + x as i32, y0 + y as i32];
                let blur = optics.blur(reader.disparity(&at, x), place[0], place[1]);
                let area = (0.785 * blur * blur).max(1.0);
                let lost = (1.0 - 1.0 / area).sqrt();
                let root = |v: f32| v.max(0.0).sqrt();
                let bright = (root(pixel[0]) + root(pixel[1]) + root(pixel[2])) / 3.0;
                let grain = lost * self.sigma[bin(bright)] * noise(place);
                for v in pixel {
                    *v = (root(*v) + grain).max(0.0).powi(2);
                }
            }
        }
    }
}

fn bin(root: f32) -> usize {
    ((root * BINS as f32) as usize).min(BINS - 1)
}

/// Mean and standard deviation of √light in 3×3 pixels.
fn window(light: &Light, x: usize, y: usize) -> [f32; 2] {
    let (mut sum, mut sum2) = (0.0, 0.0);
    for dy in 0..3 {
        for dx in 0..3 {
            let v = light.at(x + dx - 1, y + dy - 1).into_iter().map(f32::sqrt).sum::<f32>() / 3.0;
            sum += v;
            sum2 += v * v;
        }
    }
    let mean: f32 = sum / 9.0;
    [mean, (sum2 / 9.0 - mean * mean).max(0.0).sqrt()]
}

/// Gaussian noise that belongs to a pixel: the same in every tile and run.
fn noise([x, y]: [i32; 2]) -> f32 {
    let mut h = (x as u32).wrapping_mul(0x9E37_79B1) ^ (y as u32).wrapping_mul(0x85EB_CA77);
    let mut sum = 0.0;
    for _ in 0..4 {
        h ^= h >> 15;
        h = h.wrapping_mul(0x2C1B_3C6D);
        h ^= h >> 13;
        sum += h as f32 / u32::MAX as f32;
    }
    // Four even numbers have mean 2 and variance 1/3.
    (sum - 2.0) * 3.0f32.sqrt()
}
