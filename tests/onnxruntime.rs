//! tract, with our convolutions in it, against ONNX Runtime on the same files.
//!
//! `cargo xtask test` fetches the library and sets `ORT_DYLIB_PATH`. Without it these tests say that they skip; with
//! `CI=true` they fail.
#![allow(clippy::unwrap_used, reason = "in a test a panic is the failure")]
#![cfg(feature = "onnxruntime")]

#[path = "common/nets.rs"]
mod nets;
#[path = "common/runtime.rs"]
mod runtime;

use nets::Layer;
use ort::environment::Environment;
use ort::session::Session;
use ort::value::Tensor;
use plenoscope::job::Cancel;
use plenoscope::synth::tract::{Options, Path, prepare};
use plenoscope::synth::{ModelSource, Task};

/// px per view step.
const DEPTH_TOLERANCE: f32 = 1e-4;
/// Of values in −1 … 1.
const RESIDUAL_TOLERANCE: f32 = 1e-5;
/// How much more Winograd's algorithm may be off.
const WINOGRAD: f32 = 10.0;

/// Reproducible values in −1 … 1.
fn noise(count: usize) -> Vec<f32> {
    let mut state = 1u64;
    let next = |_| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    };
    (0..count).map(next).collect()
}

/// Runs one file in both engines and fails where they differ by more than `tolerance`.
fn compare(runtime: &Environment, what: &str, onnx: &[u8], shape: &[usize], tolerance: f32) {
    let input = noise(shape.iter().product());
    let mut session = Session::builder(runtime).unwrap().commit_from_memory(onnx).unwrap();
    let tensor = Tensor::from_array((shape.to_vec(), input.clone())).unwrap();
    let outputs = session.run(ort::inputs![tensor]).unwrap();
    let (want_shape, want) = outputs[0].try_extract_tensor::<f32>().unwrap();
    for (path, exact) in [(Path::Auto, false), (Path::Auto, true), (Path::Stock, true)] {
        let net = prepare(onnx, shape, &Options { path, exact, ..Options::default() }).unwrap();
        let tolerance = if exact { tolerance } else { tolerance * WINOGRAD };
        let got = net.run(&input, &Cancel::default()).unwrap();
        let got_shape: Vec<i64> = got.shape().iter().map(|n| *n as i64).collect();
        assert_eq!(got_shape[..], want_shape[..], "{what} {shape:?}");
        let worst = got.iter().zip(want).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        let how = if exact { "exactly" } else { "by Winograd" };
        assert!(worst <= tolerance, "{what} {shape:?} by {path:?} {how}: {worst} apart, {tolerance} allowed");
    }
}

#[test]
fn small_random_nets_answer_alike_at_even_odd_and_tiny_sizes() {
    let Some(runtime) = runtime::runtime() else { return };
    let depth = nets::onnx(&[Layer::conv2(5, 16), Layer::conv2(16, 24).dilated(4), Layer::conv2(24, 64)], 3);
    for (h, w) in [(48, 64), (37, 53), (5, 3), (1, 1)] {
        compare(runtime, "small depth net", &depth, &[1, 5, h, w], DEPTH_TOLERANCE);
    }
    let occlusion = nets::onnx(&[Layer::conv3(4, 8), Layer::conv3(8, 8), Layer::conv3(8, 3)], 4);
    for (h, w) in [(24, 32), (17, 23), (2, 7), (1, 1)] {
        compare(runtime, "small occlusion net", &occlusion, &[1, 4, 64, h, w], RESIDUAL_TOLERANCE);
    }
}

#[test]
fn the_papers_depth_net_answers_alike() {
    let Some(runtime) = runtime::runtime() else { return };
    let mut layers = vec![Layer::conv2(3, 16), Layer::conv2(16, 64), Layer::conv2(64, 128)];
    layers.extend([2, 4, 8, 16].map(|dilation| Layer::conv2(128, 128).dilated(dilation)));
    layers.extend([Layer::conv2(128, 128), Layer::conv2(128, 64), Layer::conv2(64, 64)]);
    compare(runtime, "the paper's depth net", &nets::onnx(&layers, 5), &[1, 3, 93, 131], DEPTH_TOLERANCE);
}

#[test]
fn the_shipped_nets_answer_alike() {
    let Some(runtime) = runtime::runtime() else { return };
    let source = ModelSource::Embedded;
    let index = source.index().unwrap();
    let depth = source.model(&index.depth, Task::RayDepth).unwrap();
    let multiple = depth.manifest.multiple_of as usize;
    for (h, w) in [(96, 128), (85, 127), (1, 33)] {
        // As the program does: brought to the multiple that the manifest asks for.
        let [h, w] = [h, w].map(|side: usize| side.next_multiple_of(multiple));
        let shape = [1, depth.manifest.input_channels(), h, w];
        compare(runtime, "shipped depth net", &depth.onnx.read().unwrap(), &shape, DEPTH_TOLERANCE);
    }
    let Some(id) = index.occlusion else { return };
    let occlusion = source.model(&id, Task::Occlusion).unwrap();
    let views = occlusion.manifest.grid().unwrap().count();
    for (h, w) in [(40, 64), (33, 47)] {
        compare(
            runtime,
            "shipped occlusion net",
            &occlusion.onnx.read().unwrap(),
            &[1, 4, views, h, w],
            RESIDUAL_TOLERANCE,
        );
    }
}
