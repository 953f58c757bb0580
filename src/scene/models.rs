//! Depth nets of other people, tried on the built-in sample, whose depth is known.

use std::path::Path;

use crate::field::View;
use crate::io::sample::{Sample, sample};
use crate::job::Job;
use crate::synth::adopt::{AdoptError, Adopted, Known, Shelf, adopt};

/// Tries a net on the sample and puts it on a shelf under a name; by default that of its file.
///
/// With `force` it may replace another of that name, and need not find the sample's depth.
///
/// # Errors
/// [`AdoptError`]; then the shelf is as it was.
pub fn add(path: &Path, name: Option<&str>, shelf: &Shelf, force: bool, job: &Job) -> Result<Adopted, AdoptError> {
    let file_name = path.file_stem().unwrap_or_default().to_string_lossy();
    let name = name.unwrap_or(&file_name);
    shelf.check(name, force)?;
    let odd = |error: crate::field::FieldError| AdoptError::NotDepth { why: error.to_string() };
    let Sample { photo, disparity } = sample().map_err(odd)?;
    let view = View::new(photo.size(), photo.srgb8().to_vec()).map_err(odd)?;
    let mut net = adopt(path, Known { view: &view, disparity: &disparity }, force, job)?;
    name.clone_into(&mut net.manifest.id);
    shelf.put(path, &net, force, job)?;
    Ok(net)
}
