//! The innermost piece of a 3×3×3 convolution by F(4, 3) along the views: a few channels of four neighbouring views at
//! a few dozen pixels of one row.
//!
//! Loops are written out: a closure would be compiled without the instructions of the function around it.

#![allow(clippy::needless_range_loop, reason = "see above")]

use super::transform::{POINTS, RESULTS, of_input, of_sums};
use crate::kernel::pack::BLOCK;
use crate::kernel::tile::{Activation, activate};
use crate::kernel::vector::Vector;

/// Values of a row of the transformed tile: pixels, one more on either side, whole vectors.
pub(super) const TILE_STEP: usize = 64;
/// Pixels of the widest tile.
pub(super) const TILE_PIXELS: usize = 48;

/// Rows of a tile's input that are to be transformed.
pub(in crate::kernel) struct VolumeInput<'a> {
    /// For each row and each of six views: channel 0 one pixel left of the tile.
    pub(super) rows: &'a [[*const f32; POINTS]],
    pub(super) channels: usize,
    /// Values between channels.
    pub(super) channel_step: usize,
    /// Pixels of the tile, at most [`TILE_PIXELS`].
    pub(super) pixels: usize,
    /// `[component][c][row]` of [`TILE_STEP`] values.
    pub(super) to: *mut f32,
}

/// One tile of one row.
pub(in crate::kernel) struct VolumeTile {
    /// Transformed input, first component, channel 0, the row above, one pixel left of the tile.
    pub(super) x: *const f32,
    pub(super) channels_in: usize,
    /// Values between channels of the input.
    pub(super) channel_step: usize,
    /// Weights of this block of channels, `[component][c_in][tap][8]`.
    pub(super) weights: *const f32,
    /// Bias of this block of channels, 8 values.
    pub(super) bias: *const f32,
    /// Result at the first pixel, first view, first channel of the block.
    pub(super) out: *mut f32,
    /// Values between channels of the result.
    pub(super) out_step: usize,
    /// Values between views of the result.
    pub(super) view_step: usize,
    /// Channels of this block that exist, 1 … 8.
    pub(super) channels_out: usize,
    /// Views that exist, 1 … 4.
    pub(super) views: usize,
    /// Pixels of the tile, at most [`TILE_PIXELS`].
    pub(super) pixels: usize,
    pub(super) activation: Activation,
}

/// Computes a tile.
///
/// # Safety
/// All pointers of the tile are good for what its sizes say; the processor has the instructions of `V`.
#[inline(always)]
pub(in crate::kernel) unsafe fn run<V: Vector>(tile: &VolumeTile) {
    // SAFETY: the caller's word.
    unsafe {
        for first in (0..tile.pixels).step_by(3 * V::LANES) {
            let vectors = (tile.pixels - first).div_ceil(V::LANES);
            if V::LANES >= 16 && tile.channels_out > 4 {
                match vectors {
                    1 => compute::<V, 8, 1>(tile, 0, first),
                    2 => compute::<V, 8, 2>(tile, 0, first),
                    _ => compute::<V, 8, 3>(tile, 0, first),
                }
                continue;
            }
            for channel in (0..tile.channels_out).step_by(4) {
                match vectors {
                    1 => compute::<V, 4, 1>(tile, channel, first),
                    2 => compute::<V, 4, 2>(tile, channel, first),
                    _ => compute::<V, 4, 3>(tile, channel, first),
                }
            }
        }
    }
}

/// `OC` channels from `first` on, `N` vectors of pixels from `pixel` on.
#[inline(always)]
unsafe fn compute<V: Vector, const OC: usize, const N: usize>(tile: &VolumeTile, first: usize, pixel: usize) {
    // SAFETY: the caller's word.
    unsafe {
        let mut sums = [[[V::splat(0.0); N]; OC]; POINTS];
        for (component, kept) in sums.iter_mut().enumerate() {
            let x = tile.x.add(component * tile.channels_in * tile.channel_step + pixel);
            let weights = tile.weights.add(component * tile.channels_in * 9 * BLOCK + first);
            *kept = accumulate::<V, OC, N>(tile, x, weights);
        }
        for o in 0..OC.min(tile.channels_out - first) {
            let bias = V::splat(*tile.bias.add(first + o));
            for n in 0..N {
                let mut results = [V::splat(0.0); POINTS];
                for component in 0..POINTS {
                    results[component] = sums[component][o][n];
                }
                let results = of_sums(results);
                let at = pixel + n * V::LANES;
                let left = tile.pixels - at.min(tile.pixels);
                for view in 0..RESULTS.min(tile.views) {
                    let value = activate(results[view].add(bias), tile.activation);
                    let out = tile.out.add(view * tile.view_step + (first + o) * tile.out_step + at);
                    if left >= V::LANES { value.store(out) } else { value.store_first(out, left) }
                }
            }
        }
    }
}

/// Σ over channels and taps of weight · input in one component. Meanwhile the next component is fetched, little by
/// little: all at once would fill the queue that the loads go through.
#[inline(always)]
unsafe fn accumulate<V: Vector, const OC: usize, const N: usize>(
    tile: &VolumeTile,
    x: *const f32,
    mut weights: *const f32,
) -> [[V; N]; OC] {
    let next = x.wrapping_add(tile.channels_in * tile.channel_step);
    // SAFETY: the caller's word.
    unsafe {
        let mut sums = [[V::splat(0.0); N]; OC];
        for channel in 0..tile.channels_in {
            for row in 0..3 {
                let at = channel * tile.channel_step + row * TILE_STEP;
                prefetch(next.wrapping_add(at + 48));
                for column in 0..3 {
                    prefetch(next.wrapping_add(at + column * 16));
                    let mut pixels = [V::splat(0.0); N];
                    for n in 0..N {
                        pixels[n] = V::load(x.add(at + column + n * V::LANES));
                    }
                    for (o, sums) in sums.iter_mut().enumerate() {
                        let weight = V::splat(*weights.add(o));
                        for n in 0..N {
                            sums[n] = pixels[n].mul_add(weight, sums[n]);
                        }
                    }
                    weights = weights.add(BLOCK);
                }
            }
        }
        sums
    }
}

/// Asks for the line at `at`.
#[inline(always)]
fn prefetch(at: *const f32) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a prefetch of any address is harmless, and every x86-64 has it.
    unsafe {
        std::arch::x86_64::_mm_prefetch::<{ std::arch::x86_64::_MM_HINT_T0 }>(at.cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = at;
}

/// Asks for the line at `at`, which the next tile reads, to wait in the second-level cache.
#[inline(always)]
fn fetch_next(at: *const f32) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a prefetch of any address is harmless, and every x86-64 has it.
    unsafe {
        std::arch::x86_64::_mm_prefetch::<{ std::arch::x86_64::_MM_HINT_T1 }>(at.cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = at;
}

/// Transforms six neighbouring views into six components.
///
/// # Safety
/// The pointers are good for the pixels, one more on either side, and the rest of the last vector; the processor has
/// the instructions of `V`.
#[inline(always)]
pub(in crate::kernel) unsafe fn transform<V: Vector>(input: &VolumeInput) {
    let vectors = (input.pixels + 2).div_ceil(V::LANES);
    let component_step = input.channels * input.rows.len() * TILE_STEP;
    // SAFETY: the caller's word.
    unsafe {
        for channel in 0..input.channels {
            for (row, views) in input.rows.iter().enumerate() {
                let to = input.to.add((channel * input.rows.len() + row) * TILE_STEP);
                for n in 0..vectors {
                    let mut values = [V::splat(0.0); POINTS];
                    for view in 0..POINTS {
                        let at = views[view].add(channel * input.channel_step + n * V::LANES);
                        fetch_next(at.wrapping_add(input.pixels));
                        values[view] = V::load(at);
                    }
                    let components = of_input(values);
                    for component in 0..POINTS {
                        components[component].store(to.add(component * component_step + n * V::LANES));
                    }
                }
            }
        }
    }
}
