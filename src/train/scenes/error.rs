//! What can be wrong with training data. Each text names the file and what is expected of it.

use std::path::{Path, PathBuf};

use crate::field::TrueFieldError;

/// Training data that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// A file is missing or unreadable.
    #[error("cannot read the {what}: {reason}; expected {expected}: {}", path.display())]
    Read {
        /// Photo, mask, view …
        what: &'static str,
        /// Why it failed.
        reason: String,
        /// What should be there.
        expected: String,
        /// The file.
        path: PathBuf,
    },
    /// A mask, map or view of another size than the picture it belongs to.
    #[error("the {what} has {} × {} pixels; expected {} × {} as {beside}: {}", got[0], got[1], want[0], want[1], path.display())]
    Size {
        /// Mask, view …
        what: &'static str,
        /// Width and height found.
        got: [usize; 2],
        /// Width and height expected.
        want: [usize; 2],
        /// What sets the size.
        beside: &'static str,
        /// The file.
        path: PathBuf,
    },
    /// A light field that cannot be used.
    #[error(transparent)]
    Field(#[from] TrueFieldError),
    /// Nothing to train on.
    #[error("the folder holds no training pictures; expected flowers/, everyday/, photos_depth/ or lightfields/ in it: {}", path.display())]
    Empty {
        /// The folder.
        path: PathBuf,
    },
    /// No maps that nets of ours made.
    #[error("the folder holds no maps of the photos; write them with `teach`: {}", path.display())]
    NoMaps {
        /// The folder.
        path: PathBuf,
    },
    /// Nothing to be judged by.
    #[error("the folder holds no photos with measured depth; expected manifest.jsonl, ID.jpg and ID.nearness.png: {}", path.display())]
    NoDepth {
        /// The folder.
        path: PathBuf,
    },
    /// Numbers that cannot work.
    #[error("{what} is {got}; expected {expected}")]
    Config {
        /// The setting.
        what: &'static str,
        /// Its value.
        got: String,
        /// What it may be.
        expected: &'static str,
    },
}

impl SceneError {
    /// A [`SceneError::Read`].
    pub fn read(what: &'static str, path: &Path, reason: impl ToString, expected: impl Into<String>) -> Self {
        // Decoders end some of their sentences with a line break.
        let reason = reason.to_string().trim_end().to_owned();
        Self::Read { what, reason, expected: expected.into(), path: path.to_owned() }
    }
}
