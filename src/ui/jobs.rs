//! What the threads do: open a file and make a light field of it; write files.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use super::document::{Document, Survey};
use super::neighbours::{Ahead, Ready};
use super::recents;
use super::state::Source;
use super::tiles::TileSet;
use super::worker::{Event, JobId, Outbox, Work};
use crate::errors::sentence;
use crate::field::{Photo, RayDepths, View, ViewIndex};
use crate::io;
use crate::job::{Cancel, Job, Progress, Sink};
use crate::recipe::Recipe;
use crate::synth::ModelSource;

/// Where a picture comes from.
#[derive(Debug)]
pub enum From {
    /// A file or folder.
    File(PathBuf),
    /// Pixels of the clipboard, `[y, x, 4]`.
    Pixels([u32; 2], Vec<u8>),
    /// The built-in sample.
    Sample,
    /// What is open already, with other settings.
    Again(Box<Document>),
}

/// A request to the thread that opens and synthesizes.
#[derive(Debug)]
pub struct Load {
    /// What to open.
    pub from: From,
    /// Long side of a view, in pixels.
    pub long_side: u32,
    /// Whether the occlusion net corrects the views.
    pub occlusion: bool,
    /// Where ray depths come from.
    pub source: Source,
    /// Where the nets come from.
    pub models: ModelSource,
}

/// Passes what a computation tells on to the window.
struct ToWindow<'a> {
    job: JobId,
    outbox: &'a Outbox,
}

impl Sink for ToWindow<'_> {
    fn progress(&self, progress: Progress) {
        self.outbox.send(self.job, Event::Progress(progress));
    }
    fn depths(&self, depths: &Arc<RayDepths>) {
        let survey = Arc::new(Survey::new(depths));
        self.outbox.send(self.job, Event::Depths(Arc::clone(depths), survey));
    }
    fn view(&self, at: ViewIndex, view: &Arc<View>) {
        self.outbox.send(self.job, Event::View(at, Arc::clone(view)));
    }
    fn warning(&self, text: String) {
        self.outbox.send(self.job, Event::Warning(text));
    }
}

/// The work of the thread that opens and synthesizes; it keeps the nets once they are loaded. `remembers`: whether small
/// pictures of what was opened are kept for the next time.
pub fn loader(threads: usize, ahead: Ahead, remembers: bool) -> impl Work<Load> {
    let mut maker = super::maker::Maker::new(threads);
    move |job: JobId, load: Load, cancel: &Cancel, outbox: &Outbox| {
        let sink = ToWindow { job, outbox };
        let done = open(&load.from, job, &Job { cancel, sink: &sink }, &ahead, outbox)
            .and_then(|document| maker.make(&document, &load, &Job { cancel, sink: &sink }));
        match done {
            _ if cancel.is_cancelled() => {
                outbox.send(job, Event::Stopped);
            }
            Ok(made) => {
                log::debug!("{}: a light field in {:.3} s", made.of.name, made.took_secs);
                let document = made.of.clone();
                outbox.send(job, Event::Made(Box::new(made)));
                outbox.send(job, Event::Models(load.models.further_models()));
                if remembers {
                    recents::keep(&document);
                }
            }
            Err(sentence) => {
                outbox.send(job, Event::Failed(sentence));
            }
        }
    }
}

/// Reads a file, and the edit that lies beside it.
pub fn read(path: &Path, job: &Job) -> Result<Document, String> {
    let opened = io::open(path, job).map_err(|error| sentence(&error))?;
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let mut document = Document::new(opened, Some(path), &name);
    if document.photo.is_some() {
        match Recipe::of_photo(path) {
            Ok(recipe) => document.recipe = recipe.map(Box::new),
            Err(error) => document.warnings.push(sentence(&error)),
        }
    }
    Ok(document)
}

/// Reads a file and tells the window at once, with the picture ready for the screen.
fn open(from: &From, job_id: JobId, job: &Job, ahead: &Ahead, outbox: &Outbox) -> Result<Document, String> {
    let started = Instant::now();
    let mut tiles = None;
    let document = match from {
        From::Again(document) => return Ok((**document).clone()),
        From::File(path) => match ahead.take(path) {
            Some(Ready { document, tiles: ready }) => {
                tiles = Some(ready);
                document
            }
            None => read(path, job)?,
        },
        From::Pixels(size, rgba) => {
            let mut rgba = rgba.clone();
            rgba.chunks_exact_mut(4).for_each(|pixel| pixel[3] = 255);
            let photo = Photo::from_srgb8(*size, rgba).map_err(|error| sentence(&error))?;
            of_photo(photo.into(), "Pasted picture")
        }
        From::Sample => {
            let sample = io::sample::sample().map_err(|error| sentence(&error))?;
            Document { reference: Some(Arc::new(sample.disparity)), ..of_photo(sample.photo, "Sample") }
        }
    };
    let photo = document.photo.as_ref().filter(|_| tiles.is_none());
    let preview = photo.and_then(|photo| TileSet::preview(photo.size(), photo.srgb8()).map(Arc::new));
    outbox.send(job_id, Event::Opened(Box::new(document.clone()), tiles.or(preview)));
    log::debug!("{}: on its way to the screen after {:.3} s", document.name, secs_since(started));
    if let Some(photo) = photo {
        outbox.send(job_id, Event::Tiles(Arc::new(TileSet::new(photo.size(), photo.srgb8()))));
    }
    Ok(document)
}

fn of_photo(photo: Arc<Photo>, name: &str) -> Document {
    let [w, h] = photo.size();
    Document { name: name.to_owned(), facts: format!("{w} × {h}"), photo: Some(photo), ..Document::default() }
}

/// How long something took.
pub fn secs_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64()
}
