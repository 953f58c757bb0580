//! The operations that the nets are made of, each in two ways: burn's own (portable, the oracle) and ours.

mod own;
mod own_conv;
mod own_flex;
mod own_patch;
mod stock;

use burn::tensor::Tensor;

use crate::nets::Form;
use own_conv::{Biased, Norm};
use plenoscope::kernel::{Activation, Halves};

/// Whose operations compute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// Burn's own operations, on the processor.
    Stock,
    /// Ours, on the kernel that inference uses; 3×3 convolutions from products of 16-bit numbers, given the proof that the
    /// processor has tiles for them.
    Own(Option<Halves>),
    /// Burn's own, on a graphics device.
    Graphics,
}

impl Path {
    /// Ours, in f32 throughout.
    pub const OWN: Self = Self::Own(None);
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
        Path::Own(halves) => own::conv_norm_elu(x, weight, gamma, beta, Norm { dilation, halves }),
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
        Path::Own(halves) => {
            own::conv_biased(x, weight, bias, Biased { dilation, activation: Activation::Elu, halves })
        }
    }
}

/// A zero-padded convolution whose normalisation is settled.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Pixels and channels that it takes together; never [`Form::Full`].
    pub form: Form,
    /// Distance of neighbouring taps.
    pub dilation: usize,
    /// Whether it ends in 0 … 6.
    pub clamped: bool,
}

impl Patch {
    pub(crate) fn stride(self) -> usize {
        self.form.stride()
    }

    pub(crate) fn each(self) -> bool {
        matches!(self.form, Form::Patch { each: true, .. })
    }

    /// Zeros before and after an axis.
    pub(crate) fn margins(self) -> [usize; 2] {
        let Form::Patch { side, stride, .. } = self.form else { return [0; 2] };
        let all = ((side - 1) * self.dilation + 1).saturating_sub(stride);
        [all / 2, all - all / 2]
    }
}

/// Such a convolution with its `[gamma, beta, mean, variance]`.
///
/// # Shapes
/// - `x`: `[n, c_in, h, w]`, sides being multiples of the stride; `weight`: `[c_out, c_in (1 for each by itself), k, k]`
/// - result: `[n, c_out, h / stride, w / stride]`
pub fn conv_settled(x: Tensor<4>, weight: Tensor<4>, norm: [Tensor<1>; 4], how: Patch, path: Path) -> Tensor<4> {
    let (weight, bias) = stock::fold(weight, norm);
    match path {
        Path::Stock | Path::Graphics => stock::conv_patch(x, weight, bias, how),
        Path::Own(_) => own::conv_patch(x, weight, bias, how),
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
        Path::Own(halves) => {
            let activation = Activation::Tanh { scale };
            own::conv_biased(x, weight, bias, Biased { dilation, activation, halves })
        }
    }
}

/// Mean of 2×2 pixels: `[n, c, h, w]` → `[n, c, h/2, w/2]`.
pub fn pool(x: Tensor<4>, path: Path) -> Tensor<4> {
    match path {
        Path::Stock | Path::Graphics => stock::pool(x),
        Path::Own(_) => own::pool(x),
    }
}

/// `low` at twice its size (nearest pixel), then `skip`: `[n, a, h/2, w/2]`, `[n, b, h, w]` → `[n, a + b, h, w]`.
pub fn up_concat(low: Tensor<4>, skip: Tensor<4>, path: Path) -> Tensor<4> {
    match path {
        Path::Stock | Path::Graphics => stock::up_concat(low, skip),
        Path::Own(_) => own::up_concat(low, skip),
    }
}

#[cfg(test)]
mod tests;
