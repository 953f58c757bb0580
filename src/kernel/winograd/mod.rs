//! Winograd's convolution F(4, 3): four neighbouring results of a kernel of three taps from six products in place of
//! twelve (Lavin & Gray 2016, "Fast algorithms for convolutional neural networks"). Results differ from the direct
//! convolution by a few units of the fifth digit.
//!
//! - [`PlaneChain`]: 3×3 kernels of many channels, F(4×4, 3×3): a quarter of the products. A dilated kernel is d²
//!   interleaved plain ones. Where the processor multiplies in tiles, split products (`kernel::split`) take its place.
//! - `PlaneBatch`: the same for one layer of a training step, and its gradients; `VolumeBatch`: so too for 3×3×3 kernels of
//!   few channels, two views as the channels of one.
//! - [`VolumeChain`]: 3×3×3 kernels of few channels, F(4, 3) along the views: half of the products; all layers go
//!   through the picture together, row by row, so that what lies between two layers stays in cache.
//!
//! Between consecutive layers nothing is copied and nothing is padded.

pub(super) mod batch;
mod plane;
mod plane_components;
mod plane_order;
pub(super) mod plane_tile;
mod transform;
mod volume;
mod volume_pass;
pub(super) mod volume_tile;

#[cfg(test)]
mod tests;

pub use plane::PlaneChain;
pub use plane_order::Planes;
pub use volume::{Columns, Rows, VolumeChain};

use super::shape::Padding;
use super::tile::Activation;

/// One convolution of a chain.
#[derive(Clone, Copy, Debug)]
pub struct Layer<'a> {
    /// `[c_out, c_in, (3 view taps,) 3 y taps, 3 x taps]`.
    pub weights: &'a [f32],
    /// One value per channel of the result.
    pub bias: &'a [f32],
    /// Channels of input and result.
    pub channels: [usize; 2],
    /// Distance of neighbouring taps in rows and columns.
    pub dilation: usize,
    /// What stands outside the picture.
    pub padding: Padding,
    /// What happens to the sums.
    pub activation: Activation,
    /// Whether its input is added to what comes out, which has as many channels; in planes alone.
    pub is_residual: bool,
}
