//! ‖L̂ − L‖₁ of the paper's comparisons: views by appearance flow, and views regressed.

use rayon::prelude::*;

use super::{Maps, sign};
use crate::nets::zeros;
use crate::warp::{sample, tap};

/// Mean |L(x + f(x, u), 0) − L(x, u)| over views, colours and pixels, `f` being the flow of each ray (Zhou et al. 2016).
///
/// # Shapes
/// - `photos`: the reference views `[n, 3, h, w]`
/// - `views`: the true views `[n, v, 3, h, w]`
/// - `flow`, `gradient`: `[n, v, 2, h, w]`, px to the right, then px down
pub fn flowed(maps: &Maps, photos: &[f32], views: &[f32], flow: &[f32], weight: f32, gradient: &mut [f32]) -> f32 {
    let (w, h, p) = (maps.width, maps.height, maps.plane());
    let k = weight / (3 * maps.len()) as f32;
    let each = (flow.par_chunks(2 * p), views.par_chunks(3 * p), gradient.par_chunks_mut(2 * p)).into_par_iter();
    let of_views = each.enumerate().map(|(map, (flow, view, gradient))| {
        let photo = maps.photo(photos, map);
        let (right, down) = gradient.split_at_mut(p);
        let mut sum = 0.0f64;
        for i in 0..p {
            let (tx, ty) = (tap((i % w) as f32 + flow[i], w), tap((i / w) as f32 + flow[p + i], h));
            for c in 0..3 {
                let (value, dx, dy) = sample(&photo[c * p..][..p], w, tx, ty);
                let r = value - view[c * p + i];
                sum += f64::from(r.abs());
                right[i] += k * sign(r) * dx;
                down[i] += k * sign(r) * dy;
            }
        }
        sum
    });
    let sums: Vec<f64> = of_views.collect();
    (sums.iter().sum::<f64>() / (3 * maps.len()) as f64) as f32
}

/// The views that flow `[n, v, 2, h, w]` makes of the photos: `[n, v, 3, h, w]`.
pub fn flowed_views(maps: &Maps, photos: &[f32], flow: &[f32]) -> Vec<f32> {
    let (w, h, p) = (maps.width, maps.height, maps.plane());
    let mut out = zeros(3 * maps.len());
    (out.par_chunks_mut(3 * p), flow.par_chunks(2 * p)).into_par_iter().enumerate().for_each(|(map, (out, flow))| {
        let photo = maps.photo(photos, map);
        for i in 0..p {
            let (tx, ty) = (tap((i % w) as f32 + flow[i], w), tap((i / w) as f32 + flow[p + i], h));
            (0..3).for_each(|c| out[c * p + i] = sample(&photo[c * p..][..p], w, tx, ty).0);
        }
    });
    out
}

/// Mean |L(x, 0) + y(x, u) − L(x, u)| over views, colours and pixels: what is said is added to the photo.
///
/// # Shapes
/// - `photos`: the reference views `[n, 3, h, w]`, in 0 … 1
/// - `views`, `y`, `gradient`: `[n, v, 3, h, w]`
pub fn regressed(maps: &Maps, photos: &[f32], views: &[f32], y: &[f32], weight: f32, gradient: &mut [f32]) -> f32 {
    let p = maps.plane();
    let k = weight / y.len() as f32;
    let each = (y.par_chunks(3 * p), views.par_chunks(3 * p), gradient.par_chunks_mut(3 * p)).into_par_iter();
    let of_views = each.enumerate().map(|(map, (y, view, gradient))| {
        let photo = maps.photo(photos, map);
        let mut sum = 0.0f64;
        for i in 0..3 * p {
            let r = photo[i] + y[i] - view[i];
            sum += f64::from(r.abs());
            gradient[i] += k * sign(r);
        }
        sum
    });
    let sums: Vec<f64> = of_views.collect();
    (sums.iter().sum::<f64>() / y.len() as f64) as f32
}

/// The views in 0 … 1 that what is said makes of the photos: `[n, v, 3, h, w]`.
pub fn regressed_views(maps: &Maps, photos: &[f32], said: &[f32]) -> Vec<f32> {
    let p = maps.plane();
    let mut out = said.to_vec();
    out.par_chunks_mut(3 * p).enumerate().for_each(|(map, out)| {
        let photo = maps.photo(photos, map);
        out.iter_mut().zip(photo).for_each(|(out, photo)| *out = (*out + photo).clamp(0.0, 1.0));
    });
    out
}
