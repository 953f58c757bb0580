//! Sixteen channels of one picture, brought channel-last and back.

use std::cell::RefCell;

use super::GROUP;

thread_local! {
    static SCRATCH: RefCell<Vec<f32>> = const { RefCell::new(Vec::new()) };
}

/// Calls `f` with room for 16 channels of `pixels` pixels and one more pixel, `[pixel][16]`, and for 16 rows of `width`.
/// Nothing in it is set.
pub(super) fn with_room<R>(pixels: usize, width: usize, f: impl FnOnce(&mut [f32], &mut [f32]) -> R) -> R {
    let (pixels, rows) = ((pixels + 1) * GROUP, width * GROUP);
    SCRATCH.with_borrow_mut(|scratch| {
        scratch.resize(scratch.len().max(pixels + rows + GROUP), 0.0);
        let aligned = scratch.as_ptr().align_offset(64);
        let (pixels, rest) = scratch[aligned..].split_at_mut(pixels);
        f(pixels, &mut rest[..rows])
    })
}

/// `[16][n]` to `[n][16]`.
pub(super) fn interleave(rows: &[f32], pixels: &mut [f32]) {
    let n = rows.len() / GROUP;
    for (x, pixel) in pixels.chunks_exact_mut(GROUP).enumerate() {
        for (c, value) in pixel.iter_mut().enumerate() {
            *value = rows[c * n + x];
        }
    }
}

/// One channel of `[n][16]`.
pub(super) fn channel(pixels: &[f32], channel: usize, plane: &mut [f32]) {
    for (value, pixel) in plane.iter_mut().zip(pixels.chunks_exact(GROUP)) {
        *value = pixel[channel];
    }
}
