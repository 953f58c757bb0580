//! Brightness and colour differences → RGB (ITU-T H.273, 8.3).

use rayon::prelude::*;

use super::FORMAT;
use super::coded::Coded;
use crate::field::sides;
use crate::io::Problem;
use crate::io::raster::Channel;
use crate::io::raster::heif::Cicp;

/// RGB = `rows` · (numbers − `offset`), in 0 … 1.
struct Conversion {
    offset: [f32; 3],
    rows: [[f32; 3]; 3],
}

/// Offset and scale of the numbers of a plane.
fn range(bits: usize, full: bool, is_difference: bool) -> [f32; 2] {
    let unit = (1 << (bits - 8)) as f32;
    let max = (1 << bits) as f32 - 1.0;
    match (full, is_difference) {
        (true, false) => [0.0, 1.0 / max],
        (true, true) => [128.0 * unit, 1.0 / max],
        (false, false) => [16.0 * unit, 1.0 / (219.0 * unit)],
        (false, true) => [128.0 * unit, 1.0 / (224.0 * unit)],
    }
}

impl Conversion {
    fn new(coded: &Coded, cicp: Cicp) -> Result<Self, Problem> {
        let [offset, scale] = range(coded.bits, cicp.full_range, false);
        let [difference_offset, difference_scale] = range(coded.bits, cicp.full_range, true);
        let rows = match (coded.subsampled, cicp.matrix) {
            (None, _) => weighted(0.299, 0.114),
            (Some([1, 1]), 0) => {
                // The planes are green, blue and red themselves.
                let rows = [[0.0, 0.0, scale], [scale, 0.0, 0.0], [0.0, scale, 0.0]];
                return Ok(Self { offset: [offset; 3], rows });
            }
            (_, 1) => weighted(0.2126, 0.0722),
            (_, 2 | 5 | 6) => weighted(0.299, 0.114),
            (_, 4) => weighted(0.30, 0.11),
            (_, 7) => weighted(0.212, 0.087),
            // Green and orange differences.
            (_, 8) => [[1.0, -1.0, 1.0], [1.0, 1.0, 0.0], [1.0, -1.0, -1.0]],
            (_, 9) => weighted(0.2627, 0.0593),
            (_, other) => {
                let reason = format!("its colours are coded in a way that is not read here (matrix {other})");
                return Err(Problem::Unsupported { format: FORMAT, reason, advice: "save it as JPEG or PNG" });
            }
        };
        let scales = [scale, difference_scale, difference_scale];
        Ok(Self {
            offset: [offset, difference_offset, difference_offset],
            rows: rows.map(|row| std::array::from_fn(|i| row[i] * scales[i])),
        })
    }

    fn rgb(&self, numbers: [f32; 3]) -> [f32; 3] {
        let [a, b, c] = std::array::from_fn(|i| numbers[i] - self.offset[i]);
        self.rows.map(|[x, y, z]| x * a + y * b + z * c)
    }
}

/// The matrix of the shares of red and blue in brightness; the differences are those to blue and to red.
fn weighted(red: f32, blue: f32) -> [[f32; 3]; 3] {
    let green = 1.0 - red - blue;
    let (to_blue, to_red) = (2.0 * (1.0 - blue), 2.0 * (1.0 - red));
    [[1.0, 0.0, to_red], [1.0, -to_blue * blue / green, -to_red * red / green], [1.0, to_blue, 0.0]]
}

fn channel<T: Channel>(value: f32) -> T {
    T::round(value.clamp(0.0, 1.0) * T::MAX)
}

/// Opaque pixels, row by row.
pub(super) fn rgba<T: Channel + Send + Default>(coded: &Coded, cicp: Cicp) -> Result<Vec<[T; 4]>, Problem> {
    let conversion = Conversion::new(coded, cicp)?;
    let [width, height] = sides(coded.size);
    let mut pixels = vec![[T::default(); 4]; width * height];
    pixels.par_chunks_mut(width).enumerate().for_each_init(
        || Rows::new(coded, &conversion),
        |rows, (y, out)| {
            rows.read(coded, y);
            for (x, px) in out.iter_mut().enumerate() {
                let [r, g, b] = conversion.rgb([rows.planes[0][x], rows.planes[1][x], rows.planes[2][x]]);
                *px = [channel(r), channel(g), channel(b), T::round(T::MAX)];
            }
        },
    );
    Ok(pixels)
}

/// Brightness as opacity, row by row.
pub(super) fn alpha<T: Channel + Send + Default>(coded: &Coded, full_range: bool) -> Vec<T> {
    let [offset, scale] = range(coded.bits, full_range, false);
    let [width, height] = sides(coded.size);
    let mut values = vec![T::default(); width * height];
    values.par_chunks_mut(width).enumerate().for_each_init(
        || vec![0.0; width],
        |row, (y, out)| {
            coded.read_row(0, y, row);
            out.iter_mut().zip(row).for_each(|(to, from)| *to = channel((*from - offset) * scale));
        },
    );
    values
}

/// One row of a picture: three planes at full width.
struct Rows {
    planes: [Vec<f32>; 3],
    /// Two rows of colour samples, as they are stored.
    stored: [Vec<f32>; 2],
}

impl Rows {
    /// Colours that are not there are neutral.
    fn new(coded: &Coded, conversion: &Conversion) -> Self {
        let width = coded.size[0] as usize;
        let stored = width.div_ceil(coded.subsampled.map_or(1, |[across, _]| across));
        Self {
            planes: conversion.offset.map(|offset| vec![offset; width]),
            stored: [vec![0.0; stored], vec![0.0; stored]],
        }
    }

    fn read(&mut self, coded: &Coded, y: usize) {
        coded.read_row(0, y, &mut self.planes[0]);
        let Some([across, down]) = coded.subsampled else { return };
        for plane in [1, 2] {
            if [across, down] == [1, 1] {
                coded.read_row(plane, y, &mut self.planes[plane]);
                continue;
            }
            let [first, second] = &mut self.stored;
            let rows = (coded.size[1] as usize).div_ceil(down);
            let (near, far, weight) = if down == 1 { (y, y, 0.0) } else { neighbours(y, rows) };
            coded.read_row(plane, near, first);
            if weight > 0.0 {
                coded.read_row(plane, far, second);
                first.iter_mut().zip(second).for_each(|(a, b)| *a += (*b - *a) * weight);
            }
            let count = first.len();
            for (x, out) in self.planes[plane].iter_mut().enumerate() {
                let (near, far, weight) = neighbours(x, count);
                *out = first[near] + (first[far] - first[near]) * weight;
            }
        }
    }
}

/// The sample in whose middle half a pixel lies, the next one, and the share of that; samples lie between two pixels.
fn neighbours(at: usize, count: usize) -> (usize, usize, f32) {
    let near = at / 2;
    let far = if at.is_multiple_of(2) { near.saturating_sub(1) } else { (near + 1).min(count - 1) };
    (near, far, if near == far { 0.0 } else { 0.25 })
}
