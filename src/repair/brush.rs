//! Brushes: a stroke that grows point by point, so that each sample costs what it changes.
//!
//! A pixel's weight hangs on the shortest way to the stroke, over edges a long one. So it does not matter how many
//! points a path has, and a stroke that was drawn slowly is no other one.

use super::fit::median;
use super::guide::apart;
use super::mender::{Mender, Rect};
use super::reach::{line, walk};
use super::{Brush, FULL_STRENGTH, Place};
use crate::field::ramp;

/// Where a brush begins to fade, as a part of its radius.
const FADES: f32 = 0.5;
/// A difference of colours that is as long as the brush's radius; of depths, as a part of the range.
const COLOUR_EDGE: f32 = 0.12;
const DEPTH_EDGE: f32 = 0.2;
/// Half the window that evens out, as a part of the radius; and that looks for an edge's sides at full strength.
const EVENS: f32 = 0.4;
const SIDES: f32 = 0.9;
/// Places of a window that are looked at in each direction from its middle.
const TAPS: i32 = 3;
/// Colours that differ by this hardly count for each other.
const ALIKE: f32 = 0.08;
/// Two sides are apart by at least this part of the range.
const APART: f32 = 0.08;
/// Part of the step between both sides within which a pixel is surely of one.
const SURE: f32 = 0.25;

/// A stroke that is being drawn.
#[derive(Clone, Debug)]
pub struct Draft {
    brush: Brush,
    radius_px: f32,
    strength: f32,
    /// The map before the stroke.
    before: Vec<f32>,
    /// The shortest way from the stroke, in radii.
    ways: Vec<f32>,
    /// What a pixel becomes at full weight; no number before it was asked for.
    full: Vec<f32>,
    last: Option<[f32; 2]>,
}

impl Mender {
    /// Begins a stroke: its diameter as a share of the longer side, its strength from 0 to 1.
    pub fn begin(&self, brush: Brush, size: f32, strength: f32) -> Draft {
        let count = self.disparity_px().len();
        Draft {
            brush,
            radius_px: (size * self.long_px() / 2.0).max(0.75),
            strength,
            before: self.disparity_px().to_vec(),
            ways: vec![f32::INFINITY; count],
            full: vec![f32::NAN; count],
            last: None,
        }
    }

    /// Goes on to a place, and says what has changed.
    pub fn extend(&mut self, draft: &mut Draft, to: Place) -> Option<Rect> {
        let sides = self.sides();
        let to = [0, 1].map(|axis| to[axis] * sides[axis] as f32 - 0.5);
        let seeds = line(sides, draft.last.unwrap_or(to), to);
        draft.last = Some(to);
        let radius = draft.radius_px;
        let stops = matches!(draft.brush, Brush::Nearer | Brush::Farther);
        let mut ways = std::mem::take(&mut draft.ways);
        let cost = |a: usize, b: usize, px: f32| {
            let edge = self.colour_edge(a, b, px) / COLOUR_EDGE + draft.step(a, b) / (DEPTH_EDGE * self.range_px());
            px / radius + if stops { edge } else { 0.0 }
        };
        let reached = walk(sides, &mut ways, seeds, 1.0, cost);
        draft.ways = ways;
        for i in &reached {
            let value = draft.value(self, *i);
            self.values_mut()[*i] = value;
        }
        Rect::around(&reached, sides[0])
    }
}

impl Draft {
    /// Whether the stroke has reached a pixel, `y · width + x`.
    pub fn has(&self, i: usize) -> bool {
        self.ways[i].is_finite()
    }

    fn step(&self, a: usize, b: usize) -> f32 {
        (self.before[a] - self.before[b]).abs()
    }

    /// What a pixel that the stroke reaches becomes.
    fn value(&mut self, mender: &Mender, i: usize) -> f32 {
        let weight = 1.0 - ramp(FADES, 1.0, self.ways[i]);
        let before = self.before[i];
        let moved = mender.px(FULL_STRENGTH) * self.strength * weight;
        match self.brush {
            Brush::Nearer => before + moved,
            Brush::Farther => before - moved,
            Brush::Smooth => before + (self.full(mender, i) - before) * weight * self.strength,
            // Never a depth in between.
            Brush::Sharpen if weight > 0.5 => self.full(mender, i),
            Brush::Sharpen => before,
        }
    }

    fn full(&mut self, mender: &Mender, i: usize) -> f32 {
        if self.full[i].is_nan() {
            self.full[i] = match self.brush {
                Brush::Sharpen => self.side(mender, i),
                _ => self.even(mender, i),
            };
        }
        self.full[i]
    }

    /// The mean of what has the pixel's colour around it.
    fn even(&self, mender: &Mender, i: usize) -> f32 {
        let (mut sum, mut total) = (0.0, 0.0);
        for (j, far) in window(mender.sides(), i, EVENS * self.radius_px) {
            let colour = mender.guide().difference(i, j) / ALIKE;
            let weight = (-colour * colour - far * far).exp();
            sum += weight * self.before[j];
            total += weight;
        }
        sum / total
    }

    /// The side of an edge whose colour the pixel has; itself where there is no edge.
    fn side(&self, mender: &Mender, i: usize) -> f32 {
        let places: Vec<(usize, f32)> = window(mender.sides(), i, SIDES * self.radius_px * self.strength).collect();
        let depths = || places.iter().map(|(j, _)| self.before[*j]);
        let (far, near) = (depths().fold(f32::MAX, f32::min), depths().fold(f32::MIN, f32::max));
        let before = self.before[i];
        if near - far < APART * mender.range_px() {
            return before;
        }
        let sure = SURE * (near - far);
        let of = |is_near: bool| {
            let is_of = move |d: f32| if is_near { d > near - sure } else { d < far + sure };
            let own: Vec<usize> = places.iter().map(|(j, _)| *j).filter(|j| is_of(self.before[*j])).collect();
            let depth = median(own.iter().map(|j| self.before[*j]).collect()).unwrap_or(before);
            let colour = mender.guide().mean(own.into_iter()).unwrap_or_default();
            (apart(colour, mender.guide().colour(i)), depth)
        };
        let (near_side, far_side) = (of(true), of(false));
        if near_side.0 < far_side.0 { near_side.1 } else { far_side.1 }
    }
}

/// Places around a pixel: its own first, and how far each is as a part of the reach.
fn window([w, h]: [usize; 2], i: usize, reach_px: f32) -> impl Iterator<Item = (usize, f32)> {
    let (x, y) = ((i % w) as i32, (i / w) as i32);
    let taps = TAPS.min(reach_px.ceil().max(1.0) as i32);
    let pitch = (reach_px / taps as f32).max(1.0);
    (-taps..=taps).flat_map(move |dy| (-taps..=taps).map(move |dx| (dx, dy))).filter_map(move |(dx, dy)| {
        let at = |from: i32, by: i32| from + (by as f32 * pitch).round() as i32;
        let (x, y) = (at(x, dx), at(y, dy));
        let is_inside = x >= 0 && y >= 0 && x < w as i32 && y < h as i32;
        is_inside.then(|| (y as usize * w + x as usize, ((dx * dx + dy * dy) as f32).sqrt() / taps as f32))
    })
}
