//! Plenoscope turns one photo into a 4-D RGBD light field, to look into and to refocus.
//!
//! The way of the data, which is also the order to read the code in:
//!
//! ```text
//! file ─io::open─► Subject ─scene::Maker─► Scene ─Edit─► picture ─export─► file
//! ```
//!
//! * [`field`]: the nouns (photo, view, light field, ray depths, lens) and the conventions they share.
//! * [`io`]: files in, files out.
//! * [`synth`]: depth net → Lambertian rendering → occlusion net (ONNX, run by tract).
//! * [`kernel`]: the convolutions that inference and training share.
//! * [`mod@bench`]: how fast the nets run, against the machine's peak.
//! * [`render`]: pictures from a light field, on the CPU (for keeping) and with wgpu (for looking).
//! * [`background`]: what goes on behind near edges.
//! * [`scene`]: the one way from a file to a picture, with edits, recipes, exports and batches.
//! * [`ui`]: the window. Everything else works without it (cargo feature `ui`).
//! * [`job`]: progress and cancel, for every long computation; [`errors`]: what went wrong, as a sentence.
//! * [`aside`]: files and folders that are there whole or not at all.
//!
//! The library computes; the front doors (window, command line, trainer) listen.

pub mod aside;
pub mod background;
pub mod bench;
pub mod errors;
pub mod field;
pub mod io;
pub mod job;
pub mod kernel;
mod panics;
pub mod render;
pub mod scene;
pub mod synth;
#[cfg(feature = "ui")]
pub mod ui;
