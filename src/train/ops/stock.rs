//! The nets' operations from burn's own: the portable path, and what ours are compared with.

use burn::tensor::Tensor;
use burn::tensor::activation::elu;
use burn::tensor::module::{conv2d, conv3d};
use burn::tensor::ops::{ConvOptions, PadMode};

use super::Patch;
use crate::nets::NORM_EPSILON;

/// Edge padding by the dilation, then a valid convolution; the angular axis of a 3-D one has dilation 1.
fn conv<const D: usize>(x: Tensor<D>, weight: Tensor<D>, dilation: usize) -> Tensor<D> {
    if D == 4 {
        let d = dilation;
        let x: Tensor<4> = Tensor::from_dispatch(x.into_dispatch());
        let weight: Tensor<4> = Tensor::from_dispatch(weight.into_dispatch());
        let padded = x.pad([(d, d), (d, d)], PadMode::Edge);
        Tensor::from_dispatch(conv2d(padded, weight, None, ConvOptions::new([1, 1], [0, 0], [d, d], 1)).into_dispatch())
    } else {
        let x: Tensor<5> = Tensor::from_dispatch(x.into_dispatch());
        let weight: Tensor<5> = Tensor::from_dispatch(weight.into_dispatch());
        let padded = x.pad([(1, 1), (1, 1), (1, 1)], PadMode::Edge);
        Tensor::from_dispatch(conv3d(padded, weight, None, ConvOptions::new([1; 3], [0; 3], [1; 3], 1)).into_dispatch())
    }
}

/// A vector of channels as `[1, c, 1, …]`.
fn by_channel<const D: usize>(vector: Tensor<1>) -> Tensor<D> {
    let mut shape = [1; D];
    shape[1] = vector.dims()[0];
    vector.reshape(shape)
}

pub(super) fn conv_norm_elu<const D: usize>(
    x: Tensor<D>,
    weight: Tensor<D>,
    gamma: Tensor<1>,
    beta: Tensor<1>,
    dilation: usize,
) -> (Tensor<D>, Tensor<2>) {
    let z = conv(x, weight, dilation);
    let channels = z.dims()[1];
    let flat = z.clone().swap_dims(0, 1).reshape([channels as i32, -1]); // [c, n·h·w]
    let mean = flat.clone().mean_dim(1); // [c, 1]
    let var = (flat - mean.clone()).powi_scalar(2).mean_dim(1); // [c, 1]
    let scale = gamma * (var.clone().reshape([channels]) + NORM_EPSILON).sqrt().recip();
    let shift = beta - mean.clone().reshape([channels]) * scale.clone();
    let y = elu(z * by_channel(scale) + by_channel(shift), 1.0);
    (y, Tensor::cat(vec![mean, var], 1).swap_dims(0, 1).detach())
}

/// Weights and bias that do the convolution and its normalisation in one.
pub(super) fn fold<const D: usize>(
    weight: Tensor<D>,
    [gamma, beta, mean, var]: [Tensor<1>; 4],
) -> (Tensor<D>, Tensor<1>) {
    let scale = gamma * (var + NORM_EPSILON).sqrt().recip();
    let bias = beta - mean * scale.clone();
    let mut shape = [1; D];
    shape[0] = scale.dims()[0];
    (weight * scale.reshape(shape), bias)
}

pub(super) fn conv_elu<const D: usize>(x: Tensor<D>, weight: Tensor<D>, bias: Tensor<1>, dilation: usize) -> Tensor<D> {
    elu(conv(x, weight, dilation) + by_channel(bias), 1.0)
}

pub(super) fn conv_patch(x: Tensor<4>, weight: Tensor<4>, bias: Tensor<1>, how: Patch) -> Tensor<4> {
    let outputs = weight.dims()[0];
    let [before, after] = how.margins();
    let padded = x.pad([(before, after), (before, after)], PadMode::Constant(0.0));
    let groups = if how.each() { outputs } else { 1 };
    let (stride, dilation) = (how.stride(), how.dilation);
    let options = ConvOptions::new([stride; 2], [0, 0], [dilation; 2], groups);
    let z = conv2d(padded, weight, Some(bias), options);
    if how.clamped { z.clamp(0.0, 6.0) } else { z }
}

pub(super) fn conv_tanh<const D: usize>(
    x: Tensor<D>,
    weight: Tensor<D>,
    bias: Tensor<1>,
    dilation: usize,
    scale: f32,
) -> Tensor<D> {
    let z = conv(x, weight, dilation) + by_channel(bias);
    (z / scale).tanh() * scale
}

pub(super) fn pool(x: Tensor<4>) -> Tensor<4> {
    let [n, c, h, w] = x.dims();
    x.reshape([n * c, h / 2, 2, w / 2, 2]).mean_dim(4).mean_dim(2).reshape([n, c, h / 2, w / 2])
}

pub(super) fn up_concat(low: Tensor<4>, skip: Tensor<4>) -> Tensor<4> {
    let [n, c, h, w] = low.dims();
    let wide: Tensor<6> = low.reshape([n, c, h, 1, w, 1]).expand([n, c, h, 2, w, 2]);
    Tensor::cat(vec![wide.reshape([n, c, 2 * h, 2 * w]), skip], 1)
}
