//! Pictures and maps at other sizes: separable filters over pixel centres (conventions in `field`).

use std::convert::Infallible;
use std::ops::Range;

use rayon::prelude::*;

use super::{Size, sides};

/// Where the centre of a pixel lies in a picture of another size, which has `ratio` times as many pixels along this side.
#[inline]
pub fn center_at(pixel: usize, ratio: f32) -> f32 {
    (pixel as f32 + 0.5) * ratio - 0.5
}

/// How a value is gathered from its neighbours. Shrinking widens the filter by the ratio of sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// Linear between centres (enlarging), a tent (shrinking). Never overshoots: for maps.
    Linear,
    /// Lanczos with three lobes: sharp, for pictures.
    Lanczos3,
    /// The mean over the area of each target pixel (shrinking), linear (enlarging).
    Area,
}

impl Filter {
    fn radius(self) -> f32 {
        match self {
            Self::Linear | Self::Area => 1.0,
            Self::Lanczos3 => 3.0,
        }
    }

    fn weight(self, x: f32) -> f32 {
        match self {
            Self::Linear | Self::Area => (1.0 - x.abs()).max(0.0),
            Self::Lanczos3 if x.abs() < 1e-6 => 1.0,
            Self::Lanczos3 if x.abs() >= 3.0 => 0.0,
            Self::Lanczos3 => {
                let a = std::f32::consts::PI * x;
                3.0 * a.sin() * (a / 3.0).sin() / (a * a)
            }
        }
    }
}

/// For each target pixel of one axis: its first source pixel and the weights from there on, which add up to 1.
pub(crate) struct Taps {
    pixels: Vec<(usize, Range<usize>)>,
    weights: Vec<f32>,
}

impl Taps {
    pub(crate) fn new(source: usize, target: usize, filter: Filter) -> Self {
        let mut taps = Self { pixels: Vec::with_capacity(target), weights: Vec::new() };
        match filter {
            Filter::Area if source >= target => taps.areas(source, target),
            _ => taps.weighed(source, target, filter),
        }
        taps
    }

    fn weighed(&mut self, source: usize, target: usize, filter: Filter) {
        let ratio = source as f32 / target as f32;
        let widen = ratio.max(1.0);
        let radius = filter.radius() * widen;
        let per_pixel = ((2.0 * radius).ceil() as usize + 1).min(source);
        for i in 0..target {
            let center = center_at(i, ratio);
            let first = ((center - radius).ceil().max(0.0) as usize).min(source - per_pixel);
            let raw: Vec<f32> =
                (first..first + per_pixel).map(|j| filter.weight((j as f32 - center) / widen)).collect();
            let sum: f32 = raw.iter().sum();
            self.push(first, raw.iter().map(|w| w / sum));
        }
    }

    /// The source pixels under each target pixel, with the shares that they have in it.
    fn areas(&mut self, source: usize, target: usize) {
        let scale = source as f64 / target as f64;
        for i in 0..target {
            let (from, to) = (i as f64 * scale, (i as f64 + 1.0) * scale);
            let first = from.floor() as usize;
            let last = (to.ceil() as usize).clamp(first + 1, source);
            let share = |p: usize| ((to.min(p as f64 + 1.0) - from.max(p as f64)) / scale) as f32;
            self.push(first, (first..last).map(share));
        }
    }

    fn push(&mut self, first: usize, weights: impl Iterator<Item = f32>) {
        let start = self.weights.len();
        self.weights.extend(weights);
        self.pixels.push((first, start..self.weights.len()));
    }

    /// First source pixel and weights of the `i`-th target pixel.
    #[inline]
    pub(crate) fn of(&self, i: usize) -> (usize, &[f32]) {
        let (first, weights) = &self.pixels[i];
        (*first, &self.weights[weights.clone()])
    }
}

/// `C` interleaved channels of a picture at another size. `row(y, buffer)` gives source row `y`; its error ends it all.
///
/// # Shapes
/// - result: `[y, x, C]` of `target`
pub(crate) fn resample_rows<const C: usize, E: Send>(
    source: Size,
    target: Size,
    filter: Filter,
    row: impl Fn(usize, &mut [f32]) -> Result<(), E> + Sync,
) -> Result<Vec<f32>, E> {
    let (source, target) = (sides(source), sides(target));
    let (across, down) = (Taps::new(source[0], target[0], filter), Taps::new(source[1], target[1], filter));
    let wide = target[0] * C;
    let mut rows = vec![0.0; source[1] * wide];
    rows.par_chunks_mut(wide).enumerate().try_for_each_init(
        || vec![0.0; source[0] * C],
        |buffer, (y, out)| {
            row(y, buffer)?;
            for (x, pixel) in out.chunks_exact_mut(C).enumerate() {
                let (first, weights) = across.of(x);
                for (weight, from) in weights.iter().zip(buffer[first * C..].chunks_exact(C)) {
                    for c in 0..C {
                        pixel[c] += weight * from[c];
                    }
                }
            }
            Ok(())
        },
    )?;
    let mut out = vec![0.0; target[1] * wide];
    out.par_chunks_mut(wide).enumerate().for_each(|(y, out)| {
        let (first, weights) = down.of(y);
        for (weight, from) in weights.iter().zip(rows[first * wide..].chunks_exact(wide)) {
            out.iter_mut().zip(from).for_each(|(o, f)| *o += weight * f);
        }
    });
    Ok(out)
}

/// `C` interleaved channels of a picture in memory at another size; the same values where the sizes agree.
///
/// # Shapes
/// - `values`: `[y, x, C]` of `source`; result: of `target`
pub fn resample<const C: usize>(values: &[f32], source: Size, target: Size, filter: Filter) -> Vec<f32> {
    if source == target {
        return values.to_vec();
    }
    let wide = source[0] as usize * C;
    let Ok(out) = resample_rows::<C, Infallible>(source, target, filter, |y, buffer| {
        buffer.copy_from_slice(&values[y * wide..(y + 1) * wide]);
        Ok(())
    });
    out
}

/// The source pixel whose centre is nearest to that of the `i`-th of `target` along a side.
pub fn nearest_index(i: usize, source: usize, target: usize) -> usize {
    (2 * i + 1) * source / (2 * target)
}

/// The value of the source pixel whose centre is nearest: for maps that must not invent values.
pub fn nearest<T: Copy>(values: &[T], source: Size, target: Size) -> Vec<T> {
    let (source, target) = (sides(source), sides(target));
    let columns: Vec<usize> = (0..target[0]).map(|x| nearest_index(x, source[0], target[0])).collect();
    let row = |y: usize| &values[nearest_index(y, source[1], target[1]) * source[0]..];
    (0..target[1]).map(row).flat_map(|row| columns.iter().map(move |x| row[*x])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Raster, pixels};

    #[test]
    fn a_ramp_stays_a_ramp_without_a_half_pixel_shift() {
        for (source, target) in [([40, 30], [20, 15]), ([40, 30], [13, 11]), ([20, 16], [47, 33])] {
            let ramp = Raster::from_fn(source, |x, y| (x + 2 * y) as f32);
            for filter in [Filter::Linear, Filter::Lanczos3, Filter::Area] {
                let out = ramp.resized(target, filter);
                let [rx, ry] = [0, 1].map(|i| source[i] as f32 / target[i] as f32);
                let (mx, my) = (6.max(target[0] / 3), 5.max(target[1] / 3));
                for y in my..target[1] - my {
                    for x in mx..target[0] - mx {
                        let want = (x as f32 + 0.5) * rx - 0.5 + 2.0 * ((y as f32 + 0.5) * ry - 0.5);
                        assert!(
                            (out.at(x as usize, y as usize) - want).abs() < 0.05,
                            "{source:?} {target:?} {filter:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_constant_stays_constant_even_for_one_pixel() {
        for (source, target) in [([1, 1], [5, 3]), ([100, 1], [7, 1]), ([3, 200], [1, 9])] {
            let out = resample::<2>(&vec![0.5; pixels(source) * 2], source, target, Filter::Lanczos3);
            assert!(out.iter().all(|v| (v - 0.5).abs() < 1e-5));
            assert_eq!(out.len(), pixels(target) * 2);
        }
    }
}
