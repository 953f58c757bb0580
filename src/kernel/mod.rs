//! The convolutions that inference and training share, on plain slices: no tensor library in sight.
//!
//! # Shapes
//! All activations are row-major `[n, c, v, y, x]` (`n` pictures of a batch, `c` channels, `v` views of a light field
//! in the order of [`crate::field`], 1 for a plain picture), weights `[c_out, c_in, (view taps,) y taps, x taps]`.
//! A 2-D kernel treats every view by itself; [`Kernel::Volume`] also reaches one view to either side.
//!
//! # Forward
//! ```no_run
//! use plenoscope::kernel::{Activation, Conv, ConvShape, Isa, Kernel, Padding};
//! # let (picture, weights, bias) = (vec![0.0; 3 * 64 * 96], vec![0.0; 16 * 3 * 9], vec![0.0; 16]);
//! let shape = ConvShape { batch: 1, channels_in: 3, channels_out: 16, views: 1, height: 64, width: 96,
//!     kernel: Kernel::Plane, dilation: 2, padding: Padding::Edge };
//! let conv = Conv::new(shape, Isa::best());
//! let x = conv.pad_input(&picture);            // padded copy, also what the weight gradient wants
//! let weights = conv.pack(&weights);           // once per weights
//! let y = conv.forward(&x, &weights, Some(&bias), Activation::Elu, None)?;   // [1, 16, 1, 64, 96]
//! # Ok::<(), plenoscope::job::Cancelled>(())
//! ```
//!
//! # A training step of convolution → batch normalisation → ELU
//! With `m = n·v·h·w` values per channel, mean μ and variance σ² of `z`, `istd = 1/√(σ²+ε)`:
//! ```text
//! forward    z, sums = conv.step(x, w)                      sums[c] = [Σ z, Σ z²]; no bias, β takes its part
//!            s = γ·istd,  t = β − μ·s
//!            y = norm::elu(isa, z, [n, c, v·h·w], s, t)      y = elu(s·z + t)
//! backward   r = norm::elu_gradient_sums(isa, z, gy, …, s, t)         r[c] = [Σ g, Σ g·z],  g = gy·elu'(s·z + t)
//!            ∂β = r0,  ∂γ = (r1 − μ·r0)·istd,  q = ∂γ·istd/m
//!            k = [s, −s·q, s·(q·μ − ∂β/m)]                  so that ∂z = k0·g + k1·z + k2
//!            ∂w, ∂x = conv.step_gradients(x, w, |row, at| norm::elu_gradient_row(isa, z_row, gy_row, row, s, t, k))
//! ```
//! [`norm::Norm`] keeps these few formulas in one place. For a convolution with bias and another activation, write
//! `gy·act'` in the closure; the bias gradient is the sum of the rows.
//!
//! # Code paths
//! [`Isa`] picks AVX-512, AVX2 + FMA or plain Rust at run time. The same generic code (`vector::Vector`) is compiled for
//! each; sums are ordered differently, so results differ in the last bits.
//!
//! [`winograd`] does the same with a half or a quarter of the products: chains of convolutions in inference, and in
//! training ([`Conv::step`]) 3×3 kernels of many channels and 3×3×3 kernels of few, forward and both gradients. Its results
//! differ from the direct ones in the fifth digit or later.
//!
//! [`Halves`] is the proof that the processor multiplies 16-bit numbers in tiles (AMX). A training step of planes that is told
//! to ([`Conv::in_halves`]) rounds its numbers to them; a chain of planes in inference splits each number into two (`split`),
//! which keeps as many digits as Winograd's algorithm.
//!
//! [`blocks::LargeBlocks`] is an allocator that spares the page faults of large activations; binaries install it.
//!
//! Parallel over blocks of rows by the [`team`] that this thread leads, else on the current rayon pool; a cancel flag is
//! looked at before each block.

#![allow(unsafe_code, reason = "SIMD intrinsics and writing disjoint rows of one buffer from several threads")]

pub mod background;
pub mod blocks;
mod conv;
mod driver;
mod ending;
mod gradient;
mod halves;
mod isa;
pub mod norm;
mod pack;
mod padded;
pub mod peak;
mod portable;
pub mod product;
pub mod resize;
mod shape;
mod split;
mod step;
pub mod team;
mod tile;
pub mod token;
mod vector;
mod weight_tile;
pub mod winograd;

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;

#[cfg(test)]
mod tests;

pub use conv::{Conv, Sums};
pub use ending::{Ending, Limits};
pub use halves::Halves;
pub use isa::Isa;
pub use pack::Packed;
pub use padded::{Padded, RowAt};
pub use shape::{ConvShape, Kernel, Padding};
pub use step::Gradients;
pub use tile::Activation;

/// Repeatable numbers in −1 … 1, for tests.
#[cfg(test)]
pub(crate) fn numbers(seed: u64, n: usize) -> Vec<f32> {
    let mut state = seed;
    let next = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    };
    std::iter::repeat_with(next).take(n).collect()
}
