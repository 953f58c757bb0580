//! Convolution with its ends, forward and backward, on the kernel. Formulas: [`plenoscope::kernel`].

use burn::backend::flex::FlexTensor;
use plenoscope::kernel::{Activation, Conv, ConvShape, Isa, Kernel, Padded, Padding, norm};

use super::own_flex::{contiguous, dims, make, slice};
use crate::nets::NORM_EPSILON;

/// A convolution that ends in normalisation and ELU.
#[derive(Clone, Copy, Debug)]
pub struct Norm {
    /// Distance of neighbouring taps in y and x.
    pub dilation: usize,
}

/// A convolution that ends in `scale · tanh(z / scale)`.
#[derive(Clone, Copy, Debug)]
pub struct ConvTanh {
    /// Distance of neighbouring taps in y and x.
    pub dilation: usize,
    /// Largest magnitude of the result.
    pub scale: f32,
}

/// What the backward pass of a normalised convolution needs.
#[derive(Clone, Debug)]
pub struct Saved {
    conv: Conv,
    x: Padded,
    z: Vec<f32>,
    weight: FlexTensor,
    norm: norm::Norm,
    x_shape: Vec<usize>,
}

/// What the backward pass of a convolution with tanh needs.
#[derive(Clone, Debug)]
pub struct SavedTanh {
    conv: Conv,
    x: Padded,
    y: FlexTensor,
    weight: FlexTensor,
    scale: f32,
    x_shape: Vec<usize>,
}

/// The kernel's convolution for tensors of these shapes.
fn conv_of(x: &[usize], weight: &[usize], dilation: usize) -> Conv {
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
    Conv::new(shape, Isa::best())
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
    let conv = conv_of(&x_shape, &dims(&weight), how.dilation);
    let (plane, channels) = (conv.shape().plane(), conv.shape().channels_out);
    let padded = conv.pad_input(slice(&x));
    let (z, sums) = conv.forward_with_sums(&padded, &conv.pack(slice(&weight)));
    let norm = norm::Norm::from_sums(&sums, conv.shape().batch * plane, slice(&gamma), slice(&beta), NORM_EPSILON);
    let y = norm::elu(Isa::best(), &z, plane, &norm.scale, &norm.shift);
    let statistics = [norm.mean.as_slice(), norm.variance.as_slice()].concat();
    let y = make(y, &out_shape(&x_shape, channels));
    (y, make(statistics, &[2, channels]), Saved { conv, x: padded, z, weight, norm, x_shape })
}

/// Gradients of input (if wanted), weights, γ and β.
pub(super) fn norm_backward(saved: &Saved, gy: &[f32], wants_x: bool) -> [Option<FlexTensor>; 4] {
    let (conv, z, isa) = (&saved.conv, &saved.z, Isa::best());
    let shape = conv.shape();
    let (plane, width, channels) = (shape.plane(), shape.width, shape.channels_out);
    let sums = norm::elu_gradient_sums(isa, z, gy, plane, &saved.norm.scale, &saved.norm.shift);
    let (gamma, beta, per_channel) = saved.norm.backward(&sums, shape.batch * plane);
    let padded = conv.pad_gradient_with(|row, at| {
        let from = ((at.image * channels + at.channel) * shape.views + at.view) * shape.height + at.y;
        let from = from * width..(from + 1) * width;
        norm::elu_gradient_row(isa, &z[from.clone()], &gy[from], row, per_channel[at.channel]);
    });
    let weight = conv.weight_gradient(&saved.x, &padded);
    let x = wants_x.then(|| make(conv.data_gradient(&padded, slice(&saved.weight)), &saved.x_shape));
    [x, Some(make(weight, &dims(&saved.weight))), Some(make(gamma, &[channels])), Some(make(beta, &[channels]))]
}

pub(super) fn elu_forward(x: FlexTensor, weight: FlexTensor, bias: FlexTensor, how: Norm) -> FlexTensor {
    forward(x, weight, bias, how.dilation, Activation::Elu).0
}

/// Result, the convolution, the padded input, and the shape of the input.
fn forward(
    x: FlexTensor,
    weight: FlexTensor,
    bias: FlexTensor,
    dilation: usize,
    activation: Activation,
) -> (FlexTensor, Conv, Padded, Vec<usize>) {
    let (x, weight, bias) = (contiguous(x), contiguous(weight), contiguous(bias));
    let x_shape = dims(&x);
    let conv = conv_of(&x_shape, &dims(&weight), dilation);
    let padded = conv.pad_input(slice(&x));
    // Without a cancel flag nothing is ever cancelled.
    let y = conv.forward(&padded, &conv.pack(slice(&weight)), Some(slice(&bias)), activation, None).unwrap_or_default();
    (make(y, &out_shape(&x_shape, conv.shape().channels_out)), conv, padded, x_shape)
}

pub(super) fn tanh_forward(
    x: FlexTensor,
    weight: FlexTensor,
    bias: FlexTensor,
    end: ConvTanh,
) -> (FlexTensor, SavedTanh) {
    let weight = contiguous(weight);
    let shrink = |t: &FlexTensor| make(slice(t).iter().map(|v| v / end.scale).collect(), &dims(t));
    let (small_weight, small_bias) = (shrink(&weight), shrink(&contiguous(bias)));
    let (y, conv, padded, x_shape) =
        forward(x, small_weight, small_bias, end.dilation, Activation::Tanh { scale: end.scale });
    let saved = SavedTanh { conv, x: padded, y: y.clone(), weight, scale: end.scale, x_shape };
    (y, saved)
}

/// Gradients of input (if wanted), weights and bias.
pub(super) fn tanh_backward(saved: &SavedTanh, gy: &[f32], wants_x: bool) -> [Option<FlexTensor>; 3] {
    let shape = saved.conv.shape();
    let channels = shape.channels_out;
    let gz: Vec<f32> = slice(&saved.y).iter().zip(gy).map(|(y, g)| g * (1.0 - (y / saved.scale).powi(2))).collect();
    let bias = norm::sums(Isa::best(), &gz, channels, shape.plane()).iter().map(|[sum, _]| *sum as f32).collect();
    let padded = saved.conv.pad_gradient(&gz);
    let weight = saved.conv.weight_gradient(&saved.x, &padded);
    let x = wants_x.then(|| make(saved.conv.data_gradient(&padded, slice(&saved.weight)), &saved.x_shape));
    [x, Some(make(weight, &dims(&saved.weight))), Some(make(bias, &[channels]))]
}
