//! ONNX Runtime on the same files.

use std::path::Path;
use std::sync::OnceLock;

use ort::environment::Environment;
use ort::session::Session;
use ort::session::builder::SessionBuilder;
use ort::value::TensorRef;

use super::nets::{Nets, numbers};
use super::timed;
use crate::synth::ModelFile;

/// Both nets in ONNX Runtime, each with an input over the whole picture.
pub(super) struct Engine {
    nets: Vec<(Session, Vec<i64>, Vec<f32>)>,
}

impl Engine {
    /// Loads the library that `ORT_DYLIB_PATH` names, and both nets.
    pub(super) fn new(nets: &Nets, threads: usize) -> Result<Self, String> {
        let [depth, occlusion] = nets.shapes();
        let threads = if threads == 0 { rayon::current_num_threads() } else { threads };
        let load = |file: &ModelFile, shape: Vec<usize>| {
            let onnx = file.onnx.read().map_err(|error| error.to_string())?;
            let session = session(&onnx, threads)?;
            let values = numbers(shape.iter().product());
            Ok::<_, String>((session, shape.into_iter().map(|n| n as i64).collect(), values))
        };
        let mut loaded = vec![load(&nets.depth_file, depth)?];
        if let Some(file) = &nets.occlusion_file {
            loaded.push(load(file, occlusion)?);
        }
        Ok(Self { nets: loaded })
    }

    /// Seconds of the depth net and of the occlusion net.
    pub(super) fn run(&mut self) -> Result<[f64; 2], String> {
        let mut seconds = [0.0; 2];
        for ((session, shape, values), seconds) in self.nets.iter_mut().zip(&mut seconds) {
            let input = TensorRef::from_array_view((shape.clone(), &values[..])).map_err(|error| error.to_string())?;
            let (took, answer) = timed(|| session.run(ort::inputs![input]).map(|_| ()));
            answer.map_err(|error| error.to_string())?;
            *seconds = took;
        }
        Ok(seconds)
    }
}

/// One net of any kind in ONNX Runtime.
pub(super) struct Single {
    session: Session,
    shape: Vec<i64>,
}

impl Single {
    /// Loads the library and the net in `file`, which takes inputs of `shape`.
    pub(super) fn new(file: &Path, shape: &[usize], threads: usize) -> Result<Self, String> {
        let session = builder(threads)?.commit_from_file(file).map_err(|error| error.to_string())?;
        Ok(Self { session, shape: shape.iter().map(|&n| n as i64).collect() })
    }

    /// Seconds, and the values of the first output.
    pub(super) fn run(&mut self, input: &[f32]) -> Result<(f64, Vec<f32>), String> {
        let input = TensorRef::from_array_view((self.shape.clone(), input)).map_err(|error| error.to_string())?;
        let (took, answer) = timed(|| self.session.run(ort::inputs![input]));
        let answer = answer.map_err(|error| error.to_string())?;
        let (_, values) = answer[0].try_extract_tensor::<f32>().map_err(|error| error.to_string())?;
        Ok((took, values.to_vec()))
    }
}

/// The one environment that a process may have.
fn environment() -> Result<&'static Environment, String> {
    static ENVIRONMENT: OnceLock<Result<Environment, String>> = OnceLock::new();
    let load = || {
        let library = std::env::var("ORT_DYLIB_PATH").map_err(|_missing| "ORT_DYLIB_PATH is not set".to_owned())?;
        let builder = ort::init_from(&library).map_err(|error| error.to_string())?;
        builder.build().map_err(|error| error.to_string())
    };
    ENVIRONMENT.get_or_init(load).as_ref().map_err(Clone::clone)
}

fn session(onnx: &[u8], threads: usize) -> Result<Session, String> {
    builder(threads)?.commit_from_memory(onnx).map_err(|error| error.to_string())
}

fn builder(threads: usize) -> Result<SessionBuilder, String> {
    let builder = Session::builder(environment()?).map_err(|error| error.to_string())?;
    builder.with_intra_threads(threads).map_err(|error| error.to_string())
}
