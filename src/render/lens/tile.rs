//! One tile: every surface spreads its light by its own kernel, nearer ones cover farther ones.
//!
//! Surfaces are sorted into slices by blur diameter, with linear membership. Each slice is spread as premultiplied light
//! and coverage, and the slices are put together from the near side on: a slice gets what the nearer ones leave over.
//! Pixels that are neighbours on one surface divide the coverage between them, so slices of one slanted surface add up
//! to 1 as they should, where multiplying coverages would let the background through.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use super::Prepared;
use super::behind::Hidden;
use super::bounds::reaches;
use super::kernel::Kernels;
use super::pixel::{Reader, Row};
use super::rays::{BLOCK, NEARLY_SHARP, Piece, SHARP_PX, Slices, is_after_nearly_sharp, slice_of};
use super::rim::Rims;
use super::spread::{Spread, close, narrow};
use super::surfaces::{MIXTURE, Seen};
use crate::field::{Lens, Mix, pixels, ramp, sides};

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
    /// Parts of the picture's sides that a pixel has.
    pub(super) per_px: [f32; 2],
}

impl Optics<'_> {
    /// Signed blur diameter in pixels, positive before the focal plane.
    #[inline]
    pub(super) fn blur(&self, disparity_px: f32, x: i32, y: i32) -> f32 {
        let [x, y] = [(x, self.per_px[0]), (y, self.per_px[1])].map(|(at, per_px)| (at as f32 + 0.5) * per_px);
        self.gain * self.lens.defocus_px(disparity_px, x, y)
    }
}

/// What a thread renders tiles with, kept from tile to tile: fresh memory costs more than what is put into it.
#[derive(Default)]
pub(super) struct Bench {
    slices: Slices,
    rims: Rims,
    spread: Spread,
    front: Vec<[f32; 4]>,
    /// What is left to cover before anything nearly sharp is put.
    open: Vec<f32>,
    colors: Vec<[f32; 3]>,
    /// Columns of the tile.
    width: usize,
    /// The tile, `[y, x, 3]`.
    light: Vec<f32>,
}

/// Benches that no thread works at.
#[derive(Default)]
pub(super) struct Pool(Mutex<Vec<Bench>>);

impl Pool {
    pub(super) fn take(&self) -> Bench {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default()
    }

    pub(super) fn give(&self, bench: Bench) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(bench);
    }
}

impl Bench {
    /// The light of the tile.
    pub(super) fn light(&mut self) -> &mut [f32] {
        &mut self.light
    }

    /// A region as it is.
    pub(super) fn sharp(&mut self, picture: &Prepared, region: Region) -> &[f32] {
        let [width, height] = sides(region.size);
        self.light.resize(width * height * 3, 0.0);
        let rows = (region.at[1] as i32..).zip(self.light.as_chunks_mut().0.chunks_exact_mut(width));
        rows.for_each(|(y, row)| picture.light.row(region.at[0] as i32, y, row));
        &self.light
    }

    /// Renders a region.
    pub(super) fn render(&mut self, picture: &Prepared, optics: &Optics, region: Region) {
        self.gather(picture, optics, region);
        self.width = region.size[0] as usize;
        self.front.clear();
        self.front.resize(pixels(region.size), [0.0, 0.0, 0.0, 1.0]);
        self.spread.begin(region);
        let [first, end] = NEARLY_SHARP;
        self.put(end..self.slices.rays.len(), optics);
        let is_any_sharp = (first..end).any(|slice| self.slices.is_lit(slice));
        if is_any_sharp {
            self.open.clear();
            self.open.extend(self.front.iter().map(|pixel| pixel[3]));
        }
        self.put(first..end, optics);
        if is_any_sharp {
            self.front.iter_mut().zip(&self.open).for_each(|(pixel, open)| close(pixel, *open));
        }
        self.put(0..first, optics);
        self.light.clear();
        self.light.extend(self.front.iter().flat_map(|[r, g, b, left]| {
            let covered = 1.0 - left;
            let share = if covered > 0.0 { 1.0 / covered } else { 0.0 };
            [r * share, g * share, b * share]
        }));
    }

    /// Puts slices behind what is there.
    fn put(&mut self, slices: Range<usize>, optics: &Optics) {
        for slice in slices.rev() {
            for [columns, rows] in self.slices.seen_before(slice) {
                let [[first, end], rows] = [columns, rows].map(|part| part.map(usize::from));
                let lines = self.front.chunks_exact_mut(self.width).take(rows[1]).skip(rows[0]);
                let pixels = lines.flat_map(|line| &mut line[first..end]);
                if is_after_nearly_sharp(slice) {
                    pixels.for_each(|pixel| narrow(pixel, 0.0));
                } else {
                    pixels.for_each(|pixel| close(pixel, 1.0));
                }
            }
            for &([x, y], open) in self.slices.rims_before(slice) {
                narrow(&mut self.front[usize::from(y) * self.width + usize::from(x)], open);
            }
            if self.slices.is_lit(slice) {
                self.spread.put_behind(&self.slices.rays[slice], optics, &mut self.front);
            }
        }
    }

    /// All light that reaches a region, block by block of the picture's grid.
    fn gather(&mut self, picture: &Prepared, optics: &Optics, region: Region) {
        let side = BLOCK as i32;
        let from = region.at.map(|at| (at as i32 - optics.reach).div_euclid(side) * side);
        let to = [0, 1].map(|a| (region.at[a] + region.size[a]) as i32 + optics.reach);
        let count = ((to[0] - from[0]) as usize).next_multiple_of(BLOCK);
        let [at, size] = [region.at, region.size].map(|pair| pair.map(|v| v as i32));
        self.slices.begin(at, size, optics.kernels.finest());
        self.rims.begin(region);
        let reader = picture.reader(from[0], count);
        let mut widest = vec![None; count / BLOCK];
        for top in (from[1]..to[1]).step_by(BLOCK) {
            // Of each block how much it is blurred, where its light reaches the region.
            for (block, widest) in widest.iter_mut().enumerate() {
                let place = [from[0] + (block * BLOCK) as i32, top];
                let px = picture.bounds.widest_px(optics, place);
                *widest = reaches(place, px, region, optics.kernels.finest()).then_some(px);
            }
            let Some(first) = widest.iter().position(Option::is_some) else { continue };
            let last = widest.iter().rposition(Option::is_some).unwrap_or(first);
            let (left, wide) = (first * BLOCK, (last + 1 - first) * BLOCK);
            self.colors.resize(wide * BLOCK, [0.0; 3]);
            for (y, colors) in (top..).zip(self.colors.chunks_exact_mut(wide)) {
                picture.light.row(from[0] + left as i32, y, colors);
            }
            let rows = std::array::from_fn(|y| reader.at_row(top + y as i32));
            for (block, widest) in widest.iter().enumerate().filter_map(|(i, px)| Some((i, (*px)?))) {
                let place = [from[0] + (block * BLOCK) as i32, top];
                let colors = Colors { px: &self.colors[block * BLOCK - left..], wide };
                if widest < STILL_PX {
                    colors.each(|[x, y], color| self.slices.stay([place[0] + x as i32, place[1] + y as i32], color));
                    continue;
                }
                let block = Block { optics, reader: &reader, rows: &rows, place, left: block * BLOCK, colors };
                if picture.bounds.is_plain(place) {
                    block.send_plain(&mut self.slices);
                } else {
                    block.send(&mut self.slices, &mut self.rims);
                }
            }
        }
        self.rims.open().for_each(|(place, blur, open)| self.slices.see_rim(place, blur, open));
    }
}

/// Blocks in which nothing is blurred more than this are the photo itself: between two surfaces in them there is no edge.
const STILL_PX: f32 = 0.2;

/// Colours of a block: its first, in rows of `wide`.
struct Colors<'a> {
    px: &'a [[f32; 3]],
    wide: usize,
}

impl Colors<'_> {
    fn each(&self, mut call: impl FnMut([usize; 2], [f32; 3])) {
        for y in 0..BLOCK {
            let row = &self.px[y * self.wide..][..BLOCK];
            row.iter().enumerate().for_each(|(x, color)| call([x, y], *color));
        }
    }
}

/// A block on its way: where it begins in the picture and among the reader's columns, its rows, and its colours.
struct Block<'a> {
    optics: &'a Optics<'a>,
    reader: &'a Reader<'a>,
    rows: &'a [Row; BLOCK],
    place: [i32; 2],
    left: usize,
    colors: Colors<'a>,
}

impl Block<'_> {
    fn at(&self, [x, y]: [usize; 2]) -> [i32; 2] {
        [self.place[0] + x as i32, self.place[1] + y as i32]
    }

    /// Sends the light of a block of one surface.
    fn send_plain(self, slices: &mut Slices) {
        let mut pieces = [Piece::default(); BLOCK * BLOCK];
        let mut blurs = [0.0; BLOCK * BLOCK];
        self.colors.each(|[x, y], color| {
            let [at_x, at_y] = self.at([x, y]);
            let blur = self.optics.blur(self.reader.disparity(&self.rows[y], self.left + x), at_x, at_y);
            blurs[y * BLOCK + x] = blur;
            pieces[y * BLOCK + x] = Piece::new(recovered(color, self.optics.lens.highlights, blur), 1.0, blur);
        });
        slices.see_block(self.place, &blurs);
        slices.send_block(self.place, &mut pieces);
    }

    /// Sends the light of any block.
    fn send(self, slices: &mut Slices, rims: &mut Rims) {
        let mut before = [Piece::default(); BLOCK * BLOCK];
        let mut after = [Piece::default(); BLOCK * BLOCK];
        let mut blurs = [f32::NAN; BLOCK * BLOCK];
        let mut any_behind = false;
        self.colors.each(|[x, y], color| {
            let (seen, hidden) = self.reader.at(&self.rows[y], self.left + x, &color);
            let place = self.at([x, y]);
            rims.cover(place, seen.cover, || self.optics.blur(seen.near_px, place[0], place[1]));
            match sight(self.optics, place, &seen, hidden.as_ref()) {
                Sight::Whole(blur) => blurs[y * BLOCK + x] = blur,
                Sight::Rim(blur) => rims.wait(place, blur),
                Sight::Far => {}
            }
            let [first, second] = pieces(self.optics, self.at([x, y]), color, seen, hidden);
            any_behind |= !second.is_empty();
            before[y * BLOCK + x] = first;
            after[y * BLOCK + x] = second;
        });
        slices.see_block(self.place, &blurs);
        slices.send_block(self.place, &mut before);
        if any_behind {
            slices.send_block(self.place, &mut after);
        }
    }
}

/// How much of the lens sees a pixel's own surface, and how much that is blurred.
enum Sight {
    /// All of it.
    Whole(f32),
    /// A part: the near side within its rim, or between two sides.
    Rim(f32),
    /// A part, and it is the far side.
    Far,
}

#[inline]
fn sight(optics: &Optics, [x, y]: [i32; 2], seen: &Seen, hidden: Option<&Hidden>) -> Sight {
    if seen.cover <= MIXTURE[0] || seen.cover >= MIXTURE[1] {
        let blur = optics.blur(seen.disparity_px(), x, y);
        if hidden.is_none_or(|hidden| hidden.distance_px > blur.abs() / 2.0 + 1.5) {
            return Sight::Whole(blur);
        }
    }
    if seen.cover > MIXTURE[0] { Sight::Rim(optics.blur(seen.near_px, x, y)) } else { Sight::Far }
}

/// Light of one pixel: from its near side, and from what goes on behind that.
#[inline]
fn pieces(optics: &Optics, [x, y]: [i32; 2], color: [f32; 3], seen: Seen, hidden: Option<Hidden>) -> [Piece; 2] {
    let near = optics.blur(seen.near_px, x, y);
    // What a blurred near side has left on the far one would stay behind as an outline.
    let stained = seen.stained * ramp(STAIN_PX[0], STAIN_PX[1], near.abs());
    // A pixel of the far side is a surface with something behind it as well.
    let (color, near) = match seen.cover <= MIXTURE[0] {
        true => (color.mix(seen.far_rgb, stained), optics.blur(seen.far_px, x, y)),
        false => (color, near),
    };
    let color_of = |blur: f32| recovered(color, optics.lens.highlights, blur);
    let alone = |blur: f32| [Piece::new(color_of(blur), 1.0, blur), Piece::default()];
    let mixed = MIXTURE[0] < seen.cover && seen.cover < MIXTURE[1];
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
        // Not far beyond what the near side is on the whole: else a little too much far side makes black specks of it.
        let [low, high] = [color[c].min(seen.near_rgb[c] / NEAR_SPREAD), color[c].max(seen.near_rgb[c] * NEAR_SPREAD)];
        let unmixed = ((color[c] - (1.0 - cover) * back[c]) / cover).clamp(low, high);
        let unmixed = (cover * unmixed).min(color[c]);
        cover * color[c] + (unmixed - cover * color[c]) * known
    });
    let rest: [f32; 3] = std::array::from_fn(|c| {
        (color[c] - own[c]).mix((1.0 - cover) * seen.far_rgb[c], stained) + cover * known * back[c]
    });
    [Piece::new(own, cover, near), Piece::new(rest, 1.0 - cover + cover * known, far)]
}

/// How much of a pixel is not the far side at least: a dark pixel before a bright sky has little of it, whatever the map
/// says. Else the sky would shine through as fine bright lines.
#[inline]
fn least_cover(color: [f32; 3], back: [f32; 3]) -> f32 {
    let parts = (0..3).map(|c| (color[c] + DARK) / (back[c] + DARK));
    (1.0 - FAR_SPREAD * parts.fold(f32::MAX, f32::min)).max(0.0)
}

/// From the first blur of the near side on, what it has left on the far one is taken away; from the second on all of it.
const STAIN_PX: [f32; 2] = [1.5, 6.0];
/// Light below which colours are not compared.
const DARK: f32 = 0.004;
/// The near side's colour at a pixel is at most so many times brighter or darker than it is on the whole, or the pixel.
const NEAR_SPREAD: f32 = 4.0;
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
