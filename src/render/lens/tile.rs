//! One tile: every surface spreads its light by its own kernel, nearer ones cover farther ones.
//!
//! Surfaces are sorted into slices by blur diameter, with linear membership. Each slice is spread as premultiplied light
//! and coverage, and the slices are put together from the near side on: a slice gets what the nearer ones leave over.
//! Pixels that are neighbours on one surface divide the coverage between them, so slices of one slanted surface add up
//! to 1 as they should, where multiplying coverages would let the background through.

use super::Prepared;
use super::behind::Hidden;
use super::kernel::{Kernel, Kernels, index_of};
use super::sample::ramp;
use super::surfaces::Seen;
use crate::field::Lens;

/// Blur diameters below this leave a pixel as it is.
const SHARP_PX: f32 = 0.3;

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

/// Light on its way: where from, how far spread, how much.
struct Ray {
    x: i16,
    y: i16,
    kernel: u16,
    flipped: bool,
    /// Premultiplied light and coverage.
    light: [f32; 4],
}

/// The slices of one tile; `slices[i]` holds what is at slice `i - MIDDLE`.
struct Slices {
    rays: Vec<Vec<Ray>>,
    /// Width and height of the tile.
    size: [i32; 2],
}

/// Slices on either side of the focal plane; the last one holds all that is blurred more.
const MIDDLE: i32 = 28;

/// Position of a blur diameter among the slices: one a pixel at first, then 30 % apart.
#[inline]
fn slice_of(blur: f32) -> f32 {
    let size = blur.abs();
    let at = if size <= 2.0 { size } else { 2.0 + (size / 2.0).ln() / 1.3f32.ln() };
    at.min(MIDDLE as f32 - 1.0).copysign(blur)
}

impl Slices {
    fn new(size: [i32; 2]) -> Self {
        Self { rays: std::iter::repeat_with(Vec::new).take(2 * MIDDLE as usize + 1).collect(), size }
    }

    /// Sends light from a pixel of the tile or around it.
    #[inline]
    fn send(&mut self, [x, y]: [i32; 2], blur: f32, light: [f32; 4]) {
        let size = blur.abs();
        let outside = (-x).max(x - self.size[0] + 1).max(-y).max(y - self.size[1] + 1);
        if outside as f32 > size / 2.0 + 1.0 || light[3] <= 0.0 {
            return;
        }
        let kernel = if size < SHARP_PX { 0 } else { index_of(size) as u16 };
        let at = slice_of(blur);
        // Membership is linear over the middle of the way from slice to slice.
        let upper = ((at - at.floor() - 0.3) / 0.4).clamp(0.0, 1.0);
        let first = (at.floor() as i32 + MIDDLE) as usize;
        for (slice, share) in [(first, 1.0 - upper), (first + 1, upper)] {
            if share > 0.0 {
                let light = light.map(|v| v * share);
                self.rays[slice].push(Ray { x: x as i16, y: y as i16, kernel, flipped: blur < 0.0, light });
            }
        }
    }
}

/// Renders a region; `out` is `[y, x, 3]`.
pub(super) fn render(picture: &Prepared, optics: &Optics, region: Region, out: &mut [f32]) {
    let slices = gather(picture, optics, region);
    let [width, height] = region.size.map(|s| s as usize);
    let mut front = vec![[0.0, 0.0, 0.0, 1.0f32]; width * height];
    let mut spread = Spread::new(width, height);
    for rays in slices.rays.iter().rev().filter(|rays| !rays.is_empty()) {
        spread.clear();
        for ray in rays {
            spread.add(ray, optics, region);
        }
        spread.put_behind(&mut front);
    }
    for (pixel, [r, g, b, left]) in out.chunks_exact_mut(3).zip(&front) {
        let covered = 1.0 - left;
        let share = if covered > 0.0 { 1.0 / covered } else { 0.0 };
        pixel.copy_from_slice(&[r * share, g * share, b * share]);
    }
}

/// All light that reaches a region.
fn gather(picture: &Prepared, optics: &Optics, region: Region) -> Slices {
    let [x0, y0] = region.at.map(|at| at as i32);
    let size = region.size.map(|s| s as i32);
    let reach = optics.reach;
    let count = (size[0] + 2 * reach) as usize;
    let mut slices = Slices::new(size);
    let surfaces = picture.surfaces.reader(x0 - reach, count, picture.size);
    let behind = picture.behind.reader(x0 - reach, count, picture.size);
    let mut colors = vec![[0.0; 3]; count];
    for y in -reach..size[1] + reach {
        let row = surfaces.at_row(y0 + y);
        let behind_row = behind.at_row(y0 + y);
        picture.light.row(x0 - reach, y0 + y, &mut colors);
        for (i, color) in colors.iter().enumerate() {
            let seen = surfaces.seen(&row, i, color);
            let hidden = if seen.cover > 0.01 { behind.hidden(behind_row, i) } else { None };
            let x = i as i32 - reach;
            let at = Place { tile: [x, y], picture: [x0 + x, y0 + y] };
            send_pixel(&mut slices, optics, at, *color, seen, hidden);
        }
    }
    slices
}

/// A pixel in the tile and in the picture.
#[derive(Clone, Copy)]
struct Place {
    tile: [i32; 2],
    picture: [i32; 2],
}

/// Light of one pixel: from its near side, and from what goes on behind that.
#[inline]
fn send_pixel(slices: &mut Slices, optics: &Optics, at: Place, color: [f32; 3], seen: Seen, hidden: Option<Hidden>) {
    let [x, y] = at.picture;
    let one = |rgb: [f32; 3], share: f32| [rgb[0], rgb[1], rgb[2], share];
    let near = optics.blur(seen.near_px, x, y);
    let color_of = |blur: f32| recovered(color, optics.lens.highlights, blur);
    if seen.cover <= 0.01 {
        let far = optics.blur(seen.far_px, x, y);
        return slices.send(at.tile, far, one(color_of(far), 1.0));
    }
    let mixed = seen.cover < 0.99;
    let far = match hidden {
        Some(hidden) if !mixed => optics.blur(hidden.disparity_px, x, y),
        _ if mixed => optics.blur(seen.far_px, x, y),
        _ => near,
    };
    // What is behind counts only where it is in another slice: in the same one, plain blur is right.
    let apart = ramp(0.4, 1.2, slice_of(near) - slice_of(far));
    if apart <= 0.0 && (!mixed || near.abs().max(far.abs()) < SHARP_PX || hidden.is_none()) {
        return slices.send(at.tile, near, one(color_of(near), 1.0));
    }
    if !mixed {
        slices.send(at.tile, near, one(color_of(near), 1.0));
        if let Some(hidden) = hidden {
            let reach = near.abs().max(far.abs()) / 2.0 + 1.5;
            // It ends softly, as what is before it may not cover it to the last per cent.
            let share = hidden.share * apart * (1.0 - ramp(reach, 1.5 * reach + 4.0, hidden.distance_px));
            let light = recovered(hidden.rgb, optics.lens.highlights, far).map(|v| v * share);
            slices.send(at.tile, far, one(light, share));
        }
        return;
    }
    let cover = seen.cover;
    let known = hidden.map_or(0.0, |h| h.share * apart * seen.edge);
    let back = hidden.map_or([0.0; 3], |h| h.rgb);
    // The pixel is a mixture: what is not the far side's is the near side's.
    let own: [f32; 3] = std::array::from_fn(|c| {
        let unmixed = (color[c] - (1.0 - cover) * back[c]).clamp(0.0, cover.min(color[c]));
        cover * color[c] + (unmixed - cover * color[c]) * known
    });
    let rest: [f32; 3] = std::array::from_fn(|c| color[c] - own[c] + cover * known * back[c]);
    slices.send(at.tile, near, one(own, cover));
    slices.send(at.tile, far, one(rest, 1.0 - cover + cover * known));
}

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

/// Light of one slice spread over a tile, as differences along rows.
struct Spread {
    size: [usize; 2],
    /// `[y, x]` with two columns more than the tile; what goes in left of it is in the first column.
    steps: Vec<[f32; 4]>,
    /// Light that stays in its pixel; not as differences, so that it stays exact.
    still: Vec<[f32; 4]>,
    /// First and last row that light reaches.
    rows: [usize; 2],
}

impl Spread {
    fn new(width: usize, height: usize) -> Self {
        let steps = vec![[0.0; 4]; (width + 2) * height];
        Self { size: [width, height], steps, still: vec![[0.0; 4]; width * height], rows: [height, 0] }
    }

    fn clear(&mut self) {
        let [first, last] = self.rows;
        if first <= last {
            let (width, wide) = (self.size[0], self.size[0] + 2);
            self.steps[first * wide..(last + 1) * wide].fill([0.0; 4]);
            self.still[first * width..(last + 1) * width].fill([0.0; 4]);
        }
        self.rows = [self.size[1], 0];
    }

    fn reached(&mut self, first: usize, last: usize) {
        self.rows = [self.rows[0].min(first), self.rows[1].max(last)];
    }

    fn add(&mut self, ray: &Ray, optics: &Optics, region: Region) {
        let [x, y] = [i32::from(ray.x), i32::from(ray.y)];
        let [width, height] = self.size.map(|s| s as i32);
        if ray.kernel == 0 {
            if (0..width).contains(&x) && (0..height).contains(&y) {
                let at = y as usize * self.size[0] + x as usize;
                add(&mut self.still[at], &ray.light, 1.0);
                self.reached(y as usize, y as usize);
            }
            return;
        }
        let [px, py] = [region.at[0] as i32 + x, region.at[1] as i32 + y];
        let Kernel { spans, reach } = optics.kernels.get(ray.kernel.into(), ray.flipped, px, py);
        let reach = *reach;
        let from = spans.partition_point(|span| span.dy < -y);
        let to = spans.partition_point(|span| span.dy < height - y);
        let (Some(first), Some(last)) = (spans.get(from), spans[..to].last()) else { return };
        if from >= to {
            return;
        }
        self.reached((first.dy + y) as usize, (last.dy + y) as usize);
        let wide = self.size[0] + 2;
        let top = (first.dy + y) as usize * wide;
        let inside = x >= reach && x + reach < width;
        for span in &spans[from..to] {
            let start = top + (span.dy - first.dy) as usize * wide;
            let row = &mut self.steps[start..start + wide];
            if inside {
                step(row, (span.begin.0 + x) as usize, &ray.light, span.begin.1);
                step(row, (span.end.0 + x) as usize, &ray.light, span.end.1.map(|p| -p));
                continue;
            }
            let column = |at: i32| (at + x).clamp(0, width + 1) as usize;
            let (at, parts) = span.begin;
            add(&mut row[column(at)], &ray.light, parts[0]);
            add(&mut row[column(at + 1)], &ray.light, parts[1]);
            let (at, parts) = span.end;
            add(&mut row[column(at)], &ray.light, -parts[0]);
            add(&mut row[column(at + 1)], &ray.light, -parts[1]);
        }
    }

    /// Puts the slice behind what is there; the last number of `front` is how much is left to cover.
    fn put_behind(&self, front: &mut [[f32; 4]]) {
        let [width, wide] = [self.size[0], self.size[0] + 2];
        if self.rows[0] > self.rows[1] {
            return;
        }
        for y in self.rows[0]..=self.rows[1] {
            let mut sum = [0.0; 4];
            let row = self.steps[y * wide..].iter().zip(&self.still[y * width..]);
            for (pixel, (step, still)) in front[y * width..(y + 1) * width].iter_mut().zip(row) {
                add(&mut sum, step, 1.0);
                let cover = sum[3] + still[3];
                if cover <= 1e-5 {
                    continue;
                }
                let share = closed(cover).min(pixel[3]);
                let part = share / cover;
                for c in 0..3 {
                    pixel[c] += part * (sum[c] + still[c]).max(0.0);
                }
                pixel[3] -= share;
            }
        }
    }
}

/// Coverage with its last per cent closed: a surface whose blur changes from place to place spreads a little unevenly,
/// and a bright background would show through a dark one.
#[inline(always)]
fn closed(cover: f32) -> f32 {
    if cover < 0.8 { cover } else { (cover + 0.015 * ((cover - 0.8) * 10.0).min(1.0)).min(1.0) }
}

/// Two neighbouring steps of a row at once.
#[inline(always)]
fn step(row: &mut [[f32; 4]], at: usize, light: &[f32; 4], parts: [f32; 2]) {
    if let Some([a, b]) = row[at..].first_chunk_mut::<2>() {
        add(a, light, parts[0]);
        add(b, light, parts[1]);
    }
}

#[inline(always)]
fn add(to: &mut [f32; 4], what: &[f32; 4], times: f32) {
    for (to, what) in to.iter_mut().zip(what) {
        *to += what * times;
    }
}
