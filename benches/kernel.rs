//! The convolutions, layer by layer and in chains: `cargo bench --bench kernel`. Items are the multiply-adds × 2 of the
//! plain sum, so divan's items per second are useful FLOP/s, whatever algorithm does them.

use divan::Bencher;
use divan::counter::ItemsCount;
use plenoscope::kernel::winograd::{Layer, PlaneChain, VolumeChain};
use plenoscope::kernel::{Activation, Conv, ConvShape, Halves, Isa, Kernel, Padding};

fn main() {
    divan::main();
}

/// (name, channels in, channels out, views, rows, columns, dilation)
const LAYERS: [(&str, usize, usize, usize, usize, usize, usize); 9] = [
    ("depth first", 5, 16, 1, 187, 270, 1),
    ("depth 64 to 128", 64, 128, 1, 187, 270, 1),
    ("depth 128, dilation 2", 128, 128, 1, 187, 270, 2),
    ("depth 128, dilation 16", 128, 128, 1, 187, 270, 16),
    ("depth last", 64, 64, 1, 187, 270, 1),
    ("occlusion first", 4, 8, 64, 64, 270, 1),
    ("occlusion middle", 8, 8, 64, 64, 270, 1),
    ("occlusion last", 8, 3, 64, 64, 270, 1),
    ("everyday, 1/16", 224, 224, 1, 12, 16, 1),
];

fn shape(layer: usize) -> ConvShape {
    let (_, channels_in, channels_out, views, height, width, dilation) = LAYERS[layer];
    let kernel = if views > 1 { Kernel::Volume } else { Kernel::Plane };
    ConvShape { batch: 1, channels_in, channels_out, views, height, width, kernel, dilation, padding: Padding::Edge }
}

fn numbers(n: usize) -> Vec<f32> {
    (0..n).map(|i| (i * 7919 % 1000) as f32 / 1000.0 - 0.5).collect()
}

fn forward(bencher: Bencher, layer: usize, isa: Option<Isa>) {
    let Some(isa) = isa else { return };
    let conv = Conv::new(shape(layer), isa);
    let x = numbers(conv.shape().input_len());
    let weights = conv.pack(&numbers(conv.shape().weights_len()));
    let flop = conv.shape().flop() as usize;
    bencher
        .counter(ItemsCount::new(flop))
        .bench(|| conv.forward(&conv.pad_input(&x), &weights, None, Activation::Elu, None));
}

#[divan::bench(args = 0..LAYERS.len(), sample_count = 10)]
fn avx512(bencher: Bencher, layer: usize) {
    forward(bencher, layer, Isa::avx512());
}

#[divan::bench(args = 0..LAYERS.len(), sample_count = 10)]
fn avx2(bencher: Bencher, layer: usize) {
    forward(bencher, layer, Isa::avx2());
}

/// One layer by Winograd's algorithm, where it pays.
#[divan::bench(args = 1..LAYERS.len(), sample_count = 10)]
fn winograd(bencher: Bencher, layer: usize) {
    chain(bencher, layer, None);
}

/// One layer by split products, where the processor has tiles.
#[divan::bench(args = [1, 2, 3, 4, 8], sample_count = 10)]
fn split(bencher: Bencher, layer: usize) {
    if let Some(halves) = Halves::best() {
        chain(bencher, layer, Some(halves));
    }
}

fn chain(bencher: Bencher, layer: usize, halves: Option<Halves>) {
    let shape = shape(layer);
    let channels = [shape.channels_in, shape.channels_out];
    let (weights, bias, x) = (numbers(shape.weights_len()), numbers(channels[1]), numbers(shape.input_len()));
    let ConvShape { views, height, width, dilation, padding, .. } = shape;
    let (activation, is_residual) = (Activation::Elu, false);
    let layer = Layer { weights: &weights, bias: &bias, channels, dilation, padding, activation, is_residual };
    let mut out: Vec<_> = std::iter::repeat_with(std::mem::MaybeUninit::uninit).take(shape.output_len()).collect();
    let bencher = bencher.counter(ItemsCount::new(shape.flop() as usize));
    if shape.kernel == Kernel::Volume {
        let chain = VolumeChain::new(&[layer], Isa::best());
        bencher.bench_local(|| chain.run_slice(&x, [views, height, width], &mut out, None));
    } else if PlaneChain::pays_alone(channels) {
        let chain = PlaneChain::new(&[layer], Isa::best(), halves);
        bencher.bench_local(|| chain.run(&x, [height, width], &mut out, None));
    }
}

#[divan::bench(args = 0..LAYERS.len(), sample_count = 10)]
fn data_gradient(bencher: Bencher, layer: usize) {
    let conv = Conv::new(shape(layer), Isa::best());
    let weights = numbers(conv.shape().weights_len());
    let gradient = conv.pad_gradient(&numbers(conv.shape().output_len()));
    let flop = conv.shape().flop() as usize;
    bencher.counter(ItemsCount::new(flop)).bench(|| conv.data_gradient(&gradient, &weights));
}

#[divan::bench(args = 0..LAYERS.len(), sample_count = 10)]
fn weight_gradient(bencher: Bencher, layer: usize) {
    let conv = Conv::new(shape(layer), Isa::best());
    let x = conv.pad_input(&numbers(conv.shape().input_len()));
    let gradient = conv.pad_gradient(&numbers(conv.shape().output_len()));
    let flop = conv.shape().flop() as usize;
    bencher.counter(ItemsCount::new(flop)).bench(|| conv.weight_gradient(&x, &gradient));
}

/// A layer of a training step, by whichever algorithm it takes.
#[divan::bench(args = 0..LAYERS.len(), sample_count = 10)]
fn step(bencher: Bencher, layer: usize) {
    let conv = Conv::new(shape(layer), Isa::best());
    let (x, weights) = (numbers(conv.shape().input_len()), numbers(conv.shape().weights_len()));
    let flop = conv.shape().flop() as usize;
    bencher.counter(ItemsCount::new(flop)).bench(|| conv.step(&x, &weights));
}

/// Both gradients of it.
#[divan::bench(args = 0..LAYERS.len(), sample_count = 10)]
fn step_gradients(bencher: Bencher, layer: usize) {
    let conv = Conv::new(shape(layer), Isa::best());
    let (x, weights) = (numbers(conv.shape().input_len()), numbers(conv.shape().weights_len()));
    let gradient = numbers(conv.shape().output_len());
    let flop = 2 * conv.shape().flop() as usize;
    let pieces = |piece: &mut [f32], at: usize| piece.copy_from_slice(&gradient[at..][..piece.len()]);
    bencher.counter(ItemsCount::new(flop)).bench(|| conv.step_gradients(&x, &weights, pieces, true));
}
