//! A piece of the picture goes through all layers of a [`VolumeChain`], a few rows at a time.

use std::cell::RefCell;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use super::transform::{POINTS, RESULTS};
use super::volume::{Columns, Ready, Rows, VolumeChain};
use super::volume_tile::{TILE_PIXELS, TILE_STEP, VolumeInput, VolumeTile};
use crate::job::Cancelled;
use crate::kernel::isa::{Isa, on_isa};
use crate::kernel::pack::BLOCK;
use crate::kernel::padded::SendPtr;
use crate::kernel::shape::Padding;
use crate::kernel::team;

/// Values in front of each row: room for the left margin, rows stay aligned.
pub(super) const MARGIN: usize = 16;
/// Rows that each layer makes in a round of all threads.
pub(super) const ROWS: usize = 4;

thread_local! {
    /// A thread's transformed tile.
    static SCRATCH: RefCell<Vec<f32>> = const { RefCell::new(Vec::new()) };
}

/// The rows of one layer's input that are still read, `[slot][view][c][x]`; a view of zeros and a slot of zeros.
pub(super) struct Ring {
    pub(super) values: Vec<f32>,
    slots: usize,
    views: usize,
    channels: usize,
    /// Values from one channel to the next.
    pub(super) step: usize,
}

impl Ring {
    fn new(slots: usize, views: usize, channels: usize, step: usize) -> Self {
        Self { values: vec![0.0; (slots + 1) * (views + 1) * channels * step + MARGIN], slots, views, channels, step }
    }

    /// Where the channels of a view's row begin; outside of the picture `None`, all zeros.
    pub(super) fn at(&self, view: Option<usize>, y: Option<usize>) -> usize {
        let slot = y.map_or(self.slots, |y| y % self.slots);
        (slot * (self.views + 1) + view.unwrap_or(self.views)) * self.view_step()
    }

    fn view_step(&self) -> usize {
        self.channels * self.step
    }
}

/// Gives the rows of some channels their left and right margin.
fn close(rows: &mut [f32], step: usize, width: usize, padding: Padding) {
    for row in rows.chunks_exact_mut(step) {
        let ends = [row[MARGIN], row[MARGIN + width - 1]];
        let [left, right] = if padding == Padding::Edge { ends } else { [0.0; 2] };
        (row[MARGIN - 1], row[MARGIN + width]) = (left, right);
    }
}

/// The place inside `0 .. size` that stands at `at`; `None` where zeros do.
fn inside(at: isize, size: usize, padding: Padding) -> Option<usize> {
    let inside = at.clamp(0, size as isize - 1);
    (inside == at || padding == Padding::Edge).then_some(inside as usize)
}

/// One pass down a piece of the picture.
pub(super) struct Pass<'a> {
    chain: &'a VolumeChain,
    size: [usize; 3],
    /// Columns of the picture that are computed, and those of them that count.
    piece: Range<usize>,
    keep: Range<usize>,
    /// Rows that each layer makes in a round.
    rows: usize,
    /// The input of each layer, and the result of the last.
    rings: Vec<Ring>,
    cancel: Option<&'a AtomicBool>,
}

impl<'a> Pass<'a> {
    pub(super) fn new(
        chain: &'a VolumeChain,
        size: [usize; 3],
        piece: Range<usize>,
        keep: Range<usize>,
        cancel: Option<&'a AtomicBool>,
    ) -> Self {
        // An odd number of cache lines, lest the channels' rows fall into one set of the cache.
        let step = (piece.len().div_ceil(16) + 2) / 2 * 32 + 16;
        let ring = |channels: usize| Ring::new(ROWS + 2, size[0], channels, step);
        let inputs = chain.layers.iter().map(|layer| layer.channels[0]);
        let rings = inputs.chain([chain.channels()[1]]).map(ring).collect();
        Self { chain, size, piece, keep, rows: ROWS, rings, cancel }
    }

    pub(super) fn run(
        &mut self,
        fill: &(impl Fn(Columns, &mut [f32], usize) + Sync),
        take: &mut impl FnMut(Rows),
    ) -> Result<(), Cancelled> {
        let (layers, height, rows) = (self.chain.layers.len(), self.size[1], self.rows);
        for round in 0..(height + layers).div_ceil(rows) {
            // The rows that the `layer`-th result (0: the input) gets in this round.
            let of = |layer: usize| {
                let end = ((round + 1) * rows).saturating_sub(layer).min(height);
                (round * rows).saturating_sub(layer).min(end)..end
            };
            self.fill(of(0), fill);
            for layer in 0..layers {
                self.convolve(layer, of(layer + 1));
                if self.stopped() {
                    return Err(Cancelled);
                }
            }
            let y = of(layers);
            if !y.is_empty() {
                take(Rows { ring: &self.rings[layers], y, x: self.keep.clone(), first_x: self.piece.start });
            }
        }
        Ok(())
    }

    fn stopped(&self) -> bool {
        self.cancel.is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// Asks for rows of the input.
    fn fill(&mut self, rows: Range<usize>, fill: &(impl Fn(Columns, &mut [f32], usize) + Sync)) {
        let (x, padding, ring) = (self.piece.clone(), self.chain.padding, &mut self.rings[0]);
        let (views, slots, step, len) = (ring.views, ring.slots, ring.step, ring.view_step());
        let whole = ring.values.len() / len * len;
        team::each_chunk(&mut ring.values[..whole], len, |i, values| {
            let (slot, view) = (i / (views + 1), i % (views + 1));
            let y = rows.clone().find(|y| y % slots == slot).filter(|_| slot < slots && view < views);
            if let Some(y) = y {
                fill(Columns { view, y, x: x.clone() }, &mut values[MARGIN..], step);
                close(values, step, x.len(), padding);
            }
        });
    }

    /// Makes rows of one layer's result.
    fn convolve(&mut self, layer: usize, rows: Range<usize>) {
        let (before, after) = self.rings.split_at_mut(layer + 1);
        let (ring, out) = (&before[layer], &mut after[0]);
        let task = Task {
            ready: &self.chain.layers[layer],
            isa: self.chain.isa,
            padding: self.chain.padding,
            ring,
            rows: rows.clone(),
            size: self.size,
            width: self.piece.len(),
        };
        let out_values = SendPtr(out.values.as_mut_ptr());
        let out: &Ring = out;
        let stopped = || self.cancel.is_some_and(|flag| flag.load(Ordering::Relaxed));
        team::each(self.size[0].div_ceil(RESULTS), |group| {
            if !stopped() && !rows.is_empty() {
                SCRATCH.with_borrow_mut(|scratch| task.run(group, out, out_values, scratch));
            }
        });
    }
}

/// Some rows of one layer's result.
struct Task<'a> {
    ready: &'a Ready,
    isa: Isa,
    padding: Padding,
    ring: &'a Ring,
    rows: Range<usize>,
    size: [usize; 3],
    width: usize,
}

impl Task<'_> {
    /// Four neighbouring views. `out` says where they lie in `values`.
    fn run(&self, group: usize, out: &Ring, values: SendPtr, scratch: &mut Vec<f32>) {
        let [channels_in, channels_out] = self.ready.channels;
        let (step, views) = (self.ring.step, group * RESULTS..((group + 1) * RESULTS).min(self.size[0]));
        let channel_step = (self.rows.len() + 2) * TILE_STEP;
        scratch.resize(scratch.len().max(POINTS * channels_in * channel_step + TILE_STEP), 0.0);
        let sources: Vec<[usize; POINTS]> = (0..self.rows.len() + 2).map(|row| self.sources(group, row)).collect();
        let tiles = self.width.div_ceil(TILE_PIXELS);
        // Whole vectors, about equally many in each tile.
        let pixels = self.width.div_ceil(tiles).next_multiple_of(16);
        for x in (0..self.width).step_by(pixels) {
            let pixels = pixels.min(self.width - x);
            let place = |at: usize| self.ring.values[at + MARGIN - 1 + x..].as_ptr();
            let mut rows = [[std::ptr::null(); POINTS]; ROWS + 2];
            rows.iter_mut().zip(&sources).for_each(|(row, views)| *row = views.map(place));
            let (rows, to) = (&rows[..sources.len()], scratch.as_mut_ptr());
            let input = VolumeInput { rows, channels: channels_in, channel_step: step, pixels, to };
            on_isa!(self.isa, winograd_views(&input));
            for (row, y) in self.rows.clone().enumerate() {
                for block in 0..channels_out.div_ceil(BLOCK) {
                    let to = out.at(Some(views.start), Some(y)) + block * BLOCK * step + MARGIN + x;
                    let tile = VolumeTile {
                        x: scratch[row * TILE_STEP..].as_ptr(),
                        channels_in,
                        channel_step,
                        weights: self.ready.block(block).as_ptr(),
                        bias: self.ready.bias[block * BLOCK..].as_ptr(),
                        // SAFETY: these rows of these views are this task's alone.
                        out: unsafe { values.at(to) },
                        out_step: step,
                        view_step: out.view_step(),
                        channels_out: (channels_out - block * BLOCK).min(BLOCK),
                        views: views.len(),
                        pixels,
                        activation: self.ready.activation,
                    };
                    on_isa!(self.isa, winograd_volume(&tile));
                }
            }
        }
        for (view, y) in views.flat_map(|view| self.rows.clone().map(move |y| (view, y))) {
            // SAFETY: as above.
            let rows = unsafe {
                let first = values.at(out.at(Some(view), Some(y)));
                std::slice::from_raw_parts_mut(first, out.view_step())
            };
            close(rows, step, self.width, self.padding);
        }
    }

    /// Where the six views around a group begin in one row, counted from the one above the first.
    fn sources(&self, group: usize, row: usize) -> [usize; POINTS] {
        let y = inside((self.rows.start + row) as isize - 1, self.size[1], self.padding);
        [0, 1, 2, 3, 4, 5].map(|i| {
            let view = inside((group * RESULTS + i) as isize - 1, self.size[0], self.padding);
            self.ring.at(view, y)
        })
    }
}
