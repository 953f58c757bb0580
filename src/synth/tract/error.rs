//! What can go wrong between an ONNX file and its answer.

use tract_onnx::prelude::TractError;

/// A net could not be made ready or run.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// The bytes are no ONNX model.
    #[error("the model cannot be read — it is no ONNX file or it is damaged ({detail}) — get it again")]
    Parse {
        /// tract's words.
        detail: String,
    },
    /// The model has an operator or attribute that tract does not know.
    #[error("the model cannot be used — it asks for something that is not supported ({detail}) — export it anew")]
    Unsupported {
        /// tract's words.
        detail: String,
    },
    /// The model has an operation that nobody here knows.
    #[error(
        "the model cannot be used — its operation {name} is not supported — take a file of the same net without it, in float32 if there is one"
    )]
    Operator {
        /// Its name, with its domain where it has one.
        name: String,
    },
    /// Weights that lie in another file, which is not there.
    #[error("the model's weights are not whole — its file {name:?} is not beside it — put it there, named like that")]
    External {
        /// Name of the file.
        name: String,
    },
    /// No one input that a picture goes into.
    #[error(
        "the model cannot be used — its inputs are {names}, and one picture is what it can be given — take a file with one input, or give the others numbers in its manifest (extra_inputs)"
    )]
    Inputs {
        /// Names of the inputs.
        names: String,
    },
    /// An input that cannot stand for a number.
    #[error("the model's input {name:?} cannot be given a number — {why} — take it out of extra_inputs")]
    Input {
        /// Its name.
        name: String,
        /// Why not.
        why: String,
    },
    /// An input or output that the manifest names and the graph has not.
    #[error("the model has no {what} named {name:?} — it has {known} — correct its manifest")]
    NoPort {
        /// `input` or `output`.
        what: &'static str,
        /// The name in the manifest.
        name: String,
        /// Names in the graph.
        known: String,
    },
    /// The model does not take inputs of this shape.
    #[error("the model does not take an input of {shape:?} ({detail}) — check the inputs in its manifest")]
    Shape {
        /// The shape that was asked for.
        shape: Vec<usize>,
        /// tract's words.
        detail: String,
    },
    /// A weight is NaN or infinite.
    #[error("the model's weights {name:?} are not all finite numbers — its training failed — train or get it again")]
    NotFinite {
        /// The name of the tensor in the file.
        name: String,
    },
    /// Its values do not fit in memory.
    #[error("the net needs {} MiB of memory — {} MiB is what it may take here — take a smaller net or a smaller working size", need_bytes >> 20, most_bytes >> 20)]
    Room {
        /// Bytes of all values that are there at one time.
        need_bytes: u64,
        /// What is free, if that is not too much for any net.
        most_bytes: u64,
    },
    /// The net stopped in the middle.
    #[error("the net stopped ({detail})")]
    Run {
        /// tract's words.
        detail: String,
    },
    /// The system gave no threads.
    #[error("no threads to run the net on — the system's limit is reached — close other programs")]
    Threads {
        /// The reason.
        source: rayon::ThreadPoolBuildError,
    },
    /// The caller asked to stop.
    #[error("stopped")]
    Cancelled,
}

impl EngineError {
    pub(super) fn parse(source: TractError) -> Self {
        Self::Parse { detail: one_line(&source) }
    }

    pub(super) fn unsupported(source: TractError) -> Self {
        Self::Unsupported { detail: one_line(&source) }
    }

    pub(super) fn shape(shape: &[usize], source: TractError) -> Self {
        Self::Shape { shape: shape.to_vec(), detail: one_line(&source) }
    }

    pub(super) fn run(source: TractError) -> Self {
        Self::Run { detail: one_line(&source) }
    }
}

/// The whole chain of causes in one line.
fn one_line(source: &TractError) -> String {
    format!("{source:#}").split_whitespace().collect::<Vec<_>>().join(" ")
}
