//! Small pictures in memory: bilinear taps, area resize, blur, and filling by push and pull.

use plenoscope::field::{Filter, Mix, bilinear, resample, size_from};

/// A picture of `[width, height]` texels, `[y, x]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster<T> {
    /// Width and height.
    pub size: [usize; 2],
    /// Texels, rows top to bottom.
    pub px: Vec<T>,
}

/// A picture, sRGB.
pub type Rgb = Raster<[f32; 3]>;

impl Rgb {
    /// Opaque RGBA of 8 bits; the colours are in 0 … 1, what is beyond is clamped.
    pub fn rgba8(&self) -> Vec<u8> {
        let byte = |c: f32| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        self.px.iter().flat_map(|&[r, g, b]| [byte(r), byte(g), byte(b), 255]).collect()
    }
}

/// `value.floor()` of numbers up to 2²², larger ones about as they are: no call into the C library, where the
/// processor's own instruction may be missing.
#[inline]
pub fn floor(value: f32) -> f32 {
    // No fractions are left beside a number as large as this.
    const LARGE: f32 = 1.5 * (1u32 << 23) as f32;
    let whole = (value + LARGE) - LARGE;
    if whole > value { whole - 1.0 } else { whole }
}

/// What a [`Raster`] can hold and interpolate.
pub trait Texel: Copy + Send + Sync {
    /// What interpolation gives.
    type Out: Mix;
    /// A texel as that.
    fn out(self) -> Self::Out;
}

impl Texel for f32 {
    type Out = f32;
    #[inline(always)]
    fn out(self) -> f32 {
        self
    }
}

impl Texel for u8 {
    type Out = f32;
    #[inline(always)]
    fn out(self) -> f32 {
        self.into()
    }
}

impl<const N: usize> Texel for [f32; N] {
    type Out = Self;
    #[inline(always)]
    fn out(self) -> Self {
        self
    }
}

impl<const N: usize> Texel for [u8; N] {
    type Out = [f32; N];
    #[inline(always)]
    fn out(self) -> [f32; N] {
        self.map(f32::from)
    }
}

impl<T: Texel> Raster<T> {
    /// A raster from its texels, made by place (x, y).
    pub fn from_fn(size: [usize; 2], mut texel: impl FnMut(usize, usize) -> T) -> Self {
        let px = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect();
        Self { size, px }
    }

    /// The texel at a place inside.
    #[inline(always)]
    pub fn at(&self, x: usize, y: usize) -> T {
        self.px[y * self.size[0] + x]
    }

    /// Bilinear tap; pixel centres at integers, the edge goes on outside.
    #[inline(always)]
    pub fn tap(&self, x: f32, y: f32) -> T::Out {
        // What is no number is the first row or column, as unknown depth must not become unknown colour.
        bilinear(self.size, x.max(0.0), y.max(0.0), |i| self.px[i].out())
    }

    /// The same raster with each texel changed.
    pub fn map<U>(&self, change: impl FnMut(&T) -> U) -> Raster<U> {
        Raster { size: self.size, px: self.px.iter().map(change).collect() }
    }
}

impl<const N: usize> Raster<[f32; N]> {
    /// Resized by averaging over each target pixel's area (bilinear where it grows).
    pub fn resized(&self, size: [usize; 2]) -> Self {
        let values = resample::<N>(self.px.as_flattened(), size_from(self.size), size_from(size), Filter::Area);
        Self { size, px: values.as_chunks().0.to_vec() }
    }

    /// Blurred by three box filters whose sum has about this deviation; nothing below 0.3 px.
    pub fn blur(&mut self, sigma_px: f32) {
        let radius = (((4.0 * sigma_px * sigma_px + 1.0).sqrt() - 1.0) / 2.0).max(0.0);
        if sigma_px < 0.3 || radius <= 0.0 {
            return;
        }
        let mut before = Vec::new();
        // Across rows, where all that stand side by side are done at once; then along them, as across columns.
        for _ in 0..2 {
            (0..3).for_each(|_| box_filter(&mut self.px, self.size[0], radius, &mut before));
            *self = self.transposed();
        }
    }

    /// Rows as columns.
    fn transposed(&self) -> Self {
        let [w, h] = self.size;
        Self::from_fn([h, w], |x, y| self.at(y, x))
    }
}

/// Box filter of fractional radius across rows of `wide` texels, the first and the last going on outside.
fn box_filter<const N: usize>(px: &mut [[f32; N]], wide: usize, radius: f32, before: &mut Vec<[f32; N]>) {
    before.clear();
    before.extend_from_slice(px);
    let last = (px.len() / wide) as isize - 1;
    let row = |i: isize| before[i.clamp(0, last) as usize * wide..][..wide].as_flattened();
    let whole = radius as isize;
    let part = radius - whole as f32;
    let norm = 1.0 / (2.0 * radius + 1.0);
    let mut sums = vec![[0.0; N]; wide];
    let sums = sums.as_flattened_mut();
    for k in -whole..=whole {
        sums.iter_mut().zip(row(k)).for_each(|(sum, value)| *sum += value);
    }
    for (i, out) in (0..).zip(px.chunks_exact_mut(wide)) {
        let ends = row(i - whole - 1).iter().zip(row(i + whole + 1)).zip(row(i - whole));
        for ((out, sum), ((left, right), drop)) in out.as_flattened_mut().iter_mut().zip(&mut *sums).zip(ends) {
            *out = (*sum + part * (left + right)) * norm;
            *sum += right - drop;
        }
    }
}

/// Fills what has weight 0 from what has weight 1, smoothly and from near by first (push-pull pyramid).
///
/// # Shapes
/// - `colour`: `[y, x]` of N channels; `weight`: `[y, x]`, 0 unknown … 1 known
pub fn push_pull<const N: usize>(colour: &Raster<[f32; N]>, weight: &[f32]) -> Raster<[f32; N]> {
    let [w, h] = colour.size;
    if w <= 1 && h <= 1 {
        return colour.clone();
    }
    let half = [w.div_ceil(2), h.div_ceil(2)];
    let (mut small, mut small_weight) = (vec![[0.0; N]; half[0] * half[1]], vec![0.0f32; half[0] * half[1]]);
    for y in 0..h {
        for x in 0..w {
            let (i, k) = (y * w + x, (y / 2) * half[0] + x / 2);
            (0..N).for_each(|c| small[k][c] += colour.px[i][c] * weight[i]);
            small_weight[k] += weight[i];
        }
    }
    for (texel, sum) in small.iter_mut().zip(&mut small_weight) {
        if *sum > 0.0 {
            texel.iter_mut().for_each(|c| *c /= *sum);
        }
        *sum = sum.min(1.0);
    }
    let filled = push_pull(&Raster { size: half, px: small }, &small_weight);
    Raster::from_fn(colour.size, |x, y| {
        let (i, k) = (y * w + x, weight[y * w + x]);
        if k >= 1.0 {
            return colour.px[i];
        }
        let below = filled.tap((x as f32 - 0.5) / 2.0, (y as f32 - 0.5) / 2.0);
        std::array::from_fn(|c| k * colour.px[i][c] + (1.0 - k) * below[c])
    })
}

/// Distance in pixels from each inside pixel to the nearest outside one (chamfer 1, √2).
pub fn distance_inside(inside: &[bool], size: [usize; 2]) -> Vec<f32> {
    let [w, h] = size;
    let far = (w + h) as f32;
    let mut distance: Vec<f32> = inside.iter().map(|&yes| if yes { far } else { 0.0 }).collect();
    let diagonal = std::f32::consts::SQRT_2;
    let mut relax = |x: usize, y: usize, sign: isize| {
        let near = [(-1, 0, 1.0), (0, -1, 1.0), (-1, -1, diagonal), (1, -1, diagonal)];
        let mut best = distance[y * w + x];
        for (dx, dy, step) in near {
            let (nx, ny) = (x as isize + dx * sign, y as isize + dy * sign);
            if (0..w as isize).contains(&nx) && (0..h as isize).contains(&ny) {
                best = best.min(distance[ny as usize * w + nx as usize] + step);
            }
        }
        distance[y * w + x] = best;
    };
    (0..h).for_each(|y| (0..w).for_each(|x| relax(x, y, 1)));
    (0..h).rev().for_each(|y| (0..w).rev().for_each(|x| relax(x, y, -1)));
    distance
}

/// A window of a map of this width, from its upper left corner on.
pub(super) fn window<T: Copy>(map: &[T], wide: usize, [x, y]: [usize; 2], [width, height]: [usize; 2]) -> Vec<T> {
    map.chunks_exact(wide).skip(y).take(height).flat_map(|row| &row[x..x + width]).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_resize_keeps_the_mean_and_a_ramp() {
        let ramp = Raster::from_fn([64, 30], |x, _| [x as f32]);
        let small = ramp.resized([16, 10]);
        for x in 0..16 {
            assert!((small.at(x, 3)[0] - (x as f32 * 4.0 + 1.5)).abs() < 1e-3);
        }
        assert_eq!(ramp.resized([128, 60]).size, [128, 60]);
    }

    #[test]
    fn a_blur_keeps_a_constant_and_spreads_a_point_by_its_deviation() {
        let mut flat = Raster::from_fn([20, 10], |_, _| [0.25f32]);
        flat.blur(2.0);
        assert!(flat.px.iter().all(|p| (p[0] - 0.25).abs() < 1e-5));
        let mut point = Raster::from_fn([61, 51], |x, y| [if (x, y) == (30, 20) { 1.0f32 } else { 0.0 }]);
        point.blur(3.0);
        let deviation = |place: fn(usize) -> f32, middle: f32| {
            point.px.iter().enumerate().map(|(i, p)| p[0] * (place(i) - middle).powi(2)).sum::<f32>().sqrt()
        };
        let both = [deviation(|i| (i % 61) as f32, 30.0), deviation(|i| (i / 61) as f32, 20.0)];
        assert!(both.iter().all(|d| (d - 3.0).abs() < 0.2), "{both:?}");
    }

    #[test]
    fn numbers_are_rounded_down() {
        for value in [0.0, 0.5, 1.0, 2.999, -0.25, -1.0, -7.5, 65_535.75, -65_535.75, 4_194_303.5] {
            assert_eq!(floor(value), value.floor());
        }
        assert!(floor(f32::MAX) > 1e38 && floor(-1e12) < -9e11 && floor(f32::INFINITY) == f32::INFINITY);
    }

    #[test]
    fn what_is_unknown_is_filled_from_what_is_near() {
        let colour = Raster::from_fn([40, 20], |x, _| [if x < 20 { 0.0f32 } else { 1.0 }]);
        let known: Vec<f32> =
            (0..800).map(|i| f32::from(!(5..15).contains(&(i % 40)) && !(25..35).contains(&(i % 40)))).collect();
        let filled = push_pull(&colour, &known);
        assert!(filled.at(9, 10)[0] < 0.2 && filled.at(30, 10)[0] > 0.8);
        assert_eq!(filled.at(2, 2)[0], 0.0);
    }

    #[test]
    fn the_distance_of_a_square_grows_towards_its_middle() {
        let inside: Vec<bool> = (0..81).map(|i| (1..8).contains(&(i % 9)) && (1..8).contains(&(i / 9))).collect();
        let distance = distance_inside(&inside, [9, 9]);
        assert_eq!((distance[4 * 9 + 4], distance[9 + 1], distance[0]), (4.0, 1.0, 0.0));
    }
}
