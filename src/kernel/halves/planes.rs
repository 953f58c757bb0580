//! Padded planes and weights of 16-bit numbers, laid out as tiles read them.

use rayon::prelude::*;

use super::product::{Product, Step};
use super::{ACROSS, TAPS, TILE};
use crate::kernel::isa::{Isa, on_isa};
use crate::kernel::padded::by_chunks;
use crate::kernel::shape::{ConvShape, Padding};

/// bfloat16, the nearest, in the low half.
#[inline(always)]
pub(in crate::kernel) fn rounded(value: f32) -> u32 {
    let bits = value.to_bits();
    bits.wrapping_add(0x7fff + (bits >> 16 & 1)) >> 16
}

/// Two rows as one row of pairs.
#[inline(always)]
pub(in crate::kernel) fn pair([a, b]: [&[f32]; 2], to: &mut [u32]) {
    to.iter_mut().zip(a.iter().zip(b)).for_each(|(to, (a, b))| *to = rounded(*a) | rounded(*b) << 16);
}

/// A row as pairs of neighbouring pixels.
#[inline(always)]
pub(in crate::kernel) fn pair_pixels(row: &[f32], to: &mut [u32]) {
    let (pairs, last) = row.as_chunks::<2>();
    to.iter_mut().zip(pairs).for_each(|(to, [a, b])| *to = rounded(*a) | rounded(*b) << 16);
    last.iter().for_each(|last| to[pairs.len()] = rounded(*last));
}

/// A row as one of 16-bit numbers.
#[inline(always)]
pub(in crate::kernel) fn halve(row: &[f32], to: &mut [u16]) {
    to.iter_mut().zip(row).for_each(|(to, value)| *to = rounded(*value) as u16);
}

/// How padded planes lie in memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub(super) images: usize,
    /// Planes of an image.
    pub(super) planes: usize,
    /// Rows and columns of the picture.
    size: [usize; 2],
    margin: usize,
    is_edge: bool,
    /// Columns with margins.
    pub(super) width: usize,
    /// Values from one plane to the next.
    pub(super) step: usize,
}

impl Layout {
    /// Planes of values of `bytes`, with room for what a kernel's last tiles read beside the picture.
    pub(super) fn new(shape: &ConvShape, planes: usize, margin: usize, padding: Padding, bytes: usize) -> Self {
        let ConvShape { batch, height, width, dilation, .. } = *shape;
        // Pairs of pixels begin at even places.
        let outer = (width + 2 * margin).next_multiple_of(2);
        let values = (height + 2 * margin) * outer + ACROSS + 2 * dilation;
        let line = 64 / bytes;
        // An odd number of lines: neighbouring planes do not collide in a cache.
        let step = (values.div_ceil(line) | 1) * line;
        let is_edge = padding == Padding::Edge;
        Self { images: batch, planes, size: [height, width], margin, is_edge, width: outer, step }
    }

    /// Rows and columns where a kernel is inside.
    pub(super) fn inside(&self, dilation: usize) -> [usize; 2] {
        self.size.map(|side| side + 2 * self.margin - 2 * dilation)
    }

    /// Writes a row of a plane by `write`, and what is repeated of it on the margin.
    pub(super) fn put<T: Copy>(&self, plane: &mut [T], y: usize, write: impl FnOnce(&mut [T])) {
        let (margin, [height, width]) = (self.margin, self.size);
        let at = (margin + y) * self.width;
        let row = &mut plane[at..][..self.width];
        write(&mut row[margin..margin + width]);
        if !self.is_edge {
            return;
        }
        let (first, last) = (row[margin], row[margin + width - 1]);
        row[..margin].fill(first);
        row[margin + width..].fill(last);
        let above = if y == 0 { margin } else { 0 };
        let below = if y + 1 == height { margin } else { 0 };
        for row in (0..above).chain(margin + height..margin + height + below) {
            plane.copy_within(at..at + self.width, row * self.width);
        }
    }
}

/// Planes of pairs of channels: what weights are multiplied with.
pub(super) struct Pairs {
    pub(super) values: Vec<u32>,
    pub(super) layout: Layout,
}

impl Pairs {
    /// Pairs of channels that are multiplied in one go: half a tile where there are no more.
    pub(super) fn depth(channels: usize) -> usize {
        if channels <= TILE { TILE / 2 } else { TILE }
    }

    /// Of channels `[n, c, y, x]` whose rows `fill` writes, each from an index on.
    pub(super) fn build(
        shape: &ConvShape,
        isa: Isa,
        channels: usize,
        (margin, padding): (usize, Padding),
        fill: impl Fn(&mut [f32], usize) + Sync,
    ) -> Self {
        let ConvShape { height, width, .. } = *shape;
        let pairs = channels.div_ceil(2).next_multiple_of(Self::depth(channels));
        let layout = Layout::new(shape, pairs, margin, padding, size_of::<u32>());
        let values = by_chunks(layout.images * pairs, layout.step, |plane, values| {
            let (image, first) = (plane / pairs, plane % pairs * 2);
            let mut rows = vec![0.0; 2 * width];
            for y in (0..height).filter(|_| first < channels) {
                for (channel, row) in (first..channels).zip(rows.chunks_mut(width)) {
                    fill(row, ((image * channels + channel) * height + y) * width);
                }
                layout.put(values, y, |to| on_isa!(isa, pair_rows(rows.split_at(width).into(), to)));
            }
        });
        Self { values, layout }
    }
}

/// Weights `[16 results][pairs]` of each tap, tile after tile.
pub(super) struct Weights {
    values: Vec<u16>,
    pub(super) results: usize,
    /// Pairs of channels that are multiplied in one go, and how often.
    pub(super) depth: usize,
    blocks: usize,
}

impl Weights {
    /// `of` gives the weight of (result, channel, tap).
    pub(super) fn pack([results, channels]: [usize; 2], of: impl Fn(usize, usize, usize) -> f32 + Sync) -> Self {
        let depth = Pairs::depth(channels);
        let blocks = channels.div_ceil(2 * depth);
        let group = blocks * TAPS * TILE * 2 * depth;
        let mut values = vec![0; results.div_ceil(TILE) * group];
        values.par_chunks_mut(2 * depth).enumerate().for_each(|(row, values)| {
            let (result, tap) = (row % TILE + row / TILE / TAPS / blocks * TILE, row / TILE % TAPS);
            let first = row / TILE / TAPS % blocks * 2 * depth;
            if result < results {
                let row = (first..channels).map(|channel| of(result, channel, tap));
                values.iter_mut().zip(row).for_each(|(to, value)| *to = rounded(value) as u16);
            }
        });
        Self { values, results, depth, blocks }
    }

    pub(super) fn groups(&self) -> usize {
        self.results.div_ceil(TILE)
    }

    /// Bytes of a tile.
    fn tile(&self) -> usize {
        TILE * self.depth * size_of::<u32>()
    }

    /// Where the tiles of weights and of pixels of each product lie.
    pub(super) fn steps(&self, layout: &Layout, dilation: usize) -> Vec<Step> {
        let place = |block: usize, tap: usize| {
            let pixels = (tap / 3 * layout.width + tap % 3) * dilation;
            [(block * TAPS + tap) * self.tile(), (block * self.depth * layout.step + pixels) * size_of::<u32>()]
        };
        (0..self.blocks).flat_map(|block| (0..TAPS).map(move |tap| place(block, tap))).collect()
    }

    /// The product of one or two groups of 16 results with the pixels from `pixel` on.
    pub(super) fn product(&self, group: usize, layout: &Layout, pixel: *const u32) -> Product {
        let bytes = self.blocks * TAPS * self.tile();
        Product {
            rows: self.values.as_ptr().cast::<u8>().wrapping_add(group * bytes),
            row_step: self.depth * size_of::<u32>(),
            more_rows: (group + 1 < self.groups()).then_some(bytes),
            columns: pixel.cast(),
            column_step: layout.step * size_of::<u32>(),
            more_columns: TILE * size_of::<u32>(),
            adds: false,
        }
    }
}
