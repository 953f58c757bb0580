//! The two gradients of a convolution.

use std::ops::Range;

use rayon::prelude::*;

use super::driver::Valid;
use super::ending::Ending;
use super::isa::{Isa, on_isa};
use super::pack::{BLOCK, Packed};
use super::padded::{Padded, SendPtr, by_chunks};
use super::shape::{ConvShape, Padding};
use super::tile::Activation;
use super::weight_tile::WeightTile;

/// Zeros round the output gradient. With edge padding the data gradient is wanted on the margin too, so the kernel
/// must fit in there once more.
pub(super) fn margin(shape: &ConvShape) -> [usize; 3] {
    match shape.padding {
        Padding::Zero => shape.reach(),
        Padding::Edge => shape.reach().map(|reach| 2 * reach),
    }
}

/// The gradient with respect to the input: the output gradient convolved with the weights turned round, and the
/// margin folded back onto the edge.
pub(super) fn data(shape: &ConvShape, isa: Isa, gradient: &Padded, weights: &[f32]) -> Vec<f32> {
    assert_eq!(weights.len(), shape.weights_len(), "number of weights");
    let weights = Packed::transposed(weights, shape.channels_out, shape.channels_in, shape.kernel);
    let (kernel, dilation) = (shape.kernel, shape.dilation);
    let (activation, ending) = (Activation::None, Ending::default());
    let valid = Valid { isa, x: gradient, weights: &weights, bias: &[], kernel, dilation, activation, ending };
    let reach = if shape.padding == Padding::Edge { shape.reach() } else { [0; 3] };
    let outer: usize = (0..3).map(|axis| shape.size()[axis] + 2 * reach[axis]).product();
    let len = shape.batch * shape.channels_in * outer;
    let mut wide = Vec::with_capacity(len);
    // Without a cancel flag it never stops early, and writes every value.
    if valid.run(&mut wide.spare_capacity_mut()[..len], false, None).is_ok() {
        // SAFETY: see above.
        unsafe { wide.set_len(len) };
    }
    if reach == [0; 3] { wide } else { fold(shape, reach, &wide) }
}

/// Adds the margin of each channel of `wide` to the edge pixels it was copied from.
pub(super) fn fold(shape: &ConvShape, reach: [usize; 3], wide: &[f32]) -> Vec<f32> {
    let [_, height, width] = shape.size();
    let outer = [0, 1, 2].map(|axis| shape.size()[axis] + 2 * reach[axis]);
    let inner = |at: usize, axis: usize| at.saturating_sub(reach[axis]).min(shape.size()[axis] - 1);
    let step: usize = outer.iter().product();
    by_chunks(shape.batch * shape.channels_in, shape.plane(), |channel, narrow: &mut [f32]| {
        for (index, row) in wide[channel * step..][..step].chunks_exact(outer[2]).enumerate() {
            let (view, y) = (inner(index / outer[1], 0), inner(index % outer[1], 1));
            let target = &mut narrow[(view * height + y) * width..][..width];
            let (left, rest) = row.split_at(reach[2]);
            let (middle, right) = rest.split_at(width);
            target.iter_mut().zip(middle).for_each(|(target, value)| *target += value);
            target[0] += left.iter().sum::<f32>();
            target[width - 1] += right.iter().sum::<f32>();
        }
    })
}

/// The gradient with respect to the weights: for each pair of channels and each tap, the sum over all pixels of
/// output gradient times shifted input.
pub(super) fn weights(shape: &ConvShape, isa: Isa, x: &Padded, gradient: &Padded) -> Vec<f32> {
    assert_eq!((x.layout.channels, x.layout.margin), (shape.channels_in, shape.reach()), "the padded input");
    assert_eq!((gradient.layout.channels, gradient.layout.margin), (shape.channels_out, margin(shape)), "the gradient");
    let job = WeightGradient::new(shape, isa, x, gradient);
    job.unpack(&added_up(job.tasks(), |tasks| job.sums(tasks)))
}

/// The sum of what all tasks bring, some of which each thread does in one go.
pub(super) fn added_up(tasks: usize, sums: impl Fn(Range<usize>) -> Vec<f32> + Sync) -> Vec<f32> {
    let chunks = tasks.min(2 * rayon::current_num_threads());
    let of_chunk = |chunk: usize| sums(tasks * chunk / chunks..tasks * (chunk + 1) / chunks);
    let added = (0..chunks).into_par_iter().with_max_len(1).map(of_chunk).reduce_with(|mut a, b| {
        a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        a
    });
    added.unwrap_or_default()
}

/// The weight gradient cut into blocks of rows.
struct WeightGradient<'a> {
    shape: &'a ConvShape,
    isa: Isa,
    x: &'a Padded,
    gradient: &'a Padded,
    /// Rows of a block: enough pixels that adding up the lanes at the end does not count.
    block_rows: usize,
    /// Columns, rounded up to whole vectors.
    columns: usize,
    /// Rows of taps, and taps in a row.
    taps: [usize; 2],
}

impl<'a> WeightGradient<'a> {
    fn new(shape: &'a ConvShape, isa: Isa, x: &'a Padded, gradient: &'a Padded) -> Self {
        let columns = shape.width.next_multiple_of(16);
        let block_rows = (1024 / columns).clamp(8, 64).min(shape.height);
        let [views, rows, across] = shape.kernel.extent();
        Self { shape, isa, x, gradient, block_rows, columns, taps: [views * rows, across] }
    }

    fn blocks(&self) -> usize {
        self.shape.height.div_ceil(self.block_rows)
    }

    fn tasks(&self) -> usize {
        self.shape.batch * self.blocks()
    }

    /// Length of the sums: `[c_out / 8][c_in][row of taps][tap in the row][8]`.
    fn len(&self) -> usize {
        self.shape.channels_out.div_ceil(BLOCK) * self.shape.channels_in * self.taps[0] * self.taps[1] * BLOCK
    }

    fn sums(&self, tasks: Range<usize>) -> Vec<f32> {
        let mut sums = vec![0.0; self.len()];
        let mut block = vec![0.0; BLOCK * self.block_rows * self.columns];
        for task in tasks {
            let (image, first) = (task / self.blocks(), task % self.blocks() * self.block_rows);
            let rows = first..(first + self.block_rows).min(self.shape.height);
            for view in 0..self.shape.views {
                for channel in (0..self.shape.channels_out).step_by(BLOCK) {
                    self.gather(image, view, channel, rows.clone(), &mut block);
                    self.all_inputs(image, view, channel, rows.clone(), &block, &mut sums);
                }
            }
        }
        sums
    }

    /// Copies the output gradient of up to 8 channels into `block` `[8][row][column]`; columns past the width are 0.
    fn gather(&self, image: usize, view: usize, channel: usize, rows: Range<usize>, block: &mut [f32]) {
        let layout = &self.gradient.layout;
        let [view_margin, row_margin, column_margin] = layout.margin;
        let width = self.shape.width;
        let channels = (self.shape.channels_out - channel).min(BLOCK);
        for (index, y) in rows.enumerate() {
            let row = self.gradient.row(image, view + view_margin, y + row_margin);
            for o in 0..channels {
                let from = &row[(channel + o) * layout.channel_step() + column_margin..][..width];
                block[(o * self.block_rows + index) * self.columns..][..width].copy_from_slice(from);
            }
        }
    }

    fn all_inputs(
        &self,
        image: usize,
        view: usize,
        channel: usize,
        rows: Range<usize>,
        block: &[f32],
        sums: &mut [f32],
    ) {
        let layout = &self.x.layout;
        let [tap_rows, tap_columns] = self.taps;
        let [_, rows_per_view, _] = self.shape.kernel.extent();
        let target = SendPtr(sums.as_mut_ptr());
        let channel_step = layout.channel_step();
        for i in 0..self.shape.channels_in {
            for tap_row in 0..tap_rows {
                let y = rows.start + tap_row % rows_per_view * self.shape.dilation;
                let x = &self.x.row(image, view + tap_row / rows_per_view, y)[i * channel_step..];
                let tile = WeightTile {
                    x: x.as_ptr(),
                    row_step: layout.row_step(),
                    next: x.as_ptr().wrapping_add(if i + 1 < self.shape.channels_in { channel_step } else { 0 }),
                    gradient: block.as_ptr(),
                    channel_step: self.block_rows * self.columns,
                    columns: self.columns,
                    rows: rows.len(),
                    dilation: self.shape.dilation,
                    taps: tap_columns,
                    channels: (self.shape.channels_out - channel).min(BLOCK),
                };
                let at = ((channel / BLOCK * self.shape.channels_in + i) * tap_rows + tap_row) * tap_columns * BLOCK;
                // SAFETY: `at` and the 8 sums of each tap are inside; the tile stays inside the padded rows.
                let target = unsafe { target.at(at) };
                on_isa!(self.isa, weight_gradient_tile(&tile, target));
            }
        }
    }

    fn unpack(&self, sums: &[f32]) -> Vec<f32> {
        let (channels_in, taps) = (self.shape.channels_in, self.taps[0] * self.taps[1]);
        let mut weights = Vec::with_capacity(self.shape.weights_len());
        for o in 0..self.shape.channels_out {
            for i in 0..channels_in {
                let first = (o / BLOCK * channels_in + i) * taps;
                weights.extend((0..taps).map(|tap| sums[(first + tap) * BLOCK + o % BLOCK]));
            }
        }
        weights
    }
}
