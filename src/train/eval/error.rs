//! Why there is nothing to judge.

use std::path::PathBuf;

use plenoscope::io::save::SaveError;

/// Why an evaluation fails.
#[derive(Debug, thiserror::Error)]
pub enum EvalError {
    /// Nothing to evaluate on.
    #[error("no validation pictures; expected flowers/ or everyday/ with `split` val in their manifests: {}", .0.display())]
    NoPhotos(PathBuf),
    /// A photo without any truth.
    #[error("this photo has no depth of its own to compare with; expected a light field, or a photo with the phone's depth in it: {}", .0.display())]
    NoDepth(PathBuf),
    /// Writing a contact sheet failed.
    #[error("{0}")]
    Save(#[from] SaveError),
}
