//! What can go wrong on the way from a photo to a light field.

use std::path::PathBuf;

use super::tract::EngineError;
use crate::field::FieldError;
use crate::job::Cancelled;

/// A model that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// The program was built without it.
    #[error(
        "this program was built without {path} — put the models into models/ and build again, or name a folder with --models"
    )]
    NotEmbedded {
        /// Path below `models/`.
        path: String,
    },
    /// A file is missing or cannot be read.
    #[error("a model's file cannot be read — {source} — choose a folder with models.toml and its models: {}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A manifest that does not say what it must.
    #[error("a model's manifest is not valid — {why} — correct it: {place}")]
    Manifest {
        /// Where it lies.
        place: String,
        /// What is wrong.
        why: String,
    },
    /// The checksum differs.
    #[error(
        "model {id} is not the file its manifest describes — its checksum differs — fetch the model again: {place}"
    )]
    Tampered {
        /// Name of the model.
        id: String,
        /// Where it lies.
        place: String,
    },
    /// Not ONNX, damaged weights, or an operation or a shape that cannot be run.
    #[error("model {id}: {source}: {place}")]
    Engine {
        /// Name of the model.
        id: String,
        /// Where it lies.
        place: String,
        /// What the engine said: a sentence with what to do.
        source: EngineError,
    },
    /// Its answer does not have the shape that its manifest promises.
    #[error(
        "model {id} does not fit its manifest — it answers {got} where {want} is needed — correct one of them: {place}"
    )]
    Shape {
        /// Name of the model.
        id: String,
        /// Where it lies.
        place: String,
        /// The shape of its answer.
        got: String,
        /// The shape that the manifest promises.
        want: String,
    },
    /// Its answer is not one map.
    #[error(
        "model {id} does not answer with one depth map — its answer has the shape {got} — export it with one output [1, 1, H, W]: {place}"
    )]
    NoMap {
        /// Name of the model.
        id: String,
        /// Where it lies.
        place: String,
        /// The shape of its answer.
        got: String,
    },
    /// A source of ray depth that nobody knows.
    #[error(
        "there is no ray depth from {name:?} — known are {known} — name one of them, or add the net with `plenoscope models add FILE.onnx`"
    )]
    NoSource {
        /// The name that was asked for.
        name: String,
        /// The names that are known.
        known: String,
    },
    /// No nets of four corners of this name.
    #[error(
        "there are no nets of four corners called {name:?} — known are {} — leave --source out, or export such nets and name their folder with --models",
        none_or(known)
    )]
    NoCornerNets {
        /// The name that was asked for.
        name: String,
        /// The names that are known.
        known: Vec<String>,
    },
    /// It answers with values that are not numbers.
    #[error(
        "model {id} answers with values that are not numbers — its weights are damaged — fetch the model again: {place}"
    )]
    NotFinite {
        /// Name of the model.
        id: String,
        /// Where it lies.
        place: String,
    },
}

/// Names, or that there are none.
fn none_or(names: &[String]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

/// A light field that could not be made.
#[derive(Debug, thiserror::Error)]
pub enum SynthError {
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A model could not be loaded or run.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// More memory than there is.
    #[error("the light field needs {} MiB of memory — {} MiB are free — choose a long side of {fits} pixels or less", need_bytes >> 20, free_bytes >> 20)]
    OutOfMemory {
        /// Memory that is needed.
        need_bytes: u64,
        /// Memory that is free.
        free_bytes: u64,
        /// Long side that would fit.
        fits: u32,
    },
    /// Threads could not be started.
    #[error("worker threads could not be started — {0} — close other programs or use fewer threads")]
    Threads(String),
    /// Parts of a light field that do not fit together.
    #[error(transparent)]
    Field(#[from] FieldError),
}
