//! A file that was read, and the edit that lies beside it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::errors::sentence;
use crate::io;
use crate::job::Job;
use crate::scene::{DepthFrom, Found, Recipe, SeveralAsked, Subject};

/// What was read.
#[derive(Clone, Debug)]
pub struct Document {
    /// The photo or the light field.
    pub subject: Arc<Subject>,
    /// The edit beside it.
    pub sidecar: Sidecar,
    /// What the file of that edit held.
    pub found: Found,
    /// What a person should know about it.
    pub warnings: Vec<String>,
}

/// The edit that lies beside a photo.
#[derive(Clone, Debug, Default)]
pub enum Sidecar {
    /// There is none yet, or none can be.
    #[default]
    None,
    /// It was read.
    Read(Box<Recipe>),
    /// It could not be read, of a later version perhaps: it must not be written over.
    Unreadable,
}

impl From<Subject> for Document {
    fn from(subject: Subject) -> Self {
        Self { subject: Arc::new(subject), sidecar: Sidecar::None, found: Found::default(), warnings: Vec::new() }
    }
}

impl Document {
    /// Reads a file, and the edit that lies beside it.
    pub fn read(path: &Path, job: &Job) -> Result<Self, String> {
        let opened = io::open(path, job).map_err(|error| sentence(&error))?;
        let warnings = opened.info().warnings.clone();
        let subject = Subject::whole(opened, path, job).map_err(|error| sentence(&error))?;
        Ok(Self::with_sidecar(subject, path, warnings))
    }

    /// Reads photos of one subject, and the edit that lies beside the first of them.
    pub fn read_several(paths: &[PathBuf], job: &Job) -> Result<Self, String> {
        let subject = Subject::open_several(paths, SeveralAsked::default(), job).map_err(|error| sentence(&error))?;
        let Some(path) = subject.path.clone() else { return Ok(subject.into()) };
        let mut document = Self::with_sidecar(subject, &path, Vec::new());
        // The edit may be of the first photo alone; now they are looked at together.
        if let Sidecar::Read(recipe) = &mut document.sidecar {
            recipe.depth = Some(DepthFrom::Auto);
        }
        Ok(document)
    }

    fn with_sidecar(subject: Subject, path: &Path, mut warnings: Vec<String>) -> Self {
        let has_edit = subject.photo().is_some();
        let (recipe, found) = if has_edit { Recipe::found_beside(path) } else { (Ok(None), Found::default()) };
        let sidecar = match recipe {
            Ok(recipe) => recipe.map_or(Sidecar::None, |recipe| Sidecar::Read(Box::new(recipe))),
            Err(error) => {
                warnings.push(sentence(&error));
                Sidecar::Unreadable
            }
        };
        Self { subject: Arc::new(subject), sidecar, found, warnings }
    }

    /// Where its depth comes from, as the edit beside it says.
    pub fn source(&self) -> Option<&DepthFrom> {
        if let Sidecar::Read(recipe) = &self.sidecar { recipe.depth.as_ref() } else { None }
    }

    /// "4032 × 3024 · Display P3 · phone depth".
    pub fn facts(&self) -> String {
        let [w, h] = self.subject.size();
        let Some(info) = &self.subject.info else { return format!("{w} × {h}") };
        let mut parts = vec![format!("{} × {}", info.size[0], info.size[1])];
        parts.extend(info.views.map(|[rows, cols]| format!("{cols} × {rows} views")));
        parts.extend(info.profile.clone().filter(|name| !name.contains("sRGB")));
        if info.bits > 8 {
            parts.push(format!("{} bits", info.bits));
        }
        if info.embedded_depth.is_some() {
            parts.push("phone depth found".to_owned());
        }
        parts.join(" · ")
    }
}
