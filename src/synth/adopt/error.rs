//! Why a net cannot be added.

use std::io;
use std::path::{Path, PathBuf};

use crate::job::Cancelled;
use crate::synth::ModelError;
use crate::synth::tract::EngineError;

/// A depth net that was not added; nothing of it is left behind.
#[derive(Debug, thiserror::Error)]
pub enum AdoptError {
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// No ONNX, damaged, or something in it that cannot be run.
    #[error("the net was not added — {source}: {}", path.display())]
    Engine {
        /// The file.
        path: PathBuf,
        /// What the engine said: a sentence with what to do.
        source: EngineError,
    },
    /// Reading it took more memory or time than there is, or broke the process that did it.
    #[error(
        "the net was not added — reading it takes more memory or time than a net may — choose another file of that net: {}", path.display()
    )]
    Unreadable {
        /// The file.
        path: PathBuf,
    },
    /// It takes no picture.
    #[error(
        "the net was not added — it takes no picture of three colours, its inputs are {inputs} — choose a depth net"
    )]
    NoPicture {
        /// Names of its inputs.
        inputs: String,
    },
    /// It takes several pictures.
    #[error("the net was not added — it takes several pictures ({inputs}) — choose one that makes depth of one photo")]
    Pictures {
        /// Names of its inputs.
        inputs: String,
    },
    /// It wants more than a picture.
    #[error(
        "the net was not added — besides the picture it wants {name:?}, and nobody here knows what — export it without that input, or write its manifest by hand (models/MANIFEST.md)"
    )]
    ExtraInput {
        /// Name of the input.
        name: String,
    },
    /// None of its outputs can be a depth map.
    #[error("the net was not added — none of its outputs ({outputs}) can be a depth map — choose a depth net")]
    NoMap {
        /// Names of its outputs.
        outputs: String,
    },
    /// It does not see the depth of a picture whose depth is known.
    #[error(
        "the net was not added — of the sample photo, whose depth is known, it finds {why} — choose a depth net, or add this one all the same with --force"
    )]
    NotDepth {
        /// What it answered.
        why: String,
    },
    /// More than an ONNX file can hold.
    #[error("the net was not added — it has {} MB, and an ONNX file has 2,147 MB at most — choose one with its weights in a second file", bytes / 1_000_000)]
    TooLarge {
        /// Length of the file.
        bytes: u64,
    },
    /// There is one of this name.
    #[error("there is a net named {name:?} already — choose another name with --name, or replace it with --force")]
    Exists {
        /// The name.
        name: String,
    },
    /// A name that cannot be one.
    #[error("a net cannot be named {name:?} — {why} — choose another name with --name")]
    Name {
        /// The name.
        name: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// No net of this name.
    #[error("there is no net named {name:?} — {known} — add one with `plenoscope models add FILE.onnx`")]
    Unknown {
        /// The name.
        name: String,
        /// The names that there are, as a sentence.
        known: String,
    },
    /// A file or a folder that cannot be read or written.
    #[error("{what} — {source} — {advice}: {}", path.display())]
    Io {
        /// What did not work.
        what: &'static str,
        /// What the system said.
        source: io::Error,
        /// What to do.
        advice: &'static str,
        /// Where.
        path: PathBuf,
    },
    /// Its manifest is not valid.
    #[error(transparent)]
    Model(#[from] ModelError),
}

impl AdoptError {
    pub(super) fn engine(path: &Path) -> impl Fn(EngineError) -> Self {
        let path = path.to_owned();
        move |source| match source {
            EngineError::Cancelled => Self::Cancelled(Cancelled),
            source => Self::Engine { path: path.clone(), source },
        }
    }

    pub(super) fn read(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io {
            what: "the net cannot be read",
            source,
            advice: "check that the file is there and whole",
            path,
        }
    }

    pub(super) fn write(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io {
            what: "the net was not added",
            source,
            advice: "make room, or check that the folder can be written to",
            path,
        }
    }
}
