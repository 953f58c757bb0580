//! Why a recipe could not be read or kept.

use std::path::PathBuf;

use crate::io::save::SaveError;

/// Why a recipe could not be read or kept.
#[derive(Debug, thiserror::Error)]
pub enum RecipeError {
    /// The file could not be read.
    #[error("the recipe cannot be read — {why}: {}", .path.display())]
    Read {
        /// What the system says.
        why: String,
        /// The file.
        path: PathBuf,
    },
    /// It is not a recipe of this program.
    #[error("this recipe cannot be used — {why} — make one with \"Copy edit\" or write the sidecar of a photo anew: {}", .path.display())]
    Parse {
        /// What is wrong, and where.
        why: String,
        /// The file.
        path: PathBuf,
    },
    /// The sidecar could not be written.
    #[error(transparent)]
    Save(#[from] SaveError),
}
