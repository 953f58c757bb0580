//! What a function works on: a path, a photo, a light field or an array.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use plenoscope::job::Job;
use plenoscope::scene::asked::{How, Output};
use plenoscope::scene::{Maker, Need, Scene, SceneError, Subject};
use pyo3::prelude::*;

use crate::arrays;
use crate::errors::wrong_type;
use crate::light_field::LightField;
use crate::options::Options;
use crate::photo::{Photo, of_array};

/// Where scenes come from.
pub enum Input {
    /// A file or a folder, which is opened.
    Path(PathBuf),
    /// What is open.
    Open(Arc<Subject>),
    /// What is made.
    Made(Scene),
}

impl Input {
    /// Of what was handed over. The scene of a light field is made here, once.
    pub fn of(value: &Bound<'_, PyAny>, options: &Options) -> PyResult<Self> {
        if let Ok(photo) = value.cast::<Photo>() {
            return Ok(Self::Open(Arc::clone(&photo.get().subject)));
        }
        if let Ok(field) = value.cast::<LightField>() {
            return Ok(Self::Made(field.get().scene(value.py(), progress(options)?.as_ref())?.clone()));
        }
        if arrays::is_array(value)? {
            return Ok(Self::Open(of_array(value, "photo")?));
        }
        let wanted = "a path, a Photo, a LightField or an array [y, x, c]";
        value.extract().map(Self::Path).map_err(|_no_path| wrong_type("input", wanted, value))
    }

    /// What it is a scene of; a file is opened.
    pub fn subject(&self, how: &How, job: &Job) -> Result<Arc<Subject>, SceneError> {
        match self {
            Self::Path(path) => how.open(path, job),
            Self::Open(subject) => Ok(how.subject(Subject::clone(subject))),
            Self::Made(scene) => Ok(Arc::clone(scene.subject())),
        }
    }

    /// A scene of which as much is made as is needed.
    pub fn scene(&self, how: &How, maker: &Maker, need: Need, job: &Job) -> Result<Scene, SceneError> {
        match self {
            Self::Made(scene) => how.made(scene, job),
            _ => how.scene(&self.subject(how, job)?, maker, need, job),
        }
    }

    /// The file, where there is one.
    fn path(&self) -> Option<&Path> {
        match self {
            Self::Path(path) => Some(path),
            Self::Open(subject) => subject.path.as_deref(),
            Self::Made(scene) => scene.subject().path.as_deref(),
        }
    }

    /// A file to write that must not be this one.
    pub fn output<'a>(&'a self, file: &'a Path, force: bool) -> Output<'a> {
        Output { file, input: self.path(), force }
    }
}

/// What is told how far the work is.
pub fn progress(options: &Options) -> PyResult<Option<Py<PyAny>>> {
    let callback = options.any("progress")?;
    match callback {
        Some(callback) if !callback.is_callable() => Err(wrong_type("progress", "something to call", &callback)),
        callback => Ok(callback.map(Bound::unbind)),
    }
}
