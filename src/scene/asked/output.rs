//! Where something is written to, and what it must not write over.

use std::path::{Path, PathBuf};

use super::Usage;
use crate::aside;
use crate::io::save::{self, SaveError};
use crate::scene::export::{Group, KINDS, Kind, Settings, Spec};
use crate::scene::{Edit, SceneError, Subject};

/// A file to write, and the input that must stay as it is unless `force` says otherwise.
#[derive(Clone, Copy, Debug)]
pub struct Output<'a> {
    /// The file, or a folder.
    pub file: &'a Path,
    /// What it is made from, where that is a file.
    pub input: Option<&'a Path>,
    /// Whether the input may be written over.
    pub force: bool,
}

impl Output<'_> {
    /// Refuses what would write over the input, before any work is done.
    ///
    /// # Errors
    /// The sentence for it; also where a folder stands for the file.
    pub fn check(&self) -> Result<(), SceneError> {
        if !self.force && self.input.is_some_and(|input| self.hits(input)) {
            return Err(SceneError::Refused(format!(
                "the output is the input — it would be lost — choose another name or add --force: {}",
                self.file.display()
            )));
        }
        if self.file.is_dir() {
            return Err(SceneError::Refused(format!(
                "the output is a folder — a file is written — name a file in it: {}",
                self.file.display()
            )));
        }
        Ok(())
    }

    /// The same for what is written of a kind: of several files only the folder itself must not be the input.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn check_written(&self, kind: Kind) -> Result<(), SceneError> {
        if !kind.is_folder() {
            return self.check();
        }
        if !self.force && self.input.is_some_and(|input| save::same_file(self.file, input)) {
            return Err(SceneError::Refused(format!(
                "the output is the input — it would be lost — choose another name: {}",
                self.file.display()
            )));
        }
        Ok(())
    }

    /// Whether the file is the input, or lies in a folder that is the input.
    fn hits(&self, input: &Path) -> bool {
        save::same_file(self.file, input)
            || (self.file.exists() && input.is_dir() && save::same_file(aside::parent(self.file), input))
    }
}

/// Refuses a recorded light field where views are to be made.
///
/// # Errors
/// The sentence for it.
pub fn check_is_photo(subject: &Subject) -> Result<(), SceneError> {
    if subject.photo().is_some() {
        return Ok(());
    }
    let place = subject.path.as_ref().map_or_else(|| subject.name.clone(), |path| path.display().to_string());
    Err(SceneError::Refused(format!(
        "this is a light field already — synth takes a photo — use `plenoscope export`: {place}"
    )))
}

/// Where a light field is written: formats of one file go into a folder that is named, under the name that readers know.
pub fn field_target(output: &Path, settings: &Settings, name: &str) -> PathBuf {
    let is_file = output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    match settings.kind {
        Kind::Eslf if !is_file => output.join(settings.file_name(name, &Edit::default())),
        Kind::Quilt if is_file => settings.device().path(output),
        Kind::Quilt => output.join(settings.file_name(name, &Edit::default())),
        _ => output.to_owned(),
    }
}

/// Light fields may go into a folder that is not there yet.
///
/// # Errors
/// The system's, as a sentence.
pub fn make_folder(target: &Path) -> Result<(), SceneError> {
    let folder = aside::parent(target);
    Ok(std::fs::create_dir_all(folder).map_err(|error| SaveError::from_io(&error, folder))?)
}

/// The formats that hold a whole light field.
pub fn field_formats() -> impl Iterator<Item = &'static Spec> {
    KINDS.iter().filter(|spec| spec.group == Group::LightField)
}

/// The format of a light field that a name stands for.
///
/// # Errors
/// The names there are.
pub fn field_format(id: &str) -> Result<Kind, Usage> {
    field_formats().find(|spec| spec.id == id).map(|spec| spec.kind).ok_or_else(|| {
        let names: Vec<&str> = field_formats().map(|spec| spec.id).collect();
        Usage(format!("there is no format {id:?} — a light field is written as one — name {}", names.join(", ")))
    })
}
