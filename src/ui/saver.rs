//! The thread that writes: one export after the other.

use std::path::PathBuf;
use std::sync::Arc;

use super::event::Event;
use super::jobs::Progressing;
use super::worker::{JobId, Outbox, Work};
use crate::errors::sentence;
use crate::job::{Cancel, Job, Stage};
use crate::scene::export::{self, FileExport, Settings, Written};
use crate::scene::{Edit, Maker, Making, Need, Recipe, Scene, SceneError};

/// What is open, as it is seen now.
pub struct Shown {
    /// What it is made of.
    pub scene: Scene,
    /// What is done to it.
    pub edit: Edit,
    /// What is written, and how.
    pub settings: Settings,
    /// Where; none puts the picture into the clipboard.
    pub target: Option<PathBuf>,
}

/// A photo that is not open: it is opened, as much of it is made as is needed, and it is written.
pub struct Queued {
    /// The photo.
    pub path: PathBuf,
    /// The edit.
    pub recipe: Recipe,
    /// What is written, and how.
    pub settings: Settings,
    /// Where.
    pub target: PathBuf,
    /// How its depth is made.
    pub making: Making,
}

/// A request to the thread that writes.
pub enum Order {
    /// What is open.
    Shown(Box<Shown>),
    /// Another photo.
    File(Box<Queued>),
}

/// The work of the thread that writes.
pub fn worker(maker: Arc<Maker>) -> impl Work<Order> {
    move |job: JobId, order: Order, cancel: &Cancel, outbox: &Outbox| {
        let told = Progressing(job, outbox);
        let task = Job { cancel, sink: &told };
        let done = match order {
            Order::Shown(shown) => shown.run(&task),
            Order::File(queued) => queued.run(&maker, &task),
        };
        outbox.send(
            job,
            match done {
                Err(_) if cancel.is_cancelled() => Event::Stopped,
                Ok(event) => event,
                Err(error) => Event::Failed(sentence(&error).into()),
            },
        );
    }
}

impl Shown {
    fn run(&self, job: &Job) -> Result<Event, SceneError> {
        let Self { scene, edit, settings, target } = self;
        job.advance(Stage::Save, 0, 1)?;
        let scene = scene.at_strength(edit.strength, &Making::default(), Need::Views, job)?;
        let Some(target) = target else {
            return Ok(Event::Copied(Arc::new(scene.shown(edit, settings.picture.size, job)?)));
        };
        let Some(free) = settings.existing.resolve(target) else { return Ok(Event::Skipped(target.clone())) };
        export::write(&scene, edit, settings, &free, job)?;
        Ok(Event::Saved(free))
    }
}

impl Queued {
    fn run(&self, maker: &Maker, job: &Job) -> Result<Event, SceneError> {
        let Self { path, recipe, settings, target, making } = self;
        job.advance(Stage::Open, 0, 1)?;
        let export = FileExport { path, own_map: None, recipe, settings, target, maker, making };
        Ok(match export.run(job)? {
            Written::Saved(path) => Event::Saved(path),
            Written::Skipped(path) => Event::Skipped(path),
        })
    }
}
