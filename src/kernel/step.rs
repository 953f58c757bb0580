//! The convolution of a training step: by Winograd's algorithm where that pays, else directly.

use super::conv::{Conv, Sums};
use super::padded::RowAt;
use super::winograd::batch::PlaneBatch;

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
        if PlaneBatch::pays(&self.shape) {
            return PlaneBatch::new(&self.shape, self.isa).forward(&self.copy_rows(x), weights);
        }
        self.forward_with_sums(&self.pad_input(x), &self.pack(weights))
    }

    /// The gradients of [`step`](Self::step). `gradient` writes rows of the output gradient, each once.
    pub fn step_gradients(
        &self,
        x: &[f32],
        weights: &[f32],
        gradient: impl Fn(&mut [f32], RowAt) + Sync,
        wants_x: bool,
    ) -> Gradients {
        if PlaneBatch::pays(&self.shape) {
            let batch = PlaneBatch::new(&self.shape, self.isa);
            let (weights, x) = batch.gradients(&self.copy_rows(x), &gradient, weights, wants_x);
            return Gradients { weights, x };
        }
        let gradient = self.pad_gradient_with(gradient);
        let x_gradient = wants_x.then(|| self.data_gradient(&gradient, weights));
        Gradients { weights: self.weight_gradient(&self.pad_input(x), &gradient), x: x_gradient }
    }

    fn copy_rows(&self, x: &[f32]) -> impl Fn(&mut [f32], RowAt) + Sync {
        assert_eq!(x.len(), self.shape.input_len(), "length of the input");
        let row = self.row_of(x, self.shape.channels_in);
        move |target, at| target.copy_from_slice(row(at))
    }
}
