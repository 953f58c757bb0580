//! The kernel with memory that ends where it must: sizes that fill no register, on every set of instructions.
//!
//! `PLENOSCOPE_NETS` names a folder of exported nets (`cargo xtask test --all` makes one) that are run here too, without
//! ONNX Runtime in the process.
#![allow(clippy::unwrap_used, reason = "in a test a panic is the failure")]
#![allow(clippy::explicit_write, reason = "the test harness keeps what eprintln! says to itself")]
#![allow(unsafe_code, reason = "results are written into memory that nobody has written yet")]

#[path = "common/foreign.rs"]
mod foreign;
#[path = "common/guard.rs"]
mod guard;

use std::io::Write as _;
use std::mem::MaybeUninit;

use plenoscope::job::{Cancel, Cancelled};
use plenoscope::kernel::product::{
    Attention, Columns, Dense, DepthWise, Head, Inverted, MOST_BIASES, Panels, Patches, Project, Sides,
};
use plenoscope::kernel::resize::{Taps, resize};
use plenoscope::kernel::winograd::{Layer, PlaneChain};
use plenoscope::kernel::{Activation, Conv, ConvShape, Ending, Halves, Isa, Kernel, Limits, Padding, token};

#[global_allocator]
static GUARDED: guard::Guarded = guard::Guarded;

/// Repeatable numbers in −1 … 1.
fn numbers(seed: u32, n: usize) -> Vec<f32> {
    (0..n as u32)
        .map(|i| ((i + 97 * seed).wrapping_mul(2_654_435_769) >> 8) as f32 / (1u32 << 23) as f32 - 1.0)
        .collect()
}

/// What `write` writes into memory of exactly `len` values.
fn written(len: usize, write: impl FnOnce(&mut [MaybeUninit<f32>]) -> Result<(), Cancelled>) -> Vec<f32> {
    let mut out = Vec::with_capacity(len);
    write(&mut out.spare_capacity_mut()[..len]).unwrap();
    // SAFETY: the kernel writes every value; one that it left out would be NaN.
    unsafe { out.set_len(len) };
    out
}

/// All sets of instructions answer the same.
fn alike(what: &str, answer: impl Fn(Isa) -> Vec<f32>) {
    let want = answer(Isa::portable());
    for isa in Isa::all() {
        for (at, (got, want)) in answer(isa).iter().zip(&want).enumerate() {
            assert!((got - want).abs() <= 1e-4 * (1.0 + want.abs()), "{what}, {isa}, value {at}: {got}, not {want}");
        }
    }
}

#[test]
fn products_stay_inside_their_memory() {
    for (rows, depth, columns) in [(1, 1, 1), (2, 7, 15), (5, 33, 17), (13, 330, 33), (37, 48, 47), (3, 5, 64)] {
        let (x, w, bias) = (numbers(1, rows * depth), numbers(2, depth * columns), numbers(3, columns));
        let summand = numbers(4, rows * columns);
        alike(&format!("{rows}×{depth}×{columns}"), |isa| {
            let weights = Panels::of(isa, [depth, columns], |k, column| w[k * columns + column]);
            let dense =
                Dense { isa, weights: &weights, bias: &bias, activation: Activation::Gelu, limits: Limits::NONE };
            written(rows * columns, |out| dense.run(&x, Some(&summand), out, None))
        });
        let bias = numbers(3, rows);
        for pixels_first in [false, true] {
            alike(&format!("planes {rows}×{depth}×{columns}"), |isa| {
                let project =
                    Project { isa, weights: &x, bias: &bias, activation: Activation::None, limits: Limits::NONE };
                let columns_of = if pixels_first { Columns::PixelsFirst(&w) } else { Columns::Planes(&w) };
                written(rows * columns, |out| project.run(columns_of, Some(&summand), out, None))
            });
        }
    }
}

#[test]
fn convolutions_by_products_stay_inside_their_memory() {
    for (channels, size, kernel, stride, dilation) in [
        (3, [9, 7], [3, 3], [2, 2], [1, 1]),
        (5, [17, 33], [5, 5], [1, 1], [1, 1]),
        (4, [14, 28], [7, 7], [7, 7], [1, 1]),
        (7, [5, 1], [3, 3], [1, 1], [1, 1]),
        (2, [12, 15], [3, 3], [1, 2], [2, 3]),
    ] {
        let before = [0, 1].map(|axis| (kernel[axis] - 1) * dilation[axis] / 2);
        let output = [0, 1].map(|axis| {
            let reach = (kernel[axis] - 1) * dilation[axis];
            (size[axis] + 2 * before[axis] - reach - 1) / stride[axis] + 1
        });
        let patches = Patches { channels, size, kernel, stride, dilation, before, output };
        let x = numbers(1, patches.input_len());
        for channels_out in [1, 11, 25] {
            let (w, bias) = (numbers(2, channels_out * patches.depth()), numbers(3, channels_out));
            alike(&format!("{patches:?}"), |isa| {
                let project =
                    Project { isa, weights: &w, bias: &bias, activation: Activation::None, limits: Limits::NONE };
                let columns = Columns::Patches(&x, &patches);
                written(channels_out * patches.pixels(), |out| project.run(columns, None, out, None))
            });
        }
        let (w, bias) = (numbers(2, patches.depth()), numbers(3, channels));
        alike(&format!("each channel by itself, {patches:?}"), |isa| {
            let activation = Activation::Clamp { low: 0.0, high: 6.0 };
            let each = DepthWise { isa, patches: &patches, weights: &w, bias: &bias, activation };
            written(channels * patches.pixels(), |out| each.run(&x, out, None))
        });
        let plane = size[0] * size[1];
        let (narrow, wide, planes) = (numbers(4, 11 * channels), numbers(5, 2 * channels), numbers(6, 2 * plane));
        let (summand, ends) = (numbers(7, 11 * patches.pixels()), numbers(8, 11));
        alike(&format!("a block, {patches:?}"), |isa| {
            let activation = Activation::Clamp { low: 0.0, high: 6.0 };
            let depthwise = DepthWise { isa, patches: &patches, weights: &w, bias: &bias, activation };
            let product = |weights, bias| Project { isa, weights, bias, activation, limits: Limits::NONE };
            let block = Inverted { widen: Some(product(&wide, &bias)), depthwise, narrow: product(&narrow, &ends) };
            written(summand.len(), |out| block.run(&planes, Some(&summand), out, None))
        });
    }
}

#[test]
fn attention_stays_inside_its_memory() {
    for (heads, queries, keys, depth, values) in
        [(1, 1, 1, 1, 1), (3, 36, 36, 16, 16), (2, 13, 50, 4, 7), (4, 97, 17, 33, 40)]
    {
        let lens = [queries * depth, keys * depth, keys * values, queries * values, queries * keys];
        let sides = Sides {
            queries,
            keys,
            depth,
            values,
            query_steps: [depth, 1],
            key_steps: [depth, 1],
            value_steps: [values, 1],
            out_steps: [values, 1],
            bias_steps: [[keys, 1]; MOST_BIASES],
        };
        let head = |head: usize| {
            let starts = std::array::from_fn(|i| head * lens[i]);
            Head { starts, biases: [head * lens[4]; MOST_BIASES], scale: 0.3 }
        };
        let attention = Attention { heads: (0..heads).map(head).collect(), sides };
        let [q, k, v, _, bias] = [0, 1, 2, 3, 4].map(|i| numbers(i as u32, heads * lens[i]));
        alike(&format!("{sides:?}"), |isa| {
            written(heads * lens[3], |out| attention.run(isa, [&q, &k, &v], &[&bias[..]; MOST_BIASES], out, None))
        });
    }
}

#[test]
fn rows_and_planes_stay_inside_their_memory() {
    for len in [1, 15, 16, 17, 48, 390] {
        let (x, scale, shift) = (numbers(1, 35 * len), numbers(2, len), numbers(3, len));
        alike(&format!("{len} values"), |isa| {
            written(35 * len, |out| token::layer_norm(isa, &x, 1e-3, [&scale, &shift], out, None))
        });
    }
    let taps = |from: usize, to: usize, window: usize| Taps {
        window,
        places: (0..to).flat_map(|i| (0..window).map(move |n| (i * from / to + n).min(from - 1))).collect(),
        weights: numbers(5, to * window),
    };
    for (size, out_size, window) in [([1, 1], [3, 5], 2), ([5, 7], [70, 98], 4), ([9, 33], [4, 17], 2)] {
        let x = numbers(1, 3 * size[0] * size[1]);
        let (down, across) = (taps(size[0], out_size[0], window), taps(size[1], out_size[1], window));
        alike(&format!("{size:?} to {out_size:?}"), |isa| {
            written(3 * out_size[0] * out_size[1], |out| resize(isa, &x, size, [&down, &across], out, None))
        });
    }
}

#[test]
fn direct_and_winograd_convolutions_stay_inside_their_memory() {
    for (channels, kernel, [views, height, width], dilation) in [
        ([1, 1], Kernel::Plane, [1, 1, 1], 1),
        ([3, 16], Kernel::Plane, [1, 9, 17], 1),
        ([5, 9], Kernel::Plane, [1, 7, 47], 2),
        ([8, 4], Kernel::Plane, [1, 5, 98], 4),
        ([4, 8], Kernel::Volume, [3, 6, 19], 1),
        ([7, 3], Kernel::Point, [1, 4, 33], 1),
    ] {
        let [channels_in, channels_out] = channels;
        let shape = ConvShape {
            batch: 1,
            channels_in,
            channels_out,
            views,
            height,
            width,
            kernel,
            dilation,
            padding: Padding::Zero,
        };
        let (x, w, bias) = (numbers(1, shape.input_len()), numbers(2, shape.weights_len()), numbers(3, channels_out));
        let (summand, limits) = (numbers(4, shape.output_len()), Limits { low: -0.5, high: 2.0 });
        alike(&format!("{shape:?}"), |isa| {
            let conv = Conv::new(shape, isa);
            let x = conv.pad_input_within(&x, limits);
            let ending = Ending { summand: Some(&summand), limits };
            let weights = conv.pack(&w);
            written(shape.output_len(), |out| {
                conv.forward_onto(&x, &weights, (&bias, Activation::Elu), ending, out, None)
            })
        });
    }
    for (channels, size, dilation) in [([32, 32], [35, 33], 1), ([16, 64], [33, 34], 2), ([64, 48], [5, 7], 1)] {
        let (x, w, bias) = (
            numbers(1, channels[0] * size[0] * size[1]),
            numbers(2, channels[0] * channels[1] * 9),
            numbers(3, channels[1]),
        );
        let layer = Layer {
            weights: &w,
            bias: &bias,
            channels,
            dilation,
            padding: Padding::Zero,
            activation: Activation::None,
            is_residual: channels[0] == channels[1],
        };
        for halves in [None, Some(Halves::portable()), Halves::best()] {
            alike(&format!("a chain, {halves:?} {channels:?} {size:?}"), |isa| {
                let chain = PlaneChain::new(&[layer], isa, halves);
                written(channels[1] * size[0] * size[1], |out| chain.run(&x, size, out, None))
            });
        }
    }
}

#[test]
fn nets_of_other_people_stay_inside_their_memory() {
    let Some(nets) = foreign::exported() else {
        writeln!(std::io::stderr(), "\nSKIPPED, no exported nets: `cargo xtask test --all` makes them\n").unwrap();
        return;
    };
    for net in nets {
        let answer = net.runnable().run(&net.picture(), &Cancel::default()).unwrap();
        assert!(answer.iter().all(|value| value.is_finite()), "{}", net.name());
    }
}
