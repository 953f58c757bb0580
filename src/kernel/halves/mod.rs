//! 3×3 convolutions of a training step from products of 16-bit numbers (bfloat16), added up in f32.
//!
//! A processor with tiles (Intel's AMX) multiplies them some twenty times as fast as f32. bfloat16 keeps the range of
//! f32 and 8 of its 24 bits, which is what mixed-precision training computes with (Kalamkar et al. 2019, "A Study of
//! BFLOAT16 for Deep Learning Training"): weights, sums, normalisation and optimiser stay f32. Inference never rounds so
//! ([`split`](super::split)).
//!
//! With x the padded input, w the weights and g the gradient of the result, the matrices of each tap are
//! ```text
//! forward          z[c_out, pixel]   = Σ w[c_out, c_in] · x[c_in, pixel + tap]
//! data gradient    ∂x[c_in, pixel]   = Σ w[c_out, c_in] · g[c_out, pixel − tap]
//! weight gradient  ∂w[c_in, c_out]   = Σ x[c_in, pixel + tap] · g[c_out, pixel]
//! ```
//! Pixels are counted through the padded rows, so that a tap is one distance; what is computed on the margin is left out.

mod gradient;
pub(in crate::kernel) mod planes;
mod product;
#[cfg(test)]
mod tests;
mod tiles;

use rayon::prelude::*;

pub(super) use planes::rounded;
pub use tiles::Halves;
pub(super) use tiles::{Means, Tiles};

use self::planes::{Pairs, Weights};
use self::product::Step;
use super::conv::Sums;
use super::isa::{Isa, on_isa};
use super::padded::SendPtr;
use super::shape::{ConvShape, Kernel};

/// Rows and columns of a tile of sums, and pairs of a row.
pub(super) const TILE: usize = 16;
/// Columns that are multiplied at a time: two tiles.
const ACROSS: usize = 2 * TILE;
/// Of the kernel.
const TAPS: usize = 9;
/// Pixels of a task, about: its results stay in the second-level cache.
const TASK_PIXELS: usize = 512;

/// A 3×3 convolution of a batch.
pub(in crate::kernel) struct HalfBatch<'a> {
    shape: &'a ConvShape,
    halves: Halves,
    isa: Isa,
}

impl<'a> HalfBatch<'a> {
    /// Whether a convolution gains by it.
    pub(in crate::kernel) fn pays(shape: &ConvShape) -> bool {
        shape.kernel == Kernel::Plane && [shape.channels_in, shape.channels_out].iter().all(|&c| c >= TILE)
    }

    /// `isa` is for all that is not a product.
    pub(in crate::kernel) fn new(shape: &'a ConvShape, halves: Halves, isa: Isa) -> Self {
        assert_eq!(shape.kernel, Kernel::Plane, "products of halves for planes");
        Self { shape, halves, isa }
    }

    /// `w ∗ x` and its sums.
    pub(in crate::kernel) fn forward(&self, x: &[f32], weights: &[f32]) -> (Vec<f32>, Sums) {
        let ConvShape { channels_in: channels, channels_out: results, dilation, padding, .. } = *self.shape;
        let row = |row: &mut [f32], at: usize| row.copy_from_slice(&x[at..][..row.len()]);
        let x = Pairs::build(self.shape, self.isa, channels, (dilation, padding), row);
        self.multiply(&x, &Weights::pack([results, channels], |o, i, tap| weights[(o * channels + i) * TAPS + tap]))
    }

    /// Each tap's weights times the pixels that it lies on, `[n, c, y, x]` for all places where the kernel is inside; and
    /// the sums.
    fn multiply(&self, x: &Pairs, weights: &Weights) -> (Vec<f32>, Sums) {
        let [height, width] = x.layout.inside(self.shape.dilation);
        let (images, channels, plane) = (x.layout.images, weights.results, height * width);
        let block = (TASK_PIXELS / x.layout.width).clamp(1, height);
        let blocks = height.div_ceil(block);
        let steps = weights.steps(&x.layout, self.shape.dilation);
        let mut z = Vec::with_capacity(images * channels * plane);
        let to = SendPtr(z.as_mut_ptr());
        let task = |task: usize| {
            let (image, first) = (task / blocks, task % blocks * block);
            let rows = block.min(height - first);
            let (results, step) = self.rows((x, image, first), rows, weights, &steps);
            let of_channel = |(channel, results): (usize, &[f32])| {
                let mut sums = [0.0; 2];
                for (y, row) in results.chunks(x.layout.width).enumerate().take(rows) {
                    let row = &row[..width];
                    let [sum, squares] = on_isa!(self.isa, sum_and_squares(row));
                    sums = [sums[0] + sum, sums[1] + squares];
                    let at = (image * channels + channel) * plane + (first + y) * width;
                    // SAFETY: each row of the result belongs to one task, and is inside the capacity.
                    unsafe { to.at(at).copy_from_nonoverlapping(row.as_ptr(), width) };
                }
                sums
            };
            results.chunks(step).take(channels).enumerate().map(of_channel).collect::<Sums>()
        };
        // Collected before they are added up, so that the sums do not depend on the threads.
        let of_tasks: Vec<Sums> = (0..images * blocks).into_par_iter().with_max_len(1).map(task).collect();
        let mut sums = vec![[0.0; 2]; channels];
        for more in of_tasks {
            sums.iter_mut().zip(more).for_each(|(sum, more)| *sum = [sum[0] + more[0], sum[1] + more[1]]);
        }
        // SAFETY: the blocks cover every row of every channel.
        unsafe { z.set_len(images * channels * plane) };
        (z, sums)
    }

    /// The results of some rows of an image from the `first` on, margins included, and how far apart channels are.
    fn rows(
        &self,
        (x, image, first): (&Pairs, usize, usize),
        rows: usize,
        weights: &Weights,
        steps: &[Step],
    ) -> (Vec<f32>, usize) {
        let layout = &x.layout;
        let pixels = (rows * layout.width).next_multiple_of(ACROSS);
        let step = pixels + TILE;
        let mut results = vec![0.0; weights.groups() * TILE * step];
        let from = &x.values[image * layout.planes * layout.step + first * layout.width..];
        let tiles = self.halves.tiles(weights.depth);
        for pixel in (0..pixels).step_by(ACROSS) {
            for group in (0..weights.groups()).step_by(2) {
                let product = weights.product(group, layout, from[pixel..].as_ptr());
                let to = &mut results[group * TILE * step + pixel..];
                // SAFETY: planes have room for their last tiles; weights and results are whole numbers of tiles.
                unsafe { product.onto(&tiles, steps, to.as_mut_ptr(), step) };
            }
        }
        (results, step)
    }
}
