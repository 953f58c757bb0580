//! The losses, each one function: its value, and its gradient added to a buffer.
//!
//! All are means in plain Rust over `[sample, view, y, x]` maps, so that each can be checked by finite differences and
//! none depends on the tensor library: the trainer hands the summed gradient to the net's backward pass.

mod flow;
mod photometric;
mod print;
mod smooth;
mod subject;
mod supervised;
mod thin;

pub use flow::{flowed, flowed_views, regressed, regressed_views};
pub use photometric::{photometric, rendered_gradient, rendered_views};
pub use print::print;
pub use smooth::{consistency, total_variation};
pub use subject::subject_order;
pub use supervised::{Along, Fit, affine, affine_fit, ordinal, row_centred, supervised};
pub use thin::thin_parts;

use rayon::prelude::*;

use crate::nets::REFERENCE;

/// Sizes of a batch of ray-depth maps.
#[derive(Clone, Debug, PartialEq)]
pub struct Maps {
    /// Samples.
    pub samples: usize,
    /// Numbers of the views, ascending (`[v, u]` order), the same for every sample.
    pub views: Vec<usize>,
    /// Height in pixels.
    pub height: usize,
    /// Width in pixels.
    pub width: usize,
}

impl Maps {
    /// Place of the reference view among the views; the first one where it is missing.
    pub fn reference(&self) -> usize {
        self.views.iter().position(|view| *view == REFERENCE).unwrap_or(0)
    }

    /// The photo, of `[n, 3, h, w]`, of the sample that a map belongs to.
    pub fn photo<'a>(&self, photos: &'a [f32], map: usize) -> &'a [f32] {
        let colours = 3 * self.plane();
        &photos[map / self.views.len() * colours..][..colours]
    }

    /// Pixels of one map.
    pub fn plane(&self) -> usize {
        self.height * self.width
    }

    /// Maps in all.
    pub fn count(&self) -> usize {
        self.samples * self.views.len()
    }

    /// Values in all.
    pub fn len(&self) -> usize {
        self.count() * self.plane()
    }

    /// Whether there is nothing.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The rows of a map, then its columns.
    fn lines(&self) -> impl Iterator<Item = Line> + use<> {
        let (w, h) = (self.width, self.height);
        let rows = (0..h).map(move |y| Line { first: y * w, stride: 1, length: w });
        rows.chain((0..w).map(move |x| Line { first: x, stride: w, length: h }))
    }
}

/// A row or a column of a map.
#[derive(Clone, Copy)]
struct Line {
    first: usize,
    stride: usize,
    length: usize,
}

impl Line {
    /// The index of its pixel `k`.
    fn at(self, k: usize) -> usize {
        self.first + k * self.stride
    }
}

/// A cost, and two pixels of a map: the one that it moves back, and the one that it moves forward.
type Cost = (f32, [usize; 2]);

/// Sum of the costs of pairs of pixels, as a mean over all known pixels. `pairs` tells those of a map, of its true ray depths and
/// of what `px` says of the sample; 0 leaves a sample out.
fn costs<'a, P: Iterator<Item = Cost>>(
    maps: &Maps,
    [depth, truth]: [&'a [f32]; 2],
    px: &[f32],
    weight: f32,
    gradient: &mut [f32],
    pairs: impl Fn([&'a [f32]; 2], f32) -> P + Sync,
) -> f32 {
    let plane = maps.plane();
    let known = truth.par_iter().filter(|t| !t.is_nan()).count().max(1) as f32;
    let sums: Vec<f64> = (depth.par_chunks(plane), truth.par_chunks(plane), gradient.par_chunks_mut(plane))
        .into_par_iter()
        .enumerate()
        .map(|(map, (d, t, g))| {
            let px = px[map / maps.views.len()];
            let mut sum = 0.0f64;
            for (cost, [back, forward]) in (px > 0.0).then(|| pairs([d, t], px)).into_iter().flatten() {
                sum += f64::from(cost);
                g[back] += weight / known;
                g[forward] -= weight / known;
            }
            sum
        })
        .collect();
    (sums.iter().sum::<f64>() / f64::from(known)) as f32
}

/// Sign with 0 for 0 (and for NaN).
#[inline]
fn sign(x: f32) -> f32 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests;
