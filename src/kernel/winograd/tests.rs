//! Chains against the direct convolution, layer by layer, on awkward shapes.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::*;
use crate::job::Cancelled;
use crate::kernel::{Conv, ConvShape, Ending, Halves, Isa, Kernel, Limits, numbers};

/// One layer's numbers.
struct Numbers {
    weights: Vec<f32>,
    bias: Vec<f32>,
    channels: [usize; 2],
    dilation: usize,
    activation: Activation,
    is_residual: bool,
}

/// Layers between some channels, the last a tanh, those of planes residual where they can be; weights keep the size of the numbers that go through them.
struct Net {
    kernel: Kernel,
    padding: Padding,
    layers: Vec<Numbers>,
}

impl Net {
    fn new(kernel: Kernel, padding: Padding, channels: &[usize], dilations: &[usize]) -> Self {
        let layer = |(i, c): (usize, &[usize])| {
            let (products, last) = (c[0] * kernel.taps(), i + 2 == channels.len());
            let scale = (3.0 / products as f32).sqrt();
            Numbers {
                weights: numbers(i as u64, products * c[1]).iter().map(|w| w * scale).collect(),
                bias: numbers(i as u64 + 50, c[1]),
                channels: [c[0], c[1]],
                dilation: dilations[i % dilations.len()],
                activation: if last { Activation::Tanh { scale: 1.0 } } else { Activation::Elu },
                is_residual: kernel == Kernel::Plane && c[0] == c[1],
            }
        };
        Self { kernel, padding, layers: channels.windows(2).enumerate().map(layer).collect() }
    }

    fn layers(&self) -> Vec<Layer<'_>> {
        let padding = self.padding;
        let ready = self.layers.iter().map(|held| {
            let Numbers { ref weights, ref bias, channels, dilation, activation, is_residual } = *held;
            Layer { weights, bias, channels, dilation, padding, activation, is_residual }
        });
        ready.collect()
    }

    fn direct(&self, isa: Isa, x: &[f32], [views, height, width]: [usize; 3]) -> Vec<f32> {
        let (kernel, padding) = (self.kernel, self.padding);
        self.layers.iter().fold(x.to_vec(), |x, held| {
            let Numbers { channels: [channels_in, channels_out], dilation, activation, .. } = *held;
            let shape =
                ConvShape { batch: 1, channels_in, channels_out, views, height, width, kernel, dilation, padding };
            let conv = Conv::new(shape, isa);
            let weights = conv.pack(&held.weights);
            let mut out = conv.forward(&conv.pad_input(&x), &weights, Some(&held.bias), activation, None).unwrap();
            if held.is_residual {
                out.iter_mut().zip(&x).for_each(|(out, x)| *out += x);
            }
            out
        })
    }
}

/// A result that was NaN all over before `f` wrote it.
fn written(len: usize, f: impl FnOnce(&mut [std::mem::MaybeUninit<f32>])) -> Vec<f32> {
    let mut out = vec![std::mem::MaybeUninit::new(f32::NAN); len];
    f(&mut out);
    // SAFETY: every value was initialised above.
    out.into_iter().map(|value| unsafe { value.assume_init() }).collect()
}

fn assert_near(got: &[f32], want: &[f32], most: f32, what: &str) {
    assert_eq!(got.len(), want.len());
    for (i, (a, b)) in got.iter().zip(want).enumerate() {
        assert!((a - b).abs() <= most, "{what}: value {i} is {a}, not {b}");
    }
}

/// All that computes planes here: vectors alone, and tiles beside them.
fn means() -> impl Iterator<Item = (Isa, Option<Halves>)> {
    let halves = [Some(Halves::portable()), Halves::best()].into_iter().flatten();
    Isa::all().map(|isa| (isa, None)).chain(halves.map(|halves| (Isa::best(), Some(halves))))
}

#[test]
fn planes_agree_with_the_direct_convolution() {
    for padding in [Padding::Edge, Padding::Zero] {
        let net = Net::new(Kernel::Plane, padding, &[16, 16, 64, 128, 80, 80, 32], &[1, 2, 16, 3]);
        for [height, width] in [[1, 1], [3, 2], [17, 53], [33, 30]] {
            let x = numbers(9, 16 * height * width);
            let want = net.direct(Isa::best(), &x, [1, height, width]);
            for (isa, halves) in means() {
                let chain = PlaneChain::new(&net.layers(), isa, halves);
                let got = written(want.len(), |out| chain.run(&x, [height, width], out, None).unwrap());
                assert_near(&got, &want, 5e-5, &format!("{isa} {halves:?} {padding:?} {width}×{height}"));
            }
        }
    }
}

#[test]
fn planes_of_many_channels_agree_with_the_direct_convolution() {
    // The second size has more tiles than are done in one round.
    for (padding, [height, width]) in [(Padding::Zero, [13, 7]), (Padding::Edge, [57, 70])] {
        let net = Net::new(Kernel::Plane, padding, &[128, 256, 256], &[1]);
        let x = numbers(9, 128 * height * width);
        let want = net.direct(Isa::best(), &x, [1, height, width]);
        for isa in Isa::all() {
            let chain = PlaneChain::new(&net.layers(), isa, None);
            let got = written(want.len(), |out| chain.run(&x, [height, width], out, None).unwrap());
            assert_near(&got, &want, 5e-5, &format!("{isa} {padding:?} {width}×{height}"));
        }
    }
}

#[test]
fn parts_are_joined_and_enlarged_as_one_picture() {
    let net = Net::new(Kernel::Plane, Padding::Edge, &[48, 32, 32], &[1]);
    let size @ [height, width] = [22, 38];
    let (small, large) = (numbers(1, 32 * height * width / 4), numbers(2, 16 * height * width));
    let at = |i: usize| {
        let (plane, y, x) = (i / (height * width), i / width % height, i % width);
        small[(plane * height / 2 + y / 2) * width / 2 + x / 2]
    };
    let limits = Limits { low: -0.5, high: 0.25 };
    let whole: Vec<f32> = (0..32 * height * width).map(at).chain(large.iter().copied()).collect();
    let parts = [Planes { values: &small, is_doubled: true }, Planes { values: &large, is_doubled: false }];
    for isa in Isa::all() {
        let chain = PlaneChain::new(&net.layers(), isa, None);
        let of = |parts: &[Planes]| {
            let ends = (limits, Ending::default());
            written(32 * height * width, |out| chain.run_between(parts, size, ends, out, None).unwrap())
        };
        assert_eq!(of(&parts), of(&[Planes { values: &whole, is_doubled: false }]), "{isa}");
    }
}

#[test]
fn volumes_agree_with_the_direct_convolution() {
    for padding in [Padding::Edge, Padding::Zero] {
        for channels in [&[4, 8, 8, 3][..], &[4, 3], &[5, 16, 12, 9]] {
            let net = Net::new(Kernel::Volume, padding, channels, &[1]);
            for size in [[1, 1, 1], [3, 2, 2], [9, 13, 33], [6, 9, 50], [10, 3, 530]] {
                let x = numbers(9, channels[0] * size.iter().product::<usize>());
                let want = net.direct(Isa::best(), &x, size);
                for isa in Isa::all() {
                    let chain = VolumeChain::new(&net.layers(), isa);
                    let got = written(want.len(), |out| chain.run_slice(&x, size, out, None).unwrap());
                    assert_near(&got, &want, 2e-5, &format!("{isa} {padding:?} {channels:?} {size:?}"));
                }
            }
        }
    }
}

#[test]
fn a_wide_picture_in_pieces_is_the_same_picture() {
    let net = Net::new(Kernel::Volume, Padding::Edge, &[4, 24, 24, 3], &[1]);
    let (size, chain) = ([64, 3, 700], VolumeChain::new(&net.layers(), Isa::best()));
    assert!(volume::pieces(700, chain.widest_piece(64), 3).len() > 1, "this test is about pieces");
    let x = numbers(9, 4 * size.iter().product::<usize>());
    let want = net.direct(Isa::best(), &x, size);
    let got = written(want.len(), |out| chain.run_slice(&x, size, out, None).unwrap());
    assert_near(&got, &want, 2e-5, "in pieces");
}

#[test]
fn pieces_cover_every_column_once_and_keep_their_halo() {
    for width in [1, 95, 96, 97, 288, 289, 300, 540, 552, 1000, 4096] {
        for widest in [116, 144, 288] {
            let mut next = 0;
            for (piece, keep) in volume::pieces(width, widest, 5) {
                assert_eq!(keep.start, next);
                assert!(piece.end <= width && piece.len() <= widest.max(width.min(widest)));
                assert!(keep.start == 0 || keep.start >= piece.start + 5);
                assert!(keep.end == width || keep.end + 5 <= piece.end);
                next = keep.end;
            }
            assert_eq!(next, width, "{width} columns in pieces of {widest}");
        }
    }
}

/// What is done after a cancel is counted in rows, not in time: no more than the round that runs.
#[test]
fn a_cancel_ends_a_volume_within_a_few_rows() {
    let net = Net::new(Kernel::Volume, Padding::Edge, &[4, 8, 8, 3], &[1]);
    let chain = VolumeChain::new(&net.layers(), Isa::best());
    let (size, cancel, rows, taken) = ([4, 400, 600], AtomicBool::new(false), AtomicUsize::new(0), AtomicUsize::new(0));
    let fill = |at: Columns, _: &mut [f32], _: usize| {
        rows.fetch_max(at.y, Ordering::Relaxed);
        cancel.fetch_or(at.y >= 100, Ordering::Relaxed);
    };
    let take = |rows: Rows| _ = taken.fetch_max(rows.y.end, Ordering::Relaxed);
    assert_eq!(chain.run(size, fill, take, Some(&cancel)), Err(Cancelled));
    assert!(rows.into_inner() <= 100 + 8, "rows went on being asked for");
    assert!(taken.into_inner() <= 100, "rows went on being made");
}

#[test]
fn a_cancelled_plane_says_so() {
    let net = Net::new(Kernel::Plane, Padding::Edge, &[32, 32], &[1]);
    for halves in [None, Some(Halves::portable())] {
        let chain = PlaneChain::new(&net.layers(), Isa::best(), halves);
        let mut out = vec![std::mem::MaybeUninit::uninit(); 32 * 64];
        assert_eq!(chain.run(&[0.0; 32 * 64], [8, 8], &mut out, Some(&AtomicBool::new(true))), Err(Cancelled));
    }
}
