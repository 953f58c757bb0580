//! ‖L_r − L‖₁: the Lambertian views against the true ones.

use rayon::prelude::*;

use super::{Maps, sign};
use crate::nets::zeros;
use crate::scenes::steps;
use crate::warp::{sample, tap};

/// Mean |L_r(x, u) − L(x, u)| over all given views, colours and pixels, with L_r(x, u) = L(x + u·D(x, u), 0)
/// (paper, §4.2 and eq. of the training loss).
///
/// # Shapes
/// - `photos`: the reference views `[n, 3, h, w]`
/// - `views`: the true views `[n, v, 3, h, w]`
/// - `depth`, `gradient`: `[n, v, h, w]`
pub fn photometric(
    maps: &Maps,
    photos: &[f32],
    views: &[f32],
    depth: &[f32],
    weight: f32,
    gradient: &mut [f32],
) -> f32 {
    let (w, h, p, nv) = (maps.width, maps.height, maps.plane(), maps.views.len());
    let k = weight / (3 * maps.len()) as f32;
    let sums: Vec<f64> = (depth.par_chunks(p), views.par_chunks(3 * p), gradient.par_chunks_mut(p))
        .into_par_iter()
        .enumerate()
        .map(|(map, (d, view, g))| {
            let photo = maps.photo(photos, map);
            let (du, dv) = steps(maps.views[map % nv]);
            let mut sum = 0.0f64;
            for y in 0..h {
                for x in 0..w {
                    let i = y * w + x;
                    let (tx, ty) = (tap(x as f32 + du * d[i], w), tap(y as f32 + dv * d[i], h));
                    for c in 0..3 {
                        let (value, dx, dy) = sample(&photo[c * p..][..p], w, tx, ty);
                        let r = value - view[c * p + i];
                        sum += f64::from(r.abs());
                        g[i] += k * sign(r) * (dx * du + dy * dv);
                    }
                }
            }
            sum
        })
        .collect();
    (sums.iter().sum::<f64>() / (3 * maps.len()) as f64) as f32
}

/// The Lambertian views L_r(x, u) = L(x + u·D(x, u), 0): `[n, v, 3, h, w]`.
pub fn rendered_views(maps: &Maps, photos: &[f32], depth: &[f32]) -> Vec<f32> {
    let (w, h, p, nv) = (maps.width, maps.height, maps.plane(), maps.views.len());
    let mut out = zeros(3 * maps.len());
    (out.par_chunks_mut(3 * p), depth.par_chunks(p)).into_par_iter().enumerate().for_each(|(map, (out, d))| {
        let photo = maps.photo(photos, map);
        let (du, dv) = steps(maps.views[map % nv]);
        for i in 0..p {
            let (tx, ty) = (tap((i % w) as f32 + du * d[i], w), tap((i / w) as f32 + dv * d[i], h));
            for c in 0..3 {
                out[c * p + i] = sample(&photo[c * p..][..p], w, tx, ty).0;
            }
        }
    });
    out
}

/// Adds to `gradient` `[n, v, h, w]` what a gradient with respect to the rendered views `[n, v, 3, h, w]` means for the
/// ray depths.
pub fn rendered_gradient(maps: &Maps, photos: &[f32], depth: &[f32], to_views: &[f32], gradient: &mut [f32]) {
    let (w, h, p, nv) = (maps.width, maps.height, maps.plane(), maps.views.len());
    let each = (depth.par_chunks(p), to_views.par_chunks(3 * p), gradient.par_chunks_mut(p));
    each.into_par_iter().enumerate().for_each(|(map, (d, to, g))| {
        let photo = maps.photo(photos, map);
        let (du, dv) = steps(maps.views[map % nv]);
        for i in 0..p {
            let (tx, ty) = (tap((i % w) as f32 + du * d[i], w), tap((i / w) as f32 + dv * d[i], h));
            for c in 0..3 {
                let (_, dx, dy) = sample(&photo[c * p..][..p], w, tx, ty);
                g[i] += to[c * p + i] * (dx * du + dy * dv);
            }
        }
    });
}
