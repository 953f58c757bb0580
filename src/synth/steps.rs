//! Steps of depth that a map draws as ramps: each of their pixels goes to the near or to the far side.
//!
//! From a pixel of a ramp one walks uphill to the near side and downhill to the far one. Where the pixel stands between
//! the two, and whose colour it has, decides. A slant has no ends, so that it stays one; print and texture on a flat
//! thing have no ramp, so that they stay flat.

use rayon::prelude::*;

use super::lift::STEP_PX;
use crate::field::{View, sides};
use crate::job::{Cancel, Cancelled};

/// Steps of less than this are no two surfaces, px per view step.
const LEAST_PX: f32 = STEP_PX / 2.0;
/// A ramp that rises by less than this from one pixel to the next is a slope, px.
const STEEP_PX: f32 = 0.03;
/// A rise of less than this part of the ramp's steepest belongs to the surface at its end.
const END: f32 = 0.15;
/// A difference of the sides' colours at which half the weight is the colour's, 0 … 1.
const TELLING: f32 = 0.15;
/// The most that colour weighs against the place on the ramp.
const COLOUR_WEIGHT: f32 = 0.6;
/// Half the window from which a side takes its colour, in px, and how far beyond the ramp's end it lies.
const WINDOW: usize = 2;
const BEYOND: usize = 2;
/// Part of a step by which the pixels of one side differ at most.
const SAME_SIDE: f32 = 0.15;

/// How sharp the steps of a map `[y, x]` are drawn: the greatest rise from one pixel to the next as a part of the step,
/// median over the pixels of steps. 1 where there are none.
pub(super) fn sharpness(map: &[f32], size: [usize; 2], reach: usize) -> f32 {
    let sharp = |at: usize| Ramp::of(map, size, at, reach).map(|ramp| ramp.steepest / ramp.height());
    let mut all: Vec<f32> = (0..map.len()).into_par_iter().with_min_len(size[0]).filter_map(sharp).collect();
    let middle = all.len() / 2;
    if all.is_empty() { 1.0 } else { *all.select_nth_unstable_by(middle, f32::total_cmp).1 }
}

/// Gives the pixels of ramps to one of their two sides; `reach` is the longest way to either, in px.
pub(super) fn settle(map: &mut [f32], guide: &View, reach: usize, cancel: &Cancel) -> Result<(), Cancelled> {
    let size = sides(guide.size());
    let before = map.to_vec();
    map.par_chunks_mut(size[0]).enumerate().try_for_each(|(y, row)| {
        cancel.check()?;
        for (x, value) in row.iter_mut().enumerate() {
            let at = y * size[0] + x;
            if let Some(ramp) = Ramp::of(&before, size, at, reach) {
                *value = if ramp.is_near(&before, guide, at) { ramp.px[0] } else { ramp.px[1] };
            }
        }
        Ok(())
    })
}

/// The way over a step, as seen from one of its pixels.
struct Ramp {
    /// Disparity at the near and at the far end.
    px: [f32; 2],
    /// Pixels a little beyond the near and the far end.
    beyond: [usize; 2],
    /// The greatest rise from one pixel to the next.
    steepest: f32,
}

impl Ramp {
    /// The ramp on which a pixel lies; none on flat ground, and none where no end is within reach.
    fn of(map: &[f32], size: [usize; 2], at: usize, reach: usize) -> Option<Self> {
        let ways = [1.0, -1.0].map(|sign| walk(map, size, at, sign, reach));
        if map[*ways[0].last()?] - map[*ways[1].last()?] < LEAST_PX {
            return None;
        }
        let rise = |pair: &[usize]| (map[pair[1]] - map[pair[0]]).abs();
        let steepest = ways.iter().flat_map(|way| way.windows(2)).map(rise).fold(0.0, f32::max);
        let ends =
            [0, 1].map(|i| ways[i].windows(2).rposition(|pair| rise(pair) >= END * steepest).map_or(0, |n| n + 1));
        let [near, far] = [0, 1].map(|i| map[ways[i][ends[i]]]);
        let beyond = [0, 1].map(|i| ways[i][(ends[i] + BEYOND).min(ways[i].len() - 1)]);
        let is_step = ends.iter().all(|end| *end < reach) && near - far >= LEAST_PX && steepest >= STEEP_PX;
        is_step.then_some(Self { px: [near, far], beyond, steepest })
    }

    fn height(&self) -> f32 {
        self.px[0] - self.px[1]
    }

    /// Which side a pixel belongs to, by its place on the ramp, and by its colour where that tells the sides apart.
    fn is_near(&self, map: &[f32], guide: &View, at: usize) -> bool {
        let place = (map[at] - self.px[1]) / self.height();
        let [near, far] = self.beyond.map(|end| side_colour(map, guide, end, SAME_SIDE * self.height()));
        let (own, apart) = (colour(guide, at) - far, near - far);
        let apart2 = apart.length_squared();
        let by_colour = (own.dot(apart) / apart2.max(1e-9)).clamp(0.0, 1.0);
        let weight = COLOUR_WEIGHT * apart2 / (apart2 + TELLING * TELLING);
        place + (by_colour - place) * weight > 0.5
    }
}

/// The pixels passed on the steepest way up (`sign` 1) or down (−1), the first among them.
fn walk(map: &[f32], [w, h]: [usize; 2], from: usize, sign: f32, reach: usize) -> Vec<usize> {
    let mut way = Vec::with_capacity(reach + 1);
    way.push(from);
    let mut at = from;
    for _ in 0..reach {
        let (x, y) = (at % w, at / w);
        let mut best = (LEAST_PX * 1e-3, at);
        for yy in y.saturating_sub(1)..(y + 2).min(h) {
            for xx in x.saturating_sub(1)..(x + 2).min(w) {
                let distance = if xx != x && yy != y { std::f32::consts::FRAC_1_SQRT_2 } else { 1.0 };
                let rise = (map[yy * w + xx] - map[at]) * sign * distance;
                best = if rise > best.0 { (rise, yy * w + xx) } else { best };
            }
        }
        if best.1 == at {
            break;
        }
        at = best.1;
        way.push(at);
    }
    way
}

fn colour(guide: &View, at: usize) -> glam::Vec3 {
    let of = |c: usize| f32::from(guide.rgba()[at * 4 + c]) / 255.0;
    glam::Vec3::new(of(0), of(1), of(2))
}

/// Mean colour around a pixel of what is as deep as it, but for `apart`.
fn side_colour(map: &[f32], guide: &View, at: usize, apart: f32) -> glam::Vec3 {
    let [w, h] = sides(guide.size());
    let (x, y) = (at % w, at / w);
    let columns = move || x.saturating_sub(WINDOW)..(x + WINDOW + 1).min(w);
    let rows = y.saturating_sub(WINDOW)..(y + WINDOW + 1).min(h);
    let around = rows.flat_map(|y| columns().map(move |x| y * w + x));
    let same = around.filter(|i| (map[*i] - map[at]).abs() <= apart);
    let (sum, n) = same.fold((glam::Vec3::ZERO, 0.0), |(sum, n), i| (sum + colour(guide, i), n + 1.0));
    sum / n
}
