//! Consecutive 3×3×3 convolutions over (views, rows, columns) by Winograd's F(4, 3) along the views.
//!
//! All layers go down the picture together: a few rows of the input are asked for, and each layer makes the rows that
//! the rows above it allow. Of each layer's result only the rows that the next one still reads are kept.
//! Wide pictures are cut into columns, so that all this stays in cache; memory does not follow the picture's height.

use std::mem::MaybeUninit;
use std::ops::Range;
use std::sync::atomic::AtomicBool;

use super::Layer;
use super::transform::{POINTS, of_weights};
use super::volume_pass::{MARGIN, Pass, ROWS, Ring};
use crate::job::Cancelled;
use crate::kernel::isa::Isa;
use crate::kernel::pack::BLOCK;
use crate::kernel::shape::Padding;
use crate::kernel::team;
use crate::kernel::tile::Activation;

/// Memory that the kept rows of all layers may take.
const CACHE_BYTES: usize = 16 << 20;
/// Values of the widest vector: pieces are a multiple of it.
const VECTOR: usize = 16;
/// 3×3×3 convolutions that follow each other, weights transformed.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeChain {
    pub(super) isa: Isa,
    pub(super) padding: Padding,
    pub(super) layers: Vec<Ready>,
}

/// A layer with transformed weights.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ready {
    /// `[c_out / 8][component][c_in][tap][8]`
    weights: Vec<f32>,
    /// Whole blocks of 8.
    pub(super) bias: Vec<f32>,
    pub(super) channels: [usize; 2],
    pub(super) activation: Activation,
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
    pub(super) ring: &'a Ring,
    /// Rows of the picture.
    pub y: Range<usize>,
    /// Columns of the picture.
    pub x: Range<usize>,
    /// First column of the piece that is being computed.
    pub(super) first_x: usize,
}

impl Rows<'_> {
    /// Values of one channel of one view at row `y` of the picture, for the columns [`x`](Self::x).
    pub fn row(&self, view: usize, channel: usize, y: usize) -> &[f32] {
        let row = self.ring.at(Some(view), Some(y)) + channel * self.ring.step;
        &self.ring.values[row + MARGIN + self.x.start - self.first_x..][..self.x.len()]
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
            team::each_chunk(out, height * width, |i, plane| {
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
        let column = channels * views * (ROWS + 2) * size_of::<f32>();
        (CACHE_BYTES / column / VECTOR * VECTOR).max(6 * VECTOR + 4 * self.layers.len())
    }
}

/// Pieces of at most `widest` columns that overlap by `halo` on either side, and the columns of each that count.
pub(super) fn pieces(width: usize, widest: usize, halo: usize) -> Vec<(Range<usize>, Range<usize>)> {
    if width <= widest {
        return vec![(0..width, 0..width)];
    }
    let count = (width - 2 * halo).div_ceil(widest - 2 * halo);
    // All pieces are equally wide, in whole vectors.
    let piece = ((width - 2 * halo).div_ceil(count) + 2 * halo).next_multiple_of(VECTOR).min(widest);
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
        let Layer { channels: [c_in, c_out], activation, is_residual, .. } = *layer;
        assert!(!is_residual, "a sum is done in planes alone");
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

    /// The weights of the `block`-th group of 8 channels.
    pub(super) fn block(&self, block: usize) -> &[f32] {
        let len = POINTS * self.channels[0] * 9 * BLOCK;
        &self.weights[block * len..][..len]
    }
}
