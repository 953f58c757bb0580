//! Our operations against burn's own: values and gradients, on all the shapes that the nets have.

use burn::tensor::{Device, Tensor, TensorData};

use super::*;
use crate::nets::values;
use crate::rng::Rng;

/// Largest difference relative to the largest value, at most.
const RELATIVE: f32 = 2e-4;

fn device() -> Device {
    Device::flex().autodiff()
}

fn random<const D: usize>(seed: u64, shape: [usize; D]) -> Tensor<D> {
    let mut rng = Rng::new(seed, D as u64);
    let data: Vec<f32> = (0..shape.iter().product()).map(|_| rng.range(-1.0, 1.0)).collect();
    Tensor::from_data(TensorData::new(data, shape), &device())
}

fn same(what: &str, a: &[f32], b: &[f32]) {
    assert_eq!(a.len(), b.len(), "{what}");
    let largest = b.iter().fold(1e-6f32, |m, v| m.max(v.abs()));
    let worst = a.iter().zip(b).fold(0.0f32, |m, (a, b)| m.max((a - b).abs()));
    assert!(worst <= RELATIVE * largest, "{what}: {worst} of {largest}");
}

/// Result, statistics and the gradients of input, weights, γ and β of Σ result·probe.
fn norm_elu<const D: usize>(x: [usize; D], outputs: usize, dilation: usize, path: Path) -> Vec<Vec<f32>> {
    let mut shape = [3; D];
    (shape[0], shape[1]) = (outputs, x[1]);
    let mut out = x;
    out[1] = outputs;
    let leaves = (random(1, x).require_grad(), random(2, shape).require_grad());
    let norm = [random(3, [outputs]).require_grad(), random(4, [outputs]).require_grad()];
    let (y, statistics) = conv_norm_elu(leaves.0.clone(), leaves.1.clone(), norm.clone(), dilation, path);
    let gradients = (y.clone() * random(5, out)).sum().backward();
    let mut all = vec![
        values(y),
        values(statistics),
        values(leaves.0.grad(&gradients).unwrap()),
        values(leaves.1.grad(&gradients).unwrap()),
    ];
    all.extend(norm.iter().map(|t| values(t.grad(&gradients).unwrap())));
    all
}

fn check_norm_elu<const D: usize>(x: [usize; D], outputs: usize, dilation: usize) {
    let (ours, theirs) = (norm_elu(x, outputs, dilation, Path::OWN), norm_elu(x, outputs, dilation, Path::Stock));
    for (what, (a, b)) in ["y", "statistics", "∂x", "∂w", "∂γ", "∂β"].into_iter().zip(ours.iter().zip(&theirs))
    {
        same(&format!("{what} of {x:?} → {outputs}, dilation {dilation}"), a, b);
    }
}

#[test]
fn convolution_with_normalisation_and_elu_is_burns() {
    check_norm_elu([2, 5, 16, 24], 16, 1);
    check_norm_elu([1, 16, 9, 50], 64, 1);
    check_norm_elu([2, 24, 8, 6], 40, 2);
    check_norm_elu([2, 8, 6, 8], 16, 4);
    check_norm_elu([8, 80, 6, 8], 112, 4);
    check_norm_elu([1, 8, 20, 20], 8, 16);
    check_norm_elu([1, 4, 5, 6, 20], 8, 1);
    check_norm_elu([2, 8, 4, 7, 9], 8, 1);
    check_norm_elu([2, 8, 7, 18, 21], 3, 1);
}

#[test]
fn convolution_with_tanh_is_burns() {
    let run = |[from, to]: [usize; 2], path| {
        let leaves = (
            random(1, [2, from, 10, 20]).require_grad(),
            random(2, [to, from, 3, 3]).require_grad(),
            random(3, [to]).require_grad(),
        );
        let y = conv_tanh(leaves.0.clone(), leaves.1.clone(), leaves.2.clone(), (1, 4.0), path);
        let gradients = (y.clone() * random(5, [2, to, 10, 20])).sum().backward();
        let (x, w, b) = (
            leaves.0.grad(&gradients).unwrap(),
            leaves.1.grad(&gradients).unwrap(),
            leaves.2.grad(&gradients).unwrap(),
        );
        [values(y), values(x), values(w), values(b)]
    };
    for channels in [[8, 6], [40, 24]] {
        for (a, b) in run(channels, Path::OWN).iter().zip(&run(channels, Path::Stock)) {
            same(&format!("conv_tanh {channels:?}"), a, b);
        }
    }
}

#[test]
fn products_of_halves_are_near_and_ours_where_the_processor_has_none() {
    let length = |values: &[f32]| values.iter().map(|v| v * v).sum::<f32>().sqrt();
    for (x, outputs, dilation) in [([1, 16, 9, 50], 64, 1), ([2, 24, 8, 6], 40, 2)] {
        let [halves, whole] = [Path::Own(Halves::best()), Path::OWN].map(|path| norm_elu(x, outputs, dilation, path));
        assert_eq!(halves == whole, Halves::best().is_none());
        for (a, b) in halves.iter().zip(&whole) {
            let differences: Vec<f32> = a.iter().zip(b).map(|(a, b)| a - b).collect();
            assert!(length(&differences) < 0.01 * length(b), "{} of {}", length(&differences), length(b));
        }
    }
}

/// Result and the gradients of input, weights, γ and β of Σ result·probe, normalised by given statistics.
fn folded_elu<const D: usize>(x: [usize; D], outputs: usize, dilation: usize, path: Path) -> Vec<Vec<f32>> {
    let mut shape = [3; D];
    (shape[0], shape[1]) = (outputs, x[1]);
    let mut out = x;
    out[1] = outputs;
    let (x, weight) = (random(1, x).require_grad(), random(2, shape).require_grad());
    let [gamma, beta] = [random(3, [outputs]).require_grad(), random(4, [outputs]).require_grad()];
    let norm = [gamma.clone(), beta.clone(), random(5, [outputs]), random(6, [outputs]).abs() + 0.1];
    let y = conv_folded_elu(x.clone(), weight.clone(), norm, dilation, path);
    let gradients = (y.clone() * random(7, out)).sum().backward();
    let of = |t: &Tensor<D>| values(t.grad(&gradients).unwrap());
    let of_channels = |t: &Tensor<1>| values(t.grad(&gradients).unwrap());
    vec![values(y), of(&x), of(&weight), of_channels(&gamma), of_channels(&beta)]
}

fn check_folded_elu<const D: usize>(x: [usize; D], outputs: usize, dilation: usize) {
    let (ours, theirs) = (folded_elu(x, outputs, dilation, Path::OWN), folded_elu(x, outputs, dilation, Path::Stock));
    for (what, (a, b)) in ["y", "∂x", "∂w", "∂γ", "∂β"].into_iter().zip(ours.iter().zip(&theirs)) {
        same(&format!("{what} of {x:?} → {outputs} with kept statistics"), a, b);
    }
}

#[test]
fn a_convolution_normalised_by_kept_statistics_is_burns() {
    check_folded_elu([1, 4, 3, 10, 12], 8, 1);
    check_folded_elu([2, 24, 10, 12], 40, 2);
}

/// Result and the gradients of input, weights, γ and β of Σ result·probe, zero padded.
fn settled(x: [usize; 4], outputs: usize, how: Patch, path: Path) -> Vec<Vec<f32>> {
    let Form::Patch { side, stride, each } = how.form else { panic!("a patch") };
    let weight = [outputs, if each { 1 } else { x[1] }, side, side];
    let (input, weight) = (random(1, x).require_grad(), random(2, weight).require_grad());
    let [gamma, beta] = [(random(3, [outputs]) * 3.0).require_grad(), random(4, [outputs]).require_grad()];
    let norm = [gamma.clone(), beta.clone(), random(5, [outputs]), random(6, [outputs]).abs() + 0.1];
    let y = conv_settled(input.clone(), weight.clone(), norm, how, path);
    let gradients = (y.clone() * random(7, [x[0], outputs, x[2] / stride, x[3] / stride])).sum().backward();
    let of = |t: &Tensor<4>| values(t.grad(&gradients).unwrap());
    let of_channels = |t: &Tensor<1>| values(t.grad(&gradients).unwrap());
    vec![values(y), of(&input), of(&weight), of_channels(&gamma), of_channels(&beta)]
}

#[test]
fn convolutions_of_settled_normalisation_are_burns() {
    let patch = |side, stride, each| Form::Patch { side, stride, each };
    let all = [
        ([2, 5, 12, 16], 8, patch(3, 2, false), 1),
        ([2, 12, 7, 9], 20, patch(1, 1, false), 1),
        ([3, 40, 5, 4], 24, patch(1, 1, false), 1),
        ([2, 6, 12, 40], 6, patch(3, 1, true), 1),
        ([2, 6, 12, 16], 6, patch(3, 2, true), 1),
        ([2, 6, 8, 20], 6, patch(5, 2, true), 1),
        ([2, 10, 9, 7], 10, patch(5, 1, true), 2),
        ([1, 4, 3, 2], 4, patch(3, 1, true), 2),
    ];
    for ((x, outputs, form, dilation), clamped) in all.into_iter().flat_map(|case| [(case, true), (case, false)]) {
        let how = Patch { form, dilation, clamped };
        let (ours, theirs) = (settled(x, outputs, how, Path::OWN), settled(x, outputs, how, Path::Stock));
        for (what, (a, b)) in ["y", "∂x", "∂w", "∂γ", "∂β"].into_iter().zip(ours.iter().zip(&theirs)) {
            same(&format!("{what} of {x:?} → {outputs}, {how:?}"), a, b);
        }
    }
}

#[test]
fn pooling_and_joining_are_burns() {
    let run = |path| {
        let (low, skip) = (random(1, [2, 3, 4, 5]).require_grad(), random(2, [2, 2, 8, 10]).require_grad());
        let joined = up_concat(low.clone(), skip.clone(), path);
        let pooled = pool(joined.clone(), path);
        let gradients = ((joined.clone() * random(3, [2, 5, 8, 10])).sum()
            + (pooled.clone() * random(4, [2, 5, 4, 5])).sum())
        .backward();
        [values(joined), values(pooled), values(low.grad(&gradients).unwrap()), values(skip.grad(&gradients).unwrap())]
    };
    for (a, b) in run(Path::OWN).iter().zip(&run(Path::Stock)) {
        same("pool and up_concat", a, b);
    }
}
