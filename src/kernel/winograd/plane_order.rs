//! From planes to channel-last, which the tiles of a plane convolution read and write, and back.

use std::mem::MaybeUninit;

use crate::kernel::ending::{Ending, Limits};
use crate::kernel::isa::{Isa, on_isa};
use crate::kernel::team;

/// Some channels of what a chain reads, `[c, y, x]`.
#[derive(Clone, Copy, Debug)]
pub struct Planes<'a> {
    /// All values.
    pub values: &'a [f32],
    /// Whether each pixel stands for two by two.
    pub is_doubled: bool,
}

/// The channels of all parts, one behind the other at each pixel of `size`, kept within limits.
///
/// # Panics
/// If a part is not of this size, or of half of it where it is doubled.
pub(super) fn channel_last(isa: Isa, parts: &[Planes], size: [usize; 2], limits: Limits) -> Vec<f32> {
    let turned = parts.iter().map(|part| Turned::of(isa, *part, size, limits));
    let mut turned: Vec<Turned> = turned.collect();
    if let [Turned { shift: 0, .. }] = turned[..] {
        return turned.remove(0).values;
    }
    let channels: usize = turned.iter().map(|part| part.channels).sum();
    let len = size[0] * size[1] * channels;
    let mut joined = Vec::with_capacity(len);
    team::each_chunk(&mut joined.spare_capacity_mut()[..len], size[1] * channels, |y, row| {
        for (x, mut pixel) in row.chunks_exact_mut(channels).enumerate() {
            for part in &turned {
                let (own, rest) = pixel.split_at_mut(part.channels);
                own.write_copy_of_slice(part.pixel(y, x));
                pixel = rest;
            }
        }
    });
    // SAFETY: the parts have all channels of every pixel.
    unsafe { joined.set_len(len) };
    joined
}

/// A part, channel-last.
struct Turned {
    values: Vec<f32>,
    channels: usize,
    columns: usize,
    /// log₂ of the pixels along a side that each of its pixels stands for.
    shift: usize,
}

impl Turned {
    fn of(isa: Isa, part: Planes, size: [usize; 2], limits: Limits) -> Self {
        let (shift, len) = (usize::from(part.is_doubled), part.values.len());
        let [rows, columns] = size.map(|side| side >> shift);
        assert_eq!([rows << shift, columns << shift], size, "a part of another size");
        assert!(len.is_multiple_of(rows * columns), "a part of another size");
        let mut values = Vec::with_capacity(len);
        let ending = Ending { summand: None, limits };
        transpose(isa, part.values, &mut values.spare_capacity_mut()[..len], rows * columns, ending);
        // SAFETY: `transpose` has written all of it.
        unsafe { values.set_len(len) };
        Self { values, channels: len / (rows * columns), columns, shift }
    }

    /// All channels of a pixel of the whole.
    fn pixel(&self, y: usize, x: usize) -> &[f32] {
        let at = (y >> self.shift) * self.columns + (x >> self.shift);
        &self.values[at * self.channels..][..self.channels]
    }
}

/// `[columns, rows]` from `from` `[rows, columns]`, and what ends it while it is in cache.
pub(super) fn transpose(isa: Isa, from: &[f32], to: &mut [MaybeUninit<f32>], columns: usize, ending: Ending) {
    const SIDE: usize = 16;
    let rows = from.len() / columns;
    assert_eq!(from.len(), to.len(), "length of the transposed picture");
    let whole = rows / SIDE * SIDE;
    team::each_chunk(to, SIDE * rows, |band, to| {
        let first = band * SIDE;
        let width = to.len() / rows;
        let squares = if width == SIDE { whole } else { 0 };
        if squares > 0 {
            let (from, to) = (from[first..].as_ptr(), to.as_mut_ptr().cast::<f32>());
            on_isa!(isa, transpose(from, [columns, rows], to, [squares, SIDE]));
        }
        for (i, to) in to.chunks_exact_mut(rows).enumerate() {
            for (row, to) in to.iter_mut().enumerate().skip(squares) {
                to.write(from[row * columns + first + i]);
            }
        }
        if ending.is_some() {
            let start = first * rows;
            let summand = ending.summand.map_or(&[][..], |summand| &summand[start..start + to.len()]);
            // SAFETY: all of it was written above.
            let to = unsafe { to.assume_init_mut() };
            on_isa!(isa, end_row(to, summand, ending.limits));
        }
    });
}
