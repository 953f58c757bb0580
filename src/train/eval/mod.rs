//! Evaluation, so that figures from two places agree.
//!
//! A [`Predictor`] gets the reference view alone and gives ray depths of all 64 views (and corrected views, if it has
//! an occlusion net); [`light_field`] compares with the true views, [`phone`] with the depth that came with a photo,
//! [`photos`] with masks and nearness maps, [`constructed`] with scenes whose ray depths are known, [`truth`] with
//! measured depth and with scenes in three dimensions. Every figure on light
//! fields stands beside copying the photo, the best plane and a plane sweep over the true views.
//!
//! * *Corner views*: (0,0) (0,7) (7,0) (7,7). *Outermost views*: the 28 on the rim.
//! * *Flat*: the best plane of −1 … 1 by 0.1. *Fit*: the best of `a·D + b`, a ∈ {.15 .3 .45 .6 .8 1 1.3}, b −0.6 … 0.6
//!   by 0.1, D on the nets' own scale (scale and focus of a lens cannot be known from a photo). *Sweep*: see [`sweep`].
//! * *Closed* = (flat − fit) / (flat − sweep), mean L1 of the corners in 0 … 1: 0 knows no depth, 1 is as good as
//!   having all views. *By the swept depth*: the same of one map swept over the true views, which is what to measure a
//!   net by: the sweep's own views fit every pixel of every view, noise with it.

mod command;
pub mod constructed;
mod error;
pub mod light_field;
pub mod metrics;
mod model;
pub mod phone;
pub mod photos;
pub mod sheet;
pub mod sweep;
pub mod truth;
pub mod warp;

#[cfg(test)]
mod tests;

pub use command::{command, run};
pub use error::EvalError;
pub use model::Models;

pub use plenoscope::synth::corners::CORNERS;

pub use crate::field::TrueField;
pub use crate::scenes::raster::Rgb;

/// Rows and columns of the views that the depth of the reference view is swept over.
pub const OUTER_STEPS: [usize; 4] = [0, 2, 5, 7];

/// What a predictor makes of one photo.
pub struct Prediction {
    /// `[view, y, x]` of the 64 views, pixels per view step at the photo's size.
    pub disparity_px: Vec<f32>,
    /// The 64 views after the occlusion net, where there is one.
    pub corrected: Option<Vec<Rgb>>,
    /// These ray depths over those of the nets' own scale.
    pub gain: f32,
}

impl Prediction {
    /// The map of one view of `count` pixels.
    pub fn view(&self, layer: usize, count: usize) -> &[f32] {
        &self.disparity_px[layer * count..(layer + 1) * count]
    }

    /// The same map for all views.
    pub fn tied(map: &[f32]) -> Self {
        Self { disparity_px: map.repeat(64), corrected: None, gain: 1.0 }
    }
}

/// Anything that finds ray depths in a photo: the product's pipeline, or nets in training.
pub trait Predictor {
    /// Ray depths of all views from the reference view, at its size.
    ///
    /// # Errors
    /// What the nets say.
    fn predict(&self, reference: &Rgb) -> anyhow::Result<Prediction>;
}

impl<F: Fn(&Rgb) -> anyhow::Result<Prediction>> Predictor for F {
    fn predict(&self, reference: &Rgb) -> anyhow::Result<Prediction> {
        self(reference)
    }
}
