//! Files in, files out. What a file is, is told by its content, never by its name's suffix.
//!
//! * [`open()`] and [`open_bytes`]: anything people have → a [`PhotoFile`] or a [`LightFieldFile`].
//! * [`formats`]: one file for each light-field or depth format, and the table of who reads and writes what.
//! * [`carried`]: what a picture of this program says of how it was made.
//! * [`opening`]: a picture as the opening of a lens.
//! * [`folder`]: the photos beside a photo, in natural order.
//!
//! Parsers never trust a length: sizes are checked in the header before anything is allocated, and what is only extra
//! (a broken depth map in a sound photo) becomes a warning.

mod avi;
pub mod carried;
#[cfg(test)]
pub(crate) mod data_tests;
pub mod decoder;
mod error;
pub mod exif;
mod file_type;
pub mod folder;
pub mod formats;
mod info;
mod jpeg_parts;
mod open;
pub mod opening;
mod raster;
pub mod sample;
pub mod save;
pub mod several;
#[cfg(test)]
mod tests;
mod xmp;

pub use crate::field::DisparityMap;
pub use error::{OpenError, Problem};
pub use info::{DepthInfo, DepthKind, EmbeddedDepth, FileInfo, FileKind, LightFieldFile, Opened, PhotoFile};
pub use open::{MAX_FILE_BYTES, open, open_bytes, open_whole};
