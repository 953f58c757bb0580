//! Products of halves against the direct convolution of numbers that are halves already.

use super::*;
use crate::kernel::shape::Padding;
use crate::kernel::{Conv, numbers};

/// Numbers with no more than 8 bits: rounding leaves them as they are.
fn halves(seed: u64, n: usize) -> Vec<f32> {
    numbers(seed, n).iter().map(|value| (value * 64.0).round() / 64.0).collect()
}

fn means() -> impl Iterator<Item = Halves> {
    [Some(Halves::portable()), Halves::best()].into_iter().flatten()
}

fn shapes() -> Vec<ConvShape> {
    let sizes = [[1, 1, 1], [2, 3, 2], [1, 17, 53], [3, 12, 9], [1, 40, 66]];
    let channels = [[16, 16], [17, 33], [48, 80], [80, 16], [112, 40]];
    let kernel = Kernel::Plane;
    let of = |(i, [batch, height, width]): (usize, [usize; 3])| {
        [Padding::Edge, Padding::Zero].map(|padding| {
            let [channels_in, channels_out] = channels[i];
            let dilation = 1 + i % 3;
            ConvShape { batch, channels_in, channels_out, views: 1, height, width, kernel, dilation, padding }
        })
    };
    sizes.into_iter().enumerate().flat_map(of).collect()
}

fn assert_near(got: &[f32], want: &[f32], what: &str) {
    assert_eq!(got.len(), want.len(), "{what}");
    let largest = want.iter().fold(1.0_f32, |most, value| most.max(value.abs()));
    for (i, (a, b)) in got.iter().zip(want).enumerate() {
        assert!((a - b).abs() <= 2e-5 * largest, "{what}: value {i} is {a}, not {b}");
    }
}

#[test]
fn a_step_in_halves_is_the_direct_one_where_nothing_is_rounded() {
    for shape in shapes() {
        let (x, weights) = (halves(1, shape.input_len()), halves(2, shape.weights_len()));
        let gz = halves(3, shape.output_len());
        let direct = Conv::new(shape, Isa::best());
        let (z, sums) = direct.forward_with_sums(&direct.pad_input(&x), &direct.pack(&weights));
        let padded = direct.pad_gradient(&gz);
        let to_weights = direct.weight_gradient(&direct.pad_input(&x), &padded);
        let to_x = direct.data_gradient(&padded, &weights);
        for means in means() {
            let what = format!("{means:?} {shape:?}");
            let conv = direct.in_halves(Some(means));
            let (got, got_sums) = conv.step(&x, &weights);
            assert_near(&got, &z, &what);
            let flat = |sums: &Sums| sums.iter().flatten().map(|sum| *sum as f32).collect::<Vec<_>>();
            assert_near(&flat(&got_sums), &flat(&sums), &what);
            let pieces = |piece: &mut [f32], at: usize| piece.copy_from_slice(&gz[at..][..piece.len()]);
            let gradients = conv.step_gradients(&x, &weights, pieces, true);
            assert_near(&gradients.weights, &to_weights, &what);
            assert_near(&gradients.x.unwrap(), &to_x, &what);
            let weights_alone = conv.step_gradients(&x, &weights, pieces, false);
            assert_eq!((weights_alone.weights, weights_alone.x), (gradients.weights, None), "{what}");
        }
    }
}

#[test]
fn numbers_are_rounded_to_the_nearest_half() {
    let mut halves = [0; 5];
    planes::halve(&[1.0, 1.003_906_3, 1.011_718_8, -2.0, f32::NAN], &mut halves);
    let [one, even_below, even_above, minus_two, nan] = halves.map(|half| f32::from_bits(u32::from(half) << 16));
    assert_eq!([one, even_below, even_above, minus_two], [1.0, 1.0, 1.015_625, -2.0]);
    assert!(nan.is_nan(), "what is no number stays none");
}

#[test]
fn few_channels_and_volumes_are_left_to_f32() {
    let shape = shapes()[0];
    assert!(HalfBatch::pays(&shape));
    assert!(!HalfBatch::pays(&ConvShape { channels_in: 5, ..shape }));
    assert!(!HalfBatch::pays(&ConvShape { kernel: Kernel::Volume, ..shape }));
}
