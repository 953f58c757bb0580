//! The convolutions' `unsafe` under the address sanitizer: bytes say shape and code path.

use plenoscope::kernel::{Activation, Conv, ConvShape, Isa, Kernel, Padding};

use crate::readers::Reader;

pub fn as_reader() -> Reader {
    let whole = vec![vec![1, 3, 16, 1, 9, 17, 1, 2, 0, 2, 1], vec![2, 5, 4, 3, 6, 33, 2, 1, 1, 0, 2]];
    let read = |bytes: &[u8]| {
        convolve(bytes);
        Ok(())
    };
    Reader { name: "kernel".to_owned(), whole, read: Box::new(read) }
}

/// Forward and both gradients of a convolution, whose numbers are finite as its inputs are.
fn convolve(bytes: &[u8]) {
    let number = |at: usize, most: usize| usize::from(bytes.get(at).copied().unwrap_or(0)) % most;
    let paths: Vec<Isa> = Isa::all().collect();
    let isa = paths[number(9, paths.len())];
    let shape = ConvShape {
        batch: 1 + number(0, 2),
        channels_in: 1 + number(1, 36),
        channels_out: 1 + number(2, 36),
        views: 1 + number(3, 4),
        height: 1 + number(4, 20),
        width: 1 + number(5, 70),
        kernel: [Kernel::Point, Kernel::Plane, Kernel::Volume][number(6, 3)],
        dilation: 1 + number(7, 8),
        padding: [Padding::Edge, Padding::Zero][number(8, 2)],
    };
    let conv = Conv::new(shape, isa);
    let values = |count: usize| (0..count).map(|n| (n % 13) as f32 / 13.0 - 0.5).collect::<Vec<_>>();
    let (input, weights, bias) = (values(shape.input_len()), values(shape.weights_len()), values(shape.channels_out));
    let act = [Activation::Elu, Activation::Tanh { scale: 2.0 }, Activation::None][number(10, 3)];
    let padded = conv.pad_input(&input);
    let Ok(output) = conv.forward(&padded, &conv.pack(&weights), Some(&bias), act, None) else { return };
    let gradient = conv.pad_gradient(&output);
    let back = [conv.data_gradient(&gradient, &weights), conv.weight_gradient(&padded, &gradient)];
    assert!(output.iter().chain(back.iter().flatten()).all(|value| value.is_finite()));
}
