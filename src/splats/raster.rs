//! One picture of a cloud: ellipses sorted by distance, put together tile by tile from the near side on.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::project::{Ellipse, LEAST, project};
use super::{Blend, Cloud, Rig};
use crate::field::{Lens, ramp, sides};
use crate::job::{Cancelled, Job};

/// Side of a tile, in pixels.
const TILE: usize = 16;
/// Pixels that are computed together.
const LANES: usize = 8;
/// The most that one Gaussian keeps off, so that sorting errors do not show as edges.
const MOST_OPAQUE: f32 = 0.99;
/// Light that is left over and is not worth going on for.
const DONE: f32 = 1e-4;
/// Ellipses after which a tile looks whether it is done.
const LOOK_AFTER: usize = 32;
/// Light that a spherical aberration moves at most; as in the layered lens.
const MOST_SPHERICAL: f32 = 0.8;

/// From where a picture is taken, and what is done to its light.
#[derive(Clone, Copy, Debug)]
pub struct Shot<'a> {
    /// The reference camera and the step.
    pub rig: Rig,
    /// Where the eye is, in view steps from the reference view.
    pub from: Vec2,
    /// Where the middle of its lens is: what is sharp stands as it is seen from there.
    pub middle: Vec2,
    /// The lens whose sharp surface stays where it is, in pixels of this width.
    pub lens: Option<&'a Lens>,
    /// Standard deviation of the part of the opening that this eye stands for, in view steps.
    pub blur: f32,
    /// The eye's place on the opening, over its radius, squared.
    pub rim: f32,
    /// The eye's place in the world.
    pub(super) eye: Vec3,
}

impl<'a> Shot<'a> {
    /// What an eye sees that stands some view steps beside the reference camera.
    pub fn view(rig: Rig, from: Vec2) -> Self {
        let camera = &rig.camera;
        let beside = from * rig.gain_px() / camera.focal_px;
        let eye = camera.place() + camera.turn.transpose() * beside.extend(0.0);
        Self { rig, from, middle: from, lens: None, blur: 0.0, rim: 0.0, eye }
    }

    /// The same as one of many eyes on a lens's opening.
    pub fn through(rig: Rig, from: Vec2, middle: Vec2, lens: &'a Lens, blur: f32, rim: f32) -> Self {
        Self { lens: Some(lens), middle, blur, rim, ..Self::view(rig, from) }
    }

    /// How far a disparity at a place is from what is sharp, in pixels per view step.
    #[inline]
    pub(super) fn away_px(&self, disparity_px: f32, at: Vec2) -> f32 {
        let size = self.rig.camera.size;
        let place = |at: f32, side: u32| (at + 0.5) / side as f32;
        self.lens.map_or(0.0, |lens| lens.defocus_px(disparity_px, place(at.x, size[0]), place(at.y, size[1])))
    }

    /// The light of something as the lens shows it: clipped lights brightened where they are blurred, and more of it
    /// towards the middle or the rim by a spherical aberration; as the layered lens does.
    #[inline]
    pub(super) fn lit(&self, color: [f32; 3], away_px: f32, blend: Blend) -> [f32; 3] {
        let Some(lens) = self.lens.filter(|lens| lens.highlights > 0.0 || lens.glass.spherical != 0.0) else {
            return color;
        };
        let blur = away_px * lens.f_number.added_views();
        let clipped = ramp(0.85, 1.0, color[0].max(color[1]).max(color[2]));
        let bright = 1.0 + 9.0 * lens.highlights.max(0.0) * clipped * ramp(1.0, 8.0, blur.abs());
        let moved = -blur.signum() * MOST_SPHERICAL * lens.glass.spherical * ramp(2.0, 4.0, blur.abs());
        let gain = bright * (1.0 + moved * (2.0 * self.rim - 1.0)).max(0.0);
        let gain = if blend == Blend::Encoded { gain.powf(1.0 / 2.2) } else { gain };
        color.map(|value| value * gain)
    }
}

/// What a picture shows, in the cloud's own values.
#[derive(Clone, Debug, Default)]
pub(super) struct Shown {
    /// Light, `[y, x]`, before what nothing covers.
    pub(super) rgb: Vec<[f32; 3]>,
    /// How much of each pixel is covered, 0 … 1.
    pub(super) cover: Vec<f32>,
    /// Inverse distance that is expected of each ray, weighted as its light is; 0 where there is nothing.
    pub(super) nearness: Vec<f32>,
}

/// Draws a cloud.
///
/// # Errors
/// Stopped.
pub(super) fn draw(cloud: &Cloud, shot: &Shot, job: &Job) -> Result<Shown, Cancelled> {
    let ellipses = project(cloud, shot);
    job.check()?;
    let tiles = Tiles::of(&ellipses, shot.rig.camera.size);
    job.check()?;
    let [width, height] = sides(shot.rig.camera.size);
    let count = width * height;
    let mut shown = Shown { rgb: vec![[0.0; 3]; count], cover: vec![0.0; count], nearness: vec![0.0; count] };
    let band = width * TILE;
    let rows = shown.rgb.par_chunks_mut(band).zip(shown.cover.par_chunks_mut(band));
    let rows = rows.zip(shown.nearness.par_chunks_mut(band)).enumerate();
    rows.try_for_each(|(row, ((rgb, cover), nearness))| {
        for column in 0..tiles.across {
            let mut tile = Tile::at(column * TILE, row * TILE);
            tile.put(tiles.of_tile(row * tiles.across + column), &ellipses);
            tile.take(width, rgb, cover, nearness);
        }
        job.check()
    })?;
    Ok(shown)
}

/// Which ellipses each tile shows, nearest first.
struct Tiles {
    across: usize,
    /// Where each tile's begin, and the end.
    starts: Vec<u32>,
    numbers: Vec<u32>,
}

impl Tiles {
    fn of(ellipses: &[Ellipse], size: [u32; 2]) -> Self {
        let counts = sides(size).map(|side| side.div_ceil(TILE));
        let mut order: Vec<u64> = ellipses
            .par_iter()
            .enumerate()
            .map(|(i, ellipse)| u64::from(!ellipse.nearness.to_bits()) << 32 | i as u64)
            .collect();
        order.par_sort_unstable();
        let touched = |number: u32| {
            let Ellipse { at, reach, .. } = ellipses[number as usize];
            let range = |low: f32, high: f32, count: usize| {
                let tile = |place: f32| (place.max(0.0) / TILE as f32) as usize;
                tile((low + 0.5).floor())..(tile(high + 0.5) + 1).min(count)
            };
            (range(at.x - reach.x, at.x + reach.x, counts[0]), range(at.y - reach.y, at.y + reach.y, counts[1]))
        };
        let mut starts = vec![0u32; counts[0] * counts[1] + 1];
        for key in &order {
            let (columns, rows) = touched(*key as u32);
            for row in rows {
                starts[row * counts[0]..][columns.start..columns.end].iter_mut().for_each(|count| *count += 1);
            }
        }
        let mut sum = 0;
        for start in &mut starts {
            (*start, sum) = (sum, sum + *start);
        }
        let mut next = starts.clone();
        let mut numbers = vec![0; sum as usize];
        for key in &order {
            let number = *key as u32;
            let (columns, rows) = touched(number);
            for row in rows {
                for next in &mut next[row * counts[0]..][columns.start..columns.end] {
                    numbers[*next as usize] = number;
                    *next += 1;
                }
            }
        }
        Self { across: counts[0], starts, numbers }
    }

    fn of_tile(&self, at: usize) -> &[u32] {
        &self.numbers[self.starts[at] as usize..self.starts[at + 1] as usize]
    }
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
