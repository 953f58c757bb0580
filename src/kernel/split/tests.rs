//! Halves against the numbers that they are of, and layers in 8 bits against the direct convolution.

use std::mem::MaybeUninit;

use super::picture::halves_of;
use super::{Store, Weights};
use crate::kernel::winograd::{self, PlaneChain};
use crate::kernel::{Activation, Conv, ConvShape, Halves, Isa, Kernel, Padding, numbers};

#[test]
fn two_halves_keep_sixteen_bits_of_a_number() {
    for x in numbers(3, 1000) {
        let [high, low] = halves_of(x).map(|half| f32::from_bits(u32::from(half) << 16));
        assert!((high + low - x).abs() <= x.abs() / 65_536.0, "{x}: {high} and {low}");
    }
}

/// Weights as those of a net in 8 bits: whole numbers of steps, the largest 127 of them; each result has a step of its own.
fn of_8_bits(channels: [usize; 2]) -> Vec<f32> {
    let row = channels[0] * 9;
    let mut weights = numbers(5, row * channels[1]);
    for (result, row) in weights.chunks_exact_mut(row).enumerate() {
        let step = 0.001 / (1.0 + result as f32);
        row[result % 9] = -1.0;
        row.iter_mut().for_each(|weight| *weight = (*weight * 127.0).round() * step);
    }
    weights
}

#[test]
fn only_weights_of_8_bits_have_no_low_halves() {
    let channels = [48, 32];
    let parts = |weights: &[f32]| Weights::new(&mut Store::new(), weights, channels).parts;
    let mut weights = of_8_bits(channels);
    assert_eq!(parts(&weights), 1);
    weights[777] += weights[777].abs().max(1e-6) * 0.003;
    assert_eq!(parts(&weights), 2, "one weight between two steps");
    assert_eq!(parts(&numbers(6, 48 * 32 * 9)), 2);
    assert_eq!(parts(&vec![0.0; 48 * 32 * 9]), 1, "a result of nothing");
}

#[test]
fn layers_of_8_bits_agree_with_the_direct_convolution() {
    for (channels @ [channels_in, channels_out], [height, width]) in [([16, 48], [9, 33]), ([80, 16], [40, 7])] {
        let (weights, bias) = (of_8_bits(channels), numbers(8, channels_out));
        let x = numbers(7, channels_in * height * width);
        let (dilation, padding, activation) = (2, Padding::Edge, Activation::Elu);
        let (kernel, is_residual) = (Kernel::Plane, false);
        let shape =
            ConvShape { batch: 1, channels_in, channels_out, views: 1, height, width, kernel, dilation, padding };
        let conv = Conv::new(shape, Isa::best());
        let want = conv.forward(&conv.pad_input(&x), &conv.pack(&weights), Some(&bias), activation, None).unwrap();
        let layer =
            winograd::Layer { weights: &weights, bias: &bias, channels, dilation, padding, activation, is_residual };
        for halves in [Some(Halves::portable()), Halves::best()].into_iter().flatten() {
            let mut out = vec![MaybeUninit::new(f32::NAN); want.len()];
            PlaneChain::new(&[layer], Isa::best(), Some(halves)).run(&x, [height, width], &mut out, None).unwrap();
            for (i, (got, want)) in out.iter().zip(&want).enumerate() {
                // SAFETY: it was initialised above.
                let got = unsafe { got.assume_init() };
                assert!((got - want).abs() <= 1e-5, "{halves:?} {channels:?}: value {i} is {got}, not {want}");
            }
        }
    }
}
