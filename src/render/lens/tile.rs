//! One tile: every surface spreads its light by its own kernel, nearer ones cover farther ones.
//!
//! Surfaces are sorted into slices by blur diameter, with linear membership. Each slice is spread as premultiplied light
//! and coverage, and the slices are put together from the near side on: a slice gets what the nearer ones leave over.
//! Pixels that are neighbours on one surface divide the coverage between them, so slices of one slanted surface add up
//! to 1 as they should, where multiplying coverages would let the background through.

use super::Prepared;
use super::behind::Hidden;
use super::kernel::Kernels;
use super::rays::{BLOCK, Piece, SHARP_PX, Slices, slice_of};
use super::spread::Spread;
use super::surfaces::{MIXTURE, Seen};
use crate::field::{Lens, ramp};

/// A part of the picture, in its pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// Left and upper corner.
    pub at: [u32; 2],
    /// Width and height.
    pub size: [u32; 2],
}

/// A lens set on a picture: how much each disparity is blurred.
pub(super) struct Optics<'a> {
    pub(super) lens: &'a Lens,
    pub(super) kernels: Kernels,
    /// Pixels of blur per pixel of disparity.
    pub(super) gain: f32,
    /// Pixels that the widest kernel reaches.
    pub(super) reach: i32,
    pub(super) size: [u32; 2],
}

impl Optics<'_> {
    /// Signed blur diameter in pixels, positive before the focal plane.
    #[inline]
    pub(super) fn blur(&self, disparity_px: f32, x: i32, y: i32) -> f32 {
        let place = |at: i32, side: u32| (at as f32 + 0.5) / side as f32;
        self.gain * self.lens.defocus_px(disparity_px, place(x, self.size[0]), place(y, self.size[1]))
    }
}

/// Renders a region; `out` is `[y, x, 3]`.
pub(super) fn render(picture: &Prepared, optics: &Optics, region: Region, out: &mut [f32]) {
    let slices = gather(picture, optics, region);
    let mut front = vec![[0.0, 0.0, 0.0, 1.0f32]; (region.size[0] * region.size[1]) as usize];
    let mut spread = Spread::new(region);
    for rays in slices.rays.iter().rev().filter(|lists| lists.iter().any(|rays| !rays.is_empty())) {
        spread.put_behind(rays, optics, &mut front);
    }
    for (pixel, [r, g, b, left]) in out.chunks_exact_mut(3).zip(&front) {
        let covered = 1.0 - left;
        let share = if covered > 0.0 { 1.0 / covered } else { 0.0 };
        pixel.copy_from_slice(&[r * share, g * share, b * share]);
    }
}

/// All light that reaches a region, block by block of the picture's grid.
fn gather(picture: &Prepared, optics: &Optics, region: Region) -> Slices {
    let side = BLOCK as i32;
    let from = region.at.map(|at| (at as i32 - optics.reach).div_euclid(side) * side);
    let to = [0, 1].map(|a| (region.at[a] + region.size[a]) as i32 + optics.reach);
    let count = ((to[0] - from[0]) as usize).next_multiple_of(BLOCK);
    let [at, size] = [region.at, region.size].map(|pair| pair.map(|v| v as i32));
    let mut slices = Slices::new(at, size, optics.kernels.finest());
    let reader = picture.reader(from[0], count);
    let mut colors = vec![[0.0; 3]; count * BLOCK];
    let mut before = [Piece::default(); BLOCK * BLOCK];
    let mut after = [Piece::default(); BLOCK * BLOCK];
    for top in (from[1]..to[1]).step_by(BLOCK) {
        let rows: [_; BLOCK] = std::array::from_fn(|y| {
            picture.light.row(from[0], top + y as i32, &mut colors[y * count..][..count]);
            reader.at_row(top + y as i32)
        });
        for left in (0..count).step_by(BLOCK) {
            let at = [from[0] + left as i32, top];
            let mut any_behind = false;
            for (y, row) in rows.iter().enumerate() {
                for x in 0..BLOCK {
                    let i = left + x;
                    let color = colors[y * count + i];
                    let (seen, hidden) = reader.at(row, i, &color);
                    let place = [at[0] + x as i32, at[1] + y as i32];
                    let [first, second] = pieces(optics, place, color, seen, hidden);
                    any_behind |= !second.is_empty();
                    before[y * BLOCK + x] = first;
                    after[y * BLOCK + x] = second;
                }
            }
            slices.send_block(at, &mut before);
            if any_behind {
                slices.send_block(at, &mut after);
            }
        }
    }
    slices
}

/// Light of one pixel: from its near side, and from what goes on behind that.
#[inline]
fn pieces(optics: &Optics, [x, y]: [i32; 2], color: [f32; 3], seen: Seen, hidden: Option<Hidden>) -> [Piece; 2] {
    let near = optics.blur(seen.near_px, x, y);
    let color_of = |blur: f32| recovered(color, optics.lens.highlights, blur);
    let alone = |blur: f32| [Piece::new(color_of(blur), 1.0, blur), Piece::default()];
    if seen.cover <= MIXTURE[0] {
        return alone(optics.blur(seen.far_px, x, y));
    }
    let mixed = seen.cover < MIXTURE[1];
    let far = match hidden {
        Some(hidden) if !mixed => optics.blur(hidden.disparity_px, x, y),
        _ if mixed => optics.blur(seen.far_px, x, y),
        _ => return alone(near),
    };
    // What is behind counts only where it is in another slice: in the same one, plain blur is right.
    let apart = ramp(0.4, 1.2, slice_of(near) - slice_of(far));
    if apart <= 0.0 && (!mixed || near.abs().max(far.abs()) < SHARP_PX || hidden.is_none()) {
        return alone(near);
    }
    if !mixed {
        let Some(hidden) = hidden else { return alone(near) };
        let reach = near.abs().max(far.abs()) / 2.0 + 1.5;
        // It ends softly, as what is before it may not cover it to the last per cent.
        let share = hidden.share * apart * (1.0 - ramp(reach, 1.5 * reach + 4.0, hidden.distance_px));
        let light = recovered(hidden.rgb, optics.lens.highlights, far).map(|v| v * share);
        return [Piece::new(color_of(near), 1.0, near), Piece::new(light, share, far)];
    }
    let known = hidden.map_or(0.0, |h| h.share * apart * seen.edge);
    let back = hidden.map_or([0.0; 3], |h| h.rgb);
    let cover = seen.cover.max(known * least_cover(color, back));
    // The pixel is a mixture: what is not the far side's is the near side's.
    let own: [f32; 3] = std::array::from_fn(|c| {
        let unmixed = (color[c] - (1.0 - cover) * back[c]).clamp(0.0, cover.min(color[c]));
        cover * color[c] + (unmixed - cover * color[c]) * known
    });
    let rest: [f32; 3] = std::array::from_fn(|c| color[c] - own[c] + cover * known * back[c]);
    [Piece::new(own, cover, near), Piece::new(rest, 1.0 - cover + cover * known, far)]
}

/// How much of a pixel is not the far side at least: a dark pixel before a bright sky has little of it, whatever the map
/// says. Else the sky would shine through as fine bright lines.
#[inline]
fn least_cover(color: [f32; 3], back: [f32; 3]) -> f32 {
    let parts = (0..3).map(|c| (color[c] + DARK) / (back[c] + DARK));
    (1.0 - FAR_SPREAD * parts.fold(f32::MAX, f32::min)).max(0.0)
}

/// Light below which colours are not compared.
const DARK: f32 = 0.004;
/// The far side's colour at a pixel may be this many times darker than what goes on behind it on average.
const FAR_SPREAD: f32 = 1.5;

/// Light that was clipped by the camera, brightened where it is blurred; strength 0 leaves it as it is.
#[inline]
fn recovered(rgb: [f32; 3], strength: f32, blur: f32) -> [f32; 3] {
    if strength <= 0.0 {
        return rgb;
    }
    let clipped = ramp(0.85, 1.0, rgb[0].max(rgb[1]).max(rgb[2]));
    let gain = 1.0 + 9.0 * strength * clipped * ramp(1.0, 8.0, blur.abs());
    rgb.map(|v| v * gain)
}
