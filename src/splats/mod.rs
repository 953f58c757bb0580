//! Gaussian splats (Kerbl et al., "3D Gaussian splatting for real-time radiance field rendering", SIGGRAPH 2023): a scene
//! of soft ellipsoids in space, pictures and ray depths of it, and a light field turned into one.
//!
//! * [`Cloud`]: the ellipsoids, and [`harmonics`]: their colour, which may depend on the direction.
//! * [`Camera`], [`Rig`]: where the reference view stands, and how far a view step is.
//! * `project`, `tiles`, `raster`: one picture, by tiles, from near to far, with the expected disparity of each ray;
//!   `gpu` is the last step's twin on a device, and both are a [`Painter`].
//! * [`Stage::new`]: a camera for a file that names none.
//! * [`views`](self): the grid of views; [`Stage::through_lens`]: true defocus, by many views over the lens's opening.
//! * [`from_field()`]: one Gaussian for each point that a light field's rays end at.
//! * [`Dots`]: the same points as dots, seen from any side at once.
//!
//! Space is that of cameras in photogrammetry: x right, y down, z away from the camera. The conventions of pixels and
//! disparities are those of [`crate::field`].

mod camera;
mod cloud;
mod defocus;
mod dots;
mod fill;
mod find;
mod from_field;
#[cfg(feature = "ui")]
mod gpu;
pub mod harmonics;
mod points;
mod project;
mod raster;
mod shot;
mod stage;
#[cfg(test)]
mod tests;
mod tiles;

use crate::field::FieldError;
use crate::job::Cancelled;

pub use camera::{Camera, Rig};
pub use cloud::{Blend, Cloud, Gaussian};
pub use dots::{Dots, Gathered, Turn};
pub use from_field::from_field;
#[cfg(feature = "ui")]
pub use gpu::SplatGpu;
pub use raster::{Painter, Processor, Shown};
pub use stage::{NamedCamera, Pictured, Stage};
pub use tiles::Tiles;

/// Why views of a scene, or a scene of views, could not be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SplatError {
    /// Stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Numbers beyond all measure.
    #[error(transparent)]
    Field(#[from] FieldError),
}
