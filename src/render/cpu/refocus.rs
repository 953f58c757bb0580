//! Refocus at light-field size: shift and add (paper, §1; sign and light as in [`crate::field`]). Twin of `refocus.wgsl`.

use glam::Vec2;

use super::{nearest, tap};
use crate::field::{Lens, LightField, RayDepths, View, ViewPoint};
use crate::render::{Picture, aperture};

/// Pieces of a tap that is strewn, along each axis.
pub(crate) const STREWN_PIECES: u32 = 2;

/// The picture that a lens around a viewpoint sees, at light-field size, in linear light.
///
/// `picture[x] = Σ_u w(u) · L_u(x − (u − c)·D_f)` with `c` the viewpoint and `w` the [shares](aperture::taps).
pub fn refocus(field: &LightField, lens: &Lens, center: ViewPoint) -> Picture {
    refocus_with_depths(field, None, lens, center)
}

/// As [`refocus`]; with ray depths, what [`Lens::keep_sharp_px`] names stays sharp around the focal plane too.
pub fn refocus_with_depths(field: &LightField, depths: Option<&RayDepths>, lens: &Lens, center: ViewPoint) -> Picture {
    gather(field, depths, lens, center, false)
}

/// As [`refocus_with_depths`], each view's light strewn over the step around it: what eyes there would see, by the view's
/// own ray depths. Where views are far apart, a little grain takes the place of copies beside each other.
pub fn refocus_strewn(field: &LightField, depths: &RayDepths, lens: &Lens, center: ViewPoint) -> Picture {
    gather(field, Some(depths), lens, center, depths.size() == field.size() && depths.grid() == field.grid())
}

fn gather(field: &LightField, depths: Option<&RayDepths>, lens: &Lens, center: ViewPoint, is_strewn: bool) -> Picture {
    let grid = field.grid();
    let taps = aperture::taps(lens, grid, center, |_| true);
    let depths = depths.filter(|d| d.size() == field.size());
    let map = depths.map(|d| d.view(grid.nearest(center.0)));
    let maps = depths.filter(|_| is_strewn);
    let [w, h] = field.size();
    Picture::from_fn(field.size(), |x, y| {
        let (nx, ny) = ((x as f32 + 0.5) / w as f32, (y as f32 + 0.5) / h as f32);
        let mut focus = lens.focus.at(nx, ny);
        if let Some(map) = map {
            let away = nearest(map, [w, h], x as f32, y as f32) - focus;
            focus += away.clamp(lens.keep_sharp_px[0].min(0.0), lens.keep_sharp_px[1].max(0.0));
        }
        let seed = seed(x, y);
        let mut sum = [0.0; 3];
        for (i, part) in (0..).zip(&taps) {
            let place = Vec2::new(x as f32, y as f32) - part.offset * focus;
            let view = field.view(part.view);
            let color = match maps {
                Some(maps) => {
                    let reach = nearest(maps.view(part.view), [w, h], place.x, place.y) - focus;
                    tap_around(view, place, reach, strewn(seed, i))
                }
                None => tap(view, place.x, place.y),
            };
            (0..3).for_each(|i| sum[i] += color[i] * part.weight);
        }
        sum
    })
}

/// The mean of what eyes beside a view see: the same things, displaced by their disparity.
fn tap_around(view: &View, place: Vec2, reach: f32, at: Vec2) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for i in 0..STREWN_PIECES * STREWN_PIECES {
        let piece = Vec2::new((i % STREWN_PIECES) as f32, (i / STREWN_PIECES) as f32);
        let there = place + ((piece + at) / STREWN_PIECES as f32 - 0.5) * reach;
        let color = tap(view, there.x, there.y);
        (0..3).for_each(|i| sum[i] += color[i]);
    }
    sum.map(|light| light / (STREWN_PIECES * STREWN_PIECES) as f32)
}

/// A number that looks random (PCG).
fn scramble(v: u32) -> u32 {
    let state = v.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

fn seed(x: u32, y: u32) -> [u32; 2] {
    let first = scramble(x.wrapping_add(scramble(y)));
    [first, scramble(first)]
}

/// The nth place of a pixel's sequence in a square of side 1, evenly spread over it: the golden ratio's in two dimensions.
fn strewn(seed: [u32; 2], n: u32) -> Vec2 {
    let at = |axis: usize, step: u32| (seed[axis].wrapping_add(step.wrapping_mul(n)) >> 8) as f32 / 16_777_216.0;
    Vec2::new(at(0, 3_242_174_889), at(1, 2_447_445_415))
}
