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
//! * [`background`]: what goes on behind near edges; `semiglobal`: which of many depths each pixel has, its neighbours heard.
//! * [`splats`]: scenes of Gaussian splats, their pictures, rays and true defocus.
//! * [`repair`]: depth mended by hand, as a list of operations on a map.
//! * [`burst`]: several photos of one subject: depth that was measured, rays that were seen.
//! * [`scene`]: the one way from a file to a picture, with edits, recipes, exports and batches.
//! * [`ui`]: the window. Everything else works without it (cargo feature `ui`).
//! * [`job`]: progress and cancel, for every long computation; [`errors`]: what went wrong, as a sentence; [`crash`]: what
//!   is kept of a fault in the program.
//! * [`apart`]: work that a stranger's file could break, in a process of its own.
//! * [`aside`]: files and folders that are there whole or not at all; [`within`]: what others sent, within bounds;
//!   [`shard`]: one of several parts of some work; [`markup`]: text inside HTML and XML.
//!
//! A photo, refocused on what is seen at a place of it:
//!
//! ```
//! use std::sync::Arc;
//!
//! use plenoscope::field::FNumber;
//! use plenoscope::job::{Cancel, Job};
//! use plenoscope::scene::{Edit, Focus, Maker, Making, Need, Subject, export};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! let cancel = Cancel::default();
//! let job = Job { cancel: &cancel, sink: &() };
//! // Or `Subject::open(path, &job)?`, of a photo or a light field.
//! let subject = Arc::new(Subject::sample()?);
//! let scene = Maker::default().scene(&subject, &Making::default(), Need::Map, &job)?;
//! let edit = Edit { f_number: FNumber(1.8), focus: Focus::At([0.43, 0.42]), ..Edit::default() };
//! let out = folder.path().join("daisy.jpg");
//! export::write(&scene, &edit, &export::Settings::default(), &out, &job)?;
//! # assert_eq!(image::image_dimensions(&out)?, (1200, 800));
//! # Ok(())
//! # }
//! ```
//!
//! `Need::Views` makes all 64 views with the disparity of each ray: [`scene::Scene::views`].
//!
//! The library computes; the front doors (window, command line, trainer) listen.

pub mod apart;
pub mod aside;
pub mod background;
pub mod bench;
pub mod burst;
pub mod crash;
pub mod errors;
pub mod field;
pub mod io;
pub mod job;
pub mod kernel;
pub mod markup;
mod panics;
pub mod render;
pub mod repair;
pub mod scene;
mod semiglobal;
pub mod shard;
pub mod splats;
pub mod synth;
#[cfg(feature = "ui")]
pub mod ui;
pub mod within;
