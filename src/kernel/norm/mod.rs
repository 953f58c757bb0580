//! Batch normalisation with ELU, forward and backward, and activations by themselves.
//!
//! Formulas: see [`crate::kernel`]. `z` and `y` are `[n, c, plane]`; sums are taken in f64 over pieces of some
//! thousands of values.

pub(in crate::kernel) mod rows;

use rayon::prelude::*;

use super::isa::{Isa, on_isa};
use super::padded::SendPtr;
use super::tile::Activation;

/// Values of a piece that one thread takes at a time.
const PIECE: usize = 1 << 14;

/// What one channel needs backward: `gz = k0·g + k1·z + k2`, `g = gy·elu'(scale·z + shift)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Channel {
    /// `s = γ·istd`.
    pub scale: f32,
    /// `t = β − μ·s`.
    pub shift: f32,
    /// `[s, −s·q, s·(q·μ − ∂β/m)]`.
    pub k: [f32; 3],
}

/// Batch normalisation of one layer in a training step, channel by channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Norm {
    /// Mean of `z`.
    pub mean: Vec<f32>,
    /// Variance of `z` (divided by the number of values).
    pub variance: Vec<f32>,
    /// `1/√(variance + ε)`.
    pub istd: Vec<f32>,
    /// `s = γ·istd`.
    pub scale: Vec<f32>,
    /// `t = β − μ·s`.
    pub shift: Vec<f32>,
}

impl Norm {
    /// From the sums that [`Conv::forward_with_sums`](super::Conv::forward_with_sums) gives, over `count` = n·v·h·w
    /// values per channel.
    pub fn from_sums(sums: &[[f64; 2]], count: usize, gamma: &[f32], beta: &[f32], epsilon: f32) -> Self {
        let mut norm = Self::default();
        for (&[sum, squares], (&gamma, &beta)) in sums.iter().zip(gamma.iter().zip(beta)) {
            let mean = sum / count as f64;
            let variance = (squares / count as f64 - mean * mean).max(0.0);
            let istd = 1.0 / (variance + f64::from(epsilon)).sqrt();
            let scale = f64::from(gamma) * istd;
            norm.mean.push(mean as f32);
            norm.variance.push(variance as f32);
            norm.istd.push(istd as f32);
            norm.scale.push(scale as f32);
            norm.shift.push((f64::from(beta) - mean * scale) as f32);
        }
        norm
    }

    /// From the sums that [`elu_gradient_sums`] gives: `(∂γ, ∂β, what each channel needs backward)`.
    pub fn backward(&self, sums: &[[f64; 2]], count: usize) -> (Vec<f32>, Vec<f32>, Vec<Channel>) {
        let (mut gamma, mut beta, mut channels) = (vec![], vec![], vec![]);
        for (c, &[sum, product]) in sums.iter().enumerate() {
            let (mean, istd, scale) = (f64::from(self.mean[c]), f64::from(self.istd[c]), f64::from(self.scale[c]));
            let gradient = (product - mean * sum) * istd;
            let q = gradient * istd / count as f64;
            let k = [scale, -scale * q, scale * (q * mean - sum / count as f64)].map(|k| k as f32);
            gamma.push(gradient as f32);
            beta.push(sum as f32);
            channels.push(Channel { scale: self.scale[c], shift: self.shift[c], k });
        }
        (gamma, beta, channels)
    }
}

/// `elu(scale[c]·z + shift[c])` for `z` `[n, c, plane]`.
pub fn elu(isa: Isa, z: &[f32], plane: usize, scale: &[f32], shift: &[f32]) -> Vec<f32> {
    let mut y = Vec::with_capacity(z.len());
    let target = SendPtr(y.as_mut_ptr());
    z.par_chunks(plane).enumerate().for_each(|(index, z)| {
        let c = index % scale.len();
        z.par_chunks(PIECE).enumerate().for_each(|(piece, z)| {
            // SAFETY: pieces are disjoint, and inside the capacity.
            let y = unsafe { target.at(index * plane + piece * PIECE) };
            on_isa!(isa, elu_row(z, y, scale[c], shift[c]));
        });
    });
    // SAFETY: the pieces are the whole of it.
    unsafe { y.set_len(z.len()) };
    y
}

/// `elu(scale·z + shift)` of one row, into a row of the same length (for
/// [`Conv::pad_input_with`](super::Conv::pad_input_with)).
pub fn elu_row(isa: Isa, z: &[f32], y: &mut [f32], scale: f32, shift: f32) {
    assert_eq!(z.len(), y.len(), "lengths of the rows");
    let y = y.as_mut_ptr();
    on_isa!(isa, elu_row(z, y, scale, shift));
}

/// Per channel Σ g and Σ g·z for `g = gy·elu'(scale·z + shift)`; `z` and `gy` are `[n, c, plane]`.
pub fn elu_gradient_sums(isa: Isa, z: &[f32], gy: &[f32], plane: usize, scale: &[f32], shift: &[f32]) -> Vec<[f64; 2]> {
    assert_eq!(z.len(), gy.len(), "lengths of z and its gradient");
    let of_plane = |(index, (z, gy)): (usize, (&[f32], &[f32]))| {
        let c = index % scale.len();
        let pieces = z.par_chunks(PIECE).zip(gy.par_chunks(PIECE));
        pieces.map(|(z, gy)| on_isa!(isa, elu_gradient_sums(z, gy, scale[c], shift[c]))).collect::<Vec<_>>()
    };
    let planes: Vec<_> = z.par_chunks(plane).zip(gy.par_chunks(plane)).enumerate().map(of_plane).collect();
    let mut sums = vec![[0.0; 2]; scale.len()];
    for (index, pieces) in planes.iter().enumerate() {
        let sum = &mut sums[index % scale.len()];
        pieces.iter().for_each(|piece| *sum = [sum[0] + piece[0], sum[1] + piece[1]]);
    }
    sums
}

/// `gz = k0·g + k1·z + k2` of one row (for [`Conv::pad_gradient_with`](super::Conv::pad_gradient_with)).
pub fn elu_gradient_row(isa: Isa, z: &[f32], gy: &[f32], gz: &mut [f32], channel: Channel) {
    assert_eq!([z.len(), gy.len()], [gz.len(); 2], "lengths of the rows");
    on_isa!(isa, elu_gradient_row(z, gy, gz, channel));
}

/// Σ a·b of two rows.
pub fn dot(isa: Isa, a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len(), "lengths of the rows");
    on_isa!(isa, dot_row(a, b))
}

/// An activation of `values`, in place.
pub fn activate(isa: Isa, values: &mut [f32], activation: Activation) {
    values.par_chunks_mut(PIECE).for_each(|piece| on_isa!(isa, activate(piece, activation)));
}

/// Per channel Σ x and Σ x² of `values` `[n, channels, plane]`: the bias gradient of a layer without normalisation,
/// for one.
pub fn sums(isa: Isa, values: &[f32], channels: usize, plane: usize) -> Vec<[f64; 2]> {
    let of_plane = |values: &[f32]| {
        values.chunks(PIECE).fold([0.0; 2], |sum, piece| {
            let [a, b] = on_isa!(isa, sum_and_squares(piece));
            [sum[0] + a, sum[1] + b]
        })
    };
    let planes: Vec<_> = values.par_chunks(plane).map(of_plane).collect();
    let mut sums = vec![[0.0; 2]; channels];
    for (index, plane) in planes.iter().enumerate() {
        let sum = &mut sums[index % channels];
        *sum = [sum[0] + plane[0], sum[1] + plane[1]];
    }
    sums
}
