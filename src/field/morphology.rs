//! Extremes of squares of pixels, and what they leave of a map (Serra 1982).

use rayon::prelude::*;

/// The extreme of the square of `2·around + 1` pixels about each pixel of a map `[y, x]`.
pub(crate) fn extremes(map: &[f32], [w, h]: [usize; 2], around: usize, most: fn(f32, f32) -> f32) -> Vec<f32> {
    let window = |at: usize, side: usize| at.saturating_sub(around)..(at + around + 1).min(side);
    let mut rows = vec![0.0; map.len()];
    rows.par_chunks_mut(w).zip(map.par_chunks(w)).for_each(|(out, row)| {
        out.iter_mut()
            .enumerate()
            .for_each(|(x, out)| *out = row[window(x, w)].iter().copied().reduce(most).unwrap_or(row[x]));
    });
    let mut all = vec![0.0; map.len()];
    all.par_chunks_mut(w).enumerate().for_each(|(y, out)| {
        out.copy_from_slice(&rows[y * w..][..w]);
        for other in window(y, h) {
            out.iter_mut().zip(&rows[other * w..][..w]).for_each(|(out, value)| *out = most(*out, *value));
        }
    });
    all
}

/// The places of the square of `2·around + 1` pixels about place `i` of a picture, row by row.
pub(crate) fn square([w, h]: [usize; 2], i: usize, around: usize) -> impl Iterator<Item = usize> {
    let window = move |at: usize, side: usize| at.saturating_sub(around)..(at + around + 1).min(side);
    window(i / w, h).flat_map(move |y| window(i % w, w).map(move |x| y * w + x))
}

/// A map without the near parts that the square does not fit into: its opening.
pub(crate) fn opening(map: &[f32], size: [usize; 2], around: usize) -> Vec<f32> {
    extremes(&extremes(map, size, around, f32::min), size, around, f32::max)
}
