//! Why there is nothing to judge.

use std::path::PathBuf;

use plenoscope::io::save::SaveError;

/// Why an evaluation fails.
#[derive(Debug, thiserror::Error)]
pub enum EvalError {
    /// Nothing to evaluate on.
    #[error("no validation pictures; expected flowers/ or everyday/ with `split` val in their manifests: {}", .0.display())]
    NoPhotos(PathBuf),
    /// Writing a contact sheet failed.
    #[error("{0}")]
    Save(#[from] SaveError),
}
