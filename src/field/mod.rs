//! The nouns: plain data, always valid, no behaviour beyond geometry.
//!
//! # Conventions, stated once
//!
//! * **Order.** Light fields and ray depths are view-major, `[v, u, y, x]`: `v` counts views downwards, `u` to the
//!   right, `y` rows, `x` columns. A network's output `[1, V·U, H, W]` already is that, a view is one contiguous
//!   block, and that block is one texture layer (`layer = v · cols + u`).
//! * **Reference view.** `(rows / 2, cols / 2)`: (4, 4) of 8×8. Offsets are steps from it, −4 … 3 for 8×8.
//! * **Sign.** `view(v, u)[y, x] = reference[y + (v − 4)·D, x + (u − 4)·D]`, with `D` the disparity of that ray at
//!   its own pixel, in pixels per view step (paper, §3: `L_r(x, u) = L(x + u·D(x, u), 0)`). `D > 0` is nearer than the
//!   focal plane. A refocus at plane `D_f` therefore averages `view(v, u)[y − (v − 4)·D_f, x − (u − 4)·D_f]`.
//! * **Pixels.** Origin top left, x right, y down, pixel centres at integers. Resampling maps centres:
//!   `x_src = (x + ½)·W_src / W_dst − ½`, the same for y. Outside the picture the edge pixel goes on (clamp).
//! * **Scale.** A disparity belongs to a width. Brought from a picture of width `w` to one of width `W` it is
//!   multiplied by `W / w`.
//! * **Strength.** At strength `s` the cameras of the views stand `s` times as far apart: what was seen from `s·u` is seen
//!   from `u`, so every disparity is `s·D`, about the plane of disparity 0. A focal plane, its tilt and the band that is kept
//!   sharp are disparities too: what was in focus stays in focus, and a blur is `s` times as wide. Recipes and typed numbers
//!   are those of strength 1; maps, views and what the window shows are those of the strength in use (`scene`).
//! * **Depth.** What only orders, or is in metres, becomes disparity in one place, `synth::range`.
//! * **Light.** Stored pixels are sRGB-encoded; wherever light is summed it is linear.

pub mod color;
mod disparity_map;
mod glass;
mod grid;
mod histogram;
mod lens;
mod light_field;
pub(crate) mod morphology;
mod opening;
mod photo;
mod picture;
mod provenance;
mod rank;
mod raster;
mod ray_depths;
mod resample;
mod size;
mod strength;
mod tap;
mod transfer;
mod view;

pub use disparity_map::{DisparityMap, RelativeDepth, disparity_scale};
pub use glass::Glass;
pub use grid::{ViewBlock, ViewGrid, ViewIndex, ViewOffset};
pub use histogram::Histogram;
pub use lens::{FNumber, FocalPlane, Lens, LensShape, ViewPoint};
pub use light_field::{EpiLine, LightField};
pub(crate) use opening::Integral;
pub use opening::Opening;
pub use photo::{Metadata, Photo, PhotoPixels, PixelsPart, ToSrgb8};
pub use picture::{Picture, Pixels, Samples};
pub use provenance::{Provenance, Seen};
pub use rank::{Moments, correlation, spearman};
pub use raster::Raster;
pub use ray_depths::RayDepths;
pub use resample::{Filter, center_at, nearest, nearest_index, resample};
pub(crate) use resample::{Taps, resample_rows};
pub use size::{Size, fit_long_side, pixels, sides, size_from};
pub use strength::Strength;
pub use tap::{Mix, between, bilinear, corners, ramp};
pub use transfer::Transfer;
pub use view::View;

/// A picture whose parts do not fit together; the text says which.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FieldError {
    /// A grid without views, or with more than 17×17.
    #[error("a light field has 1 to 17 rows and columns of views, not {rows}×{cols}")]
    Grid {
        /// Rows that were asked for.
        rows: usize,
        /// Columns that were asked for.
        cols: usize,
    },
    /// A buffer of the wrong length, or a side of 0.
    #[error("{what} has {got} values where its size needs {want}")]
    Length {
        /// The picture or map.
        what: &'static str,
        /// Values needed.
        want: usize,
        /// Values given.
        got: usize,
    },
    /// Disparities that are no numbers.
    #[error("{what} cannot be used — it has values that are not numbers (NaN or infinity) — repair it first")]
    NotANumber {
        /// The map.
        what: &'static str,
    },
    /// Views of different sizes.
    #[error("view ({v}, {u}) is {got:?} pixels where the others are {want:?}")]
    ViewSize {
        /// Row of the odd view.
        v: usize,
        /// Column of the odd view.
        u: usize,
        /// Width and height of the first view.
        want: Size,
        /// Width and height of the odd view.
        got: Size,
    },
}

/// Length check shared by the nouns.
fn check_len(what: &'static str, want: usize, got: usize) -> Result<(), FieldError> {
    if want == got && want > 0 { Ok(()) } else { Err(FieldError::Length { what, want, got }) }
}

/// Refuses NaN and infinity, so that nobody behind has to.
fn check_finite(what: &'static str, values: &[f32]) -> Result<(), FieldError> {
    if values.iter().all(|value| value.is_finite()) { Ok(()) } else { Err(FieldError::NotANumber { what }) }
}
