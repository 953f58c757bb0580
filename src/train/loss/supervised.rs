//! Losses against known ray depths. Unknown pixels are NaN in the truth and count nowhere.

use rayon::prelude::*;

use super::{Maps, sign};

/// Mean |D − D*| over the pixels whose truth is known; its gradient times `weight` is added to `gradient`.
pub fn supervised(depth: &[f32], truth: &[f32], weight: f32, gradient: &mut [f32]) -> f32 {
    let known = truth.par_iter().filter(|t| !t.is_nan()).count();
    if known == 0 {
        return 0.0;
    }
    let k = weight / known as f32;
    let sum: f64 = (depth.par_chunks(4096), truth.par_chunks(4096), gradient.par_chunks_mut(4096))
        .into_par_iter()
        .map(|(d, t, g)| {
            let mut sum = 0.0f64;
            for i in 0..d.len() {
                if !t[i].is_nan() {
                    let r = d[i] - t[i];
                    sum += f64::from(r.abs());
                    g[i] += k * sign(r);
                }
            }
            sum
        })
        .collect::<Vec<_>>()
        .into_iter()
        .sum();
    (sum / known as f64) as f32
}

/// Scale and shift of a prediction that bring it nearest to the truth in the least squares, scale kept in 0.2 … 4.
/// One pair for all maps of a sample.
pub fn affine_fit(depth: &[f32], truth: &[f32]) -> (f32, f32) {
    let known = || depth.iter().zip(truth).filter(|(_, t)| !t.is_nan()).map(|(d, t)| (f64::from(*d), f64::from(*t)));
    let n = known().count().max(1) as f64;
    let (sd, st) = known().fold((0.0, 0.0), |(a, b), (d, t)| (a + d, b + t));
    let (md, mt) = (sd / n, st / n);
    let (cov, var) = known().fold((0.0, 0.0), |(c, v), (d, t)| (c + (d - md) * (t - mt), v + (d - md) * (d - md)));
    let scale = (cov / n / (var / n).max(1e-4)).clamp(0.2, 4.0);
    (scale as f32, (mt - scale * md) as f32)
}

/// Distances in px over which gradients of the residual are compared.
const STRIDES: [usize; 4] = [1, 2, 4, 8];

/// How the prediction of a sample is brought to its truth.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// Scale and shift; constants.
    pub affine: (f32, f32),
    /// The share of the largest differences that counts nowhere: where another net made the map, they are its errors.
    pub trim: f32,
}

/// Affine-invariant loss of each sample, mean over samples: mean |s·D + t − D*| plus `edges` times the mean absolute
/// differences of that residual over 1, 2, 4 and 8 px in x and y. `fits` gives (s, t) of each sample.
pub fn affine(
    maps: &Maps,
    depth: &[f32],
    truth: &[f32],
    fits: &[Fit],
    edges: f32,
    weight: f32,
    gradient: &mut [f32],
) -> f32 {
    let per_sample = maps.views.len() * maps.plane();
    let n = maps.samples.max(1) as f32;
    let values: Vec<f32> =
        (depth.par_chunks(per_sample), truth.par_chunks(per_sample), gradient.par_chunks_mut(per_sample), fits)
            .into_par_iter()
            .map(|(d, t, g, &Fit { affine: (scale, shift), trim })| {
                let mut residual: Vec<f32> = d.iter().zip(t).map(|(d, t)| scale * d + shift - t).collect();
                trim_largest(&mut residual, trim);
                let mut back = vec![0.0; residual.len()];
                let mut loss = absolute(&residual, 1.0, &mut back);
                for stride in STRIDES {
                    for step in [(stride, 0), (0, stride)] {
                        loss += edges * differences(maps, &residual, step, edges, &mut back);
                    }
                }
                g.iter_mut().zip(&back).for_each(|(g, b)| *g += weight / n * scale * b);
                loss
            })
            .collect();
    values.iter().sum::<f32>() / n
}

/// Forgets this share of what is known, the largest first.
fn trim_largest(residual: &mut [f32], share: f32) {
    let mut sizes: Vec<f32> = residual.iter().filter(|r| !r.is_nan()).map(|r| r.abs()).collect();
    let kept = ((1.0 - share) * sizes.len() as f32) as usize;
    if share <= 0.0 || kept == 0 || kept >= sizes.len() {
        return;
    }
    let largest = *sizes.select_nth_unstable_by(kept, f32::total_cmp).1;
    residual.iter_mut().filter(|r| r.abs() >= largest).for_each(|r| *r = f32::NAN);
}

fn absolute(residual: &[f32], weight: f32, back: &mut [f32]) -> f32 {
    let known = residual.iter().filter(|r| !r.is_nan()).count().max(1) as f32;
    let mut sum = 0.0f64;
    for (r, b) in residual.iter().zip(back) {
        if !r.is_nan() {
            sum += f64::from(r.abs());
            *b += weight / known * sign(*r);
        }
    }
    (sum / f64::from(known)) as f32
}

/// Mean |r(x + step) − r(x)| over the pairs whose two ends are known.
fn differences(maps: &Maps, residual: &[f32], (dx, dy): (usize, usize), weight: f32, back: &mut [f32]) -> f32 {
    let (w, h) = (maps.width, maps.height);
    if dx >= w || dy >= h {
        return 0.0;
    }
    let k = weight / (maps.views.len() * (w - dx) * (h - dy)) as f32;
    let mut sum = 0.0f64;
    for map in 0..maps.views.len() {
        for y in 0..h - dy {
            let row = (map * h + y) * w;
            for i in row..row + w - dx {
                let j = i + dy * w + dx;
                let r = residual[j] - residual[i];
                if !r.is_nan() {
                    sum += f64::from(r.abs());
                    back[j] += k * sign(r);
                    back[i] -= k * sign(r);
                }
            }
        }
    }
    (sum / (maps.views.len() * (w - dx) * (h - dy)) as f64) as f32
}

/// What the row cannot explain: mean |r − r̄| with r = D − D* and r̄ its mean over the known pixels of its row.
/// A prediction that is right but for a shift of each row costs nothing here; a ramp that misses the subject does.
pub fn row_centred(maps: &Maps, depth: &[f32], truth: &[f32], weight: f32, gradient: &mut [f32]) -> f32 {
    let w = maps.width;
    let known = truth.par_iter().filter(|t| !t.is_nan()).count().max(1) as f32;
    let sums: Vec<f64> = (depth.par_chunks(w), truth.par_chunks(w), gradient.par_chunks_mut(w))
        .into_par_iter()
        .map(|(d, t, g)| {
            let residual: Vec<f32> = d.iter().zip(t).map(|(d, t)| d - t).collect();
            let there = residual.iter().filter(|r| !r.is_nan());
            let n = there.clone().count().max(1) as f32;
            let mean = there.clone().sum::<f32>() / n;
            let mean_sign = there.clone().map(|r| sign(r - mean)).sum::<f32>() / n;
            let mut sum = 0.0f64;
            for (r, g) in residual.iter().zip(g) {
                if !r.is_nan() {
                    sum += f64::from((r - mean).abs());
                    *g += weight / known * (sign(r - mean) - mean_sign);
                }
            }
            sum
        })
        .collect();
    (sums.iter().sum::<f64>() / f64::from(known)) as f32
}

/// Distances in px of the pairs of the ordinal loss.
const REACHES: [usize; 5] = [3, 6, 12, 24, 48];

/// Along which axis pairs of the ordinal loss lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Along {
    /// Pairs of one row: its height in the picture tells nothing about them, only what stands there does.
    Rows,
    /// Pairs of one column: ground, and what stands on it.
    Columns,
}

/// Order of pairs whose true ray depths differ by at least `apart` px of their sample: mean of max(0, margin − (D₁ − D₂)·sign(D₁* − D₂*))
/// with a margin of |D₁* − D₂*|, at most twice `apart`.
pub fn ordinal(
    maps: &Maps,
    depth: &[f32],
    truth: &[f32],
    along: Along,
    apart: &[f32],
    weight: f32,
    gradient: &mut [f32],
) -> f32 {
    let plane = maps.plane();
    let apart = |map: usize| apart[map / maps.views.len()];
    let far =
        |(map, t): (usize, &[f32])| pairs(maps, along).filter(|&(i, j)| (t[i] - t[j]).abs() >= apart(map)).count();
    let count = truth.par_chunks(plane).enumerate().map(far).sum::<usize>().max(1);
    let k = weight / count as f32;
    let sums: Vec<f64> = (depth.par_chunks(plane), truth.par_chunks(plane), gradient.par_chunks_mut(plane))
        .into_par_iter()
        .enumerate()
        .map(|(map, (d, t, g))| {
            let (mut sum, apart) = (0.0f64, apart(map));
            for (i, j) in pairs(maps, along) {
                let step = t[i] - t[j];
                // NaN steps (an end unknown) fail the comparison.
                if step.abs() >= apart {
                    let lack = step.abs().min(2.0 * apart) - (d[i] - d[j]) * sign(step);
                    if lack > 0.0 {
                        sum += f64::from(lack);
                        g[i] -= k * sign(step);
                        g[j] += k * sign(step);
                    }
                }
            }
            sum
        })
        .collect();
    (sums.iter().sum::<f64>() / count as f64) as f32
}

/// Pixels of a map and those that lie [`REACHES`] to the left of them or above.
fn pairs(maps: &Maps, along: Along) -> impl Iterator<Item = (usize, usize)> {
    let (plane, w) = (maps.plane(), maps.width);
    REACHES.into_iter().flat_map(move |reach| {
        let (back, first) = if along == Along::Rows { (reach, reach) } else { (reach * w, 0) };
        (back..plane).filter(move |i| i % w >= first).map(move |i| (i, i - back))
    })
}
