//! The window's own dialogs, each with what it is about.

use std::path::PathBuf;

use super::added::Shown;
use super::ask::PathFor;
use super::near_end::Question;
use crate::crash::Report;

/// A dialog of the window's own.
pub enum Dialog {
    /// What is exported, how and where: of these photos, or of what is open where there are none.
    Export(Vec<PathBuf>),
    /// All keys.
    Shortcuts,
    /// A box for a path, where the system shows no dialogs.
    Path(PathFor, String),
    /// What is not part of an edit.
    Settings,
    /// Training on one's own light fields.
    Training,
    /// Lenses and exports by name, and the name for a new one.
    Presets {
        /// Those there are.
        names: Vec<String>,
        /// What a new one is called.
        new: String,
    },
    /// Which end of a depth map is near.
    NearEnd(Question),
    /// The program broke off the last time.
    Broke(Box<Broke>),
    /// A depth net was added.
    Added(Box<Shown>),
    /// Several files were dropped: one subject, open the first, or export them all.
    Many(Vec<PathBuf>),
}

/// A fault of the last time.
pub struct Broke {
    /// What was kept of it.
    pub report: Report,
    /// Whether it is shown.
    pub is_shown: bool,
}
