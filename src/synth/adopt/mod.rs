//! A depth net that a person brings: what it is, how it wants its picture, and what its numbers mean.
//!
//! ```text
//! ONNX file ─rehearsal─► signs ─reading─► family, or all that can be meant ─trial on a picture of known depth─► manifest ─► shelf
//! ```
//!
//! Facts about families are in `family`; what a file says of itself, in [`Signs`](super::tract::Signs).

mod draft;
mod error;
mod family;
mod reading;
mod rehearsal;
mod shelf;
mod trial;

#[cfg(test)]
mod tests;

pub use error::AdoptError;
pub use rehearsal::serve;
pub use shelf::{Shelf, Shelved};
pub use trial::{Adopted, Known, adopt};
