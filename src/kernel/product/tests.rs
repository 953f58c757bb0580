//! Every code path against sums written out plainly, on awkward sizes.

use std::sync::atomic::AtomicBool;

use super::*;
use crate::job::Cancelled;
use crate::kernel::resize::{Taps, resize};
use crate::kernel::{Activation, Isa, Limits, norm, numbers, token};

/// |a − b| ≤ 1e-5 · (1 + the largest |b|).
fn assert_close(a: &[f32], b: &[f32], what: &str) {
    assert_eq!(a.len(), b.len(), "{what}: length");
    let largest = b.iter().fold(0.0, |m: f32, b| m.max(b.abs()));
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        assert!((a - b).abs() <= 1e-5 * (1.0 + largest), "{what}: value {i} is {a}, not {b}");
    }
}

/// What `run` writes into room for `len` values, on one thread and on two.
fn written(len: usize, run: impl Fn(&mut [std::mem::MaybeUninit<f32>]) -> Result<(), Cancelled> + Sync) -> Vec<f32> {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut out = vec![std::mem::MaybeUninit::new(f32::NAN); len];
        pool.install(|| run(&mut out)).unwrap();
        // SAFETY: every value was made above.
        out.iter().map(|value| unsafe { value.assume_init() }).collect::<Vec<_>>()
    };
    let one = on(1);
    assert_close(&on(2), &one, "two threads");
    one
}

/// `a` `[rows, depth]` times `b` `[depth, columns]`.
fn plainly(
    [rows, depth, columns]: [usize; 3],
    a: impl Fn(usize, usize) -> f32,
    b: impl Fn(usize, usize) -> f32,
) -> Vec<f32> {
    let sum = |row, column| (0..depth).map(|k| f64::from(a(row, k)) * f64::from(b(k, column))).sum::<f64>() as f32;
    (0..rows * columns).map(|i| sum(i / columns, i % columns)).collect()
}

const SIZES: [[usize; 3]; 6] = [[1, 1, 1], [5, 3, 33], [13, 7, 47], [37, 641, 15], [121, 64, 64], [2, 400, 100]];

#[test]
fn a_product_with_weights_agrees_with_plain_sums() {
    for (seed, [rows, depth, columns]) in SIZES.into_iter().enumerate() {
        let seed = seed as u64;
        let (x, w) = (numbers(seed, rows * depth), numbers(seed + 50, depth * columns));
        let (bias, more) = (numbers(seed + 90, columns), numbers(seed + 70, rows * columns));
        let sums = plainly([rows, depth, columns], |r, k| x[r * depth + k], |k, c| w[k * columns + c]);
        let want: Vec<f32> = sums.iter().enumerate().map(|(i, s)| (s + bias[i % columns]).max(0.0) + more[i]).collect();
        for isa in Isa::all() {
            let weights = Panels::of(isa, [depth, columns], |k, c| w[k * columns + c]);
            let activation = Activation::Clamp { low: 0.0, high: f32::INFINITY };
            let dense = Dense { isa, weights: &weights, bias: &bias, activation, limits: Limits::NONE };
            let got = written(rows * columns, |out| dense.run(&x, Some(&more), out, None));
            assert_close(&got, &want, &format!("{isa} {rows}×{depth}×{columns}"));
        }
    }
}

#[test]
fn a_product_with_planes_agrees_with_plain_sums() {
    for (seed, [channels, depth, pixels]) in SIZES.into_iter().enumerate() {
        let seed = seed as u64;
        let (x, w) = (numbers(seed, pixels * depth), numbers(seed + 50, depth * channels));
        let (bias, more) = (numbers(seed + 90, channels), numbers(seed + 70, channels * pixels));
        for pixels_first in [false, true] {
            let at = |k: usize, p: usize| if pixels_first { x[p * depth + k] } else { x[k * pixels + p] };
            let sums = plainly([channels, depth, pixels], |r, k| w[r * depth + k], at);
            let want: Vec<f32> = sums.iter().enumerate().map(|(i, s)| s + bias[i / pixels] + more[i]).collect();
            for isa in Isa::all() {
                let columns = if pixels_first { Columns::PixelsFirst(&x) } else { Columns::Planes(&x) };
                let project =
                    Project { isa, weights: &w, bias: &bias, activation: Activation::None, limits: Limits::NONE };
                let got = written(channels * pixels, |out| project.run(columns, Some(&more), out, None));
                assert_close(&got, &want, &format!("{isa} {channels}×{depth}×{pixels} {pixels_first}"));
            }
        }
    }
}

#[test]
fn patches_are_those_of_a_convolution() {
    let patches = |kernel: [usize; 2], stride: [usize; 2], dilation: [usize; 2], before: [usize; 2]| {
        let size = [9, 14];
        let output = [0, 1].map(|a| (size[a] + 2 * before[a] - dilation[a] * (kernel[a] - 1) - 1) / stride[a] + 1);
        Patches { channels: 3, size, kernel, stride, dilation, before, output }
    };
    for p in [
        patches([3, 3], [2, 2], [1, 1], [1, 1]),
        patches([4, 7], [4, 7], [1, 1], [0, 0]),
        patches([5, 1], [1, 3], [2, 1], [4, 0]),
    ] {
        let (x, w, bias) = (numbers(1, p.input_len()), numbers(2, 7 * p.depth()), numbers(3, 7));
        let at = |k: usize, pixel: usize| {
            let (channel, tap) = (k / (p.kernel[0] * p.kernel[1]), k % (p.kernel[0] * p.kernel[1]));
            let tap = [tap / p.kernel[1], tap % p.kernel[1]];
            let pixel = [pixel / p.output[1], pixel % p.output[1]];
            let place = [0, 1].map(|a| (pixel[a] * p.stride[a] + tap[a] * p.dilation[a]).wrapping_sub(p.before[a]));
            let inside = place[0] < p.size[0] && place[1] < p.size[1];
            if inside { x[(channel * p.size[0] + place[0]) * p.size[1] + place[1]] } else { 0.0 }
        };
        let sums = plainly([7, p.depth(), p.pixels()], |r, k| w[r * p.depth() + k], at);
        let want: Vec<f32> = sums.iter().enumerate().map(|(i, s)| s + bias[i / p.pixels()]).collect();
        for isa in Isa::all() {
            let project = Project { isa, weights: &w, bias: &bias, activation: Activation::None, limits: Limits::NONE };
            let got = written(want.len(), |out| project.run(Columns::Patches(&x, &p), None, out, None));
            assert_close(&got, &want, &format!("{isa} {p:?}"));
        }
    }
}

/// Heads beside each other in a token, as transformers have them, each with a factor of its own.
fn attention(heads: usize, [queries, keys, depth, values]: [usize; 4], bias_steps: [[usize; 2]; 3]) -> Attention {
    let sides = Sides {
        queries,
        keys,
        depth,
        values,
        query_steps: [heads * depth, 1],
        key_steps: [heads * depth, 1],
        value_steps: [heads * values, 1],
        out_steps: [heads * values, 1],
        bias_steps,
    };
    let head = |h: usize| Head {
        starts: [h * depth, h * depth, h * values, h * values],
        biases: bias_steps.map(|steps| if steps == [0, 0] { 0 } else { h }),
        scale: 0.7 + 0.2 * h as f32,
    };
    Attention { heads: (0..heads).map(head).collect(), sides }
}

fn attended_plainly(a: &Attention, [q, k, v]: [&[f32]; 3], biases: &[&[f32]], len: usize) -> Vec<f32> {
    let s = &a.sides;
    let mut out = vec![f32::NAN; len];
    for Head { starts, biases: from, scale } in &a.heads {
        for query in 0..s.queries {
            let score = |key: usize| {
                let at =
                    |d: usize| q[starts[0] + query * s.query_steps[0] + d] * k[starts[1] + key * s.key_steps[0] + d];
                let place = |i: usize| from[i] + query * s.bias_steps[i][0] + key * s.bias_steps[i][1];
                let bias: f64 = biases.iter().enumerate().map(|(i, bias)| f64::from(bias[place(i)])).sum();
                f64::from(*scale) * (0..s.depth).map(|d| f64::from(at(d))).sum::<f64>() + bias
            };
            let scores: Vec<f64> = (0..s.keys).map(score).collect();
            let most = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let weights: Vec<f64> = scores.iter().map(|score| (score - most).exp()).collect();
            let sum: f64 = weights.iter().sum();
            for column in 0..s.values {
                let value = |key: usize| f64::from(v[starts[2] + key * s.value_steps[0] + column]);
                let answer = (0..s.keys).map(|key| weights[key] * value(key)).sum::<f64>() / sum;
                out[starts[3] + query * s.out_steps[0] + column] = answer as f32;
            }
        }
    }
    out
}

#[test]
fn attention_agrees_with_its_formula() {
    for (heads, sides @ [queries, keys, depth, values]) in
        [(1, [1, 1, 1, 1]), (3, [37, 37, 8, 8]), (2, [100, 333, 16, 40]), (5, [13, 16, 3, 1])]
    {
        let (q, k, v) =
            (numbers(1, heads * queries * depth), numbers(2, heads * keys * depth), numbers(3, heads * keys * values));
        // One whose heads lie side by side, one for all queries, one with its keys in a row.
        let (beside, all, row) = ([keys * heads, heads], [0, 1], [keys, 1]);
        for steps in [vec![], vec![beside], vec![all], vec![row], vec![row, all, all], vec![beside, row, beside]] {
            let attention = attention(heads, sides, std::array::from_fn(|i| steps.get(i).copied().unwrap_or_default()));
            let biases: Vec<_> =
                (0..steps.len()).map(|i| numbers(4 + i as u64, (queries * keys + 1) * heads)).collect();
            let biases: Vec<&[f32]> = biases.iter().map(|bias| &bias[..]).collect();
            let len = heads * queries * values;
            let want = attended_plainly(&attention, [&q, &k, &v], &biases, len);
            for isa in Isa::all() {
                let got = written(len, |out| attention.run(isa, [&q, &k, &v], &biases, out, None));
                assert_close(&got, &want, &format!("{isa} {heads} {sides:?} {steps:?}"));
            }
        }
    }
}

#[test]
fn a_block_in_one_pass_is_its_three_operations() {
    // Strides, kernels, dilations, sizes of which no piece is whole; and values that are wide already.
    for (channels, size, kernel, stride, dilation, widens) in [
        ([5, 24, 7], [40, 33], 3, 1, 1, true),
        ([8, 17, 3], [64, 16], 5, 1, 1, true),
        ([3, 20, 30], [75, 50], 5, 2, 1, true),
        ([3, 9, 4], [31, 70], 3, 1, 2, false),
        ([4, 6, 5], [7, 9], 3, 2, 1, true),
    ] {
        let [channels_in, wide, channels_out] = channels;
        let reach = (kernel - 1) * dilation;
        let output = size.map(|len: usize| (len - 1) / stride + 1);
        let (kernel, stride, dilation) = ([kernel; 2], [stride; 2], [dilation; 2]);
        let patches = Patches { channels: wide, size, kernel, stride, dilation, before: [reach / 2; 2], output };
        let plane = size[0] * size[1];
        let channels_in = if widens { channels_in } else { wide };
        let x = numbers(1, channels_in * plane);
        let (w1, b1) = (numbers(2, wide * channels_in), numbers(3, wide));
        let (w2, b2) = (numbers(4, wide * kernel[0] * kernel[1]), numbers(5, wide));
        let (w3, b3) = (numbers(6, channels_out * wide), numbers(7, channels_out));
        let more = numbers(8, channels_out * patches.pixels());
        let (activation, limits) = (Activation::Clamp { low: 0.0, high: 6.0 }, Limits { low: -2.0, high: 2.0 });
        for isa in Isa::all() {
            let widen = Project { isa, weights: &w1, bias: &b1, activation, limits: Limits::NONE };
            let depthwise = DepthWise { isa, patches: &patches, weights: &w2, bias: &b2, activation };
            let narrow = Project { isa, weights: &w3, bias: &b3, activation: Activation::None, limits };
            let first = written(wide * plane, |out| widen.run(Columns::Planes(&x), None, out, None));
            let second =
                written(wide * patches.pixels(), |out| depthwise.run(if widens { &first } else { &x }, out, None));
            let want = written(more.len(), |out| narrow.run(Columns::Planes(&second), Some(&more), out, None));
            let block = Inverted { widen: widens.then_some(widen), depthwise, narrow };
            let got = written(more.len(), |out| block.run(&x, Some(&more), out, None));
            assert_close(&got, &want, &format!("{isa} {patches:?}"));
        }
    }
}

#[test]
fn tokens_are_normalised_by_their_own_mean_and_deviation() {
    for len in [1, 7, 16, 33, 384] {
        let (x, scale, shift) = (numbers(1, 35 * len), numbers(2, len), numbers(3, len));
        let of = |i: usize| {
            let row = &x[i / len * len..][..len];
            let mean = row.iter().map(|x| f64::from(*x)).sum::<f64>() / len as f64;
            let variance = row.iter().map(|x| (f64::from(*x) - mean).powi(2)).sum::<f64>() / len as f64;
            let unit = (f64::from(x[i]) - mean) / (variance + 1e-3).sqrt();
            (unit * f64::from(scale[i % len]) + f64::from(shift[i % len])) as f32
        };
        let want: Vec<f32> = (0..x.len()).map(of).collect();
        for isa in Isa::all() {
            let got = written(x.len(), |out| token::layer_norm(isa, &x, 1e-3, [&scale, &shift], out, None));
            assert_close(&got, &want, &format!("{isa} {len}"));
        }
    }
}

#[test]
fn gelu_is_that_of_the_error_function() {
    // erf by its series, which converges everywhere.
    let erf = |x: f64| {
        let terms = (0..200).scan(x, |term, n| {
            let now = *term / (2 * n + 1) as f64;
            *term *= -x * x / (n + 1) as f64;
            Some(now)
        });
        terms.sum::<f64>() * 2.0 / std::f64::consts::PI.sqrt()
    };
    let x: Vec<f32> = (-400..=400).map(|n| n as f32 / 100.0).collect();
    let gelu = |x: &f32| (0.5 * f64::from(*x) * (1.0 + erf(f64::from(*x) / std::f64::consts::SQRT_2))) as f32;
    let want: Vec<f32> = x.iter().map(gelu).collect();
    for isa in Isa::all() {
        let mut got = x.clone();
        norm::activate(isa, &mut got, Activation::Gelu);
        assert_close(&got, &want, &format!("{isa}"));
    }
}

#[test]
fn planes_are_resized_by_their_taps() {
    let taps = |places: Vec<usize>, window: usize| {
        let weights = numbers(places.len() as u64, places.len());
        Taps { window, places, weights }
    };
    let size @ [rows, columns] = [5, 17];
    let down = taps(vec![0, 0, 0, 1, 1, 2, 3, 4, 4, 4], 2);
    let across = taps((0..40).flat_map(|x: usize| (0..4).map(move |k| (x / 3 + k).min(16))).collect(), 4);
    let x = numbers(7, 3 * rows * columns);
    let at = |plane: usize, y: usize, column: usize| {
        let sum = |k: usize, l: usize| {
            let (row, place) = (down.places[y * 2 + k], across.places[column * 4 + l]);
            x[(plane * rows + row) * columns + place] * down.weights[y * 2 + k] * across.weights[column * 4 + l]
        };
        (0..2).flat_map(|k| (0..4).map(move |l| (k, l))).map(|(k, l)| sum(k, l)).sum::<f32>()
    };
    let want: Vec<f32> = (0..3)
        .flat_map(|p| (0..5).flat_map(move |y| (0..40).map(move |x| (p, y, x))))
        .map(|(p, y, x)| at(p, y, x))
        .collect();
    for isa in Isa::all() {
        let got = written(want.len(), |out| resize(isa, &x, size, [&down, &across], out, None));
        assert_close(&got, &want, &format!("{isa}"));
    }
}

#[test]
fn a_set_flag_stops_them_all() {
    let (stop, isa) = (AtomicBool::new(true), Isa::best());
    let mut out = vec![std::mem::MaybeUninit::new(0.0); 64];
    let weights = Panels::of(isa, [8, 8], |_, _| 0.0);
    let (x, bias, activation) = ([0.0; 64], [0.0; 8], Activation::None);
    let dense = Dense { isa, weights: &weights, bias: &bias, activation, limits: Limits::NONE };
    assert_eq!(dense.run(&x, None, &mut out, Some(&stop)), Err(Cancelled));
    let project = Project { isa, weights: &x, bias: &bias, activation, limits: Limits::NONE };
    assert_eq!(project.run(Columns::Planes(&x), None, &mut out, Some(&stop)), Err(Cancelled));
    let attention = attention(1, [8; 4], [[0, 0]; 3]);
    assert_eq!(attention.run(isa, [&x, &x, &x], &[], &mut out, Some(&stop)), Err(Cancelled));
    assert_eq!(token::layer_norm(isa, &x, 1.0, [&bias, &bias], &mut out, Some(&stop)), Err(Cancelled));
}
