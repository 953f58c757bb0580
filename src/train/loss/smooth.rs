//! The regularisers ψ_c and ψ_tv.

use rayon::prelude::*;

use super::{Maps, sign};
use crate::nets::SIDE;
use crate::warp::{sample, tap, weights};

/// Depth consistency ψ_c = mean |D(x, u) − D(x + D(x, u), u − 1)| (paper, §4.1), over each pair of given views that are
/// neighbours in u, in v, or in both; the sum of the pairs' means over their number.
pub fn consistency(maps: &Maps, depth: &[f32], weight: f32, gradient: &mut [f32]) -> f32 {
    let pairs = neighbours(&maps.views);
    let per_sample = maps.views.len() * maps.plane();
    let n = (maps.samples * pairs.len().max(1) * maps.plane()) as f32;
    let sums: Vec<f64> = (depth.par_chunks(per_sample), gradient.par_chunks_mut(per_sample))
        .into_par_iter()
        .map(|(d, g)| pairs.iter().map(|pair| pair_consistency(maps, d, pair, weight / n, g)).sum())
        .collect();
    (sums.iter().sum::<f64>() / f64::from(n)) as f32
}

/// Two neighbouring views: places of the view and of the one before it, and the step between them.
struct Pair {
    view: usize,
    before: usize,
    du: f32,
    dv: f32,
}

fn neighbours(views: &[usize]) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for (i, &a) in views.iter().enumerate() {
        for (j, &b) in views.iter().enumerate() {
            let du = (a % SIDE) as isize - (b % SIDE) as isize;
            let dv = (a / SIDE) as isize - (b / SIDE) as isize;
            if matches!((du, dv), (1, 0) | (0, 1) | (1, 1)) {
                pairs.push(Pair { view: i, before: j, du: du as f32, dv: dv as f32 });
            }
        }
    }
    pairs
}

fn pair_consistency(maps: &Maps, depth: &[f32], pair: &Pair, k: f32, gradient: &mut [f32]) -> f64 {
    let (w, p) = (maps.width, maps.plane());
    let (here, there) = (pair.view * p, pair.before * p);
    let mut sum = 0.0f64;
    for i in 0..p {
        let d = depth[here + i];
        let (tx, ty) = (tap((i % w) as f32 + pair.du * d, w), tap((i / w) as f32 + pair.dv * d, maps.height));
        let (value, dx, dy) = sample(&depth[there..there + p], w, tx, ty);
        let r = d - value;
        sum += f64::from(r.abs());
        let s = k * sign(r);
        gradient[here + i] += s * (1.0 - dx * pair.du - dy * pair.dv);
        for (at, weight) in weights(w, tx, ty) {
            gradient[there + at] -= s * weight;
        }
    }
    sum
}

/// Total variation ψ_tv = mean |∇ₓD| (paper, §4.1): mean |difference to the right| + mean |difference downwards|.
pub fn total_variation(maps: &Maps, depth: &[f32], weight: f32, gradient: &mut [f32]) -> f32 {
    let (w, h, p) = (maps.width, maps.height, maps.plane());
    let across = (maps.count() * (w - 1) * h).max(1) as f32;
    let down = (maps.count() * w * (h - 1)).max(1) as f32;
    let sums: Vec<f64> = (depth.par_chunks(p), gradient.par_chunks_mut(p))
        .into_par_iter()
        .map(|(d, g)| {
            let mut sum = 0.0f64;
            let mut pair = |i: usize, j: usize, n: f32| {
                let r = d[j] - d[i];
                sum += f64::from(r.abs() / n);
                g[j] += weight / n * sign(r);
                g[i] -= weight / n * sign(r);
            };
            for i in 0..p {
                if i % w + 1 < w {
                    pair(i, i + 1, across);
                }
                if i + w < p {
                    pair(i, i + w, down);
                }
            }
            sum
        })
        .collect();
    sums.iter().sum::<f64>() as f32
}
