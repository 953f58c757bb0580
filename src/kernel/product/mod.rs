//! Matrix products: of activations with constant weights, in attention, and as convolutions that are no 3×3.

use std::mem::MaybeUninit;

pub(in crate::kernel) mod attention;
mod dense;
pub(in crate::kernel) mod depthwise;
mod inverted;
mod panels;
mod patches;
mod project;
pub(in crate::kernel) mod soft;
pub(in crate::kernel) mod tile;

pub use attention::{Attention, Head, MOST_BIASES, Sides};
pub use dense::Dense;
pub use depthwise::DepthWise;
pub use inverted::Inverted;
pub use panels::Panels;
pub use patches::Patches;
pub use project::{Columns, Project};

/// An array as a place for results; nothing but values is written there.
fn room(out: &mut [f32]) -> &mut [MaybeUninit<f32>] {
    // SAFETY: the same memory, and the products write whole values only, so that all stays initialised.
    unsafe { std::slice::from_raw_parts_mut(out.as_mut_ptr().cast(), out.len()) }
}

#[cfg(test)]
mod tests;
