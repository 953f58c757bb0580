//! A file that was read, and the edit that lies beside it.

use super::words::{Message, message, t};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::errors::sentence;
use crate::io::{self, Opened};
use crate::job::Job;
use crate::scene::{DepthFrom, Found, Recipe, Restored, SeveralAsked, Subject};

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
    pub warnings: Vec<Message>,
    /// The picture that it was made into, and the edit which that carried, where this led here.
    pub restored: Option<(PathBuf, Box<Recipe>)>,
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
        let (sidecar, found) = (Sidecar::None, Found::default());
        Self { subject: Arc::new(subject), sidecar, found, warnings: Vec::new(), restored: None }
    }
}

impl Document {
    /// Reads a file, and the edit that lies beside it. A picture that knows its photo leads to that, with its edit.
    pub fn read(path: &Path, job: &Job) -> Result<Self, String> {
        let opened = io::open(path, job).map_err(|error| sentence(&error))?;
        let mut warnings: Vec<_> = opened.info().warnings.iter().cloned().map(Message::heard).collect();
        if let Opened::Photo(file) = &opened
            && let Some(found) = &file.carried
        {
            match Restored::of(found, path, job) {
                Ok(restored) => return Ok(Self::restored(restored, path)),
                Err(error) => warnings.push(sentence(&error).into()),
            }
        }
        let subject = Subject::whole(opened, path, job).map_err(|error| sentence(&error))?;
        Ok(Self::with_sidecar(subject, path, warnings))
    }

    /// Reads photos of one subject, and the edit that lies beside the first of them.
    pub fn read_several(paths: &[PathBuf], asked: SeveralAsked, job: &Job) -> Result<Self, String> {
        let subject = Subject::open_several(paths, asked, job).map_err(|error| sentence(&error))?;
        let Some(path) = subject.path.clone() else { return Ok(subject.into()) };
        let mut document = Self::with_sidecar(subject, &path, Vec::new());
        // The edit may be of the first photo alone; now they are looked at together.
        if let Sidecar::Read(recipe) = &mut document.sidecar {
            recipe.depth = Some(DepthFrom::Auto);
        }
        Ok(document)
    }

    fn with_sidecar(subject: Subject, path: &Path, mut warnings: Vec<Message>) -> Self {
        let has_edit = subject.photo().is_some();
        let (recipe, found) = if has_edit { Recipe::found_beside(path) } else { (Ok(None), Found::default()) };
        let sidecar = match recipe {
            Ok(recipe) => recipe.map_or(Sidecar::None, |recipe| Sidecar::Read(Box::new(recipe))),
            Err(error) => {
                warnings.push(sentence(&error).into());
                Sidecar::Unreadable
            }
        };
        Self { subject: Arc::new(subject), sidecar, found, warnings, restored: None }
    }

    /// The photo that a picture was made of.
    fn restored(Restored { subject, recipe }: Restored, picture: &Path) -> Self {
        let file_name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let told = message!("was-made-of", picture = file_name(picture), photo = &subject.name);
        let mut document = match subject.path.clone() {
            Some(photo) => Self::with_sidecar(subject, &photo, Vec::new()),
            None => subject.into(),
        };
        document.warnings.insert(0, told);
        document.restored = Some((picture.to_owned(), Box::new(recipe)));
        document
    }

    /// Where it lies among others: as its picture, where that led here, else as itself.
    pub fn path(&self) -> Option<&Path> {
        self.restored.as_ref().map(|(picture, _)| picture).or(self.subject.path.as_ref()).map(PathBuf::as_path)
    }

    /// The edit that it is shown with first.
    pub fn recipe(&self) -> Option<&Recipe> {
        match (&self.restored, &self.sidecar) {
            (Some((_, recipe)), _) | (None, Sidecar::Read(recipe)) => Some(recipe),
            (None, Sidecar::None | Sidecar::Unreadable) => None,
        }
    }

    /// Where its depth comes from, as its edit says.
    pub fn source(&self) -> Option<&DepthFrom> {
        self.recipe().and_then(|recipe| recipe.depth.as_ref())
    }

    /// "4032 × 3024 · Display P3 · phone depth".
    pub fn facts(&self) -> String {
        let [w, h] = self.subject.size();
        let Some(info) = &self.subject.info else { return t!("size-only", width = w, height = h) };
        let mut parts = vec![t!("size-only", width = info.size[0], height = info.size[1])];
        parts.extend(info.views.map(|[rows, cols]| t!("views-count", cols = cols, rows = rows)));
        parts.extend(info.profile.clone().filter(|name| !name.contains("sRGB")));
        if info.bits > 8 {
            parts.push(t!("bits", bits = info.bits));
        }
        if info.embedded_depth.is_some() {
            parts.push(t!("phone-depth").to_owned());
        }
        parts.join(" · ")
    }
}
