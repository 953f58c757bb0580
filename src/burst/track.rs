//! Where each corner of the reference frame lies in another frame.
//!
//! The whole picture's shift and roll first, then each corner's own patch, searched where the picture is small and
//! refined where it is large (Lucas and Kanade 1981, coarse to fine). Patches are compared without their brightness and
//! contrast, so that exposure has no say.

use std::f32::consts::PI;

use glam::Vec2;
use rayon::prelude::*;

use super::pyramid::Pyramid;
use crate::field::Raster;

/// Long side at which the whole picture is brought over the other.
const WHOLE: u32 = 80;
/// How far the whole picture may have moved, as a share of its long side.
const WHOLE_REACH: f32 = 0.3;
/// Rolls that are tried, in degrees.
const ROLLS: [f32; 7] = [-6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0];
/// Long side at which corners are searched.
const SEARCH: u32 = 320;
/// How far a corner may lie from where the whole picture's movement brings it, in pixels of that size.
const SEARCH_PX: i32 = 22;
/// Half the side of a patch that is searched, and of one that is refined.
const HALF: [i32; 2] = [4, 6];
/// Least correlation of two patches that are the same thing.
const ALIKE: [f32; 2] = [0.6, 0.8];
/// Another place that is nearly as alike leaves it open which it is.
const AMBIGUOUS: f32 = 0.03;
/// Pixels from the best place from which on a place is another.
const ELSEWHERE: i32 = 3;
/// Steps of the refinement, and the step in pixels that ends it.
const STEPS: usize = 12;
const SETTLED_PX: f32 = 0.01;
/// A refinement that goes farther than this many pixels is lost.
const LOST_PX: f32 = 3.0;

/// Shift and roll of a whole picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whole {
    /// From the middle, in long sides.
    shift: Vec2,
    /// Radians.
    roll: f32,
    /// How alike both are then, −1 … 1.
    pub alike: f32,
}

impl Whole {
    /// Where a place, from the middle in long sides, comes to lie.
    fn brings(&self, at: Vec2) -> Vec2 {
        Vec2::from_angle(self.roll).rotate(at) + self.shift
    }
}

/// For each corner of the finest level, where it lies in the other frame's finest level.
pub fn track(from: &Pyramid, to: &Pyramid, corners: &[[f32; 2]]) -> Vec<Option<[f32; 2]>> {
    let whole = whole(from, to);
    corners.par_iter().map(|at| one(from, to, Vec2::from(*at), &whole)).collect()
}

/// The movement of the whole picture that makes both most alike.
pub fn whole(from: &Pyramid, to: &Pyramid) -> Whole {
    let level = from.near(WHOLE).min(to.levels().len() - 1);
    let (a, b) = (&from.levels()[level], &to.levels()[level]);
    let reach = (WHOLE_REACH * long(a)) as i32;
    let tries: Vec<(f32, i32)> = ROLLS.iter().flat_map(|r| (-reach..=reach).map(move |dy| (*r, dy))).collect();
    let best = |(roll, dy): &(f32, i32)| {
        let roll = roll * PI / 180.0;
        let row = (-reach..=reach).map(|dx| {
            let shift = Vec2::new(dx as f32, *dy as f32) / long(a);
            Whole { shift, roll, alike: overlap(a, b, &Whole { shift, roll, alike: 0.0 }) }
        });
        row.max_by(|a, b| a.alike.total_cmp(&b.alike))
    };
    let none = Whole { shift: Vec2::ZERO, roll: 0.0, alike: -1.0 };
    tries.par_iter().filter_map(best).reduce(|| none, |a, b| if b.alike > a.alike { b } else { a })
}

/// Correlation of what two pictures share; less for little of it.
fn overlap(a: &Raster<f32>, b: &Raster<f32>, whole: &Whole) -> f32 {
    let ([w, h], [bw, bh]) = (a.sides(), b.sides());
    let (middle, other) = (Vec2::new(w as f32, h as f32) / 2.0, Vec2::new(bw as f32, bh as f32) / 2.0);
    let mut sums = Sums::default();
    for y in (0..h).step_by(2) {
        for x in (0..w).step_by(2) {
            let at = (Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - middle) / long(a);
            // What lies inside is cut down to its pixel below, as fast as that goes.
            let to = whole.brings(at) * long(b) + other;
            if to.x >= 0.0 && to.y >= 0.0 && to.x < bw as f32 && to.y < bh as f32 {
                sums.add(a.at(x, y), b.at(to.x as usize, to.y as usize));
            }
        }
    }
    let share = sums.count / (w.div_ceil(2) * h.div_ceil(2)) as f32;
    if share < 0.4 { -1.0 } else { sums.correlation() * share.powf(0.25) }
}

fn long(picture: &Raster<f32>) -> f32 {
    picture.size()[0].max(picture.size()[1]) as f32
}

/// What the correlation of two patches is made of.
#[derive(Clone, Copy, Default)]
struct Sums {
    count: f32,
    a: f32,
    b: f32,
    aa: f32,
    ab: f32,
    bb: f32,
}

impl Sums {
    #[inline]
    fn add(&mut self, a: f32, b: f32) {
        self.count += 1.0;
        (self.a, self.b) = (self.a + a, self.b + b);
        (self.aa, self.ab, self.bb) = (self.aa + a * a, self.ab + a * b, self.bb + b * b);
    }

    fn correlation(&self) -> f32 {
        let of = |ab: f32, a: f32, b: f32| ab - a * b / self.count;
        let spreads = of(self.aa, self.a, self.a) * of(self.bb, self.b, self.b);
        if spreads > 1e-9 { of(self.ab, self.a, self.b) / spreads.sqrt() } else { 0.0 }
    }
}

fn one(from: &Pyramid, to: &Pyramid, at: Vec2, whole: &Whole) -> Option<[f32; 2]> {
    let finest = from.finest();
    let middle = |p: &Raster<f32>| Vec2::new(p.size()[0] as f32, p.size()[1] as f32) / 2.0 - 0.5;
    let level = from.near(SEARCH).min(to.levels().len() - 1);
    let (a, b) = (&from.levels()[level], &to.levels()[level]);
    let place = (at - middle(finest)) / long(finest);
    let start = whole.brings(place) * long(b) + middle(b);
    let mut found = search(a, b, place * long(a) + middle(a), start, whole.roll)?;
    let mut now = (found - middle(b)) / long(b);
    for level in (0..=level).rev() {
        let (a, b) = (&from.levels()[level], &to.levels()[level]);
        found = refine(a, b, place * long(a) + middle(a), now * long(b) + middle(b), whole.roll)?;
        now = (found - middle(b)) / long(b);
    }
    Some(found.to_array())
}

/// The place around `start` whose patch is most like that at `at`, where no other place is as much.
fn search(a: &Raster<f32>, b: &Raster<f32>, at: Vec2, start: Vec2, roll: f32) -> Option<Vec2> {
    let half = HALF[0];
    let turn = Vec2::from_angle(-roll);
    // The reference's patch, turned as the other frame is.
    let steps = || (-half..=half).flat_map(move |dy| (-half..=half).map(move |dx| (dx, dy)));
    let of = |(dx, dy): (i32, i32)| at + turn.rotate(Vec2::new(dx as f32, dy as f32));
    let patch: Vec<f32> = steps().map(of).map(|p| a.tap(p.x, p.y)).collect();
    let mean = patch.iter().sum::<f32>() / patch.len() as f32;
    let patch: Vec<f32> = patch.iter().map(|v| v - mean).collect();
    let spread = patch.iter().map(|v| v * v).sum::<f32>();
    if spread < 1e-5 * patch.len() as f32 {
        return None;
    }
    let [w, h] = b.sides().map(|side| side as i32);
    let (cx, cy) = (start.x.round() as i32, start.y.round() as i32);
    let inside = |c: i32, n: i32| (c - SEARCH_PX).max(half)..=(c + SEARCH_PX).min(n - 1 - half);
    let side = (2 * half + 1) as usize;
    let score = |x: i32, y: i32| {
        let (mut sum, mut squares, mut product) = (0.0, 0.0, 0.0);
        for (row, weights) in patch.chunks_exact(side).enumerate() {
            let first = ((y - half) as usize + row) * w as usize + (x - half) as usize;
            for (v, weight) in b.pixels()[first..first + side].iter().zip(weights) {
                (sum, squares, product) = (sum + v, squares + v * v, product + v * weight);
            }
        }
        let other = squares - sum * sum / patch.len() as f32;
        if other > 1e-6 { product / (spread * other).sqrt() } else { 0.0 }
    };
    let all: Vec<(f32, i32, i32)> =
        inside(cy, h).flat_map(|y| inside(cx, w).map(move |x| (x, y))).map(|(x, y)| (score(x, y), x, y)).collect();
    let best = all.iter().copied().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let is_other = |o: &&(f32, i32, i32)| (o.1 - best.1).abs().max((o.2 - best.2).abs()) > ELSEWHERE;
    let second = all.iter().filter(is_other).map(|o| o.0).fold(-1.0, f32::max);
    (best.0 > ALIKE[0] && best.0 - second > AMBIGUOUS).then(|| Vec2::new(best.1 as f32, best.2 as f32))
}

/// Brings a patch to a fraction of a pixel over its like.
fn refine(a: &Raster<f32>, b: &Raster<f32>, at: Vec2, start: Vec2, roll: f32) -> Option<Vec2> {
    const SIDE: usize = 2 * HALF[1] as usize + 1;
    let turn = Vec2::from_angle(-roll);
    let half = HALF[1];
    let steps = || (-half..=half).flat_map(move |dy| (-half..=half).map(move |dx| Vec2::new(dx as f32, dy as f32)));
    let patch: Vec<f32> = steps().map(|step| at + turn.rotate(step)).map(|p| a.tap(p.x, p.y)).collect();
    let (mean, deviation) = moments(&patch)?;
    let patch: Vec<f32> = patch.iter().map(|v| (v - mean) / deviation).collect();
    let mut now = start;
    let mut there = vec![0.0; SIDE * SIDE];
    for _ in 0..STEPS {
        there.iter_mut().zip(steps()).for_each(|(v, step)| *v = b.tap(now.x + step.x, now.y + step.y));
        let (mean, deviation) = moments(&there)?;
        let (mut gxx, mut gxy, mut gyy, mut ex, mut ey) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for y in 1..SIDE - 1 {
            for x in 1..SIDE - 1 {
                let i = y * SIDE + x;
                let dx = (there[i + 1] - there[i - 1]) / (2.0 * deviation);
                let dy = (there[i + SIDE] - there[i - SIDE]) / (2.0 * deviation);
                let error = patch[i] - (there[i] - mean) / deviation;
                (gxx, gxy, gyy) = (gxx + dx * dx, gxy + dx * dy, gyy + dy * dy);
                (ex, ey) = (ex + dx * error, ey + dy * error);
            }
        }
        let det = gxx * gyy - gxy * gxy;
        if det < 1e-6 {
            return None;
        }
        let step = Vec2::new(gyy * ex - gxy * ey, gxx * ey - gxy * ex) / det;
        now += step.clamp_length_max(1.0);
        if now.distance(start) > LOST_PX {
            return None;
        }
        if step.length() < SETTLED_PX {
            break;
        }
    }
    there.iter_mut().zip(steps()).for_each(|(v, step)| *v = b.tap(now.x + step.x, now.y + step.y));
    let (mean, deviation) = moments(&there)?;
    let alike = patch.iter().zip(&there).map(|(a, b)| a * (b - mean) / deviation).sum::<f32>() / patch.len() as f32;
    let [w, h] = b.sides();
    let inside = now.x > 1.0 && now.y > 1.0 && now.x < w as f32 - 2.0 && now.y < h as f32 - 2.0;
    (alike > ALIKE[1] && inside).then_some(now)
}

/// Mean and standard deviation; none of what is even.
fn moments(values: &[f32]) -> Option<(f32, f32)> {
    let count = values.len() as f32;
    let mean = values.iter().sum::<f32>() / count;
    let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / count).sqrt();
    (deviation > 2e-3).then_some((mean, deviation))
}
