//! ONNX Runtime on the same two files.

use std::sync::OnceLock;

use ort::environment::Environment;
use ort::session::Session;
use ort::value::TensorRef;

use super::nets::{Nets, numbers};
use super::timed;

/// Both nets in ONNX Runtime, each with an input over the whole picture.
pub(super) struct Engine {
    nets: Vec<(Session, Vec<i64>, Vec<f32>)>,
}

impl Engine {
    /// Loads the library that `ORT_DYLIB_PATH` names, and both nets.
    pub(super) fn new(nets: &Nets, threads: usize) -> Result<Self, String> {
        let [depth, occlusion] = nets.shapes();
        let threads = if threads == 0 { rayon::current_num_threads() } else { threads };
        let load = |onnx: &[u8], shape: Vec<usize>| {
            let session = session(onnx, threads)?;
            let values = numbers(shape.iter().product());
            Ok::<_, String>((session, shape.into_iter().map(|n| n as i64).collect(), values))
        };
        let mut loaded = vec![load(&nets.depth_file.onnx, depth)?];
        if let Some(file) = &nets.occlusion_file {
            loaded.push(load(&file.onnx, occlusion)?);
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
    let builder = Session::builder(environment()?).map_err(|error| error.to_string())?;
    let mut builder = builder.with_intra_threads(threads).map_err(|error| error.to_string())?;
    builder.commit_from_memory(onnx).map_err(|error| error.to_string())
}
