//! The innermost piece of the weight gradient: 8 output channels × the taps of one row, summed over a block of rows.

use super::pack::BLOCK;
use super::vector::Vector;

/// One input channel and one row of taps against a block of the output gradient.
pub(super) struct WeightTile {
    /// Padded input at the first row of the block, first tap.
    pub(super) x: *const f32,
    /// Values between rows of the input.
    pub(super) row_step: usize,
    /// The input that will be wanted next.
    pub(super) next: *const f32,
    /// Output gradient `[8][row][column]`.
    pub(super) gradient: *const f32,
    /// Values between channels of the output gradient.
    pub(super) channel_step: usize,
    /// Columns, whole vectors; also the values between rows of the output gradient.
    pub(super) columns: usize,
    pub(super) rows: usize,
    pub(super) dilation: usize,
    /// Taps in the row, 1 or 3.
    pub(super) taps: usize,
    /// Output channels that exist, 1 … 8.
    pub(super) channels: usize,
}

/// Adds to `sums` `[tap][8]`.
///
/// # Safety
/// The pointers are good for what the sizes say; the processor has the instructions of `V`.
#[inline(always)]
pub(super) unsafe fn run<V: Vector>(tile: &WeightTile, sums: *mut f32) {
    // SAFETY: the caller's word.
    unsafe {
        match (tile.taps, V::LANES >= 16, tile.channels <= 4) {
            (1, _, true) => compute::<V, 4, 1>(tile, 0, sums),
            (1, _, false) => {
                compute::<V, 4, 1>(tile, 0, sums);
                compute::<V, 4, 1>(tile, 4, sums);
            }
            (_, true, false) => compute::<V, 8, 3>(tile, 0, sums),
            (_, _, true) => compute::<V, 4, 3>(tile, 0, sums),
            (_, false, false) => {
                compute::<V, 4, 3>(tile, 0, sums);
                compute::<V, 4, 3>(tile, 4, sums);
            }
        }
    }
}

#[inline(always)]
unsafe fn compute<V: Vector, const OC: usize, const TAPS: usize>(tile: &WeightTile, first: usize, sums: *mut f32) {
    // SAFETY: the caller's word.
    unsafe {
        let mut lanes = [[V::splat(0.0); TAPS]; OC];
        for y in 0..tile.rows {
            let x = tile.x.add(y * tile.row_step);
            let gradient = tile.gradient.add(first * tile.channel_step + y * tile.columns);
            let next = tile.next.wrapping_add(y * tile.row_step);
            for column in (0..tile.columns).step_by(V::LANES) {
                prefetch(next.wrapping_add(column));
                let mut pixels = [V::splat(0.0); TAPS];
                for (tap, pixels) in pixels.iter_mut().enumerate() {
                    *pixels = V::load(x.add(column + tap * tile.dilation));
                }
                for (o, lanes) in lanes.iter_mut().enumerate() {
                    let gradient = V::load(gradient.add(o * tile.channel_step + column));
                    for tap in 0..TAPS {
                        lanes[tap] = gradient.mul_add(pixels[tap], lanes[tap]);
                    }
                }
            }
        }
        for (o, lanes) in lanes.iter().enumerate() {
            for (tap, lanes) in lanes.iter().enumerate() {
                *sums.add(tap * BLOCK + first + o) += lanes.sum();
            }
        }
    }
}

#[inline(always)]
fn prefetch(at: *const f32) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a prefetch of any address is harmless, and every x86-64 has it.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(at.cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = at;
}
