//! The convolution as its users see it.

use std::mem::MaybeUninit;
use std::sync::atomic::AtomicBool;

use super::driver::Valid;
use super::ending::{Ending, Limits};
use super::gradient;
use super::halves::Halves;
use super::isa::Isa;
use super::pack::Packed;
use super::padded::{Layout, Padded, RowAt};
use super::shape::{ConvShape, Padding};
use super::tile::Activation;
use crate::job::Cancelled;

/// Per channel of the result: sum and sum of squares over pictures, views and pixels.
pub type Sums = Vec<[f64; 2]>;

/// One convolution, made ready for a shape and a set of instructions. Cheap to make.
#[derive(Clone, Copy, Debug)]
pub struct Conv {
    pub(super) shape: ConvShape,
    pub(super) isa: Isa,
    pub(super) halves: Option<Halves>,
}

impl Conv {
    /// A convolution of `shape` done with `isa`.
    ///
    /// # Panics
    /// If a size or the dilation is 0.
    pub fn new(shape: ConvShape, isa: Isa) -> Self {
        let sizes = [shape.batch, shape.channels_in, shape.channels_out, shape.plane(), shape.dilation];
        assert!(!sizes.contains(&0), "a convolution needs sizes of at least 1, not {shape:?}");
        Self { shape, isa, halves: None }
    }

    /// The same whose training steps multiply 16-bit numbers where that pays.
    pub fn in_halves(self, halves: Option<Halves>) -> Self {
        Self { halves, ..self }
    }

    /// What is convolved with what.
    pub fn shape(&self) -> &ConvShape {
        &self.shape
    }

    /// Packs `weights` `[c_out, c_in, (view taps,) y taps, x taps]` for [`forward`](Self::forward).
    pub fn pack(&self, weights: &[f32]) -> Packed {
        assert_eq!(weights.len(), self.shape.weights_len(), "number of weights");
        Packed::of(weights, self.shape.channels_out, self.shape.channels_in, self.shape.kernel)
    }

    /// The padded copy of `x` `[n, c_in, v, y, x]`.
    pub fn pad_input(&self, x: &[f32]) -> Padded {
        assert_eq!(x.len(), self.shape.input_len(), "length of the input");
        let row = self.row_of(x, self.shape.channels_in);
        self.pad_input_with(|target, at| target.copy_from_slice(row(at)))
    }

    /// The padded copy of `x` `[n, c_in, v, y, x]` kept within limits.
    pub fn pad_input_within(&self, x: &[f32], limits: Limits) -> Padded {
        if !limits.are_some() {
            return self.pad_input(x);
        }
        assert_eq!(x.len(), self.shape.input_len(), "length of the input");
        let row = self.row_of(x, self.shape.channels_in);
        self.pad_input_with(|target, at| target.iter_mut().zip(row(at)).for_each(|(t, value)| *t = limits.of(*value)))
    }

    /// The padded copy of an input whose rows (of `width` values) are written by `fill`; it gets them zeroed. Saves
    /// a pass over memory where the input is computed element by element. Called again for rows of the margin.
    pub fn pad_input_with(&self, fill: impl Fn(&mut [f32], RowAt) + Sync) -> Padded {
        let layout = Layout {
            batch: self.shape.batch,
            channels: self.shape.channels_in,
            size: self.shape.size(),
            margin: self.shape.reach(),
        };
        Padded::build(layout, self.shape.padding, fill)
    }

    /// The padded copy of an output gradient `[n, c_out, v, y, x]`, for both gradients.
    pub fn pad_gradient(&self, gradient: &[f32]) -> Padded {
        assert_eq!(gradient.len(), self.shape.output_len(), "length of the output gradient");
        let row = self.row_of(gradient, self.shape.channels_out);
        self.pad_gradient_with(|target, at| target.copy_from_slice(row(at)))
    }

    /// The padded copy of an output gradient whose rows (of `width` values) are written by `fill`, each once.
    pub fn pad_gradient_with(&self, fill: impl Fn(&mut [f32], RowAt) + Sync) -> Padded {
        let layout = Layout {
            batch: self.shape.batch,
            channels: self.shape.channels_out,
            size: self.shape.size(),
            margin: gradient::margin(&self.shape),
        };
        Padded::build(layout, Padding::Zero, fill)
    }

    fn row_of<'a>(&self, values: &'a [f32], channels: usize) -> impl Fn(RowAt) -> &'a [f32] + Sync + use<'a> {
        let [views, height, width] = self.shape.size();
        move |at| {
            let row = ((at.image * channels + at.channel) * views + at.view) * height + at.y;
            &values[row * width..][..width]
        }
    }

    /// `act(w ∗ x + bias)`, `[n, c_out, v, y, x]`.
    ///
    /// # Errors
    /// [`Cancelled`] once `cancel` is set.
    pub fn forward(
        &self,
        x: &Padded,
        weights: &Packed,
        bias: Option<&[f32]>,
        activation: Activation,
        cancel: Option<&AtomicBool>,
    ) -> Result<Vec<f32>, Cancelled> {
        let mut out = Vec::with_capacity(self.shape.output_len());
        let room = &mut out.spare_capacity_mut()[..self.shape.output_len()];
        self.forward_into(x, weights, bias, activation, room, cancel)?;
        // SAFETY: `forward_into` has written every value.
        unsafe { out.set_len(self.shape.output_len()) };
        Ok(out)
    }

    /// [`forward`](Self::forward) into memory of the caller. After `Ok` every value of `out` is written.
    ///
    /// # Errors
    /// [`Cancelled`] once `cancel` is set.
    pub fn forward_into(
        &self,
        x: &Padded,
        weights: &Packed,
        bias: Option<&[f32]>,
        activation: Activation,
        out: &mut [MaybeUninit<f32>],
        cancel: Option<&AtomicBool>,
    ) -> Result<(), Cancelled> {
        self.forward_onto(x, weights, (bias.unwrap_or_default(), activation), Ending::default(), out, cancel)
    }

    /// `ending(act(w ∗ x + bias))` into memory of the caller. After `Ok` every value of `out` is written.
    ///
    /// # Errors
    /// [`Cancelled`] once `cancel` is set.
    pub fn forward_onto(
        &self,
        x: &Padded,
        weights: &Packed,
        (bias, activation): (&[f32], Activation),
        ending: Ending,
        out: &mut [MaybeUninit<f32>],
        cancel: Option<&AtomicBool>,
    ) -> Result<(), Cancelled> {
        Valid { ending, ..self.valid(x, weights, bias, activation) }.run(out, false, cancel).map(|_| ())
    }

    /// `w ∗ x` (no bias, no activation) `[n, c_out, v, y, x]`, and its sums for batch normalisation.
    pub fn forward_with_sums(&self, x: &Padded, weights: &Packed) -> (Vec<f32>, Sums) {
        let mut out = Vec::with_capacity(self.shape.output_len());
        let room = &mut out.spare_capacity_mut()[..self.shape.output_len()];
        let sums = self.valid(x, weights, &[], Activation::None).run(room, true, None).unwrap_or_default();
        // SAFETY: without a cancel flag, all is written.
        unsafe { out.set_len(self.shape.output_len()) };
        (out, sums)
    }

    fn valid<'a>(&self, x: &'a Padded, weights: &'a Packed, bias: &'a [f32], activation: Activation) -> Valid<'a> {
        let expected = Layout { margin: self.shape.reach(), size: self.shape.size(), ..x.layout };
        assert_eq!(x.layout, expected, "an input padded for another convolution");
        let ConvShape { kernel, dilation, .. } = self.shape;
        Valid { isa: self.isa, x, weights, bias, kernel, dilation, activation, ending: Ending::default() }
    }

    /// The gradient with respect to the input, `[n, c_in, v, y, x]`. With edge padding, what falls on the margin is
    /// added to the edge pixels that the margin was copied from.
    pub fn data_gradient(&self, gradient: &Padded, weights: &[f32]) -> Vec<f32> {
        gradient::data(&self.shape, self.isa, gradient, weights)
    }

    /// The gradient with respect to the weights, `[c_out, c_in, (view taps,) y taps, x taps]`.
    pub fn weight_gradient(&self, x: &Padded, gradient: &Padded) -> Vec<f32> {
        gradient::weights(&self.shape, self.isa, x, gradient)
    }
}
