//! Burn's CPU tensors as slices, and the two operations that only move pixels.

use burn::backend::TensorMetadata as _;
use burn::backend::flex::FlexTensor;
use burn::tensor::TensorData;
use rayon::prelude::*;

use crate::nets::zeros;

pub(super) fn make(values: Vec<f32>, shape: &[usize]) -> FlexTensor {
    FlexTensor::from_data(TensorData::new(values, shape.to_vec()))
}

pub(super) fn dims(tensor: &FlexTensor) -> Vec<usize> {
    tensor.shape().iter().copied().collect()
}

/// The tensor with its values in a row, so that [`slice()`] can see them.
pub(super) fn contiguous(tensor: FlexTensor) -> FlexTensor {
    if tensor.as_slice::<f32>().is_some() { tensor } else { tensor.to_contiguous() }
}

/// The values of a contiguous f32 tensor.
pub(super) fn slice(tensor: &FlexTensor) -> &[f32] {
    tensor.as_slice::<f32>().expect("made contiguous, and all our tensors are f32")
}

pub(super) fn pool_forward(x: &FlexTensor) -> FlexTensor {
    let [n, c, h, w] = four(&dims(x));
    let mut y = zeros(n * c * (h / 2) * (w / 2));
    y.par_chunks_mut(w / 2).enumerate().for_each(|(row, y)| {
        let (top, bottom) = slice(x)[row * 2 * w..][..2 * w].split_at(w);
        for (y, (top, bottom)) in y.iter_mut().zip(top.chunks_exact(2).zip(bottom.chunks_exact(2))) {
            *y = 0.25 * (top[0] + top[1] + bottom[0] + bottom[1]);
        }
    });
    make(y, &[n, c, h / 2, w / 2])
}

pub(super) fn pool_backward(gy: &[f32], shape: &[usize]) -> Vec<f32> {
    let [n, c, h, w] = four(shape);
    let mut gx = zeros(n * c * h * w);
    gx.par_chunks_mut(2 * w).zip(gy.par_chunks(w / 2)).for_each(|(gx, gy)| {
        for row in gx.chunks_exact_mut(w) {
            row.chunks_exact_mut(2).zip(gy).for_each(|(pair, gy)| pair.fill(0.25 * gy));
        }
    });
    gx
}

pub(super) fn up_forward(low: &FlexTensor, skip: &FlexTensor) -> FlexTensor {
    let ([n, a, _, _], [_, b, h, w]) = (four(&dims(low)), four(&dims(skip)));
    let plane = h * w;
    let mut y = zeros(n * (a + b) * plane);
    y.par_chunks_mut(plane).enumerate().for_each(|(map, y)| {
        let (sample, channel) = (map / (a + b), map % (a + b));
        if channel >= a {
            y.copy_from_slice(&slice(skip)[(sample * b + channel - a) * plane..][..plane]);
            return;
        }
        let small = &slice(low)[(sample * a + channel) * plane / 4..][..plane / 4];
        for (row, y) in y.chunks_mut(w).enumerate() {
            let small = &small[row / 2 * (w / 2)..][..w / 2];
            y.chunks_exact_mut(2).zip(small).for_each(|(pair, value)| pair.fill(*value));
        }
    });
    make(y, &[n, a + b, h, w])
}

/// Gradients of the small map and of the skip.
pub(super) fn up_backward(gy: &[f32], low: &[usize], skip: &[usize]) -> (Vec<f32>, Vec<f32>) {
    let ([n, a, _, _], [_, b, h, w]) = (four(low), four(skip));
    let plane = h * w;
    let of = |sample: usize, channel: usize| &gy[(sample * (a + b) + channel) * plane..][..plane];
    let mut to_low = zeros(n * a * plane / 4);
    to_low.par_chunks_mut(plane / 4).enumerate().for_each(|(map, to)| {
        let from = of(map / a, map % a);
        for (row, to) in to.chunks_mut(w / 2).enumerate() {
            let (top, bottom) = from[row * 2 * w..][..2 * w].split_at(w);
            for (to, (top, bottom)) in to.iter_mut().zip(top.chunks_exact(2).zip(bottom.chunks_exact(2))) {
                *to = top[0] + top[1] + bottom[0] + bottom[1];
            }
        }
    });
    let mut to_skip = zeros(n * b * plane);
    to_skip.par_chunks_mut(plane).enumerate().for_each(|(map, to)| to.copy_from_slice(of(map / b, a + map % b)));
    (to_low, to_skip)
}

fn four(dims: &[usize]) -> [usize; 4] {
    [dims[0], dims[1], dims[2], dims[3]]
}
