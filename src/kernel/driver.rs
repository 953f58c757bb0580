//! Cuts a convolution into blocks of rows, and rows into tiles.

use std::mem::MaybeUninit;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::ending::Ending;
use super::isa::{Isa, on_isa};
use super::pack::{BLOCK, Packed};
use super::padded::{Padded, SendPtr};
use super::shape::Kernel;
use super::team;
use super::tile::{Activation, Tile, max_vectors};
use crate::job::Cancelled;

/// A convolution without padding of its own: the result is smaller than the padded input by the kernel's reach.
pub(super) struct Valid<'a> {
    pub(super) isa: Isa,
    pub(super) x: &'a Padded,
    pub(super) weights: &'a Packed,
    /// One value per channel of the result; empty means 0.
    pub(super) bias: &'a [f32],
    pub(super) kernel: Kernel,
    pub(super) dilation: usize,
    pub(super) activation: Activation,
    pub(super) ending: Ending<'a>,
}

/// How the rows of the result are shared out.
struct Plan {
    /// (views, rows, columns) of the result.
    size: [usize; 3],
    /// Offsets of the taps in the padded input.
    taps: Vec<usize>,
    /// Taps per row of taps.
    tap_columns: usize,
    /// Rows of a block; a block goes through all views, so that its neighbours in the next view are still in cache.
    block_rows: usize,
    /// Blocks of channels that a task has. Of a few short rows each task has some channels, whose weights it reads once.
    task_channels: usize,
    bias: Vec<f32>,
}

impl Valid<'_> {
    /// Computes into `out` `[n, c_out, v, y, x]` and answers per channel the sum and the sum of squares of the result,
    /// if `sums` asks for it.
    pub(super) fn run(
        &self,
        out: &mut [MaybeUninit<f32>],
        sums: bool,
        cancel: Option<&AtomicBool>,
    ) -> Result<Vec<[f64; 2]>, Cancelled> {
        let plan = self.plan();
        let [views, rows, columns] = plan.size;
        let (batch, channels) = (self.x.layout.batch, self.weights.channels_out);
        assert_eq!(out.len(), batch * channels * views * rows * columns, "length of the result");
        assert_eq!(self.x.layout.channels, self.weights.channels_in, "channels of input and weights");
        assert!(self.ending.summand.is_none_or(|summand| summand.len() == out.len()), "length of the summand");
        let out = SendPtr(out.as_mut_ptr().cast());
        let blocks = rows.div_ceil(plan.block_rows);
        let channel_blocks = channels.div_ceil(BLOCK);
        let parts = channel_blocks.div_ceil(plan.task_channels);
        let stopped = || cancel.is_some_and(|flag| flag.load(Ordering::Relaxed));
        let block = |task: usize, sums: &mut [[f64; 2]]| {
            let piece = |number: usize, len: usize, all: usize| number * len..((number + 1) * len).min(all);
            let (image, place) = (task / (blocks * parts), task % (blocks * parts));
            let rows = piece(place % blocks, plan.block_rows, rows);
            let channels = piece(place / blocks, plan.task_channels, channel_blocks);
            if !stopped() {
                self.block(&plan, image, rows, channels, (out, sums));
            }
        };
        let mut total = Vec::new();
        if sums {
            total = summed(batch * blocks * parts, channels, block);
        } else {
            team::each(batch * blocks * parts, |task| block(task, &mut []));
        }
        if stopped() { Err(Cancelled) } else { Ok(total) }
    }

    fn plan(&self) -> Plan {
        let layout = &self.x.layout;
        let extent = self.kernel.extent();
        let reach = [1, self.dilation, self.dilation];
        let size = [0, 1, 2].map(|axis| layout.outer()[axis] - (extent[axis] - 1) * reach[axis]);
        let mut taps = Vec::with_capacity(self.kernel.taps());
        for view in 0..extent[0] {
            for row in 0..extent[1] {
                for column in 0..extent[2] {
                    let row = view * layout.view_step() + row * self.dilation * layout.row_step();
                    taps.push(row + column * self.dilation);
                }
            }
        }
        let channel_blocks = self.weights.channels_out.div_ceil(BLOCK);
        let wanted = 2 * rayon::current_num_threads();
        let is_narrow = size[0] == 1 && size[2] <= self.isa.lanes();
        let (block_rows, task_channels) = if is_narrow && channel_blocks >= 2 * wanted {
            (size[1], channel_blocks.div_ceil(wanted))
        } else if is_narrow {
            (3, channel_blocks)
        } else {
            (if size[0] > 1 { 8 } else { 2 }, channel_blocks)
        };
        let mut bias = self.bias.to_vec();
        bias.resize(self.weights.channels_out.next_multiple_of(BLOCK), 0.0);
        Plan { size, taps, tap_columns: extent[2], block_rows, task_channels, bias }
    }

    /// Some rows of one picture, all views, some blocks of channels.
    fn block(
        &self,
        plan: &Plan,
        image: usize,
        rows: Range<usize>,
        blocks: Range<usize>,
        (out, sums): (SendPtr, &mut [[f64; 2]]),
    ) {
        let [views, height, width] = plan.size;
        let plane = views * height * width;
        let image_out = image * self.weights.channels_out * plane;
        let together = if width <= self.isa.lanes() { 3 } else { 1 };
        let channels = blocks.start * BLOCK..(blocks.end * BLOCK).min(self.weights.channels_out);
        for view in 0..views {
            for y in rows.clone().step_by(together) {
                let last = (y + together).min(rows.end);
                let next = if last < rows.end { (view, last) } else { ((view + 1).min(views - 1), rows.start) };
                let next = &self.x.row(image, next.0, next.1)[0];
                // SAFETY: these channels of the rows y..last of this picture and view belong to this task alone.
                let out = unsafe { out.at(image_out + (view * height + y) * width) };
                self.rows(plan, (self.x.row(image, view, y), last - y), blocks.clone(), out, next);
            }
            if self.ending.is_some() {
                let first = image_out + (view * height + rows.start) * width;
                self.end(out, channels.clone().map(|channel| first + channel * plane), rows.len() * width);
            }
            for (channel, sums) in sums.iter_mut().enumerate().take(channels.end).skip(channels.start) {
                // SAFETY: written above, by this task.
                let written = unsafe {
                    let first = out.at(image_out + channel * plane + (view * height + rows.start) * width);
                    std::slice::from_raw_parts(first, rows.len() * width)
                };
                let [sum, squares] = on_isa!(self.isa, sum_and_squares(written));
                *sums = [sums[0] + sum, sums[1] + squares];
            }
        }
    }

    /// Ends pieces of the result of `len` values each, while they are in cache.
    fn end(&self, out: SendPtr, firsts: impl Iterator<Item = usize>, len: usize) {
        for first in firsts {
            // SAFETY: written by this task, and by no other.
            let written = unsafe { std::slice::from_raw_parts_mut(out.at(first), len) };
            let summand = self.ending.summand.map_or(&[][..], |summand| &summand[first..first + len]);
            on_isa!(self.isa, end_row(written, summand, self.ending.limits));
        }
    }

    /// One row of the result, some blocks of channels; or up to three rows that are no wider than a vector.
    fn rows(&self, plan: &Plan, (x, rows): (&[f32], usize), blocks: Range<usize>, out: *mut f32, next_row: *const f32) {
        let lanes = self.isa.lanes();
        let [views, height, width] = plan.size;
        let narrow = width <= lanes;
        let vectors = width.div_ceil(lanes);
        let most = max_vectors(lanes, self.weights.channels_out);
        let per_tile = vectors.div_ceil(vectors.div_ceil(most));
        for first in (0..vectors).step_by(per_tile) {
            let at = first * lanes;
            let more = first + per_tile < vectors;
            // SAFETY: the padded row goes on for whole vectors behind its width.
            let next = if more { unsafe { x.as_ptr().add(at + per_tile * lanes) } } else { next_row };
            let mut tile = Tile {
                // SAFETY: as above.
                x: unsafe { x.as_ptr().add(at) },
                channels_in: self.weights.channels_in,
                channel_step: self.x.layout.channel_step(),
                taps: &plan.taps,
                weights: std::ptr::null(),
                bias: std::ptr::null(),
                out: std::ptr::null_mut(),
                out_step: views * height * width,
                channels_out: 0,
                vectors: if narrow { rows } else { per_tile.min(vectors - first) },
                vector_step: if narrow { [self.x.layout.row_step(), width] } else { [lanes; 2] },
                width: width - at,
                lane_step: if narrow { 0 } else { lanes },
                activation: self.activation,
            };
            // SAFETY: the row has room for the pixels from `at` on.
            self.tiles(plan, &mut tile, blocks.clone(), unsafe { out.add(at) }, next);
        }
    }

    /// Some blocks of channels of the result at the pixels of one tile; meanwhile the input of the next one is fetched.
    fn tiles(&self, plan: &Plan, tile: &mut Tile, blocks: Range<usize>, out: *mut f32, next: *const f32) {
        let tap_rows = plan.taps.len() / plan.tap_columns;
        let segments = tap_rows * tile.channels_in;
        let per_block = segments.div_ceil(blocks.len().max(1));
        // Of a tile's row, and one more as it begins anywhere in the first.
        let lines = (max_vectors(self.isa.lanes(), self.weights.channels_out) * self.isa.lanes() / LINE + 1).min(4);
        for (number, block) in blocks.enumerate() {
            for segment in number * per_block..((number + 1) * per_block).min(segments) {
                let (row, channel) = (segment / tile.channels_in, segment % tile.channels_in);
                prefetch(next.wrapping_add(plan.taps[row * plan.tap_columns] + channel * tile.channel_step), lines);
            }
            tile.weights = self.weights.block(block).as_ptr();
            tile.bias = plan.bias[block * BLOCK..].as_ptr();
            // SAFETY: the result has this channel.
            tile.out = unsafe { out.add(block * BLOCK * tile.out_step) };
            tile.channels_out = (self.weights.channels_out - block * BLOCK).min(BLOCK);
            on_isa!(self.isa, convolve_tile(tile));
        }
    }
}

/// The sums over all blocks, each of which adds to those it is given.
fn summed(blocks: usize, channels: usize, block: impl Fn(usize, &mut [[f64; 2]]) + Sync + Send) -> Vec<[f64; 2]> {
    let zero = || vec![[0.0; 2]; channels];
    let of_block = |task| {
        let mut sums = zero();
        block(task, &mut sums);
        sums
    };
    (0..blocks).into_par_iter().with_max_len(1).map(of_block).reduce(zero, |mut a, b| {
        a.iter_mut().zip(b).for_each(|(a, b)| *a = [a[0] + b[0], a[1] + b[1]]);
        a
    })
}

/// Values in a line of the cache.
const LINE: usize = 16;

/// Asks for some lines of the cache from `at` on.
#[inline(always)]
fn prefetch(at: *const f32, lines: usize) {
    #[cfg(target_arch = "x86_64")]
    for line in 0..lines {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a prefetch of any address is harmless, and every x86-64 has it.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(at.wrapping_add(LINE * line).cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (at, lines);
}
