//! Sixteen channels of one picture, brought channel-last and back.

use std::cell::RefCell;
use std::ops::Range;

use super::GROUP;
use crate::kernel::isa::{Isa, on_isa};
use crate::kernel::vector::Vector;

/// Pixels that are brought at a time: 16 channels of them stay in the first-level cache.
const PIECE: usize = 256;

thread_local! {
    static SCRATCH: RefCell<Vec<f32>> = const { RefCell::new(Vec::new()) };
}

/// Room for 16 channels of a picture.
pub(super) struct Room<'a> {
    isa: Isa,
    /// `[pixel][16]`, and one pixel more.
    pub(super) pixels: &'a mut [f32],
    /// `[16][PIECE]`
    rows: &'a mut [f32],
}

/// Calls `f` with room for `pixels` pixels and one more. Nothing in it is set.
pub(super) fn with_room<R>(isa: Isa, pixels: usize, f: impl FnOnce(Room) -> R) -> R {
    let len = (pixels + 1) * GROUP;
    SCRATCH.with_borrow_mut(|scratch| {
        scratch.resize(scratch.len().max(len + GROUP * PIECE + GROUP), 0.0);
        let aligned = scratch.as_ptr().align_offset(64).min(GROUP);
        let (pixels, rest) = scratch[aligned..].split_at_mut(len);
        f(Room { isa, pixels, rows: &mut rest[..GROUP * PIECE] })
    })
}

impl Room<'_> {
    /// Gets some pixels: `fill` writes so many values of a lane from a pixel on. The pixel more becomes 0.
    pub(super) fn fill(&mut self, range: Range<usize>, fill: impl Fn(usize, usize, &mut [f32])) {
        let (inside, outside) = self.pixels.split_at_mut(self.pixels.len() - GROUP);
        outside.fill(0.0);
        let pieces = inside[range.start * GROUP..range.end * GROUP].chunks_mut(PIECE * GROUP);
        for (first, pixels) in range.step_by(PIECE).zip(pieces) {
            for (lane, row) in self.rows.chunks_exact_mut(PIECE).enumerate() {
                fill(lane, first, &mut row[..pixels.len() / GROUP]);
            }
            let (from, to, n) = (self.rows.as_ptr(), pixels.as_mut_ptr(), pixels.len() / GROUP);
            on_isa!(self.isa, transpose(from, [PIECE, GROUP], to, [GROUP, n]));
        }
    }

    /// Hands out some pixels: `take` gets the values of a lane from a pixel on.
    pub(super) fn take(&mut self, range: Range<usize>, mut take: impl FnMut(usize, usize, &[f32])) {
        let pieces = self.pixels[range.start * GROUP..range.end * GROUP].chunks(PIECE * GROUP);
        for (first, pixels) in range.step_by(PIECE).zip(pieces) {
            let (from, to, n) = (pixels.as_ptr(), self.rows.as_mut_ptr(), pixels.len() / GROUP);
            on_isa!(self.isa, transpose(from, [GROUP, PIECE], to, [n, GROUP]));
            for (lane, row) in self.rows.chunks_exact(PIECE).enumerate() {
                take(lane, first, &row[..n]);
            }
        }
    }
}

/// Transposes `[rows, columns]`; steps are those from row to row of `from` and of `to`.
///
/// # Safety
/// The pointers are good for what the sizes say; the processor has the instructions of `V`.
#[inline(always)]
pub(in crate::kernel) unsafe fn transpose<V: Vector>(
    from: *const f32,
    [from_step, to_step]: [usize; 2],
    to: *mut f32,
    [rows, columns]: [usize; 2],
) {
    for row in (0..rows).step_by(16) {
        for column in (0..columns).step_by(16) {
            // SAFETY: the caller's word.
            unsafe {
                let (from, to) = (from.add(row * from_step + column), to.add(column * to_step + row));
                if row + 16 <= rows && column + 16 <= columns {
                    V::transpose_16(from, from_step, to, to_step);
                    continue;
                }
                for i in 0..(rows - row).min(16) {
                    for j in 0..(columns - column).min(16) {
                        *to.add(j * to_step + i) = *from.add(i * from_step + j);
                    }
                }
            }
        }
    }
}
