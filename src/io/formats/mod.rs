//! Light-field and depth formats: one file each.

pub mod depth_map;
mod grid_names;
mod matching;
pub mod pfm;
pub(crate) mod phone;
pub mod views;

use std::path::Path;

use super::sniff::Sniffed;
use super::{LightFieldFile, Problem};
use crate::job::Job;

/// Files that stand for the folder they lie in.
pub(crate) fn is_index_file(path: &Path) -> bool {
    let name = path.file_name().map(|n| n.to_string_lossy().to_lowercase()).unwrap_or_default();
    matches!(name.as_str(), "lightfield.json" | "parameters.cfg") && path.is_file()
}

/// A light field in a folder, or `None` where the folder holds none.
pub(crate) fn read_folder(path: &Path, job: &Job) -> Result<Option<LightFieldFile>, Problem> {
    views::read(path, job)
}

/// A light field in one file, or `None` where the file is an ordinary picture.
pub(crate) fn read_single(
    _bytes: &[u8],
    _format: Sniffed,
    _name: Option<&Path>,
    _job: &Job,
) -> Result<Option<LightFieldFile>, Problem> {
    Ok(None)
}
