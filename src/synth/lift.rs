//! From the disparity of the reference view to that of every ray.
//!
//! A ray of view u at pixel x meets the surface whose disparity d solves `d = D(x + u·d)`, with `D` the reference
//! map (conventions in `field`). Where several do, the nearest hides the others; where none does, the ray looks past
//! an edge at what the reference view cannot see, and the far side of that edge goes on.

use rayon::prelude::*;

use crate::field::{DisparityMap, RayDepths, ViewGrid, ViewOffset, between, corners};
use crate::job::{Cancelled, Job, Stage};

/// A difference between neighbours beyond which they belong to different surfaces, in px per view step.
pub(super) const STEP_PX: f32 = 0.2;
/// Fixed-point steps at most, and the change in px that ends them.
const STEPS: usize = 12;
const SETTLED_PX: f32 = 5e-4;
/// Marks a ray without a solution.
const HOLE: f32 = f32::NEG_INFINITY;

/// The ray depths of all views of a grid from those of its reference view.
pub fn ray_depths(reference: &DisparityMap, grid: ViewGrid) -> RayDepths {
    let cancel = crate::job::Cancel::default();
    lifted(reference, grid, &Job { cancel: &cancel, sink: &() }).unwrap_or_else(|Cancelled| flat(reference, grid))
}

/// The same with progress and cancel.
pub fn lifted(reference: &DisparityMap, grid: ViewGrid, job: &Job) -> Result<RayDepths, Cancelled> {
    let plane = reference.disparity_px().len();
    let mut all = vec![0.0; plane * grid.count()];
    all.par_chunks_mut(plane).enumerate().try_for_each(|(layer, out)| {
        let offset = grid.offset(grid.view_from_layer(layer));
        lift_view(reference, offset, out);
        job.check()
    })?;
    job.advance(Stage::Depth, 1, 1)?;
    Ok(RayDepths::new(grid, reference.size(), all).unwrap_or_else(|_| flat(reference, grid)))
}

fn flat(reference: &DisparityMap, grid: ViewGrid) -> RayDepths {
    let all = (0..grid.count()).flat_map(|_| reference.disparity_px().iter().copied()).collect();
    RayDepths::new(grid, reference.size(), all).expect("a map repeated for each view has the length of the grid")
}

/// The map of one view, written to `out`.
pub(super) fn lift_view(reference: &DisparityMap, from: ViewOffset, out: &mut [f32]) {
    if from == ViewOffset::default() {
        return out.copy_from_slice(reference.disparity_px());
    }
    let map = Map::new(reference);
    let starts = splat(&map, from);
    for y in 0..map.h {
        for x in 0..map.w {
            out[y * map.w + x] = solve(&map, &starts, from, x, y);
        }
    }
    fill_holes(out, map.d, [map.w, map.h], from);
}

struct Map<'a> {
    w: usize,
    h: usize,
    d: &'a [f32],
}

impl<'a> Map<'a> {
    fn new(map: &'a DisparityMap) -> Self {
        Self { w: map.size()[0] as usize, h: map.size()[1] as usize, d: map.disparity_px() }
    }

    /// Disparity between pixels: bilinear on a surface, the nearest pixel's where an edge runs between them.
    fn tap(&self, x: f32, y: f32) -> f32 {
        let (corners, shares) = corners([self.w, self.h], x, y);
        let [a, b, c, d] = corners.map(|i| self.d[i]);
        if a.max(b).max(c.max(d)) - a.min(b).min(c.min(d)) > STEP_PX {
            let [left, up] = shares.map(|share| share < 0.5);
            return match (left, up) {
                (true, true) => a,
                (false, true) => b,
                (true, false) => c,
                (false, false) => d,
            };
        }
        between([a, b, c, d], shares)
    }
}

/// Carries each reference pixel to where the view sees it; the nearest stays.
fn splat(map: &Map, from: ViewOffset) -> Vec<f32> {
    let mut starts = vec![HOLE; map.d.len()];
    for y in 0..map.h {
        for x in 0..map.w {
            let d = map.d[y * map.w + x];
            let (tx, ty) = ((x as f32 - from.du * d).round(), (y as f32 - from.dv * d).round());
            if tx >= 0.0 && ty >= 0.0 && tx < map.w as f32 && ty < map.h as f32 {
                let start = &mut starts[ty as usize * map.w + tx as usize];
                *start = start.max(d);
            }
        }
    }
    starts
}

/// The nearest solution of `d = D(x + u·d)` that starts from what was carried here or next to here.
fn solve(map: &Map, starts: &[f32], from: ViewOffset, x: usize, y: usize) -> f32 {
    let own = starts[y * map.w + x];
    let mut nearest = own;
    for y in y.saturating_sub(1)..(y + 2).min(map.h) {
        for start in &starts[y * map.w + x.saturating_sub(1)..y * map.w + (x + 2).min(map.w)] {
            nearest = if *start > nearest { *start } else { nearest };
        }
    }
    // On one surface all starts lead to the same solution, and its own is the nearest to it.
    let first = if nearest - own < STEP_PX { own } else { nearest };
    // A ray that leaves the reference picture was carried nowhere: the surface at the picture's edge goes on.
    let starts = [first, own, map.d[y * map.w + x]];
    starts.iter().find_map(|start| settle(map, from, *start, x, y)).unwrap_or(own)
}

/// Iterates `d ← D(x + u·d)` from a start; none where that leads to another surface.
fn settle(map: &Map, from: ViewOffset, start: f32, x: usize, y: usize) -> Option<f32> {
    if start == HOLE {
        return None;
    }
    let mut d = start;
    for _ in 0..STEPS {
        let next = map.tap(x as f32 + from.du * d, y as f32 + from.dv * d);
        if (next - d).abs() > STEP_PX {
            return None;
        }
        let change = (next - d).abs();
        d = next;
        if change < SETTLED_PX {
            break;
        }
    }
    Some(d)
}

/// Rays without a solution take the farther of the two surfaces that they lie between, seen along the view's offset.
fn fill_holes(out: &mut [f32], reference: &[f32], [w, h]: [usize; 2], from: ViewOffset) {
    let reach = from.du.abs().max(from.dv.abs());
    let (sx, sy) = (from.du / reach, from.dv / reach);
    let holes: Vec<usize> = (0..out.len()).filter(|i| out[*i] == HOLE).collect();
    let march = |i: usize, sign: f32| {
        let (mut x, mut y) = ((i % w) as f32, (i / w) as f32);
        loop {
            (x, y) = (x + sign * sx, y + sign * sy);
            let (cx, cy) = (x.round(), y.round());
            if cx < 0.0 || cy < 0.0 || cx >= w as f32 || cy >= h as f32 {
                return None;
            }
            let d = out[cy as usize * w + cx as usize];
            if d != HOLE {
                return Some(d);
            }
        }
    };
    let filled: Vec<f32> = holes
        .iter()
        .map(|i| match (march(*i, 1.0), march(*i, -1.0)) {
            (Some(a), Some(b)) => a.min(b),
            (Some(a), None) | (None, Some(a)) => a,
            (None, None) => reference[*i],
        })
        .collect();
    holes.iter().zip(filled).for_each(|(i, d)| out[*i] = d);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::ViewIndex;

    /// A near square before a far plane.
    fn two_planes(near: f32, far: f32) -> DisparityMap {
        let inside = |i: u32| (20..40).contains(&(i % 60)) && (15..35).contains(&(i / 60));
        DisparityMap::new([60, 50], (0..3000).map(|i| if inside(i) { near } else { far }).collect()).unwrap()
    }

    #[test]
    fn each_view_sees_the_near_square_where_the_sign_says_and_the_far_plane_elsewhere() {
        let (near, far) = (2.0, -1.0);
        let depths = ray_depths(&two_planes(near, far), ViewGrid::PAPER);
        for at in ViewGrid::PAPER.views() {
            let o = ViewGrid::PAPER.offset(at);
            for y in 0..50u32 {
                for x in 0..60u32 {
                    let (rx, ry) = (x as f32 + o.du * near, y as f32 + o.dv * near);
                    let inside = (20.0..40.0).contains(&rx) && (15.0..35.0).contains(&ry);
                    assert_eq!(depths.at(at, x, y), if inside { near } else { far }, "view {at:?} pixel {x},{y}");
                }
            }
        }
    }

    #[test]
    fn every_ray_of_a_slanted_plane_agrees_with_the_reference() {
        let slanted = |i: u32| (i % 60) as f32 * 0.05 - 1.5 + (i / 60) as f32 * 0.02;
        let reference = DisparityMap::new([60, 50], (0..3000).map(slanted).collect()).unwrap();
        let depths = ray_depths(&reference, ViewGrid::PAPER);
        let map = Map::new(&reference);
        for at in ViewGrid::PAPER.views() {
            let o = ViewGrid::PAPER.offset(at);
            for (y, x) in [(25, 30), (18, 22), (30, 40)] {
                let d = depths.at(at, x, y);
                let back = map.tap(x as f32 + o.du * d, y as f32 + o.dv * d);
                assert!((d - back).abs() < 1e-3, "view {at:?}: {d} leads to {back}");
            }
        }
    }

    #[test]
    fn one_pixel_and_one_view_are_fine() {
        let one = DisparityMap::constant([1, 1], 3.0);
        assert_eq!(ray_depths(&one, ViewGrid::PAPER).at(ViewIndex { v: 0, u: 7 }, 0, 0), 3.0);
        let grid = ViewGrid::new(1, 1).unwrap();
        assert_eq!(ray_depths(&one, grid).disparity_px(), [3.0]);
    }
}
