//! The operations that the nets are made of, each in two ways: burn's own (portable, the oracle) and ours.

mod own;
mod own_conv;
mod own_flex;
mod stock;

use burn::tensor::Tensor;

use own_conv::{Biased, Norm};
use plenoscope::kernel::Activation;

/// Whose operations compute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// Burn's own operations, on the processor.
    Stock,
    /// Ours, on the kernel that inference uses.
    Own,
    /// Burn's own, on a graphics device.
    Graphics,
}

/// Convolution (edge padded, no bias), batch normalisation with the batch's statistics, ELU.
///
/// # Shapes
/// - `x`: `[n, c_in, (v,) h, w]`, `weight`: `[c_out, c_in, 3, 3 (, 3)]`
/// - result: `[n, c_out, (v,) h, w]` and `[2, c_out]`: the batch's means and variances before normalisation
pub fn conv_norm_elu<const D: usize>(
    x: Tensor<D>,
    weight: Tensor<D>,
    norm: [Tensor<1>; 2],
    dilation: usize,
    path: Path,
) -> (Tensor<D>, Tensor<2>) {
    let [gamma, beta] = norm;
    match path {
        Path::Stock | Path::Graphics => stock::conv_norm_elu(x, weight, gamma, beta, dilation),
        Path::Own => own::conv_norm_elu(x, weight, gamma, beta, Norm { dilation }),
    }
}

/// Convolution (edge padded), normalisation with given `[gamma, beta, mean, variance]`, ELU: what inference computes.
pub fn conv_folded_elu<const D: usize>(
    x: Tensor<D>,
    weight: Tensor<D>,
    norm: [Tensor<1>; 4],
    dilation: usize,
    path: Path,
) -> Tensor<D> {
    let (weight, bias) = stock::fold(weight, norm);
    match path {
        Path::Stock | Path::Graphics => stock::conv_elu(x, weight, bias, dilation),
        Path::Own => own::conv_biased(x, weight, bias, Biased { dilation, activation: Activation::Elu }),
    }
}

/// Convolution (edge padded) with bias, then `scale · tanh(z / scale)`.
pub fn conv_tanh<const D: usize>(
    x: Tensor<D>,
    weight: Tensor<D>,
    bias: Tensor<1>,
    (dilation, scale): (usize, f32),
    path: Path,
) -> Tensor<D> {
    match path {
        Path::Stock | Path::Graphics => stock::conv_tanh(x, weight, bias, dilation, scale),
        Path::Own => own::conv_biased(x, weight, bias, Biased { dilation, activation: Activation::Tanh { scale } }),
    }
}

/// Mean of 2×2 pixels: `[n, c, h, w]` → `[n, c, h/2, w/2]`.
pub fn pool(x: Tensor<4>, path: Path) -> Tensor<4> {
    match path {
        Path::Stock | Path::Graphics => stock::pool(x),
        Path::Own => own::pool(x),
    }
}

/// `low` at twice its size (nearest pixel), then `skip`: `[n, a, h/2, w/2]`, `[n, b, h, w]` → `[n, a + b, h, w]`.
pub fn up_concat(low: Tensor<4>, skip: Tensor<4>, path: Path) -> Tensor<4> {
    match path {
        Path::Stock | Path::Graphics => stock::up_concat(low, skip),
        Path::Own => own::up_concat(low, skip),
    }
}

#[cfg(test)]
mod tests;
