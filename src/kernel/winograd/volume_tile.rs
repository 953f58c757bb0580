//! The innermost piece of a 3×3×3 convolution by F(4, 3) along the views: a few channels of four neighbouring views at
//! a few dozen pixels of one row.
//!
//! Loops are written out: a closure would be compiled without the instructions of the function around it.

#![allow(clippy::needless_range_loop, reason = "see above")]

use super::transform::{POINTS, RESULTS, of_input, of_sums};
use crate::kernel::pack::BLOCK;
use crate::kernel::tile::{Activation, activate};
use crate::kernel::vector::Vector;

/// One tile.
pub(in crate::kernel) struct VolumeTile<'a> {
    /// Transformed input at the first pixel, first component, channel 0, left tap.
    pub(super) x: *const f32,
    /// The same of the tile that comes next.
    pub(super) next: *const f32,
    pub(super) channels_in: usize,
    /// Values between channels, in input and result.
    pub(super) channel_step: usize,
    /// Values between components of the input.
    pub(super) component_step: usize,
    /// Offsets of the 3×3 taps.
    pub(super) taps: &'a [usize; 9],
    /// Weights of this block of channels, `[component][c_in][tap][8]`.
    pub(super) weights: *const f32,
    /// Bias of this block of channels, 8 values.
    pub(super) bias: *const f32,
    /// Result at the first pixel, first view, first channel of the block.
    pub(super) out: *mut f32,
    /// Values between views of the result.
    pub(super) view_step: usize,
    /// Channels of this block that exist, 1 … 8.
    pub(super) channels_out: usize,
    /// Views that exist, 1 … 4.
    pub(super) views: usize,
    /// Vectors of this tile.
    pub(super) vectors: usize,
    /// Pixels of the row from the first one on.
    pub(super) width: usize,
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
        match (V::LANES >= 16, tile.channels_out <= 4) {
            (true, false) => match tile.vectors {
                1 => compute::<V, 8, 1>(tile, 0),
                2 => compute::<V, 8, 2>(tile, 0),
                _ => compute::<V, 8, 3>(tile, 0),
            },
            (_, few) => {
                for half in 0..if few { 1 } else { 2 } {
                    match tile.vectors {
                        1 => compute::<V, 4, 1>(tile, 4 * half),
                        2 => compute::<V, 4, 2>(tile, 4 * half),
                        _ => compute::<V, 4, 3>(tile, 4 * half),
                    }
                }
            }
        }
    }
}

/// `OC` channels from `first` on, `N` vectors.
#[inline(always)]
unsafe fn compute<V: Vector, const OC: usize, const N: usize>(tile: &VolumeTile, first: usize) {
    // SAFETY: the caller's word.
    unsafe {
        let mut sums = [[[V::splat(0.0); N]; OC]; POINTS];
        for (component, kept) in sums.iter_mut().enumerate() {
            let x = tile.x.add(component * tile.component_step);
            let next = if component + 1 < POINTS { x.wrapping_add(tile.component_step) } else { tile.next };
            *kept = accumulate::<V, OC, N>(tile, x, component, first, next);
        }
        for o in 0..OC.min(tile.channels_out - first) {
            let bias = V::splat(*tile.bias.add(first + o));
            for n in 0..N {
                let mut results = [V::splat(0.0); POINTS];
                for component in 0..POINTS {
                    results[component] = sums[component][o][n];
                }
                let results = of_sums(results);
                let left = tile.width - (n * V::LANES).min(tile.width);
                for view in 0..RESULTS.min(tile.views) {
                    let value = activate(results[view].add(bias), tile.activation);
                    let out = tile.out.add(view * tile.view_step + (first + o) * tile.channel_step + n * V::LANES);
                    if left >= V::LANES { value.store(out) } else { value.store_first(out, left) }
                }
            }
        }
    }
}

/// Σ over channels and taps of weight · input in one component. Meanwhile the input from `next` on is fetched, little
/// by little: all at once would fill the queue that the loads go through.
#[inline(always)]
unsafe fn accumulate<V: Vector, const OC: usize, const N: usize>(
    tile: &VolumeTile,
    x: *const f32,
    component: usize,
    first: usize,
    next: *const f32,
) -> [[V; N]; OC] {
    // SAFETY: the caller's word.
    unsafe {
        let mut sums = [[V::splat(0.0); N]; OC];
        let mut weights = tile.weights.add(component * tile.channels_in * 9 * BLOCK + first);
        for channel in 0..tile.channels_in {
            let at = channel * tile.channel_step;
            for (i, &tap) in tile.taps.iter().enumerate() {
                prefetch(next.wrapping_add(at + tap + i % 3 * 16));
                let mut pixels = [V::splat(0.0); N];
                for n in 0..N {
                    pixels[n] = V::load(x.add(at + tap + n * V::LANES));
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

/// Transforms six neighbouring views of `len` values (a multiple of 16) each into six components, `step` values apart.
///
/// # Safety
/// The pointers are good for that; the processor has the instructions of `V`.
#[inline(always)]
pub(in crate::kernel) unsafe fn transform_views<V: Vector>(
    views: [*const f32; POINTS],
    to: *mut f32,
    step: usize,
    len: usize,
) {
    // SAFETY: the caller's word.
    unsafe {
        for i in (0..len).step_by(V::LANES) {
            let mut values = [V::splat(0.0); POINTS];
            for view in 0..POINTS {
                values[view] = V::load(views[view].add(i));
            }
            let components = of_input(values);
            for component in 0..POINTS {
                components[component].store(to.add(component * step + i));
            }
        }
    }
}
