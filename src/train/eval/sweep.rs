//! Plane sweep over true views: the best that one disparity per pixel can do, and depth to compare with.
//!
//! The planes, windows and views are those of our evaluation protocol; figures from elsewhere agree only if these do.

use rayon::prelude::*;

use super::{OUTER_STEPS, Rgb, TrueField, warp};
use crate::scenes::steps;

/// Planes of the picture sweep, −2 … 2 by 0.05 px per view step.
fn picture_planes() -> impl Iterator<Item = f32> {
    (-40..=40).map(|i| i as f32 * 0.05)
}

/// Planes of the depth sweep, −1.5 … 1.5 by 0.05.
fn depth_planes() -> impl Iterator<Item = f32> {
    (-30..=30).map(|i| i as f32 * 0.05)
}

/// Mean absolute difference of channels, `[y, x]`.
fn difference(a: &Rgb, b: &Rgb) -> Vec<f32> {
    a.px.iter().zip(&b.px).map(|(p, q)| (0..3).map(|c| (p[c] - q[c]).abs()).sum::<f32>() / 3.0).collect()
}

/// Mean over 7 × 7 pixels; at the border over those that there are.
pub fn box_7(values: &[f32], size: [usize; 2]) -> Vec<f32> {
    let [w, h] = size;
    let mut rows = vec![0.0; w * h];
    for (source, out) in values.chunks_exact(w).zip(rows.chunks_exact_mut(w)) {
        window_means(|i| source[i], w, |i, mean| out[i] = mean);
    }
    let mut out = vec![0.0; w * h];
    for x in 0..w {
        window_means(|y| rows[y * w + x], h, |y, mean| out[y * w + x] = mean);
    }
    out
}

fn window_means(at: impl Fn(usize) -> f32, len: usize, mut put: impl FnMut(usize, f32)) {
    let (mut sum, mut from, mut to) = (0.0, 0, 0);
    for i in 0..len {
        while to < (i + 4).min(len) {
            sum += at(to);
            to += 1;
        }
        while from + 3 < i {
            sum -= at(from);
            from += 1;
        }
        put(i, sum / (to - from) as f32);
    }
}

/// The view made of each pixel's best plane: least difference from the true view, averaged over 7 × 7.
pub fn picture(field: &TrueField, layer: usize) -> Rgb {
    let (reference, truth) = (field.reference(), &field.views[layer]);
    let (du, dv) = steps(layer);
    let mut best = reference.clone();
    let mut least = vec![f32::INFINITY; best.px.len()];
    for plane in picture_planes() {
        let view = warp::plane(reference, plane, du, dv);
        let cost = box_7(&difference(&view, truth), truth.size);
        for (i, cost) in cost.into_iter().enumerate() {
            if cost < least[i] {
                (least[i], best.px[i]) = (cost, view.px[i]);
            }
        }
    }
    best
}

/// Depth of the reference view, swept over 16 views.
pub struct Swept {
    /// `[y, x]`, pixels per view step.
    pub disparity_px: Vec<f32>,
    /// Where the views tell: the largest and the least cost differ by more than 0.02.
    pub known: Vec<bool>,
}

/// The plane of each pixel of the reference view with the least mean difference over the views v, u ∈ {0, 2, 5, 7}.
pub fn reference_depth(field: &TrueField) -> Swept {
    let reference = field.reference();
    let layers: Vec<usize> = OUTER_STEPS.iter().flat_map(|v| OUTER_STEPS.iter().map(move |u| v * 8 + u)).collect();
    let costs: Vec<(f32, Vec<f32>)> = depth_planes()
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|plane| {
            let mut sum = vec![0.0f32; reference.px.len()];
            for &layer in &layers {
                let (du, dv) = steps(layer);
                // The reference's point x lies in the view at x − u·D.
                let seen = warp::plane(&field.views[layer], -plane, du, dv);
                sum.iter_mut().zip(difference(&seen, reference)).for_each(|(sum, d)| *sum += d / 16.0);
            }
            (plane, box_7(&sum, reference.size))
        })
        .collect();
    let range = |i: usize| {
        costs.iter().fold((f32::INFINITY, f32::NEG_INFINITY, 0.0), |(least, most, best), (plane, cost)| {
            let c = cost[i];
            (least.min(c), most.max(c), if c < least { *plane } else { best })
        })
    };
    let all: Vec<_> = (0..reference.px.len()).map(range).collect();
    Swept {
        disparity_px: all.iter().map(|(_, _, plane)| *plane).collect(),
        known: all.iter().map(|(least, most, _)| most - least > 0.02).collect(),
    }
}
