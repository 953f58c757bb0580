//! Pictures from a light field or a photo: on the CPU for keeping, with wgpu for looking.
//!
//! Each pass of `gpu/shaders/` has a twin of the same name in [`cpu`], with the same taps in the same order; the tests
//! compare the two. [`aperture`] is shared: it says how much each view counts in a refocus. [`lens`] renders at the
//! photo's own size.

pub mod aperture;
pub mod cpu;
#[cfg(feature = "ui")]
pub mod gpu;
pub mod lens;

pub use crate::field::Picture;
