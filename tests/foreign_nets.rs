//! Depth nets of other people, as they are exported, in tract against ONNX Runtime.
//!
//! `cargo xtask test --all` exports small ones of each architecture (`tests/foreign_nets/export.py`) and names their
//! folder in `PLENOSCOPE_NETS`. Without it this test says that it skips; what each export needs is tested with graphs
//! of a few nodes in `synth::tract::graph`.
#![allow(clippy::unwrap_used, reason = "in a test a panic is the failure")]
#![allow(clippy::explicit_write, reason = "the test harness keeps what eprintln! says to itself")]
#![cfg(feature = "onnxruntime")]

#[path = "common/runtime.rs"]
mod runtime;

use std::io::Write as _;
use std::path::{Path, PathBuf};

use ort::session::Session;
use ort::value::Tensor;
use plenoscope::job::Cancel;
use plenoscope::synth::tract::{OnnxFile, Options, Wiring, prepare_file, signs};

/// Of the map's standard deviation: full precision, and half.
const FULL: f32 = 1e-3;
const HALF: f32 = 2e-3;

struct Net {
    path: PathBuf,
    /// The shape of the input, as the script says.
    shape: Vec<usize>,
}

impl Net {
    /// All of a folder, from the lists `NAME.shape` beside the nets.
    fn all(folder: &Path) -> Vec<Self> {
        let mut nets: Vec<Self> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.extension().is_some_and(|end| end == "onnx"))
            .map(|path| {
                let text = std::fs::read_to_string(path.with_extension("shape")).unwrap();
                Self { path, shape: text.split_whitespace().map(|n| n.parse().unwrap()).collect() }
            })
            .collect();
        nets.sort_by(|a, b| a.path.cmp(&b.path));
        nets
    }

    fn name(&self) -> String {
        self.path.file_stem().unwrap().to_string_lossy().into_owned()
    }

    /// What the program answers.
    fn ours(&self, input: &[f32]) -> Vec<f32> {
        let bytes = std::fs::read(&self.path).unwrap();
        let file = OnnxFile { bytes: &bytes, folder: self.path.parent(), wiring: &Wiring::default() };
        let net =
            prepare_file(&file, &self.shape, &Options::default()).unwrap_or_else(|e| panic!("{}: {e}", self.name()));
        net.run(input, &Cancel::default()).unwrap().to_vec()
    }

    /// What ONNX Runtime answers; it is given float32, so nets of float16 are none for it.
    fn theirs(&self, environment: &ort::environment::Environment, input: &[f32]) -> Vec<f32> {
        let mut session = Session::builder(environment).unwrap().commit_from_file(&self.path).unwrap();
        let tensor = Tensor::from_array((self.shape.clone(), input.to_vec())).unwrap();
        let outputs = session.run(ort::inputs![tensor]).unwrap();
        outputs[0].try_extract_tensor::<f32>().unwrap().1.to_vec()
    }
}

/// A smooth picture with edges, −1 … 1, in the order of its shape.
fn picture(shape: &[usize]) -> Vec<f32> {
    let (h, w) = (shape[shape.len() - 2], shape[shape.len() - 1]);
    let at = |i: usize| {
        let (x, y, c) = ((i % w) as f32, (i / w % h) as f32, (i / (w * h)) as f32);
        let step = if (x - 0.4 * w as f32).hypot(y - 0.6 * h as f32) < 0.2 * h as f32 { 0.5 } else { -0.1 };
        step + 0.3 * (x * 0.11 + c).sin() + 0.2 * (y * 0.07 - x * 0.013).cos()
    };
    (0..shape.iter().product()).map(at).collect()
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
    let Some(folder) = std::env::var_os("PLENOSCOPE_NETS").map(PathBuf::from) else {
        writeln!(std::io::stderr(), "\nSKIPPED, no exported nets: `cargo xtask test --all` makes them\n").unwrap();
        return;
    };
    let mut faults = Vec::new();
    for net in Net::all(&folder) {
        let name = net.name();
        let input = picture(&net.shape);
        let ours = net.ours(&input);
        let whole = folder.join(format!("{}.onnx", name.rsplit_once('-').map_or(&*name, |(base, _)| base)));
        let whole = Net { path: whole, shape: net.shape.clone() };
        let (error, allowed) = match name.rsplit('-').next() {
            // Fewer bits: not worse than what ONNX Runtime itself loses by them.
            Some("int8" | "q4" | "fp16") => {
                let full = whole.theirs(runtime, &input);
                (apart(&ours, &full), (1.5 * apart(&net.theirs(runtime, &input), &full)).max(HALF))
            }
            // What takes float16 is the net beside it that takes float32, to us.
            Some("fp16io") => {
                let like = Net {
                    path: net.path.with_file_name(name.replace("fp16io", "fp16.onnx")),
                    shape: net.shape.clone(),
                };
                (apart(&ours, &like.ours(&input)), FULL)
            }
            _ => (apart(&ours, &net.theirs(runtime, &input)), FULL),
        };
        let families = signs(&std::fs::read(&net.path).unwrap()).unwrap();
        writeln!(std::io::stderr(), "{name:28} {error:.1e} of {allowed:.1e}, patch {:?}", families.patch).unwrap();
        if error > allowed {
            faults.push(format!("{name}: {error:.1e} apart, {allowed:.1e} allowed"));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}
