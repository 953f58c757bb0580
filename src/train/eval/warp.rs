//! A view from the reference view and a disparity: `L_r(x, u) = L(x + u·D(x, u), 0)` (paper, §3).

use super::Rgb;
use crate::scenes::raster::Raster;

/// The view `(du, dv)` steps away, its ray depths given at its own pixels (`[y, x]`, pixels per view step).
pub fn lambertian(reference: &Rgb, disparity_px: &[f32], du: f32, dv: f32) -> Rgb {
    affine(reference, disparity_px, [du, dv], [1.0, 0.0])
}

/// The same with `a·D + b` for D.
pub fn affine(reference: &Rgb, disparity_px: &[f32], [du, dv]: [f32; 2], [a, b]: [f32; 2]) -> Rgb {
    let width = reference.size[0];
    let mut px = Vec::with_capacity(reference.px.len());
    for (y, row) in disparity_px.chunks_exact(width).enumerate() {
        px.extend(row.iter().enumerate().map(|(x, d)| {
            let d = a * d + b;
            reference.tap(x as f32 + du * d, y as f32 + dv * d)
        }));
    }
    Raster { size: reference.size, px }
}

/// The view that a plane of one disparity gives.
pub fn plane(reference: &Rgb, disparity_px: f32, du: f32, dv: f32) -> Rgb {
    Raster::from_fn(reference.size, |x, y| reference.tap(x as f32 + du * disparity_px, y as f32 + dv * disparity_px))
}
