//! What a caller may ask of the synthesis, and what comes out.

use std::sync::Arc;
use std::time::Duration;

use super::range::{Camera, Estimate, Metric};
use super::{ModelTag, Scale};
use crate::field::{DisparityMap, LightField, RayDepths};

/// Where the reference view's ray depth comes from.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub enum DepthSource {
    /// The depth net.
    #[default]
    Network,
    /// The map that the phone measured ([`SynthParams::phone`]), refined with the photo.
    Phone,
    /// The phone's order on the depth net's scale, edges from net and photo.
    Fused,
    /// Another depth net of the models folder, by name: one of ours, or anybody's with `task = "relative-depth"`.
    Model(String),
}

/// What a caller may ask of the synthesis.
#[derive(Clone, Debug)]
pub struct SynthParams {
    /// Long side of a view, in pixels; never enlarges the photo.
    pub long_side: u32,
    /// Whether the occlusion net corrects the Lambertian views.
    pub occlusion: bool,
    /// Threads that compute; 0 means one per processor core.
    pub threads: usize,
    /// Ray depth of the reference view, instead of any other source (`--disparity`). Used as it is: no guide.
    pub disparity: Option<Arc<DisparityMap>>,
    /// Where the ray depth comes from otherwise.
    pub source: DepthSource,
    /// What the phone measured, in metres or in an order alone. For [`DepthSource::Phone`] and `Fused`.
    pub phone: Option<Arc<Estimate>>,
    /// What the photo's file says of the camera: for depth in metres.
    pub camera: Camera,
    /// How far the ray depths reach, where they are neither the person's own nor in metres.
    pub scale: Scale,
}

impl Default for SynthParams {
    fn default() -> Self {
        Self {
            long_side: 540,
            occlusion: true,
            threads: 0,
            disparity: None,
            source: DepthSource::Network,
            phone: None,
            camera: Camera::default(),
            scale: Scale::default(),
        }
    }
}

/// A light field made from one photo.
#[derive(Clone, Debug)]
pub struct Synthesis {
    /// The views.
    pub field: Arc<LightField>,
    /// The disparity of every ray.
    pub depths: Arc<RayDepths>,
    /// How disparity and distance hang together, where the source of depth is in metres.
    pub metric: Option<Metric>,
    /// The models that took part.
    pub models: Vec<ModelTag>,
    /// How long it took.
    pub took: Duration,
}
