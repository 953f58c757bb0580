//! Consecutive 3×3×3 convolutions over (views, rows, columns) by Winograd's F(4, 3) along the views.
//!
//! All layers go down the picture together: a few rows of the input are asked for, and each layer makes the rows that
//! the rows above it allow. Of each layer's result only the rows that the next one still reads are kept, transformed.
//! Wide pictures are cut into columns, so that all this stays in cache; memory does not follow the picture's height.

use std::mem::MaybeUninit;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::Layer;
use super::transform::{POINTS, RESULTS, of_weights};
use super::volume_tile::VolumeTile;
use crate::job::Cancelled;
use crate::kernel::isa::{Isa, on_isa};
use crate::kernel::pack::BLOCK;
use crate::kernel::padded::SendPtr;
use crate::kernel::shape::Padding;
use crate::kernel::tile::Activation;

/// Values in front of each row: room for the left margin, rows stay aligned.
const MARGIN: usize = 16;
/// Memory that the kept rows of all layers may take.
const CACHE_BYTES: usize = 16 << 20;
/// Columns of the widest tile: pieces are a multiple of it.
const TILE_COLUMNS: usize = 48;
/// Pixels of a row that are worth a round of all threads.
const ROUND_PIXELS: usize = 512;

/// 3×3×3 convolutions that follow each other, weights transformed.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeChain {
    isa: Isa,
    padding: Padding,
    layers: Vec<Ready>,
}

/// A layer with transformed weights.
#[derive(Clone, Debug, PartialEq)]
struct Ready {
    /// `[c_out / 8][component][c_in][tap][8]`
    weights: Vec<f32>,
    /// Whole blocks of 8.
    bias: Vec<f32>,
    channels: [usize; 2],
    activation: Activation,
}

/// Columns of one row of one view.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Columns {
    /// View.
    pub view: usize,
    /// Row.
    pub y: usize,
    /// Columns.
    pub x: Range<usize>,
}

/// Some rows of the result, all channels and views, at some columns of the picture.
pub struct Rows<'a> {
    values: &'a [f32],
    steps: Steps,
    /// Rows of the picture.
    pub y: Range<usize>,
    /// Columns of the picture.
    pub x: Range<usize>,
    /// First column of the piece that is being computed.
    first_x: usize,
}

impl Rows<'_> {
    /// Values of one channel of one view at row `y` of the picture, for the columns [`x`](Self::x).
    pub fn row(&self, view: usize, channel: usize, y: usize) -> &[f32] {
        let row = self.steps.raw(y - self.y.start, view) + channel * self.steps.channel;
        &self.values[row + MARGIN + self.x.start - self.first_x..][..self.x.len()]
    }
}

/// Where things lie while a piece of the picture is computed.
#[derive(Clone, Copy)]
struct Steps {
    /// Values from one channel to the next.
    channel: usize,
    /// Channels of the widest layer.
    most: usize,
    /// Views, and one of zeros.
    views: usize,
}

impl Steps {
    /// Where a view's row begins in the untransformed rows.
    fn raw(&self, row: usize, view: usize) -> usize {
        (row * self.views + view) * self.most * self.channel
    }
}

impl VolumeChain {
    /// Transforms the weights of `layers`; each takes the channels that the one before it makes. All have dilation 1
    /// and the padding of the first.
    pub fn new(layers: &[Layer], isa: Isa) -> Self {
        let padding = layers.first().map_or(Padding::Edge, |layer| layer.padding);
        Self { isa, padding, layers: layers.iter().map(Ready::new).collect() }
    }

    /// Channels of input and result.
    pub fn channels(&self) -> [usize; 2] {
        let ends = self.layers.first().zip(self.layers.last());
        ends.map_or([0; 2], |(first, last)| [first.channels[0], last.channels[1]])
    }

    /// Runs the chain over `[views, rows, columns]`.
    ///
    /// `fill` writes the columns that it is asked for: channel c from c·step on, step being its last argument. `take`
    /// gets finished rows, each value of the picture once.
    ///
    /// # Errors
    /// [`Cancelled`] once `cancel` is set.
    pub fn run(
        &self,
        size: [usize; 3],
        fill: impl Fn(Columns, &mut [f32], usize) + Sync,
        mut take: impl FnMut(Rows),
        cancel: Option<&AtomicBool>,
    ) -> Result<(), Cancelled> {
        let halo = self.layers.len();
        assert!(!size.contains(&0), "a picture of {size:?}");
        for (piece, keep) in pieces(size[2], self.widest_piece(size[0]), halo) {
            Pass::new(self, size, piece, keep, cancel).run(&fill, &mut take)?;
        }
        Ok(())
    }

    /// [`run`](Self::run) on `x` `[c, v, y, x]`. After `Ok` every value of `out` is written.
    ///
    /// # Errors
    /// [`Cancelled`] once `cancel` is set.
    pub fn run_slice(
        &self,
        x: &[f32],
        size: [usize; 3],
        out: &mut [MaybeUninit<f32>],
        cancel: Option<&AtomicBool>,
    ) -> Result<(), Cancelled> {
        let ([views, height, width], channels) = (size, self.channels());
        let plane: usize = size.iter().product();
        assert_eq!([x.len(), out.len()], channels.map(|c| c * plane), "lengths of input and result");
        let fill = |at: Columns, rows: &mut [f32], step: usize| {
            for (c, row) in rows.chunks_mut(step).enumerate().take(channels[0]) {
                let from = &x[((c * views + at.view) * height + at.y) * width..][at.x.clone()];
                row[..from.len()].copy_from_slice(from);
            }
        };
        let take = |rows: Rows| {
            out.par_chunks_exact_mut(height * width).enumerate().for_each(|(i, plane)| {
                for y in rows.y.clone() {
                    let from = rows.row(i % views, i / views, y);
                    plane[y * width..][rows.x.clone()].iter_mut().zip(from).for_each(|(to, from)| _ = to.write(*from));
                }
            });
        };
        self.run(size, fill, take, cancel)
    }

    /// Columns whose kept rows fit into [`CACHE_BYTES`].
    pub(super) fn widest_piece(&self, views: usize) -> usize {
        let channels: usize = self.layers.iter().map(|layer| layer.channels[0]).sum();
        let column = channels * views.div_ceil(RESULTS) * POINTS * 3 * size_of::<f32>();
        (CACHE_BYTES / column / TILE_COLUMNS * TILE_COLUMNS).max(2 * TILE_COLUMNS + 4 * self.layers.len())
    }
}

/// Pieces of at most `widest` columns that overlap by `halo` on either side, and the columns of each that count.
pub(super) fn pieces(width: usize, widest: usize, halo: usize) -> Vec<(Range<usize>, Range<usize>)> {
    if width <= widest {
        return vec![(0..width, 0..width)];
    }
    let count = (width - 2 * halo).div_ceil(widest - 2 * halo);
    // All pieces are equally wide, in whole tiles.
    let piece = ((width - 2 * halo).div_ceil(count) + 2 * halo).next_multiple_of(TILE_COLUMNS).min(widest);
    let step = piece - 2 * halo;
    (0..count)
        .map(|i| {
            let first = (i * step).min(width - piece);
            let from = if i == 0 { 0 } else { i * step + halo };
            let to = if i + 1 == count { width } else { (i + 1) * step + halo };
            (first..first + piece, from..to.min(width))
        })
        .filter(|(_, keep)| !keep.is_empty())
        .collect()
}

impl Ready {
    fn new(layer: &Layer) -> Self {
        let Layer { channels: [c_in, c_out], activation, .. } = *layer;
        assert_eq!(layer.weights.len(), c_in * c_out * 27, "number of weights");
        assert_eq!(layer.dilation, 1, "dilation of a volume");
        let mut weights = vec![0.0; c_out.div_ceil(BLOCK) * POINTS * c_in * 9 * BLOCK];
        for (i, taps) in layer.weights.chunks_exact(27).enumerate() {
            let (o, c) = (i / c_in, i % c_in);
            for tap in 0..9 {
                let along_views = of_weights([taps[tap], taps[9 + tap], taps[18 + tap]]);
                for (component, weight) in along_views.into_iter().enumerate() {
                    let at = ((o / BLOCK * POINTS + component) * c_in + c) * 9 + tap;
                    weights[at * BLOCK + o % BLOCK] = weight;
                }
            }
        }
        let mut bias = layer.bias.to_vec();
        bias.resize(c_out.next_multiple_of(BLOCK), 0.0);
        Self { weights, bias, channels: [c_in, c_out], activation }
    }
}

/// The transformed rows of one layer's input that are still read, `[slot][component][c][x]`, and a slot of zeros.
struct Ring {
    values: Vec<f32>,
    slots: usize,
    slot_step: usize,
    component_step: usize,
}

/// One pass down a piece of the picture.
struct Pass<'a> {
    chain: &'a VolumeChain,
    size: [usize; 3],
    /// Columns of the picture that are computed, and those of them that count.
    piece: Range<usize>,
    keep: Range<usize>,
    /// Rows that each layer makes in a round.
    rows: usize,
    steps: Steps,
    rings: Vec<Ring>,
    /// Rows of one layer's result, not transformed: `[row][view][c][x]`.
    raw: Vec<f32>,
    cancel: Option<&'a AtomicBool>,
}

impl<'a> Pass<'a> {
    fn new(
        chain: &'a VolumeChain,
        size: [usize; 3],
        piece: Range<usize>,
        keep: Range<usize>,
        cancel: Option<&'a AtomicBool>,
    ) -> Self {
        let width = piece.len();
        // An odd number of cache lines, lest the channels' rows fall into one set of the cache.
        let channel = (width.next_multiple_of(16) / 16 + 2) / 2 * 32 + 16;
        let most = chain.layers.iter().flat_map(|layer| layer.channels).max().unwrap_or(1);
        let steps = Steps { channel, most, views: size[0] + 1 };
        let rows = ROUND_PIXELS.div_ceil(width).min(8);
        let components = size[0].div_ceil(RESULTS) * POINTS;
        let ring = |layer: &Ready| {
            let (slots, component_step) = (rows + 2, layer.channels[0] * channel);
            let slot_step = components * component_step;
            Ring { values: vec![0.0; (slots + 1) * slot_step + 64], slots, slot_step, component_step }
        };
        let rings = chain.layers.iter().map(ring).collect();
        let raw = vec![0.0; steps.raw(rows, 0)];
        Self { chain, size, piece, keep, rows, steps, rings, raw, cancel }
    }

    fn run(&mut self, fill: &(impl Fn(Columns, &mut [f32], usize) + Sync), take: &mut impl FnMut(Rows)) -> Result<(), Cancelled> {
        let (layers, height, rows) = (self.chain.layers.len(), self.size[1], self.rows);
        for round in 0..(height + layers).div_ceil(rows) {
            // The rows that the `layer`-th result (0: the input) gets in this round.
            let of = |layer: usize| {
                let end = ((round + 1) * rows).saturating_sub(layer).min(height);
                (round * rows).saturating_sub(layer).min(end)..end
            };
            self.fill(of(0), fill);
            self.keep_for(0, of(0));
            for layer in 0..layers {
                if self.cancel.is_some_and(|flag| flag.load(Ordering::Relaxed)) {
                    return Err(Cancelled);
                }
                self.convolve(layer, of(layer + 1));
                if layer + 1 < layers {
                    self.keep_for(layer + 1, of(layer + 1));
                }
            }
            let y = of(layers);
            if !y.is_empty() {
                take(Rows { values: &self.raw, steps: self.steps, y, x: self.keep.clone(), first_x: self.piece.start });
            }
        }
        Ok(())
    }

    /// Asks for rows of the input.
    fn fill(&mut self, rows: Range<usize>, fill: &(impl Fn(Columns, &mut [f32], usize) + Sync)) {
        let (views, step, len) = (self.size[0], self.steps.channel, self.steps.most * self.steps.channel);
        let x = self.piece.clone();
        self.raw.par_chunks_exact_mut(len).enumerate().for_each(|(i, values)| {
            let (row, view) = (i / (views + 1), i % (views + 1));
            if row < rows.len() && view < views {
                fill(Columns { view, y: rows.start + row, x: x.clone() }, &mut values[MARGIN..], step);
            }
        });
    }

    /// Transforms untransformed rows into the ring of `layer`'s inputs, with their margins.
    fn keep_for(&mut self, layer: usize, rows: Range<usize>) {
        let (isa, padding, views, width) = (self.chain.isa, self.chain.padding, self.size[0], self.piece.len());
        let (steps, raw, ring) = (self.steps, &self.raw[..], &mut self.rings[layer]);
        let (slots, component_step) = (ring.slots, ring.component_step);
        let first = SendPtr(ring.values.as_mut_ptr());
        let groups = views.div_ceil(RESULTS);
        let slot_step = ring.slot_step;
        (0..rows.len() * groups).into_par_iter().with_min_len(4).for_each(|task| {
            let (row, group) = (task % rows.len(), task / rows.len());
            let view = |i: usize| {
                let at = (group * RESULTS + i) as isize - 1;
                let inside = at.clamp(0, views as isize - 1);
                let outside = inside != at && padding == Padding::Zero;
                raw[steps.raw(row, if outside { views } else { inside as usize })..].as_ptr()
            };
            let at = (rows.start + row) % slots * slot_step + group * POINTS * component_step;
            // SAFETY: this row and group of the ring are this task's alone.
            let to = unsafe { std::slice::from_raw_parts_mut(first.at(at), POINTS * component_step) };
            let neighbours = [0, 1, 2, 3, 4, 5].map(view);
            on_isa!(isa, winograd_views(neighbours, to.as_mut_ptr(), component_step, component_step));
            for row in to.chunks_exact_mut(steps.channel) {
                let (left, right) = (row[MARGIN], row[MARGIN + width - 1]);
                let edge = padding == Padding::Edge;
                row[MARGIN - 1] = if edge { left } else { 0.0 };
                row[MARGIN + width] = if edge { right } else { 0.0 };
            }
        });
    }

    /// Makes rows of one layer's result, untransformed.
    fn convolve(&mut self, layer: usize, rows: Range<usize>) {
        let ready = &self.chain.layers[layer];
        let (ring, steps) = (&self.rings[layer], self.steps);
        let (isa, padding, [views, height, _]) = (self.chain.isa, self.chain.padding, self.size);
        let width = self.piece.len();
        let groups = views.div_ceil(RESULTS);
        let out = SendPtr(self.raw.as_mut_ptr());
        let slot = |y: usize, tap: usize| {
            let at = y as isize + tap as isize - 1;
            let inside = at.clamp(0, height as isize - 1);
            let outside = inside != at && padding == Padding::Zero;
            if outside { ring.slots } else { inside as usize % ring.slots }
        };
        let stopped = || self.cancel.is_some_and(|flag| flag.load(Ordering::Relaxed));
        // The rows of a group follow each other on one thread: they read nearly the same.
        (0..rows.len() * groups).into_par_iter().with_max_len(1).for_each(|task| {
            let (row, group) = (task % rows.len(), task / rows.len());
            if stopped() {
                return;
            }
            let taps = std::array::from_fn(|tap| slot(rows.start + row, tap / 3) * ring.slot_step + tap % 3);
            let x = &ring.values[group * POINTS * ring.component_step + MARGIN - 1..];
            // SAFETY: these views of this row are this task's alone.
            let out = unsafe { out.at(steps.raw(row, group * RESULTS) + MARGIN) };
            ready.row(isa, x, &taps, ring.component_step, (views - group * RESULTS).min(RESULTS), width, out, steps);
        });
    }
}

impl Ready {
    /// One row of up to four views.
    #[allow(clippy::too_many_arguments, reason = "the ends of two buffers")]
    fn row(
        &self,
        isa: Isa,
        x: &[f32],
        taps: &[usize; 9],
        component_step: usize,
        views: usize,
        width: usize,
        out: *mut f32,
        steps: Steps,
    ) {
        let (lanes, [channels_in, channels_out]) = (isa.lanes(), self.channels);
        let vectors = width.div_ceil(lanes);
        let per_tile = vectors.div_ceil(vectors.div_ceil(3));
        let block_len = POINTS * channels_in * 9 * BLOCK;
        for first in (0..vectors).step_by(per_tile) {
            let at = first * lanes;
            for block in 0..channels_out.div_ceil(BLOCK) {
                let tile = VolumeTile {
                    x: x[at..].as_ptr(),
                    next: x.as_ptr().wrapping_add(at + per_tile * lanes),
                    channels_in,
                    channel_step: steps.channel,
                    component_step,
                    taps,
                    weights: self.weights[block * block_len..].as_ptr(),
                    bias: self.bias[block * BLOCK..].as_ptr(),
                    // SAFETY: the result has this channel and these columns.
                    out: unsafe { out.add(block * BLOCK * steps.channel + at) },
                    view_step: steps.most * steps.channel,
                    channels_out: (channels_out - block * BLOCK).min(BLOCK),
                    views,
                    vectors: per_tile.min(vectors - first),
                    width: width - at,
                    activation: self.activation,
                };
                on_isa!(isa, winograd_volume(&tile));
            }
        }
    }
}
