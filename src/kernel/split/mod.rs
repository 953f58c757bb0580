//! A 3×3 convolution of f32 from products of 16-bit numbers (bfloat16), where the processor multiplies those in tiles.
//!
//! A number is a high half of 8 bits and a low one of the next 8, x = h + l, and of the product of two such sums three
//! terms are taken (Henry, Tang and Heinecke 2019, "Leveraging the bfloat16 Artificial Intelligence Datatype for
//! Higher-Precision Computations"); sums are f32:
//! ```text
//! x · w ≈ h·h' + h·l' + l·h'        what is left out is below 2⁻¹⁶ of x · w
//! ```
//! So results differ from the direct convolution in the fifth digit, as Winograd's do.
//!
//! Weights of a net in 8 bits are whole numbers of steps: they have no low halves, and two terms are all. The products are
//! two or three times as many as the direct ones and each takes a sixteenth; there are no transforms, and an eighth or a
//! quarter of Winograd's weights to read, for which small pictures of many channels wait.
//!
//! Activations lie channel-last: a row of a tile is some channels of a pixel as they stand in memory, and a tap is one
//! distance. Pixels are counted through the padded rows; what is computed on the margin is left out.

mod finish;
mod picture;
mod product;
#[cfg(test)]
mod tests;
mod weights;

use std::cell::RefCell;
use std::mem::MaybeUninit;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

pub(super) use finish::{Finish, run as finish};
pub(super) use picture::{Row, split};
pub(super) use weights::{Store, Weights};

use self::picture::{Layout, Line};
use self::product::{PIXELS, Product, Sums};
use super::halves::{Halves, TILE, Tiles};
use super::isa::{Isa, on_isa};
use super::padded::SendPtr;
use super::shape::Padding;
use super::team;
use super::tile::Activation;
use crate::job::Cancelled;

/// Bytes of a picture's halves that a task works on, about: they stay in the second-level cache.
const TASK_BYTES: usize = 1 << 20;

thread_local! {
    /// A thread's rows as halves.
    static SCRATCH: RefCell<Vec<Line>> = const { RefCell::new(Vec::new()) };
}

/// A convolution of a picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layer<'a> {
    pub(super) isa: Isa,
    pub(super) halves: Halves,
    /// `[y, x, c]`
    pub(super) x: &'a [f32],
    /// Rows and columns.
    pub(super) size: [usize; 2],
    pub(super) store: &'a Store,
    pub(super) weights: &'a Weights,
    pub(super) bias: &'a [f32],
    pub(super) dilation: usize,
    pub(super) padding: Padding,
    pub(super) activation: Activation,
    /// Whether the input is added behind the activation.
    pub(super) is_residual: bool,
}

impl Layer<'_> {
    /// Writes `[y, x, c]`; after `Ok` every value of `out` is written.
    ///
    /// # Errors
    /// [`Cancelled`] once `cancel` is set.
    pub(super) fn run(&self, out: &mut [MaybeUninit<f32>], cancel: Option<&AtomicBool>) -> Result<(), Cancelled> {
        let to = SendPtr(out.as_mut_ptr().cast());
        let stopped = || cancel.is_some_and(|flag| flag.load(Ordering::Relaxed));
        let [blocks, parts] = self.tasks();
        let piece = |number: usize, of: usize, len: usize| number * len / of..(number + 1) * len / of;
        team::each(blocks * parts, |task| {
            if !stopped() {
                let rows = piece(task % blocks, blocks, self.size[0]);
                self.compute(rows, piece(task / blocks, parts, self.weights.groups()), &to, stopped);
            }
        });
        if stopped() { Err(Cancelled) } else { Ok(()) }
    }

    /// Into how many blocks of rows, and of results, the work is cut: two for each thread, so that one that is late
    /// leaves its second to others.
    fn tasks(&self) -> [usize; 2] {
        let (threads, [height, _]) = (rayon::current_num_threads(), self.size);
        // Margins are split twice, and all weights read for each block: the latter costs more where they are many.
        let least_rows = 2 * self.dilation * if self.has_more_weights(height) { 4 } else { 1 };
        let blocks = self.bytes(height).div_ceil(TASK_BYTES).max(2 * threads).next_multiple_of(threads);
        let blocks = blocks.min(height / least_rows).max(1);
        [blocks, (2 * threads).div_ceil(blocks).min(self.weights.groups())]
    }

    /// Bytes of some rows' halves.
    fn bytes(&self, rows: usize) -> usize {
        let layout = self.layout();
        rows * layout.width * layout.pixel_bytes()
    }

    fn has_more_weights(&self, rows: usize) -> bool {
        self.weights.bytes() > self.bytes(rows)
    }

    fn layout(&self) -> Layout {
        Layout::new(self.weights.channels[0], self.size[1], self.dilation)
    }

    /// Some rows of some groups of 16 results, until it is stopped.
    fn compute(&self, rows: Range<usize>, groups: Range<usize>, out: &SendPtr, stopped: impl Fn() -> bool) {
        let layout = self.layout();
        let taps = layout.taps(self.dilation);
        let pieces = 0..(rows.len() * layout.width).div_ceil(PIXELS);
        SCRATCH.with_borrow_mut(|lines| {
            let first = layout.fill(self, rows.clone(), lines);
            let task = Task { layout, taps: &taps, first, rows, out, tiles: self.halves.tiles(layout.depth) };
            let goes_on = |_: &usize| !stopped();
            // Whichever is more is read once.
            if self.has_more_weights(task.rows.len()) {
                groups
                    .take_while(goes_on)
                    .for_each(|group| pieces.clone().for_each(|piece| self.piece(&task, group, piece)));
            } else {
                pieces
                    .take_while(goes_on)
                    .for_each(|piece| groups.clone().for_each(|group| self.piece(&task, group, piece)));
            }
        });
    }

    /// 16 results at some pixels.
    fn piece(&self, task: &Task, group: usize, piece: usize) {
        let Task { layout, taps, first, ref rows, out, ref tiles } = *task;
        let (channel, pixel, results) = (group * TILE, piece * PIXELS, self.weights.channels[1]);
        let at = rows.start * self.size[1] * results + channel;
        let product = Product {
            pixels: first.wrapping_add(pixel * layout.pixel_bytes()),
            pixel_step: layout.pixel_bytes(),
            low: layout.low(),
            weights: self.weights.group(self.store, group),
            parts: self.weights.parts,
            taps,
        };
        let mut sums = Sums([0.0; PIXELS * TILE]);
        // SAFETY: the rows have room for the last pixels' taps; weights have tiles for each of them.
        unsafe { product.onto(tiles, &mut sums) };
        let finish = Finish {
            sums: &sums,
            first: pixel,
            outer: layout.width,
            size: [rows.len(), self.size[1]],
            step: results,
            factors: self.weights.steps[channel..].as_ptr(),
            bias: self.bias[channel..].as_ptr(),
            activation: self.activation,
            residual: if self.is_residual { self.x[at..].as_ptr() } else { std::ptr::null() },
            // SAFETY: rows and groups are inside the result.
            out: unsafe { out.at(at) },
        };
        on_isa!(self.isa, finish_split(&finish));
    }
}

/// What the pieces of a task share.
struct Task<'a> {
    layout: Layout,
    taps: &'a [usize],
    /// The first byte of the rows' halves.
    first: *const u8,
    rows: Range<usize>,
    out: &'a SendPtr,
    tiles: Tiles,
}
