//! What the threads do: open a file and make a light field of it; write files.

use super::adding;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use super::document::Document;
use super::event::Event;
use super::neighbours::{Ahead, Ready};
use super::open::Made;
use super::rays::Rays;
use super::recents;
use super::tiles::TileSet;
use super::words::t;
use super::worker::{JobId, Outbox, Work};
use crate::errors::sentence;
use crate::field::{Photo, RayDepths, View, ViewIndex};
use crate::io::folder;
use crate::job::{Cancel, Job, Progress, Sink};
use crate::scene::{DepthFrom, Maker, Making, Need, Salience, SceneError, SeveralAsked, Subject};

/// Where a picture comes from.
#[derive(Debug)]
pub enum OpenFrom {
    /// A file or folder.
    File(PathBuf),
    /// Photos of one subject, the one that is looked at first.
    Several(Vec<PathBuf>, SeveralAsked),
    /// Pixels of the clipboard, `[y, x, 4]`, and what they are called.
    Pixels([u32; 2], Vec<u8>, &'static str),
    /// The built-in sample.
    Sample,
    /// What is open already, with other settings.
    Again(Box<Document>),
}

impl OpenFrom {
    /// Pixels of the clipboard, `[y, x, 4]`.
    pub fn pasted(size: [u32; 2], rgba: Vec<u8>) -> Self {
        Self::Pixels(size, rgba, t!("pasted-picture"))
    }
}

/// A request to the thread that opens and synthesizes.
#[derive(Debug)]
pub struct Load {
    /// What to open.
    pub from: OpenFrom,
    /// How its light field is made.
    pub making: Making,
}

/// Passes what a computation tells on to the window.
pub struct ToWindow<'a> {
    /// The job.
    pub job: JobId,
    /// The way to the window.
    pub outbox: &'a Outbox,
    /// What stands out in the picture whose ray depths are made.
    pub salience: Salience,
}

impl Sink for ToWindow<'_> {
    fn progress(&self, progress: Progress) {
        self.outbox.send(self.job, Event::Progress(progress));
    }
    fn depths(&self, depths: &Arc<RayDepths>) {
        self.outbox.send(self.job, Event::Rays(Rays::new(Arc::clone(depths), &self.salience)));
    }
    fn view(&self, at: ViewIndex, view: &Arc<View>) {
        self.outbox.send(self.job, Event::View(at, Arc::clone(view)));
    }
    fn warning(&self, text: String) {
        self.outbox.send(self.job, Event::Warning(text.into()));
    }
}

/// Only how far a job is goes to the window: its depths and views are not those that are shown.
pub struct Progressing<'a>(pub JobId, pub &'a Outbox);

impl Sink for Progressing<'_> {
    fn progress(&self, progress: Progress) {
        self.1.send(self.0, Event::Progress(progress));
    }
    fn warning(&self, text: String) {
        log::info!("{text}");
    }
}

/// The work of the thread that opens and synthesizes. `remembers`: whether small pictures of what was opened are kept for
/// the next time.
pub fn loader(maker: Arc<Maker>, ahead: Ahead, remembers: bool) -> impl Work<Load> {
    move |job: JobId, load: Load, cancel: &Cancel, outbox: &Outbox| {
        let sink = |salience| ToWindow { job, outbox, salience };
        let opening = sink(Salience::even());
        let task = Job { cancel, sink: &opening };
        let done = open(&load.from, job, &task, &ahead, outbox).and_then(|document| {
            let Some(document) = document else { return Ok(None) };
            outbox.send(job, Event::Models(adding::listed(&load.making)));
            let making = making_of(&load, &document);
            let task = Job { cancel, sink: &sink(document.subject.salience()) };
            let made = make(&maker, &document.subject, &making, &task)?;
            Ok(Some((document, made)))
        });
        match done {
            _ if cancel.is_cancelled() => {
                outbox.send(job, Event::Stopped);
            }
            Ok(None) => {}
            Ok(Some((document, made))) => {
                outbox.send(job, Event::Made(Box::new(made)));
                if remembers {
                    recents::keep(&document.subject);
                }
            }
            Err(sentence) => {
                outbox.send(job, Event::Failed(sentence.into()));
            }
        }
    }
}

/// How a file's light field is made: its depth from where the edit beside it says.
fn making_of(load: &Load, document: &Document) -> Making {
    let making = load.making.clone();
    match (&load.from, document.source()) {
        (OpenFrom::Several(..), _) => Making { source: DepthFrom::Auto, ..making },
        (OpenFrom::File(_), Some(source)) => Making { source: source.clone(), ..making },
        _ => making,
    }
}

fn make(maker: &Maker, subject: &Arc<Subject>, making: &Making, job: &Job) -> Result<Made, String> {
    let fail = |error: SceneError| sentence(&error);
    let scene = maker.scene(subject, making, Need::Views, job).map_err(fail)?;
    Made::of(scene).map_err(fail)
}

/// The photos of a folder that was read as the first of them; none where it is one alone, or a light field.
fn photos_of(from: &OpenFrom, document: &Document) -> Option<Vec<PathBuf>> {
    let OpenFrom::File(path) = from else { return None };
    let is_of_photos = path.is_dir() && document.subject.photo().is_some();
    is_of_photos.then(|| folder::pictures(path).ok()).flatten().filter(|photos| photos.len() > 1)
}

/// Reads a file and tells the window at once, with the picture ready for the screen. None where a person is asked first.
fn open(from: &OpenFrom, job_id: JobId, job: &Job, ahead: &Ahead, outbox: &Outbox) -> Result<Option<Document>, String> {
    let started = Instant::now();
    let mut tiles = None;
    let document = match from {
        OpenFrom::Again(document) => return Ok(Some((**document).clone())),
        OpenFrom::File(path) => match ahead.take(path) {
            Some(Ready { document, tiles: ready }) => {
                tiles = Some(ready);
                document
            }
            None => Document::read(path, job)?,
        },
        OpenFrom::Several(paths, asked) => Document::read_several(paths, *asked, job)?,
        OpenFrom::Pixels(size, rgba, name) => {
            let mut rgba = rgba.clone();
            rgba.chunks_exact_mut(4).for_each(|pixel| pixel[3] = 255);
            let photo = Photo::from_srgb8(*size, rgba).map_err(|error| sentence(&error))?;
            Subject::from_photo(Arc::new(photo), name).into()
        }
        OpenFrom::Sample => Subject::sample().map_err(|error| sentence(&error))?.into(),
    };
    if let Some(photos) = photos_of(from, &document) {
        outbox.send(job_id, Event::Several(photos));
        return Ok(None);
    }
    let photo = document.subject.photo().filter(|_| tiles.is_none());
    let preview = photo.and_then(|photo| TileSet::preview(photo.size(), photo.srgb8()).map(Arc::new));
    let depths = document.subject.recorded().and_then(|recorded| recorded.depths.clone());
    let rays = depths.map(|depths| Rays::new(depths, &document.subject.salience()));
    outbox.send(job_id, Event::Opened(Box::new(document.clone()), rays, tiles.or(preview)));
    log::debug!("{}: on its way to the screen after {:.3} s", document.subject.name, started.elapsed().as_secs_f64());
    if let Some(photo) = photo {
        outbox.send(job_id, Event::Tiles(Arc::new(TileSet::new(photo.size(), photo.srgb8()))));
    }
    Ok(Some(document))
}
