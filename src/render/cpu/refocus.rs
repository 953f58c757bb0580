//! Refocus at light-field size: shift and add (paper, §1; sign and light as in [`crate::field`]). Twin of `refocus.wgsl`.

use super::{nearest, tap};
use crate::field::{Lens, LightField, RayDepths, ViewPoint};
use crate::render::{Picture, aperture};

/// The picture that a lens around a viewpoint sees, at light-field size, in linear light.
///
/// `picture[x] = Σ_u w(u) · L_u(x − (u − c)·D_f)` with `c` the viewpoint and `w` the [shares](aperture::taps).
pub fn refocus(field: &LightField, lens: &Lens, center: ViewPoint) -> Picture {
    refocus_with_depths(field, None, lens, center)
}

/// As [`refocus`]; with ray depths, what [`Lens::keep_sharp_px`] names stays sharp around the focal plane too.
pub fn refocus_with_depths(field: &LightField, depths: Option<&RayDepths>, lens: &Lens, center: ViewPoint) -> Picture {
    let grid = field.grid();
    let taps = aperture::taps(lens, grid, center, |_| true);
    let map = depths.filter(|d| d.size() == field.size()).map(|d| d.view(grid.nearest(center.0)));
    let [w, h] = field.size();
    Picture::from_fn(field.size(), |x, y| {
        let (nx, ny) = ((x as f32 + 0.5) / w as f32, (y as f32 + 0.5) / h as f32);
        let mut focus = lens.focus.at(nx, ny);
        if let Some(map) = map {
            let away = nearest(map, [w, h], x as f32, y as f32) - focus;
            focus += away.clamp(lens.keep_sharp_px[0].min(0.0), lens.keep_sharp_px[1].max(0.0));
        }
        let mut sum = [0.0; 3];
        for part in &taps {
            let place = glam::Vec2::new(x as f32, y as f32) - part.offset * focus;
            let color = tap(field.view(part.view), place.x, place.y);
            (0..3).for_each(|i| sum[i] += color[i] * part.weight);
        }
        sum
    })
}
