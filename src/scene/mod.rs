//! One way from a file to a picture, for every front door.
//!
//! ```text
//! path ─Subject::open─► Subject ─Maker─► Scene ─Edit─► picture ─export─► file
//! ```
//!
//! * [`Subject`]: a photo, several of one subject, or a recorded light field, and what is known of its depth.
//! * [`Maker`]: its disparities and views, by nets that stay warm, from the cache, or by sweep; only what is needed.
//! * [`Scene`]: a subject with its disparity; pictures of it by the lens renderer, or by its views.
//! * [`Edit`], [`Focus`]: what a person does to a picture, in numbers without a width.
//! * [`asked`]: what is typed, on the command line or in Python, brought to what stands above.
//! * [`recipe`]: an edit as a small JSON file; [`export`]: everything that can be written; [`batch`]: of many photos.
//!
//! Window, command line and Python package hold arguments, threads and what is on the screen, and decide nothing that is
//! decided here.

pub mod asked;
pub mod batch;
#[cfg(test)]
mod data_tests;
pub mod disagree;
pub mod dots;
mod edit;
mod embed;
mod error;
pub mod export;
pub mod focus;
pub mod layers;
mod make;
mod mended;
pub mod models;
mod picture;
pub mod real;
pub mod recipe;
mod salience;
mod series;
mod several;
pub mod sharp;
mod source;
mod splats;
mod strength;
mod subject;
pub mod timeline;
pub mod training;
pub mod trust;

pub use edit::{Edit, Focus};
pub use embed::{Embed, Part, Restored};
pub use error::SceneError;
pub use make::{Maker, Making, Need};
pub use mended::OTHER_PHOTO;
pub use picture::{MadeViews, OutputSize, Scene};
pub use recipe::{Found, Recipe};
pub use salience::Salience;
pub use series::Movement;
pub use several::{Several, SeveralAsked, SeveralFound, told as rays_told};
pub use source::DepthFrom;
pub use subject::{Content, OnePhoto, Recorded, Subject};
pub use timeline::Timeline;
