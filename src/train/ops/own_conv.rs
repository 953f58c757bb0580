//! Convolution with its ends, forward and backward, on the kernel. Formulas: [`plenoscope::kernel`].

use burn::backend::flex::FlexTensor;
use plenoscope::kernel::{Activation, Conv, ConvShape, Gradients, Halves, Isa, Kernel, Padding, norm};
use rayon::prelude::*;

use super::own_flex::{contiguous, dims, make, slice};
use crate::nets::NORM_EPSILON;

/// A convolution that ends in normalisation and ELU.
#[derive(Clone, Copy, Debug)]
pub struct Norm {
    /// Distance of neighbouring taps in y and x.
    pub dilation: usize,
    /// Whether its products are of 16-bit numbers.
    pub halves: Option<Halves>,
}

/// A convolution with bias that ends in ELU or in `scale · tanh(z / scale)`.
#[derive(Clone, Copy, Debug)]
pub struct Biased {
    /// Distance of neighbouring taps in y and x.
    pub dilation: usize,
    /// What it ends in.
    pub activation: Activation,
    /// Whether its products are of 16-bit numbers.
    pub halves: Option<Halves>,
}

/// What the backward pass of a normalised convolution needs.
#[derive(Clone, Debug)]
pub struct Saved {
    conv: Conv,
    x: FlexTensor,
    z: Vec<f32>,
    weight: FlexTensor,
    norm: norm::Norm,
}

/// What the backward pass of a convolution with bias needs.
#[derive(Clone, Debug)]
pub struct SavedBiased {
    conv: Conv,
    x: FlexTensor,
    y: FlexTensor,
    weight: FlexTensor,
    activation: Activation,
}

/// The kernel's convolution for tensors of these shapes.
fn conv_of(x: &[usize], weight: &[usize], dilation: usize, halves: Option<Halves>) -> Conv {
    let volume = x.len() == 5;
    let shape = ConvShape {
        batch: x[0],
        channels_in: x[1],
        channels_out: weight[0],
        views: if volume { x[2] } else { 1 },
        height: x[x.len() - 2],
        width: x[x.len() - 1],
        kernel: if volume { Kernel::Volume } else { Kernel::Plane },
        dilation,
        padding: Padding::Edge,
    };
    Conv::new(shape, Isa::best()).in_halves(halves)
}

fn out_shape(x: &[usize], channels: usize) -> Vec<usize> {
    let mut shape = x.to_vec();
    shape[1] = channels;
    shape
}

pub(super) fn norm_forward(
    x: FlexTensor,
    weight: FlexTensor,
    [gamma, beta]: [FlexTensor; 2],
    how: Norm,
) -> (FlexTensor, FlexTensor, Saved) {
    let (x, weight, gamma, beta) = (contiguous(x), contiguous(weight), contiguous(gamma), contiguous(beta));
    let x_shape = dims(&x);
    let conv = conv_of(&x_shape, &dims(&weight), how.dilation, how.halves);
    let (plane, channels) = (conv.shape().plane(), conv.shape().channels_out);
    let (z, sums) = conv.step(slice(&x), slice(&weight));
    let norm = norm::Norm::from_sums(&sums, conv.shape().batch * plane, slice(&gamma), slice(&beta), NORM_EPSILON);
    let y = norm::elu(Isa::best(), &z, plane, &norm.scale, &norm.shift);
    let statistics = [norm.mean.as_slice(), norm.variance.as_slice()].concat();
    let y = make(y, &out_shape(&x_shape, channels));
    (y, make(statistics, &[2, channels]), Saved { conv, x, z, weight, norm })
}

/// Gradients of input (if wanted), weights, γ and β.
pub(super) fn norm_backward(saved: &Saved, gy: &[f32], wants_x: bool) -> [Option<FlexTensor>; 4] {
    let (conv, z, isa) = (&saved.conv, &saved.z, Isa::best());
    let shape = conv.shape();
    let (plane, channels) = (shape.plane(), shape.channels_out);
    let sums = norm::elu_gradient_sums(isa, z, gy, plane, &saved.norm.scale, &saved.norm.shift);
    let (gamma, beta, per_channel) = saved.norm.backward(&sums, shape.batch * plane);
    let pieces = |gz: &mut [f32], at: usize| {
        let from = at..at + gz.len();
        norm::elu_gradient_row(isa, &z[from.clone()], &gy[from], gz, per_channel[at / plane % channels]);
    };
    let gradients = conv.step_gradients(slice(&saved.x), slice(&saved.weight), pieces, wants_x);
    let [weight, x] = tensors(gradients, &saved.weight, &saved.x);
    [x, weight, Some(make(gamma, &[channels])), Some(make(beta, &[channels]))]
}

/// Gradients of weights and (if there is one) input.
fn tensors(gradients: Gradients, weight: &FlexTensor, x: &FlexTensor) -> [Option<FlexTensor>; 2] {
    [Some(make(gradients.weights, &dims(weight))), gradients.x.map(|gradient| make(gradient, &dims(x)))]
}

pub(super) fn biased_forward(
    x: FlexTensor,
    weight: FlexTensor,
    bias: FlexTensor,
    Biased { dilation, activation, halves }: Biased,
) -> (FlexTensor, SavedBiased) {
    let (x, weight, bias) = (contiguous(x), contiguous(weight), contiguous(bias));
    let conv = conv_of(&dims(&x), &dims(&weight), dilation, halves);
    let (mut y, _) = conv.step(slice(&x), slice(&weight));
    let (plane, channels) = (conv.shape().plane(), conv.shape().channels_out);
    let scale = if let Activation::Tanh { scale } = activation { scale } else { 1.0 };
    y.par_chunks_mut(plane).enumerate().for_each(|(i, plane)| {
        let bias = slice(&bias)[i % channels];
        plane.iter_mut().for_each(|z| *z = (*z + bias) / scale);
        norm::activate(Isa::best(), plane, activation);
    });
    let y = make(y, &out_shape(&dims(&x), channels));
    (y.clone(), SavedBiased { conv, x, y, weight, activation })
}

/// Gradients of input (if wanted), weights and bias.
pub(super) fn biased_backward(saved: &SavedBiased, gy: &[f32], wants_x: bool) -> [Option<FlexTensor>; 3] {
    let shape = saved.conv.shape();
    let channels = shape.channels_out;
    let slope = |y: f32| match saved.activation {
        Activation::Tanh { scale } => 1.0 - (y / scale).powi(2),
        // exp(z) for z below 0, which is y + 1.
        Activation::Elu => 1.0 + y.min(0.0),
        Activation::None => 1.0,
        Activation::Clamp { low, high } => f32::from(low < y && y < high),
        // It cannot be told from y, and no net is trained with it.
        Activation::Gelu => f32::NAN,
    };
    let values = slice(&saved.y).par_iter().zip(gy).with_min_len(8192);
    let gz: Vec<f32> = values.map(|(y, gy)| gy * slope(*y)).collect();
    let bias = norm::sums(Isa::best(), &gz, channels, shape.plane()).iter().map(|[sum, _]| *sum as f32).collect();
    let pieces = |piece: &mut [f32], at: usize| piece.copy_from_slice(&gz[at..][..piece.len()]);
    let gradients = saved.conv.step_gradients(slice(&saved.x), slice(&saved.weight), pieces, wants_x);
    let [weight, x] = tensors(gradients, &saved.weight, &saved.x);
    [x, weight, Some(make(bias, &[channels]))]
}
