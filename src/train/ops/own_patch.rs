//! Zero-padded convolutions of settled normalisation, forward on the kernel that inference uses, and backward.

use std::borrow::Cow;
use std::ops::Range;

use burn::backend::flex::FlexTensor;
use plenoscope::kernel::product::{Columns, DepthWise, Patches, Project};
use plenoscope::kernel::{Activation, Isa, Limits, norm};
use rayon::prelude::*;

use super::Patch;
use super::own_flex::{contiguous, dims, make, slice};
use crate::nets::zeros;

/// What the backward pass needs.
#[derive(Clone, Debug)]
pub struct SavedPatch {
    how: Patch,
    shape: Shape,
    x: FlexTensor,
    y: FlexTensor,
    weight: FlexTensor,
}

/// The convolution of one sample, and how many there are.
#[derive(Clone, Copy, Debug)]
struct Shape {
    patches: Patches,
    samples: usize,
    outputs: usize,
}

impl Shape {
    fn of(x: &[usize], weight: &[usize], how: Patch) -> Self {
        let (side, stride) = (weight[2], how.stride());
        let [before, _] = how.margins();
        let patches = Patches {
            channels: x[1],
            size: [x[2], x[3]],
            kernel: [side; 2],
            stride: [stride; 2],
            dilation: [how.dilation; 2],
            before: [before; 2],
            output: [x[2] / stride, x[3] / stride],
        };
        Self { patches, samples: x[0], outputs: weight[0] }
    }

    /// Whether each patch is one pixel.
    fn is_pointwise(&self) -> bool {
        self.patches.kernel == [1; 2] && self.patches.stride == [1; 2]
    }

    fn input_len(&self) -> usize {
        self.patches.input_len()
    }

    fn output_len(&self) -> usize {
        self.outputs * self.patches.pixels()
    }
}

pub(super) fn patch_forward(
    x: FlexTensor,
    weight: FlexTensor,
    bias: FlexTensor,
    how: Patch,
) -> (FlexTensor, SavedPatch) {
    let (x, weight, bias) = (contiguous(x), contiguous(weight), contiguous(bias));
    let shape = Shape::of(&dims(&x), &dims(&weight), how);
    let (patches, isa) = (&shape.patches, Isa::best());
    let activation = if how.clamped { Activation::Clamp { low: 0.0, high: 6.0 } } else { Activation::None };
    let of_sample = |(x, y): (&[f32], &mut [f32])| {
        let (weights, bias) = (slice(&weight), slice(&bias));
        if how.each() {
            return DepthWise { isa, patches, weights, bias, activation }.onto(x, y);
        }
        let columns = if shape.is_pointwise() { Columns::Planes(x) } else { Columns::Patches(x, patches) };
        Project { isa, weights, bias, activation, limits: Limits::NONE }.onto(columns, None, y);
    };
    let mut y = zeros(shape.samples * shape.output_len());
    slice(&x).par_chunks(shape.input_len()).zip(y.par_chunks_mut(shape.output_len())).for_each(of_sample);
    let [height, width] = patches.output;
    let y = make(y, &[shape.samples, shape.outputs, height, width]);
    (y.clone(), SavedPatch { how, shape, x, y, weight })
}

impl SavedPatch {
    /// Gradients of input (if wanted), weights and bias.
    pub(super) fn backward(&self, gy: &[f32], wants_x: bool) -> [Option<FlexTensor>; 3] {
        let (shape, isa) = (&self.shape, Isa::best());
        let inside = |(y, gy): (&f32, &f32)| if 0.0 < *y && *y < 6.0 { *gy } else { 0.0 };
        let clamped = || slice(&self.y).par_iter().zip(gy).with_min_len(8192).map(inside).collect::<Vec<f32>>();
        let gz = if self.how.clamped { Cow::Owned(clamped()) } else { Cow::Borrowed(gy) };
        let sums = norm::sums(isa, &gz, shape.outputs, shape.patches.pixels());
        let bias = sums.iter().map(|[sum, _]| *sum as f32).collect();
        let (weights, x) = if self.how.each() { self.each(&gz, wants_x) } else { self.all(&gz, wants_x) };
        let x = x.map(|x| make(x, &dims(&self.x)));
        [x, Some(make(weights, &dims(&self.weight))), Some(make(bias, &[shape.outputs]))]
    }

    /// Gradients of weights and input where all channels are taken together: products with the patches' matrix.
    fn all(&self, gz: &[f32], wants_x: bool) -> (Vec<f32>, Option<Vec<f32>>) {
        let (shape, patches) = (&self.shape, &self.shape.patches);
        let (depth, pixels, outputs) = (patches.depth(), patches.pixels(), shape.outputs);
        let (mut weights, mut sum) = (vec![0.0; outputs * depth], vec![0.0; outputs * depth]);
        let no_bias = vec![0.0; outputs.max(depth)];
        for (x, gz) in slice(&self.x).chunks(shape.input_len()).zip(gz.chunks(shape.output_len())) {
            let gathered = if shape.is_pointwise() { None } else { Some(gather(patches, x)) };
            let columns = Columns::PixelsFirst(gathered.as_deref().unwrap_or(x));
            plain(gz, &no_bias[..outputs]).onto(columns, Some(&weights), &mut sum);
            std::mem::swap(&mut weights, &mut sum);
        }
        let turned = transposed(slice(&self.weight), outputs);
        let to_x = |(gz, x): (&[f32], &mut [f32])| {
            let product = plain(&turned, &no_bias[..depth]);
            if shape.is_pointwise() {
                return product.onto(Columns::Planes(gz), None, x);
            }
            let mut columns = vec![0.0; depth * pixels];
            product.onto(Columns::Planes(gz), None, &mut columns);
            scatter(patches, &columns, x);
        };
        let x = wants_x.then(|| self.samples(gz, to_x));
        (weights, x)
    }

    /// The same where each channel is convolved by itself.
    fn each(&self, gz: &[f32], wants_x: bool) -> (Vec<f32>, Option<Vec<f32>>) {
        let (shape, patches) = (&self.shape, &self.shape.patches);
        let (plane, pixels, channels) = (patches.size[0] * patches.size[1], patches.pixels(), patches.channels);
        let taps = patches.kernel[0] * patches.kernel[1];
        let x = slice(&self.x);
        let of_channel = |(channel, weights): (usize, &mut [f32])| {
            for map in (channel..channels * shape.samples).step_by(channels) {
                let (x, gz) = (&x[map * plane..][..plane], &gz[map * pixels..][..pixels]);
                weights.iter_mut().enumerate().for_each(|(tap, w)| *w += correlation(patches, tap, x, gz));
            }
        };
        let mut weights = zeros(channels * taps);
        weights.par_chunks_mut(taps).enumerate().for_each(of_channel);
        (weights, wants_x.then(|| if patches.stride == [1; 2] { self.turned(gz) } else { self.spread_all(gz) }))
    }

    /// The gradient of the input of such a convolution of stride 1: one with the kernels turned round.
    fn turned(&self, gz: &[f32]) -> Vec<f32> {
        let (patches, isa) = (&self.shape.patches, Isa::best());
        let kernels = slice(&self.weight).chunks(patches.kernel[0] * patches.kernel[1]);
        let weights: Vec<f32> = kernels.flat_map(|kernel| kernel.iter().rev().copied()).collect();
        let bias = vec![0.0; patches.channels];
        let each = DepthWise { isa, patches, weights: &weights, bias: &bias, activation: Activation::None };
        self.samples(gz, |(gz, x)| each.onto(gz, x))
    }

    /// The same of any stride, tap by tap.
    fn spread_all(&self, gz: &[f32]) -> Vec<f32> {
        let patches = &self.shape.patches;
        let (plane, taps) = (patches.size[0] * patches.size[1], patches.kernel[0] * patches.kernel[1]);
        let mut to_x = zeros(self.shape.samples * self.shape.input_len());
        to_x.par_chunks_mut(plane).zip(gz.par_chunks(patches.pixels())).enumerate().for_each(|(map, (to_x, gz))| {
            let kernel = &slice(&self.weight)[map % patches.channels * taps..][..taps];
            kernel.iter().enumerate().for_each(|(tap, w)| spread(patches, tap, gz, *w, to_x));
        });
        to_x
    }

    /// An array like the input, each sample of it made from that of the result's gradient.
    fn samples(&self, gz: &[f32], make: impl Fn((&[f32], &mut [f32])) + Send + Sync) -> Vec<f32> {
        let mut x = zeros(self.shape.samples * self.shape.input_len());
        gz.par_chunks(self.shape.output_len()).zip(x.par_chunks_mut(self.shape.input_len())).for_each(make);
        x
    }
}

/// A product and no more.
fn plain<'a>(weights: &'a [f32], bias: &'a [f32]) -> Project<'a> {
    Project { isa: Isa::best(), weights, bias, activation: Activation::None, limits: Limits::NONE }
}

/// Rows `[columns of the result]` of a tap that lie in the picture, each with where its first pixel lies there.
fn rows(patches: &Patches, tap: usize) -> impl Iterator<Item = (Range<usize>, usize)> {
    let Patches { size: [height, width], kernel, stride, dilation, before, output, .. } = *patches;
    let [down, across] = [tap / kernel[1] * dilation[0], tap % kernel[1] * dilation[1]];
    let first = before[1].saturating_sub(across).div_ceil(stride[1]);
    let end = (width + before[1]).saturating_sub(across).div_ceil(stride[1]).min(output[1]);
    (0..output[0]).filter(move |_| first < end).filter_map(move |y| {
        let row = (y * stride[0] + down).checked_sub(before[0]).filter(|row| *row < height)?;
        Some((y * output[1] + first..y * output[1] + end, row * width + first * stride[1] + across - before[1]))
    })
}

/// Σ of a tap's pixels with the result's gradient.
fn correlation(patches: &Patches, tap: usize, x: &[f32], gz: &[f32]) -> f32 {
    let (isa, mut sum) = (Isa::best(), 0.0);
    for (at, from) in rows(patches, tap) {
        let gz = &gz[at];
        if patches.stride[1] == 1 {
            sum += norm::dot(isa, &x[from..][..gz.len()], gz);
        } else {
            sum += x[from..].iter().step_by(patches.stride[1]).zip(gz).map(|(x, gz)| x * gz).sum::<f32>();
        }
    }
    sum
}

/// Adds the result's gradient, times a weight, to a tap's pixels.
fn spread(patches: &Patches, tap: usize, gz: &[f32], weight: f32, to_x: &mut [f32]) {
    for (at, from) in rows(patches, tap) {
        if patches.stride[1] == 1 {
            let to_x = &mut to_x[from..][..at.len()];
            to_x.iter_mut().zip(&gz[at]).for_each(|(x, gz)| *x += weight * gz);
        } else {
            to_x[from..].iter_mut().step_by(patches.stride[1]).zip(&gz[at]).for_each(|(x, gz)| *x += weight * gz);
        }
    }
}

/// The patches as columns of a matrix `[depth, pixels]`.
fn gather(patches: &Patches, x: &[f32]) -> Vec<f32> {
    let taps = patches.kernel[0] * patches.kernel[1];
    let mut columns = vec![0.0; patches.depth() * patches.pixels()];
    for (row, columns) in columns.chunks_mut(patches.pixels()).enumerate() {
        let plane = &x[row / taps * patches.size[0] * patches.size[1]..];
        for (at, from) in rows(patches, row % taps) {
            columns[at].iter_mut().zip(plane[from..].iter().step_by(patches.stride[1])).for_each(|(to, x)| *to = *x);
        }
    }
    columns
}

/// Adds to a picture's pixels what lies in the patches for them.
fn scatter(patches: &Patches, columns: &[f32], x: &mut [f32]) {
    let (taps, plane) = (patches.kernel[0] * patches.kernel[1], patches.size[0] * patches.size[1]);
    for (row, columns) in columns.chunks(patches.pixels()).enumerate() {
        spread(patches, row % taps, columns, 1.0, &mut x[row / taps * plane..][..plane]);
    }
}

/// `[rows, n]` as `[n, rows]`.
fn transposed(matrix: &[f32], rows: usize) -> Vec<f32> {
    let n = matrix.len() / rows;
    let mut turned = vec![0.0; matrix.len()];
    turned.par_chunks_mut(rows).enumerate().with_min_len(8).for_each(|(column, turned)| {
        turned.iter_mut().zip(matrix[column..].iter().step_by(n)).for_each(|(to, value)| *to = *value);
    });
    turned
}
