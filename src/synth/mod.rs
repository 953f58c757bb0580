//! From one photo to a light field (paper, §3): depth net → Lambertian rendering → occlusion net.
//!
//! ```text
//! Photo ─picture─► reference view ─depth─► working scale ─upsample─► reference map ─lift─► RayDepths
//!       ─lambertian─► views ─occlusion─► corrected views ─► LightField
//! ```
//!
//! [`Synthesizer`] knows the order; every other file does one arrow. Models come from a [`ModelSource`] and say what
//! they are in a [`Manifest`]; only `tract` runs them.

pub mod adopt;
pub mod cache;
mod cached;
pub mod carry;
pub mod corners;
mod depth;
mod error;
mod far_side;
pub mod fuse;
pub mod lambertian;
mod library;
pub mod lift;
mod loose;
mod manifest;
pub mod memory;
mod net;
mod occlusion;
mod params;
mod picture;
mod pipeline;
pub mod range;
mod relative;
mod scale;
mod speckles;
mod steps;
pub mod sweep;
mod thin;
mod tips;
pub mod tract;
pub mod upsample;

pub use error::{ModelError, SynthError};
pub use far_side::FarSide;
pub use library::{ModelBytes, ModelFile, ModelIndex, ModelSource, ModelTag};
pub use manifest::{
    Channels, ColourOrder, Layout, LongSides, Manifest, RayDepthsFrom, RelativeOutput, RelativeRules, Task,
};
pub use params::{DepthSource, SynthParams, Synthesis};
pub use picture::{Signed, reference_view};
pub use pipeline::{Synthesizer, synthesize_bared, synthesize_from_map};
pub use scale::{NoScale, Scale};
