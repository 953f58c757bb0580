//! Rays that end behind what the photo sees: there the far side goes on.
//!
//! Lambertian rendering (paper, §3.2) gives such a ray the colour of what hides its end, and the occlusion net (§3.3), which
//! sees a few pixels, takes back a part of that. What is left of the near side's colours would show as a fringe beside it.

use glam::Vec4;
use rayon::prelude::*;

use super::lift::STEP_PX;
use super::picture::Signed;
use crate::background::{self, Front, Hidden, SHARE};
use crate::field::{RayDepths, ViewOffset, ramp};

/// A surface is behind another when it is farther by this much, px per view step.
const APART_PX: f32 = 0.08;
/// The photo's surface hides a ray's end when it is nearer by the second of these, and does not by the first.
const HIDDEN_PX: [f32; 2] = [0.5 * STEP_PX, 1.5 * STEP_PX];

/// A photo's pixel beside a nearer one has some of its colour. It is seen for what it is once a view brings this many
/// pixels between the two: from the first on, wholly at the second.
const BARE_PX: [f32; 2] = [1.0, 2.0];

/// What the photo sees, and what goes on behind it.
pub(super) struct FarSide {
    size: [usize; 2],
    nearest: Vec<Near>,
    behind: Vec<Hidden>,
}

/// A place's own surface, and the nearest one of its neighbours.
struct Near {
    own_px: f32,
    beside_px: f32,
    /// Where that neighbour lies from the place.
    at: [i8; 2],
}

impl FarSide {
    /// Of a photo with these ray depths.
    pub(super) fn new(photo: &Signed, depths: &RayDepths) -> Self {
        let rgb = photo.pixels.iter().map(|p| p.truncate().to_array()).collect();
        let front = Front { size: photo.size, rgb, disparity_px: depths.reference().to_vec() };
        let behind = background::behind(&front, APART_PX, |_, _| [0.0; 5]);
        let nearest = (0..behind.len()).into_par_iter().map(|i| near(&front, i)).collect();
        Self { size: photo.size, nearest, behind }
    }

    /// The colour of a pixel of a view whose ray has disparity `d`: `own` where the photo sees its end.
    #[inline]
    pub(super) fn colour(&self, own: Vec4, [x, y]: [usize; 2], from: ViewOffset, d: f32) -> Vec4 {
        let [x, y] = [x as f32 + from.du * d, y as f32 + from.dv * d];
        let inside = |at: f32, side: usize| (at.round().max(0.0) as usize).min(side - 1);
        let near = &self.nearest[inside(y, self.size[1]) * self.size[0] + inside(x, self.size[0])];
        let apart = near.beside_px - d;
        if apart <= HIDDEN_PX[0] {
            return own;
        }
        let hides = |apart: f32| ramp(HIDDEN_PX[0], HIDDEN_PX[1], apart);
        let between = background::between(near.at.map(f32::from), [from.du, from.dv], apart);
        let bare = hides(apart) * ramp(BARE_PX[0], BARE_PX[1], between);
        let [r, g, b, share] = self.tap(x, y).to_array();
        let known = hides(near.own_px - d).max(bare) * share.min(1.0);
        own + (Vec4::new(r, g, b, 0.0) / share.max(1e-6) - own) * known
    }

    /// Colour times share, and share, between pixels.
    fn tap(&self, x: f32, y: f32) -> Vec4 {
        let at = |i: usize| {
            let cell = &self.behind[i];
            Vec4::new(cell[0], cell[1], cell[2], cell[SHARE])
        };
        crate::field::bilinear(self.size, x, y, at)
    }
}

fn near(front: &Front, i: usize) -> Near {
    let own_px = front.disparity_px[i];
    let start = Near { own_px, beside_px: own_px, at: [0; 2] };
    let place = |i: usize| [i % front.size[0], i / front.size[0]].map(|at| at as isize);
    front.around(i, 1).fold(start, |nearest, j| match front.disparity_px[j] > nearest.beside_px {
        true => {
            let ([x, y], [to_x, to_y]) = (place(i), place(j));
            Near { beside_px: front.disparity_px[j], at: [(to_x - x) as i8, (to_y - y) as i8], ..nearest }
        }
        false => nearest,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{DisparityMap, ViewGrid};
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
        let far = FarSide::new(&Signed { size: [60, 50], pixels }, &depths);
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
