//! Rows of a picture as high and low halves, with margins.

use std::ops::Range;

use super::{Layer, PIXELS, TILE};
use crate::kernel::halves::rounded;
use crate::kernel::isa::on_isa;
use crate::kernel::shape::Padding;

/// A line of the cache: tiles are read faster where their rows do not cross two.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub(in crate::kernel) struct Line([u16; Line::LEN]);

impl Line {
    pub(super) const ZERO: Self = Self([0; Self::LEN]);
    /// Halves in a line.
    pub(super) const LEN: usize = 32;

    /// The halves of some lines.
    pub(super) fn halves(lines: &mut [Self]) -> &mut [u16] {
        let len = lines.len() * Self::LEN;
        // SAFETY: a line is nothing but its halves.
        unsafe { std::slice::from_raw_parts_mut(lines.as_mut_ptr().cast(), len) }
    }
}

/// Where the halves of a pixel lie: `[y][x][high, low][block][2 · depth channels]`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    /// Columns with margins.
    pub(super) width: usize,
    /// Pairs of channels that are multiplied in one go: half a tile where there are no more.
    pub(super) depth: usize,
    /// How often.
    blocks: usize,
    margin: usize,
}

impl Layout {
    pub(super) fn new(channels: usize, columns: usize, margin: usize) -> Self {
        let depth = Self::depth(channels);
        Self { width: columns + 2 * margin, depth, blocks: channels.div_ceil(2 * depth), margin }
    }

    pub(super) fn depth(channels: usize) -> usize {
        if channels <= TILE { TILE / 2 } else { TILE }
    }

    /// Channels, and zeros up to a whole block.
    fn padded(&self) -> usize {
        self.blocks * 2 * self.depth
    }

    /// Bytes from a pixel's high halves to its low ones.
    pub(super) fn low(&self) -> usize {
        self.padded() * size_of::<u16>()
    }

    /// Halves from one pixel to the next: a line more where pixels would fall into few sets of the fastest cache.
    fn pixel(&self) -> usize {
        let halves = 2 * self.padded();
        if halves.is_multiple_of(4 * Line::LEN) { halves + Line::LEN } else { halves }
    }

    /// Bytes from one pixel to the next.
    pub(super) fn pixel_bytes(&self) -> usize {
        self.pixel() * size_of::<u16>()
    }

    /// Bytes from the corner of a kernel to what each tap of each block reads, in the order of the weights.
    pub(super) fn taps(&self, dilation: usize) -> Vec<usize> {
        let of_tap = |tap: usize| (tap / 3 * self.width + tap % 3) * dilation * self.pixel_bytes();
        let of_block = |block: usize| block * 2 * self.depth * size_of::<u16>();
        (0..self.blocks).flat_map(|block| (0..9).map(move |tap| of_block(block) + of_tap(tap))).collect()
    }

    /// Splits `rows` of a layer's input and their margins; answers the first byte.
    pub(super) fn fill(&self, layer: &Layer, rows: Range<usize>, lines: &mut Vec<Line>) -> *const u8 {
        let channels = layer.weights.channels[0];
        let [height, columns] = layer.size;
        let pixel = self.pixel();
        let outer = rows.len() + 2 * self.margin;
        // The last tiles reach beyond the last row.
        let room = (outer * self.width + PIXELS + 2 * self.margin) * pixel;
        if lines.len() * Line::LEN < room {
            lines.resize(room.div_ceil(Line::LEN), Line::ZERO);
        }
        let halves = Line::halves(lines);
        for (i, to) in halves.chunks_exact_mut(self.width * pixel).take(outer).enumerate() {
            let y = (rows.start + i).wrapping_sub(self.margin);
            if y >= height && layer.padding == Padding::Zero {
                to.fill(0);
                continue;
            }
            let y = (rows.start + i).saturating_sub(self.margin).min(height - 1);
            let from = &layer.x[y * columns * channels..][..columns * channels];
            let (before, inside) = to.split_at_mut(self.margin * pixel);
            let (inside, behind) = inside.split_at_mut(columns * pixel);
            let padded = self.padded();
            on_isa!(layer.isa, split_row(&mut Row { from, channels, to: &mut *inside, pixel, padded }));
            match layer.padding {
                Padding::Zero => [before, behind].into_iter().for_each(|margin| margin.fill(0)),
                Padding::Edge => {
                    before.chunks_exact_mut(pixel).for_each(|to| to.copy_from_slice(&inside[..pixel]));
                    let last = inside.len() - pixel;
                    behind.chunks_exact_mut(pixel).for_each(|to| to.copy_from_slice(&inside[last..]));
                }
            }
        }
        halves.as_ptr().cast()
    }
}

/// A row of pixels and the place for its halves.
pub(in crate::kernel) struct Row<'a> {
    /// `[x, c]`
    from: &'a [f32],
    channels: usize,
    /// `[x][high, low][padded]`
    to: &'a mut [u16],
    /// Halves from one pixel to the next.
    pixel: usize,
    padded: usize,
}

/// Splits the numbers of a row, 16 channels at a time: a loop of an unknown length would go one by one over so few.
#[inline(always)]
pub(in crate::kernel) fn split(row: &mut Row) {
    let pixels = row.from.chunks_exact(row.channels).zip(row.to.chunks_exact_mut(row.pixel));
    for (from, to) in pixels {
        let (high, low) = to.split_at_mut(row.padded);
        let low = &mut low[..row.padded];
        let parts = high.as_chunks_mut::<TILE>().0.iter_mut().zip(low.as_chunks_mut::<TILE>().0);
        for (from, (high, low)) in from.as_chunks::<TILE>().0.iter().zip(parts) {
            for (i, x) in from.iter().enumerate() {
                [high[i], low[i]] = halves_of(*x);
            }
        }
        if row.padded > row.channels {
            high[row.channels..].fill(0);
            low[row.channels..].fill(0);
        }
    }
}

/// A number's high half and its low one.
#[inline(always)]
pub(super) fn halves_of(x: f32) -> [u16; 2] {
    let high = rounded(x);
    [high as u16, rounded(x - f32::from_bits(high << 16)) as u16]
}
