//! Depth nets of other people, as they are exported, in tract against ONNX Runtime.
//!
//! `cargo xtask test --all` exports small ones of each architecture (`tests/foreign_nets/export.py`) and names their
//! folder in `PLENOSCOPE_NETS`. Without it this test says that it skips; what each export needs is tested with graphs
//! of a few nodes in `synth::tract::graph`.
#![allow(clippy::unwrap_used, reason = "in a test a panic is the failure")]
#![allow(clippy::explicit_write, reason = "the test harness keeps what eprintln! says to itself")]
#![cfg(feature = "onnxruntime")]

#[path = "common/foreign.rs"]
mod foreign;
#[path = "common/runtime.rs"]
mod runtime;

use std::io::Write as _;

use foreign::Net;
use ort::session::Session;
use ort::value::Tensor;
use plenoscope::job::Cancel;
use plenoscope::synth::tract::{OnnxBytes, signs};

/// Of the map's standard deviation: full precision, and half.
const FULL: f32 = 1e-3;
const HALF: f32 = 2e-3;

/// What the program answers.
fn ours(net: &Net, input: &[f32]) -> Vec<f32> {
    net.runnable().run(input, &Cancel::default()).unwrap().to_vec()
}

/// What ONNX Runtime answers; it is given float32, so nets of float16 are none for it.
fn theirs(net: &Net, environment: &ort::environment::Environment, input: &[f32]) -> Vec<f32> {
    let mut session = Session::builder(environment).unwrap().commit_from_file(&net.path).unwrap();
    let tensor = Tensor::from_array((net.shape.clone(), input.to_vec())).unwrap();
    let outputs = session.run(ort::inputs![tensor]).unwrap();
    outputs[0].try_extract_tensor::<f32>().unwrap().1.to_vec()
}

/// The greatest difference, in standard deviations of what is wanted.
fn apart(got: &[f32], want: &[f32]) -> f32 {
    assert_eq!(got.len(), want.len());
    let mean = want.iter().sum::<f32>() / want.len() as f32;
    let deviation = (want.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / want.len() as f32).sqrt();
    got.iter().zip(want).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) / deviation.max(1e-12)
}

#[test]
fn exports_of_other_peoples_nets_answer_as_in_onnx_runtime() {
    let Some(runtime) = runtime::runtime() else { return };
    let Some(nets) = foreign::exported() else {
        writeln!(std::io::stderr(), "\nSKIPPED, no exported nets: `cargo xtask test --all` makes them\n").unwrap();
        return;
    };
    let mut faults = Vec::new();
    for net in nets {
        let (name, input) = (net.name(), net.picture());
        let answer = ours(&net, &input);
        let beside = |name: String| Net { path: net.path.with_file_name(name), shape: net.shape.clone() };
        let whole = beside(format!("{}.onnx", name.rsplit_once('-').map_or(&*name, |(base, _)| base)));
        let (error, allowed) = match name.rsplit('-').next() {
            // Fewer bits: not worse than what ONNX Runtime itself loses by them.
            Some("int8" | "q4" | "fp16") => {
                let full = theirs(&whole, runtime, &input);
                (apart(&answer, &full), (1.5 * apart(&theirs(&net, runtime, &input), &full)).max(HALF))
            }
            // What takes float16 is the net beside it that takes float32, to us.
            Some("fp16io") => {
                let like = beside(name.replace("fp16io", "fp16.onnx"));
                (apart(&answer, &ours(&like, &input)), FULL)
            }
            _ => (apart(&answer, &theirs(&net, runtime, &input)), FULL),
        };
        let families = signs(OnnxBytes::File(&net.path)).unwrap();
        writeln!(std::io::stderr(), "{name:28} {error:.1e} of {allowed:.1e}, patch {:?}", families.patch).unwrap();
        if error > allowed {
            faults.push(format!("{name}: {error:.1e} apart, {allowed:.1e} allowed"));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}
