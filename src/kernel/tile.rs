//! The innermost piece: a few channels of the result at a few dozen neighbouring pixels, held in registers.
//!
//! With 32 registers of 16 values a tile is 8 channels × 48 pixels: 24 sums, 3 pieces of input, and the weight comes
//! from memory as an operand. With 16 registers of 8 values it is 4 channels × 24 pixels. A picture narrower than one
//! vector puts several of its rows into a tile instead.

use super::pack::BLOCK;
use super::vector::{Vector, elu, gelu, tanh};

/// What happens to the sums before they are written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Activation {
    /// Nothing.
    #[default]
    None,
    /// ELU with α = 1.
    Elu,
    /// `scale · tanh`.
    Tanh {
        /// The largest value that comes out.
        scale: f32,
    },
    /// GELU by the error function, `x · Φ(x)`.
    Gelu,
    /// Nothing below `low`, nothing above `high`: ReLU is 0 … ∞.
    Clamp {
        /// The least value that comes out.
        low: f32,
        /// The largest.
        high: f32,
    },
}

/// One tile: up to 8 channels, up to [`max_vectors`] vectors of pixels.
pub(super) struct Tile<'a> {
    /// Input at the first pixel, channel 0, first tap.
    pub(super) x: *const f32,
    pub(super) channels_in: usize,
    /// Values between channels of the input.
    pub(super) channel_step: usize,
    /// Offsets of the taps.
    pub(super) taps: &'a [usize],
    /// Packed weights of this block of channels, `[c_in][tap][8]`.
    pub(super) weights: *const f32,
    /// Bias of this block of channels, 8 values.
    pub(super) bias: *const f32,
    /// Result at the first pixel, first channel of the block.
    pub(super) out: *mut f32,
    /// Values between channels of the result.
    pub(super) out_step: usize,
    /// Channels of this block that exist, 1 … 8.
    pub(super) channels_out: usize,
    /// Vectors of this tile.
    pub(super) vectors: usize,
    /// Values from one vector to the next in input and result.
    pub(super) vector_step: [usize; 2],
    /// Pixels of the row from the first vector on; each vector takes [`lane_step`](Self::lane_step) of them.
    pub(super) width: usize,
    /// Pixels from one vector to the next in a row: the lanes, or 0 where each vector is a row of its own.
    pub(super) lane_step: usize,
    pub(super) activation: Activation,
}

/// The most vectors a tile holds for a block of `channels_out` channels.
pub(super) fn max_vectors(lanes: usize, channels_out: usize) -> usize {
    if lanes >= 16 && channels_out <= 4 { 6 } else { 3 }
}

/// Computes a tile.
///
/// # Safety
/// All pointers of the tile are good for what its sizes say; the processor has the instructions of `V`.
#[inline(always)]
pub(super) unsafe fn run<V: Vector>(tile: &Tile) {
    // SAFETY: the caller's word; the second half of a block lies 4 weights and 4 channels further.
    unsafe {
        match (V::LANES >= 16, tile.channels_out <= 4) {
            (true, false) => match tile.vectors {
                1 => compute::<V, 8, 1>(tile, 0),
                2 => compute::<V, 8, 2>(tile, 0),
                _ => compute::<V, 8, 3>(tile, 0),
            },
            (true, true) => match tile.vectors {
                1 => compute::<V, 4, 1>(tile, 0),
                2 => compute::<V, 4, 2>(tile, 0),
                3 => compute::<V, 4, 3>(tile, 0),
                4 => compute::<V, 4, 4>(tile, 0),
                5 => compute::<V, 4, 5>(tile, 0),
                _ => compute::<V, 4, 6>(tile, 0),
            },
            (false, few) => {
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
#[allow(clippy::manual_memcpy, reason = "a memcpy would take the address of the sums and push them out of registers")]
unsafe fn compute<V: Vector, const OC: usize, const N: usize>(tile: &Tile, first: usize) {
    // SAFETY: the caller's word.
    unsafe {
        let sums = accumulate::<V, OC, N>(tile, first);
        // A copy: the loops of the epilogue are not unrolled, so what they index lives in memory. The sums must not.
        let mut results = [[V::splat(0.0); N]; OC];
        for (results, sums) in results.iter_mut().zip(&sums) {
            for n in 0..N {
                results[n] = sums[n];
            }
        }
        for (o, results) in results.iter().enumerate().take(tile.channels_out - first) {
            for (n, &sum) in results.iter().enumerate() {
                let value = activate(sum, tile.activation);
                let out = tile.out.add((first + o) * tile.out_step + n * tile.vector_step[1]);
                match tile.width - (n * tile.lane_step).min(tile.width) {
                    left if left >= V::LANES => value.store(out),
                    left => value.store_first(out, left),
                }
            }
        }
    }
}

/// The activation of every lane.
#[inline(always)]
pub(super) unsafe fn activate<V: Vector>(value: V, activation: Activation) -> V {
    // SAFETY: the caller's word; no memory is touched.
    unsafe {
        match activation {
            Activation::None => value,
            Activation::Elu => elu(value),
            Activation::Tanh { scale } => tanh(value).mul(V::splat(scale)),
            Activation::Gelu => gelu(value),
            Activation::Clamp { low, high } => V::splat(high).min(V::splat(low).max(value)),
        }
    }
}

/// Bias + Σ over channels and taps of weight · input.
#[inline(always)]
unsafe fn accumulate<V: Vector, const OC: usize, const N: usize>(tile: &Tile, first: usize) -> [[V; N]; OC] {
    // SAFETY: the caller's word.
    unsafe {
        let mut sums = [[V::splat(0.0); N]; OC];
        for (o, sums) in sums.iter_mut().enumerate() {
            *sums = [V::splat(*tile.bias.add(first + o)); N];
        }
        let mut weights = tile.weights.add(first);
        for channel in 0..tile.channels_in {
            let x = tile.x.add(channel * tile.channel_step);
            for &tap in tile.taps {
                let x = x.add(tap);
                let mut pixels = [V::splat(0.0); N];
                for (n, pixels) in pixels.iter_mut().enumerate() {
                    *pixels = V::load(x.add(n * tile.vector_step[0]));
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
