//! Rays that end behind what the photo sees: there the far side goes on.
//!
//! Lambertian rendering (paper, §3.2) gives such a ray the colour of what hides its end, and the occlusion net (§3.3), which
//! sees a few pixels, takes back a part of that. What is left of the near side's colours would show as a fringe beside it.

use glam::Vec4;

use super::lambertian::{encode, render_row};
use super::lift::STEP_PX;
use super::picture::Signed;
use crate::background::{self, Beside, Front, Hidden, SHARE};
use crate::field::{DisparityMap, FieldError, Raster, RayDepths, View, ViewGrid, ViewOffset, bilinear, ramp};

/// A surface is behind another when it is farther by this much, px per view step.
const APART_PX: f32 = 0.08;
/// The photo's surface hides a ray's end when it is nearer by the second of these, and does not by the first.
const HIDDEN_PX: [f32; 2] = [0.5 * STEP_PX, 1.5 * STEP_PX];
/// A ray that ends this far beside the photo, in pixels, shows what the photo does not.
const BESIDE_PX: f32 = 0.75;

/// What the photo sees, and what goes on behind it.
pub struct FarSide {
    /// Each place's own surface, and what is nearer beside it.
    front: Raster<(f32, Option<Beside>)>,
    behind: Raster<Hidden>,
}

impl FarSide {
    /// Of a photo with these ray depths.
    pub(super) fn new(photo: &Signed, depths: &RayDepths) -> Self {
        let (map, [width, _]) = (depths.reference(), photo.sides());
        let rgb = photo.pixels().iter().map(|p| p.truncate().to_array()).collect();
        let front = Front { size: photo.size(), rgb, disparity_px: map.to_vec() };
        let behind = background::behind(&front, APART_PX, |_, _| [0.0; 5]);
        let of = |i: usize| (map[i], Beside::of(map, photo.sides(), i, APART_PX));
        Self { front: Raster::par_from_fn(photo.size(), |x, y| of(y * width + x)), behind }
    }

    /// Of a view and its own disparity.
    ///
    /// # Errors
    /// None for a map of the view's size.
    pub fn of_view(view: &View, map: &DisparityMap) -> Result<Self, FieldError> {
        let depths = RayDepths::new(ViewGrid::new(1, 1)?, map.size(), map.disparity_px().to_vec())?;
        Ok(Self::new(&Signed::from_view(view), &depths))
    }

    /// One whole view from its ray depths, `[y, x]` of the photo's size.
    pub fn view(&self, photo: &Signed, disparity_px: &[f32], from: ViewOffset) -> Result<View, FieldError> {
        let [w, h] = photo.sides();
        let mut rgba = vec![255; w * h * 4];
        for (y, (row, d)) in rgba.chunks_exact_mut(w * 4).zip(disparity_px.chunks_exact(w)).enumerate() {
            render_row(photo, d, [0, y], from, |x, colour| {
                let colour = self.colour(colour, [x, y], from, d[x]);
                row[x * 4..x * 4 + 3].copy_from_slice(&encode(colour));
            });
        }
        View::new(photo.size(), rgba)
    }

    /// Whether a ray of disparity `d` ends where the photo does not see it, behind a nearer surface or beside the photo:
    /// 0 seen … 1.
    pub fn unseen(&self, [x, y]: [usize; 2], from: ViewOffset, d: f32) -> f32 {
        let end = [x as f32 + from.du * d, y as f32 + from.dv * d];
        let sides = self.front.sides();
        let is_beside = |axis: usize| end[axis] < -BESIDE_PX || end[axis] > sides[axis] as f32 - 1.0 + BESIDE_PX;
        if is_beside(0) || is_beside(1) { 1.0 } else { self.hidden(end, from, d) }
    }

    /// Whether the photo's surfaces hide the place where a ray of disparity `d` ends: 0 … 1.
    #[inline]
    fn hidden(&self, [x, y]: [f32; 2], from: ViewOffset, d: f32) -> f32 {
        let inside = |at: f32, side: usize| (at.round().max(0.0) as usize).min(side - 1);
        let [width, height] = self.front.sides();
        let (front_px, beside) = self.front.at(inside(x, width), inside(y, height));
        let hides = |surface_px: f32| ramp(HIDDEN_PX[0], HIDDEN_PX[1], surface_px - d);
        let bare = |beside: Beside| hides(beside.disparity_px) * beside.bare(d, [from.du, from.dv]);
        hides(front_px).max(beside.map_or(0.0, bare))
    }

    /// The colour of a pixel of a view whose ray has disparity `d`: `own` where the photo sees its end.
    #[inline]
    pub(super) fn colour(&self, own: Vec4, [x, y]: [usize; 2], from: ViewOffset, d: f32) -> Vec4 {
        let end = [x as f32 + from.du * d, y as f32 + from.dv * d];
        let unseen = self.hidden(end, from, d);
        if unseen <= 0.0 {
            return own;
        }
        let [x, y] = end;
        let cell = |i: usize| {
            let cell = &self.behind.pixels()[i];
            // Colour times share, and share.
            [cell[0], cell[1], cell[2], cell[SHARE]]
        };
        let [r, g, b, share] = bilinear(self.behind.sides(), x, y, cell);
        let known = unseen * share.min(1.0);
        own + (Vec4::new(r, g, b, 0.0) / share.max(1e-6) - own) * known
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::lift;

    #[test]
    fn a_hidden_ray_has_the_far_sides_colour_and_a_seen_one_its_own() {
        // A red square before green.
        let size = [60u32, 50];
        let inside = |i: usize| (20..40).contains(&(i % 60)) && (15..35).contains(&(i / 60));
        let [red, green] = [Vec4::new(0.8, -1.0, -1.0, 0.0), Vec4::new(-1.0, 0.5, -1.0, 0.0)];
        let pixels = (0..3000).map(|i| if inside(i) { red } else { green }).collect();
        let map = (0..3000).map(|i| if inside(i) { 1.0 } else { -1.0 }).collect();
        let depths = lift::ray_depths(&DisparityMap::new(size, map).unwrap(), ViewGrid::PAPER);
        let far = FarSide::new(&Signed::new([60, 50], pixels).unwrap(), &depths);
        let one_left = ViewOffset { du: -1.0, dv: 0.0 };
        for (place, disparity, own, want) in [
            // Inside the square and beside its edge; a ray that ends on it; one that ends on the ground.
            ([25, 25], -1.0, red, green),
            ([20, 25], -1.0, red, green),
            ([30, 25], 1.0, red, red),
            ([10, 25], -1.0, green, green),
            // The ground's last column beside the square has some of its red, and is bare where the square moves away.
            ([40, 25], -1.0, red, red),
            ([19, 25], -1.0, red, green),
        ] {
            let pixel = [(place[0] as f32 + disparity) as usize, place[1]];
            let colour = far.colour(own, pixel, one_left, disparity);
            assert!((colour - want).abs().max_element() < 0.02, "{place:?} {disparity}: {colour}");
        }
    }
}
