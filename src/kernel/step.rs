//! The convolution of a training step: from 16-bit numbers if that was asked for, by Winograd's algorithm where that
//! pays, else directly.

use super::conv::{Conv, Sums};
use super::halves::HalfBatch;
use super::shape::ConvShape;
use super::winograd::batch::{PlaneBatch, VolumeBatch};

/// The gradients of a convolution.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradients {
    /// With respect to the weights, `[c_out, c_in, (view taps,) y taps, x taps]`.
    pub weights: Vec<f32>,
    /// With respect to the input, `[n, c_in, v, y, x]`, if it was wanted.
    pub x: Option<Vec<f32>>,
}

impl Conv {
    /// `w ∗ x` (no bias, no activation) of `x` `[n, c_in, v, y, x]`, and its sums for batch normalisation.
    pub fn step(&self, x: &[f32], weights: &[f32]) -> (Vec<f32>, Sums) {
        if let Some(batch) = self.half_batch() {
            return batch.forward(x, weights);
        }
        if PlaneBatch::pays(&self.shape) {
            return PlaneBatch::new(&self.shape, self.isa).forward(x, weights);
        }
        if VolumeBatch::pays(&self.shape) {
            return VolumeBatch::new(&self.shape, self.isa).forward(x, weights);
        }
        self.forward_with_sums(&self.pad_input(x), &self.pack(weights))
    }

    /// The gradients of [`step`](Self::step). `gradient` writes pieces of the output gradient `[n, c_out, v, y, x]`, each
    /// inside of one channel and one view, some more than once; it gets the index of the first value.
    pub fn step_gradients(
        &self,
        x: &[f32],
        weights: &[f32],
        gradient: impl Fn(&mut [f32], usize) + Sync,
        wants_x: bool,
    ) -> Gradients {
        if let Some(batch) = self.half_batch() {
            let (weights, x) = batch.gradients(x, &gradient, weights, wants_x);
            return Gradients { weights, x };
        }
        if PlaneBatch::pays(&self.shape) {
            let batch = PlaneBatch::new(&self.shape, self.isa);
            let (weights, x) = batch.gradients(x, &gradient, weights, wants_x);
            return Gradients { weights, x };
        }
        if VolumeBatch::pays(&self.shape) {
            let batch = VolumeBatch::new(&self.shape, self.isa);
            let (weights, x) = batch.gradients(x, &gradient, weights, wants_x);
            return Gradients { weights, x };
        }
        let ConvShape { channels_out, views, height, width, .. } = self.shape;
        let gradient = self.pad_gradient_with(|row, at| {
            gradient(row, (((at.image * channels_out + at.channel) * views + at.view) * height + at.y) * width);
        });
        let x_gradient = wants_x.then(|| self.data_gradient(&gradient, weights));
        Gradients { weights: self.weight_gradient(&self.pad_input(x), &gradient), x: x_gradient }
    }

    fn half_batch(&self) -> Option<HalfBatch<'_>> {
        let halves = self.halves.filter(|_| HalfBatch::pays(&self.shape))?;
        Some(HalfBatch::new(&self.shape, halves, self.isa))
    }
}
