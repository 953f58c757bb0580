//! From one photo to a light field: depth net → Lambertian rendering → occlusion net.

mod error;
mod library;
mod manifest;
pub mod tract;

pub use error::{ModelError, SynthError};
pub use library::{ModelFile, ModelIndex, ModelSource, ModelTag};
pub use manifest::{
    Channels, ColourOrder, Layout, LongSides, Manifest, RayDepthsFrom, RelativeOutput, RelativeRules, Task,
};
