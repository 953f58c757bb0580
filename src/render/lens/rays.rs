//! Light on its way: sorted into slices by how far it is spread, and even neighbours put together into coarse rays.
//!
//! Where a surface is spread over many pixels, its single pixels cannot be told apart in the picture. So blocks of 2×2,
//! 4×4 … 16×16 neighbours with about the same blur and no light among them that outshines the others become one ray on
//! a grid that much coarser: wide blurs cost less, not more. Blocks lie on a grid of the whole picture, so tiles agree.

use super::kernel::index_of;

/// Levels of coarseness: cells of 1, 2, 4, 8 and 16 pixels.
pub(super) const LEVELS: usize = 5;
/// Side of the largest block.
pub(super) const BLOCK: usize = 1 << (LEVELS - 1);
/// From this blur diameter on, blocks of a level may become one ray: eight cells and more across.
pub(super) const COARSE_PX: [f32; LEVELS] = [0.0, 16.0, 36.0, 72.0, 144.0];
/// Blur may differ by this part within a block.
const SAME_BLUR: f32 = 0.06;
/// Blur diameters below this leave a pixel as it is.
pub(super) const SHARP_PX: f32 = 0.3;

/// Slices on either side of the focal plane; the last one holds all that is blurred more.
const MIDDLE: i32 = 28;

/// What is nearly sharp is blurred by less.
pub(super) const NEARLY_SHARP_PX: f32 = 5.7;
/// Slices of what is nearly sharp: the first, and the one after the last.
pub(super) const NEARLY_SHARP: [usize; 2] = [(MIDDLE - 6) as usize, (MIDDLE + 7) as usize];

/// Position of a blur diameter among the slices: one a pixel at first, then 30 % apart.
#[inline]
pub(super) fn slice_of(blur: f32) -> f32 {
    let size = blur.abs();
    let at = if size <= 2.0 { size } else { 2.0 + log2(size / 2.0) / LOG2_STEP };
    at.min(MIDDLE as f32 - 1.0).copysign(blur)
}

/// The slice before which a surface of this blur is put, with those beside it that it shares its light with.
fn after(blur: f32) -> i32 {
    slice_of(blur).floor() as i32 + MIDDLE - 2
}

/// Whether all that is put just before a slice is nearly sharp.
pub(super) fn is_after_nearly_sharp(slice: usize) -> bool {
    (after(-NEARLY_SHARP_PX) as usize..=after(NEARLY_SHARP_PX) as usize).contains(&slice)
}

/// Slices are 30 % apart: log₂ 1.3.
const LOG2_STEP: f32 = 0.378_511_6;

/// A logarithm of a number from 1 on, off by 0.01 at most, even and growing everywhere: where slices lie exactly is nobody's
/// business.
#[inline]
fn log2(x: f32) -> f32 {
    let bits = x.to_bits();
    let part = f32::from_bits(bits & 0x007F_FFFF | 1.0f32.to_bits()) - 1.0;
    (bits >> 23) as f32 - 127.0 + part * (1.3465 - 0.3465 * part)
}

/// Light of a cell: premultiplied with its coverage, and how far it is spread (signed, positive before the focal plane).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Piece {
    /// Red, green, blue, and coverage; no coverage means that there is nothing.
    pub(super) light: [f32; 4],
    /// Least and greatest blur in the cell, pixels.
    blur: [f32; 2],
    /// Light of its brightest pixel; infinite where parts of the cell are sent already.
    peak: f32,
}

impl Piece {
    pub(super) fn new(rgb: [f32; 3], share: f32, blur: f32) -> Self {
        Self { light: [rgb[0], rgb[1], rgb[2], share], blur: [blur; 2], peak: rgb[0] + rgb[1] + rgb[2] }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.light[3] <= 0.0
    }
}

/// One ray, from a cell of a level's grid.
pub(super) struct Ray {
    /// Cell, from the tile's first.
    pub(super) x: i16,
    pub(super) y: i16,
    /// Index into the lens's kernels; 0 stays where it is.
    pub(super) kernel: u16,
    pub(super) flipped: bool,
    /// Premultiplied light and coverage.
    pub(super) light: [f32; 4],
}

/// The rays of one tile, from far to near; each slice has a list for every level.
pub(super) struct Slices {
    pub(super) rays: Vec<[Vec<Ray>; LEVELS]>,
    /// The tile's pixels whose own surface is put before the slice is: columns and rows, the first and the one after the last.
    seen: Vec<Vec<[[u16; 2]; 2]>>,
    /// Pixels of the tile of which their own surface and nearer ones leave no more than a part open, once they are put.
    rims: Vec<Vec<([u16; 2], f32)>>,
    at: [i32; 2],
    size: [i32; 2],
    /// Part of the diameter that is the finest in the lens's shape (see [`Kernels::finest`](super::kernel::Kernels::finest)).
    finest: f32,
}

impl Default for Slices {
    fn default() -> Self {
        let empty = || std::array::from_fn(|_| Vec::new());
        let count = 2 * MIDDLE as usize + 1;
        let rays = std::iter::repeat_with(empty).take(count).collect();
        Self {
            rays,
            seen: vec![Vec::new(); count],
            rims: vec![Vec::new(); count],
            at: [0; 2],
            size: [0; 2],
            finest: 1.0,
        }
    }
}

impl Slices {
    /// Begins another tile.
    pub(super) fn begin(&mut self, at: [i32; 2], size: [i32; 2], finest: f32) {
        self.rays.iter_mut().flatten().for_each(Vec::clear);
        self.seen.iter_mut().for_each(Vec::clear);
        self.rims.iter_mut().for_each(Vec::clear);
        (self.at, self.size, self.finest) = (at, size, finest);
    }

    /// Whether a slice has any light.
    pub(super) fn is_lit(&self, slice: usize) -> bool {
        self.rays[slice].iter().any(|rays| !rays.is_empty())
    }

    /// Pixels of the tile whose own surface is put before a slice is: columns and rows, the first and the one after the last.
    pub(super) fn seen_before(&self, slice: usize) -> &[[[u16; 2]; 2]] {
        &self.seen[slice]
    }

    /// Notes how much the surface is blurred at least that a square of pixels sees through all of the lens.
    #[inline]
    fn see(&mut self, place: [i32; 2], side: i32, blur: f32) {
        let part = [0, 1].map(|a| [0, side].map(|end| (place[a] + end - self.at[a]).clamp(0, self.size[a]) as u16));
        let slice = after(blur);
        if slice >= 0 && part.iter().all(|[first, end]| first < end) {
            self.seen[slice as usize].push(part);
        }
    }

    /// Notes how much of a pixel of the tile its own surface leaves open at most.
    pub(super) fn see_rim(&mut self, place: [i32; 2], blur: f32, open: f32) {
        let at = [0, 1].map(|a| (place[a] - self.at[a]) as u16);
        if let Ok(slice) = usize::try_from(after(blur)) {
            self.rims[slice].push((at, open));
        }
    }

    /// Pixels of which no more than a part is open before a slice is put.
    pub(super) fn rims_before(&self, slice: usize) -> &[([u16; 2], f32)] {
        &self.rims[slice]
    }

    /// The same of a block, `[y, x]` of [`BLOCK`]² blurs; not a number where not all of the lens sees a pixel's surface.
    pub(super) fn see_block(&mut self, place: [i32; 2], blurs: &[f32; BLOCK * BLOCK]) {
        let least = blurs.iter().fold(f32::MAX, |least, blur| least.min(*blur));
        if !blurs.iter().any(|blur| blur.is_nan()) {
            return self.see(place, BLOCK as i32, least);
        }
        for (i, blur) in blurs.iter().enumerate().filter(|(_, blur)| !blur.is_nan()) {
            self.see([place[0] + (i % BLOCK) as i32, place[1] + (i / BLOCK) as i32], 1, *blur);
        }
    }

    /// Sends light that stays in its pixel, in or around the tile.
    #[inline]
    pub(super) fn stay(&mut self, place: [i32; 2], [r, g, b]: [f32; 3]) {
        let [x, y] = [0, 1].map(|axis| place[axis] - self.at[axis]);
        if (0..self.size[0]).contains(&x) && (0..self.size[1]).contains(&y) {
            let ray = Ray { x: x as i16, y: y as i16, kernel: 0, flipped: false, light: [r, g, b, 1.0] };
            self.rays[MIDDLE as usize][0].push(ray);
        }
    }

    /// Sends a block of pixels whose upper left one is at `place`, `[y, x]` of [`BLOCK`]² pieces.
    pub(super) fn send_block(&mut self, place: [i32; 2], pieces: &mut [Piece]) {
        let mut side = BLOCK;
        for (level, coarse_px) in COARSE_PX.iter().enumerate().skip(1) {
            let mut left = false;
            let half = side / 2;
            for y in 0..half {
                for x in 0..half {
                    // The parent takes the place of cells that were read already.
                    let children = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (2 * y + dy) * side + 2 * x + dx);
                    let four = children.map(|i| pieces[i]);
                    let parent = joined(&four, coarse_px / self.finest);
                    if parent.peak.is_infinite() {
                        for (i, piece) in four.iter().enumerate().filter(|(_, p)| p.peak.is_finite()) {
                            let cell = [2 * x + i % 2, 2 * y + i / 2];
                            self.send(level - 1, [0, 1].map(|a| (place[a] >> (level - 1)) + cell[a] as i32), piece);
                        }
                    }
                    left |= parent.peak.is_finite() && !parent.is_empty();
                    pieces[y * half + x] = parent;
                }
            }
            if !left {
                return;
            }
            side = half;
        }
        self.send(LEVELS - 1, place.map(|p| p >> (LEVELS - 1)), &pieces[0]);
    }

    /// Sends light from a cell of the picture, in or around the tile.
    fn send(&mut self, level: usize, cell: [i32; 2], piece: &Piece) {
        if piece.is_empty() || piece.peak.is_infinite() {
            return;
        }
        let blur = (piece.blur[0] + piece.blur[1]) / 2.0;
        let side = 1 << level;
        let outside = |a: usize| {
            let from = cell[a] * side - self.at[a];
            (-from - side + 1).max(from - self.size[a] + 1)
        };
        let size = blur.abs();
        if outside(0).max(outside(1)) as f32 > size / 2.0 + 2.0 * side as f32 {
            return;
        }
        let kernel = if size < SHARP_PX { 0 } else { index_of(coarse_diameter(size, level)) as u16 };
        let at = slice_of(blur);
        // Membership is linear over the middle of the way from slice to slice.
        let upper = ((at - at.floor() - 0.3) / 0.4).clamp(0.0, 1.0);
        let first = (at.floor() as i32 + MIDDLE) as usize;
        let [x, y] = [0, 1].map(|a| (cell[a] - (self.at[a] >> level)) as i16);
        for (slice, share) in [(first, 1.0 - upper), (first + 1, upper)] {
            if share > 0.0 {
                let light = piece.light.map(|v| v * share);
                self.rays[slice][level].push(Ray { x, y, kernel, flipped: blur < 0.0, light });
            }
        }
    }
}

/// Diameter in cells of a level that gives a blur after the coarse grid has added its own: as wide in the mean square.
fn coarse_diameter(blur: f32, level: usize) -> f32 {
    let side = (1 << level) as f32;
    (blur * blur - COARSE_BLUR * (side * side - 1.0)).sqrt() / side
}

/// The square of the diameter that a block and its interpolation add, in cells: a disc of diameter c varies by c²/16, a
/// block by 1/12, and interpolation to half the cells again and again by 1/4 in all.
const COARSE_BLUR: f32 = 16.0 * (1.0 / 12.0 + 0.25);

/// Four cells as one of the next level, or a mark that they cannot be one: they must be spread by `coarse_px` or more.
#[inline]
fn joined(four: &[Piece; 4], coarse_px: f32) -> Piece {
    let mut sum = Piece { light: [0.0; 4], blur: [f32::MAX, f32::MIN], peak: 0.0 };
    for piece in four {
        sum.peak = sum.peak.max(piece.peak);
        if !piece.is_empty() {
            sum.blur = [sum.blur[0].min(piece.blur[0]), sum.blur[1].max(piece.blur[1])];
        }
        sum.light.iter_mut().zip(piece.light).for_each(|(s, v)| *s += 0.25 * v);
    }
    let [low, high] = sum.blur;
    let size = low.abs().min(high.abs());
    let mean = sum.light[0] + sum.light[1] + sum.light[2];
    let even = sum.peak <= 2.0 * mean + 1e-4 && size >= coarse_px && high - low <= SAME_BLUR * size;
    if !even && !sum.is_empty() {
        sum.peak = f32::INFINITY;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sent(piece: impl Fn(usize, usize) -> Piece) -> Vec<(usize, Ray)> {
        let mut slices = Slices::default();
        slices.begin([0, 0], [16, 16], 1.0);
        let mut block: Vec<Piece> = (0..BLOCK * BLOCK).map(|i| piece(i % BLOCK, i / BLOCK)).collect();
        slices.send_block([0, 0], &mut block);
        let with_level = |lists: [Vec<Ray>; LEVELS]| {
            lists.into_iter().enumerate().flat_map(|(level, rays)| rays.into_iter().map(move |ray| (level, ray)))
        };
        slices.rays.into_iter().flat_map(with_level).collect()
    }

    fn light(rays: &[(usize, Ray)]) -> f32 {
        rays.iter().map(|(level, ray)| ray.light[1] * (1 << (2 * level)) as f32).sum()
    }

    #[test]
    fn what_is_blurred_much_goes_in_blocks_and_what_is_blurred_little_by_pixels() {
        for (blur, level) in [(0.1, 0), (10.0, 0), (20.0, 1), (40.0, 2), (-80.0, 3), (150.0, 4)] {
            let rays = sent(|_, _| Piece::new([0.5; 3], 1.0, blur));
            assert!(rays.iter().all(|(l, _)| *l == level), "{blur}");
            assert!((light(&rays) - 128.0).abs() < 1e-2, "{blur}: {}", light(&rays));
        }
    }

    #[test]
    fn a_light_that_outshines_its_surroundings_goes_alone_and_no_light_is_lost() {
        let rays = sent(|x, y| Piece::new([if (x, y) == (5, 9) { 1.0 } else { 0.01 }; 3], 1.0, 60.0));
        let alone: Vec<_> = rays.iter().filter(|(level, ray)| *level == 0 && ray.light[1] > 0.2).collect();
        assert!(alone.iter().all(|(_, ray)| (ray.x, ray.y) == (5, 9)) && !alone.is_empty());
        assert!((light(&rays) - (1.0 + 2.55)).abs() < 1e-3);
    }

    #[test]
    fn two_surfaces_do_not_mix() {
        let rays = sent(|x, _| Piece::new([0.5; 3], 1.0, if x < 7 { 80.0 } else { 120.0 }));
        assert!((light(&rays) - 128.0).abs() < 1e-2);
        assert!(rays.iter().any(|(level, _)| *level == 0) && rays.iter().any(|(level, _)| *level > 1));
    }
}
