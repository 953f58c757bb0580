//! Every code path against sums written out plainly, on awkward shapes.

use std::sync::atomic::AtomicBool;

use super::winograd::batch::{PlaneBatch, VolumeBatch};
use super::*;
use crate::job::Cancelled;

/// A repeatable stream of numbers in −1 … 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    }

    fn take(&mut self, n: usize) -> Vec<f32> {
        (0..n).map(|_| self.next()).collect()
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.next() + 1.0) * 0.5 * n as f32) as usize % n
    }
}

/// Calls `f` for every product of the convolution with the indices of (result, input, weight); the input is left out
/// where zero padding stands.
fn products(s: &ConvShape, mut f: impl FnMut(usize, usize, usize)) {
    let [kv, kh, kw] = s.kernel.extent();
    let edge = s.padding == Padding::Edge;
    let place = |at: usize, tap: usize, taps: usize, step: usize, size: usize| -> Option<usize> {
        let at = at as isize + (tap as isize - taps as isize / 2) * step as isize;
        let inside = at.clamp(0, size as isize - 1);
        (edge || inside == at).then_some(inside as usize)
    };
    let index = |n: usize, c: usize, channels: usize, v: usize, y: usize, x: usize| {
        (((n * channels + c) * s.views + v) * s.height + y) * s.width + x
    };
    for n in 0..s.batch {
        for (v, y, x) in pixels(s) {
            for (a, b, c) in (0..kv).flat_map(|a| (0..kh).flat_map(move |b| (0..kw).map(move |c| (a, b, c)))) {
                let from = place(v, a, kv, 1, s.views)
                    .zip(place(y, b, kh, s.dilation, s.height))
                    .zip(place(x, c, kw, s.dilation, s.width));
                let Some(((v0, y0), x0)) = from else { continue };
                for o in 0..s.channels_out {
                    for i in 0..s.channels_in {
                        let weight = ((o * s.channels_in + i) * kv + a) * kh * kw + b * kw + c;
                        f(index(n, o, s.channels_out, v, y, x), index(n, i, s.channels_in, v0, y0, x0), weight);
                    }
                }
            }
        }
    }
}

fn pixels(s: &ConvShape) -> impl Iterator<Item = (usize, usize, usize)> + use<> {
    let s = *s;
    (0..s.plane()).map(move |i| (i / s.width / s.height, i / s.width % s.height, i % s.width))
}

fn forward_plainly(s: &ConvShape, x: &[f32], w: &[f32], bias: &[f32]) -> Vec<f32> {
    let mut y: Vec<f64> = (0..s.output_len()).map(|i| f64::from(bias[i / s.plane() % s.channels_out])).collect();
    products(s, |o, i, k| y[o] += f64::from(x[i]) * f64::from(w[k]));
    y.into_iter().map(|y| y as f32).collect()
}

fn gradients_plainly(s: &ConvShape, x: &[f32], w: &[f32], gy: &[f32]) -> (Vec<f32>, Vec<f32>) {
    let (mut gx, mut gw) = (vec![0.0; x.len()], vec![0.0; w.len()]);
    products(s, |o, i, k| {
        gx[i] += f64::from(gy[o]) * f64::from(w[k]);
        gw[k] += f64::from(gy[o]) * f64::from(x[i]);
    });
    let narrow = |v: Vec<f64>| v.into_iter().map(|v| v as f32).collect();
    (narrow(gx), narrow(gw))
}

/// Shapes with odd sizes, 1×1 pictures, dilations larger than the picture, channels that fill no block.
fn shapes() -> Vec<ConvShape> {
    let shape = |batch, [i, o]: [usize; 2], [views, height, width]: [usize; 3], kernel, dilation| ConvShape {
        batch,
        channels_in: i,
        channels_out: o,
        views,
        height,
        width,
        kernel,
        dilation,
        padding: Padding::Edge,
    };
    let mut shapes = vec![
        shape(1, [1, 1], [1, 1, 1], Kernel::Plane, 1),
        shape(1, [3, 5], [1, 1, 1], Kernel::Plane, 16),
        shape(1, [2, 9], [1, 3, 4], Kernel::Plane, 7),
        shape(2, [5, 24], [1, 7, 53], Kernel::Plane, 1),
        shape(1, [8, 17], [1, 12, 16], Kernel::Plane, 2),
        shape(1, [8, 3], [6, 5, 101], Kernel::Volume, 1),
        shape(2, [4, 8], [3, 9, 20], Kernel::Volume, 1),
        shape(1, [3, 8], [1, 2, 5], Kernel::Volume, 2),
        shape(1, [3, 4], [2, 4, 33], Kernel::Point, 1),
        shape(2, [2, 3], [4, 3, 7], Kernel::Plane, 3),
        // Short rows of many channels, which are shared out.
        shape(2, [3, 333], [1, 7, 8], Kernel::Plane, 2),
    ];
    let mut numbers = Numbers(11);
    for _ in 0..12 {
        let channels = [1 + numbers.below(12), 1 + numbers.below(20)];
        let size = [1 + numbers.below(3), 1 + numbers.below(11), 1 + numbers.below(70)];
        let kernel = [Kernel::Plane, Kernel::Volume, Kernel::Point][numbers.below(3)];
        shapes.push(shape(1 + numbers.below(2), channels, size, kernel, 1 + numbers.below(5)));
    }
    let zero = shapes.clone().into_iter().map(|shape| ConvShape { padding: Padding::Zero, ..shape });
    shapes.extend(zero);
    shapes
}

/// |a − b| ≤ 1e-5 · (1 + the largest |b|).
fn assert_close(a: &[f32], b: &[f32], what: &str) {
    assert_within(1.0, a, b, what);
}

/// |a − b| ≤ 1e-5 · `times` · (1 + the largest |b|).
fn assert_within(times: f32, a: &[f32], b: &[f32], what: &str) {
    assert_eq!(a.len(), b.len(), "{what}: length");
    let largest = b.iter().fold(0.0, |m: f32, b| m.max(b.abs()));
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        assert!((a - b).abs() <= 1e-5 * times * (1.0 + largest), "{what}: value {i} is {a}, not {b}");
    }
}

#[test]
fn forward_agrees_with_plain_sums() {
    for (seed, shape) in shapes().into_iter().enumerate() {
        let mut numbers = Numbers(seed as u64);
        let (x, w) = (numbers.take(shape.input_len()), numbers.take(shape.weights_len()));
        let bias = numbers.take(shape.channels_out);
        let plain = forward_plainly(&shape, &x, &w, &bias);
        for isa in Isa::all() {
            let conv = Conv::new(shape, isa);
            let (x, w) = (conv.pad_input(&x), conv.pack(&w));
            let y = conv.forward(&x, &w, Some(&bias), Activation::None, None).unwrap();
            assert_close(&y, &plain, &format!("{isa} {shape:?}"));
        }
    }
}

#[test]
fn activations_are_those_of_the_standard_library() {
    let shape = shapes()[3];
    let mut numbers = Numbers(5);
    let (x, w) = (numbers.take(shape.input_len()), numbers.take(shape.weights_len()));
    let plain = forward_plainly(&shape, &x, &w, &vec![0.0; shape.channels_out]);
    let elu: Vec<f32> = plain.iter().map(|&z| if z > 0.0 { z } else { z.exp_m1() }).collect();
    let tanh: Vec<f32> = plain.iter().map(|&z| 4.0 * z.tanh()).collect();
    for isa in Isa::all() {
        let conv = Conv::new(shape, isa);
        let (x, w) = (conv.pad_input(&x), conv.pack(&w));
        let forward = |activation| conv.forward(&x, &w, None, activation, None).unwrap();
        assert_close(&forward(Activation::Elu), &elu, "elu");
        assert_close(&forward(Activation::Tanh { scale: 4.0 }), &tanh, "tanh");
        let mut in_place = plain.clone();
        norm::activate(isa, &mut in_place, Activation::Elu);
        assert_close(&in_place, &elu, "elu in place");
    }
}

#[test]
fn not_a_number_stays_not_a_number() {
    for isa in Isa::all() {
        for activation in [Activation::None, Activation::Elu, Activation::Tanh { scale: 1.0 }] {
            let mut values = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
            norm::activate(isa, &mut values, activation);
            assert!(values[0].is_nan(), "{isa} {activation:?}");
            assert!(values[1] > 0.99 && values[2] < -0.99, "{isa} {activation:?} {values:?}");
        }
    }
}

#[test]
fn gradients_agree_with_plain_sums() {
    for (seed, shape) in shapes().into_iter().enumerate() {
        let mut numbers = Numbers(100 + seed as u64);
        let (x, w) = (numbers.take(shape.input_len()), numbers.take(shape.weights_len()));
        let gy = numbers.take(shape.output_len());
        let (gx, gw) = gradients_plainly(&shape, &x, &w, &gy);
        for isa in Isa::all() {
            let conv = Conv::new(shape, isa);
            let (x, gy) = (conv.pad_input(&x), conv.pad_gradient(&gy));
            assert_close(&conv.data_gradient(&gy, &w), &gx, &format!("data gradient {isa} {shape:?}"));
            assert_close(&conv.weight_gradient(&x, &gy), &gw, &format!("weight gradient {isa} {shape:?}"));
        }
    }
}

/// Mean, normalise, ELU, written plainly in f64: (y, sum of y·gy).
fn norm_plainly(z: &[f32], plane: usize, gamma: &[f32], beta: &[f32], gy: &[f32]) -> (Vec<f32>, f64) {
    let channels = gamma.len();
    let of = |c: usize| z.iter().enumerate().filter(move |(i, _)| i / plane % channels == c);
    let mut y = vec![0.0; z.len()];
    let mut loss = 0.0;
    for c in 0..channels {
        let count = of(c).count() as f64;
        let mean = of(c).map(|(_, z)| f64::from(*z)).sum::<f64>() / count;
        let variance = of(c).map(|(_, z)| (f64::from(*z) - mean).powi(2)).sum::<f64>() / count;
        for (i, z) in of(c) {
            let x = (f64::from(*z) - mean) / (variance + 1e-5).sqrt() * f64::from(gamma[c]) + f64::from(beta[c]);
            let value = if x > 0.0 { x } else { x.exp_m1() };
            y[i] = value as f32;
            loss += value * f64::from(gy[i]);
        }
    }
    (y, loss)
}

#[test]
fn normalisation_agrees_with_its_formula_and_with_finite_differences() {
    let (n, channels, [v, h, w]) = (2, 3, [2, 3, 19]);
    let plane = v * h * w;
    let mut numbers = Numbers(3);
    let (z, gy) = (numbers.take(n * channels * plane), numbers.take(n * channels * plane));
    let (gamma, beta) = ([0.5, 1.5, -1.0], [0.1, -0.3, 0.2]);
    let (y, _) = norm_plainly(&z, plane, &gamma, &beta, &gy);
    let difference = |z: &[f32], gamma: &[f32], beta: &[f32]| norm_plainly(z, plane, gamma, beta, &gy).1;
    for isa in Isa::all() {
        let sums = norm::sums(isa, &z, channels, plane);
        let norm = norm::Norm::from_sums(&sums, n * plane, &gamma, &beta, 1e-5);
        assert_close(&norm::elu(isa, &z, plane, &norm.scale, &norm.shift), &y, "forward");
        let sums = norm::elu_gradient_sums(isa, &z, &gy, plane, &norm.scale, &norm.shift);
        let (ggamma, gbeta, k) = norm.backward(&sums, n * plane);
        let mut gz = vec![0.0; z.len()];
        for (row, gz) in gz.chunks_mut(w).enumerate() {
            let at = row * w..(row + 1) * w;
            norm::elu_gradient_row(isa, &z[at.clone()], &gy[at], gz, k[row * w / plane % channels]);
        }
        let step = 1.0 / 1024.0;
        let slope = |i: usize, of: &dyn Fn(&[f32; 3], &[f32; 3]) -> f64, gamma: bool| {
            let moved = |by: f32| {
                let (mut g, mut b) = (gamma_of(gamma), beta_of(gamma));
                if gamma {
                    g[i] += by
                } else {
                    b[i] += by
                }
                of(&g, &b)
            };
            ((moved(step) - moved(-step)) / (2.0 * f64::from(step))) as f32
        };
        fn gamma_of(_: bool) -> [f32; 3] {
            [0.5, 1.5, -1.0]
        }
        fn beta_of(_: bool) -> [f32; 3] {
            [0.1, -0.3, 0.2]
        }
        for c in 0..channels {
            let of = |g: &[f32; 3], b: &[f32; 3]| difference(&z, g, b);
            assert!((slope(c, &of, true) - ggamma[c]).abs() < 1e-3 * (1.0 + ggamma[c].abs()), "{isa} gamma {c}");
            assert!((slope(c, &of, false) - gbeta[c]).abs() < 1e-3 * (1.0 + gbeta[c].abs()), "{isa} beta {c}");
        }
        for i in [0, 40, plane + 7, z.len() - 1] {
            let moved = |by: f32| {
                let mut z = z.clone();
                z[i] += by;
                difference(&z, &gamma, &beta)
            };
            let slope = ((moved(step) - moved(-step)) / (2.0 * f64::from(step))) as f32;
            assert!((slope - gz[i]).abs() < 1e-3 * (1.0 + slope.abs()), "{isa} z {i}: {slope} {}", gz[i]);
        }
    }
}

#[test]
fn sums_for_normalisation_come_with_the_forward_pass() {
    let shape = shapes()[6];
    let mut numbers = Numbers(8);
    let (x, w) = (numbers.take(shape.input_len()), numbers.take(shape.weights_len()));
    for isa in Isa::all() {
        let conv = Conv::new(shape, isa);
        let (y, sums) = conv.forward_with_sums(&conv.pad_input(&x), &conv.pack(&w));
        let plain = norm::sums(isa, &y, shape.channels_out, shape.plane());
        for (a, b) in sums.iter().zip(plain) {
            assert!((a[0] - b[0]).abs() < 1e-3 && (a[1] - b[1]).abs() < 1e-3 * b[1], "{isa}");
        }
    }
}

#[test]
fn a_set_flag_stops_the_forward_pass() {
    let shape = shapes()[3];
    let conv = Conv::new(shape, Isa::best());
    let x = conv.pad_input(&vec![0.0; shape.input_len()]);
    let w = conv.pack(&vec![0.0; shape.weights_len()]);
    let stop = AtomicBool::new(true);
    assert_eq!(conv.forward(&x, &w, None, Activation::None, Some(&stop)), Err(Cancelled));
}

/// Light fields of few and of odd numbers of views, in one round and in several.
fn volumes() -> impl Iterator<Item = ConvShape> {
    let of = |(views, padding)| ConvShape {
        batch: 2,
        channels_in: 8,
        channels_out: 3 + views % 6,
        views,
        height: if views > 9 { 40 } else { 5 },
        width: if views > 9 { 41 } else { 6 },
        kernel: Kernel::Volume,
        dilation: 1,
        padding,
    };
    (1..8).chain([31]).flat_map(|views| [(views, Padding::Edge), (views, Padding::Zero)]).map(of)
}

/// Winograd's algorithm adds up larger numbers than the sums it makes.
#[test]
fn a_step_agrees_with_plain_sums() {
    for (seed, shape) in shapes()
        .into_iter()
        .chain(volumes())
        .filter(|shape| shape.kernel == Kernel::Plane || VolumeBatch::can(shape))
        .enumerate()
    {
        let mut numbers = Numbers(200 + seed as u64);
        let (x, w) = (numbers.take(shape.input_len()), numbers.take(shape.weights_len()));
        let gy = numbers.take(shape.output_len());
        let plain = forward_plainly(&shape, &x, &w, &vec![0.0; shape.channels_out]);
        let (gx, gw) = gradients_plainly(&shape, &x, &w, &gy);
        let gradient = |values: &mut [f32], at: usize| values.copy_from_slice(&gy[at..][..values.len()]);
        for isa in Isa::all() {
            let ((y, sums), (weights, to_x)) = if shape.kernel == Kernel::Plane {
                let batch = PlaneBatch::new(&shape, isa);
                (batch.forward(&x, &w), batch.gradients(&x, &gradient, &w, true))
            } else {
                let batch = VolumeBatch::new(&shape, isa);
                (batch.forward(&x, &w), batch.gradients(&x, &gradient, &w, true))
            };
            assert_close(&y, &plain, &format!("{isa} {shape:?}"));
            for (a, b) in sums.iter().zip(norm::sums(isa, &y, shape.channels_out, shape.plane())) {
                assert!((a[0] - b[0]).abs() < 1e-4 * (1.0 + b[1]) && (a[1] - b[1]).abs() <= 1e-4 * b[1], "{isa}");
            }
            assert_within(5.0, &weights, &gw, &format!("weight gradient {isa} {shape:?}"));
            assert_close(&to_x.unwrap(), &gx, &format!("data gradient {isa} {shape:?}"));
        }
    }
}
