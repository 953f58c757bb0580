//! One picture of a cloud: ellipses put together tile by tile, from the near side on.

use glam::Vec2;
use rayon::prelude::*;

use super::project::{Ellipse, LEAST};
use super::tiles::{TILE, Tiles};
use crate::field::sides;
use crate::job::{Cancelled, Job};

/// Pixels that are computed together.
const LANES: usize = 8;
/// The most that one Gaussian keeps off, so that sorting errors do not show as edges.
pub(super) const MOST_OPAQUE: f32 = 0.99;
/// Light that is left over and is not worth going on for.
pub(super) const DONE: f32 = 1e-4;
/// Ellipses after which a tile looks whether it is done.
const LOOK_AFTER: usize = 32;

/// What puts the ellipses of a picture together.
pub trait Painter: Send + Sync {
    /// The picture; none where it is too much for what draws. Then the processor does it.
    ///
    /// # Errors
    /// Stopped.
    fn paint(&self, tiles: &Tiles, job: &Job) -> Result<Option<Shown>, Cancelled>;
}

/// The processor, on all its cores.
#[derive(Clone, Copy, Debug)]
pub struct Processor;

/// What a picture shows, in the cloud's own values.
#[derive(Clone, Debug, Default)]
pub struct Shown {
    /// Light, `[y, x]`, before what nothing covers.
    pub rgb: Vec<[f32; 3]>,
    /// How much of each pixel is covered, 0 … 1.
    pub cover: Vec<f32>,
    /// Inverse distance that is expected of each ray, weighted as its light is; 0 where there is nothing.
    pub nearness: Vec<f32>,
}

impl Painter for Processor {
    fn paint(&self, tiles: &Tiles, job: &Job) -> Result<Option<Shown>, Cancelled> {
        put_together(tiles, job).map(Some)
    }
}

/// Every tile in its turn.
///
/// # Errors
/// Stopped.
pub(super) fn put_together(tiles: &Tiles, job: &Job) -> Result<Shown, Cancelled> {
    let [width, height] = sides(tiles.size);
    let count = width * height;
    let mut shown = Shown { rgb: vec![[0.0; 3]; count], cover: vec![0.0; count], nearness: vec![0.0; count] };
    let band = width * TILE;
    let rows = shown.rgb.par_chunks_mut(band).zip(shown.cover.par_chunks_mut(band));
    let rows = rows.zip(shown.nearness.par_chunks_mut(band)).enumerate();
    rows.try_for_each(|(row, ((rgb, cover), nearness))| {
        for column in 0..tiles.across {
            let mut tile = Tile::at(column * TILE, row * TILE);
            tile.put(tiles.of_tile(row * tiles.across + column), &tiles.ellipses);
            tile.take(width, rgb, cover, nearness);
        }
        job.check()
    })?;
    Ok(shown)
}

/// A row of a tile.
type Row = [f32; TILE];

/// The pixels of one tile while they are put together.
struct Tile {
    at: [usize; 2],
    /// Light that still comes from behind.
    left: [Row; TILE],
    /// Red, green, blue and nearness.
    sums: [[Row; 4]; TILE],
    /// Rows that are not done.
    open: [bool; TILE],
}

impl Tile {
    fn at(x: usize, y: usize) -> Self {
        Self { at: [x, y], left: [[1.0; TILE]; TILE], sums: [[[0.0; TILE]; 4]; TILE], open: [true; TILE] }
    }

    fn put(&mut self, numbers: &[u32], ellipses: &[Ellipse]) {
        for some in numbers.chunks(LOOK_AFTER) {
            some.iter().for_each(|number| self.put_one(&ellipses[*number as usize]));
            for (open, left) in self.open.iter_mut().zip(&self.left) {
                *open = left.iter().any(|left| *left > DONE);
            }
            if !self.open.contains(&true) {
                return;
            }
        }
    }

    fn put_one(&mut self, ellipse: &Ellipse) {
        let middle = ellipse.at - Vec2::new(self.at[0] as f32, self.at[1] as f32);
        // Whole numbers are found by cutting off, which is much faster than rounding.
        let first = |low: f32| (low.max(-1.0) + 1.0) as usize;
        let end = |high: f32| (high + 1.0).clamp(0.0, TILE as f32) as usize;
        let [low, high] = [middle - ellipse.reach, middle + ellipse.reach];
        let columns = first(low.x)..end(high.x);
        if columns.is_empty() {
            return;
        }
        let blocks = columns.start / LANES..columns.end.div_ceil(LANES);
        for row in first(low.y)..end(high.y) {
            if self.open[row] {
                let (y, left, sums) = (row as f32 - middle.y, &mut self.left[row], &mut self.sums[row]);
                for block in blocks.clone() {
                    let from = block * LANES;
                    put_lanes(ellipse, from, from as f32 - middle.x, y, left, sums);
                }
            }
        }
    }

    /// Brings the pixels into the picture's rows.
    fn take(&self, width: usize, rgb: &mut [[f32; 3]], cover: &mut [f32], nearness: &mut [f32]) {
        let columns = TILE.min(width - self.at[0]);
        for row in 0..rgb.len() / width {
            let start = row * width + self.at[0];
            let [r, g, b, n] = &self.sums[row];
            for x in 0..columns {
                let covered = 1.0 - self.left[row][x];
                rgb[start + x] = [r[x], g[x], b[x]];
                cover[start + x] = covered;
                nearness[start + x] = if covered > LEAST { n[x] / covered } else { 0.0 };
            }
        }
    }
}

/// Puts an ellipse behind what is there already, for pixels beside each other.
#[inline(always)]
fn put_lanes(ellipse: &Ellipse, from: usize, x: f32, y: f32, left: &mut Row, sums: &mut [Row; 4]) {
    let [a, b, c] = ellipse.shape;
    let (cross, own) = (2.0 * b * y, c * y * y);
    let mut weight = [0.0f32; LANES];
    let left = &mut left[from..from + LANES];
    for lane in 0..LANES {
        let x = x + lane as f32;
        let away = (a * x + cross) * x + own;
        let alpha =
            (ellipse.opacity * exp2(away.clamp(0.0, 60.0) * (-0.5 * std::f32::consts::LOG2_E))).min(MOST_OPAQUE);
        let alpha = if away <= ellipse.most { alpha } else { 0.0 };
        weight[lane] = alpha * left[lane];
        left[lane] -= weight[lane];
    }
    let values = [ellipse.color[0], ellipse.color[1], ellipse.color[2], ellipse.nearness];
    for (sum, value) in sums.iter_mut().zip(values) {
        let sum = &mut sum[from..from + LANES];
        for lane in 0..LANES {
            sum[lane] += weight[lane] * value;
        }
    }
}

/// `2ˣ` for x from −100 to 0, to 6 digits.
#[inline(always)]
fn exp2(x: f32) -> f32 {
    // Adding it rounds to a whole number, which then stands in the lowest bits.
    const ROUND: f32 = 12_582_912.0;
    let whole = x + ROUND;
    let part = (x - (whole - ROUND)) * std::f32::consts::LN_2;
    let value = 1.0 + part * (1.0 + part * (0.5 + part * (1.0 / 6.0 + part * (1.0 / 24.0 + part * (1.0 / 120.0)))));
    f32::from_bits(value.to_bits().wrapping_add(whole.to_bits() << 23))
}

#[cfg(test)]
mod tests {
    use super::exp2;

    #[test]
    fn powers_of_two() {
        for i in 0..10_000 {
            let x = -(i as f32) * 0.01;
            assert!((exp2(x) - x.exp2()).abs() <= 4e-6 * x.exp2(), "{x}");
        }
    }
}
