//! Training a net on one's own light fields, while the window stays usable: what it tells, and the thread that listens.

use std::path::Path;
use std::sync::Arc;
use std::time::SystemTime;

use egui::{ColorImage, Context, TextureHandle, TextureOptions};

use super::adding;
use super::dialog::Dialog;
use super::event::Event;
use super::window::Window;
use super::words::{Message, message};
use super::worker::{JobId, Outbox};
use crate::errors::sentence;
use crate::job::{Cancel, Job};
use crate::scene::training::{Run, Told, Trainer, TrainingError};
use crate::scene::{DepthFrom, Making};

/// What is trained, and what it has told.
#[derive(Default)]
pub struct Training {
    /// The run that is looked at.
    pub run: Option<Run>,
    /// What it has told.
    pub told: Told,
    /// Its contact sheet.
    pub sheet: Option<TextureHandle>,
    /// The job, while one is under way; and whether it has been asked to end.
    pub running: Option<(JobId, bool)>,
}

/// What is wanted of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// Train, from where the run stands.
    Train,
    /// Save and rest.
    Rest,
    /// Use its net for what is open, beside the one before.
    Use,
}

/// What the thread is asked for.
pub enum Request {
    /// Train.
    Train(Trainer, Run),
    /// Put the net where nets are chosen.
    Use(Trainer, Run, Box<Making>),
}

/// What the thread tells.
pub enum Answer {
    /// What the run says.
    Told(Told),
    /// A new contact sheet.
    Sheet(Arc<ColorImage>),
    /// The trainer has saved and ended.
    Rests,
    /// The net is where nets are chosen.
    Net(DepthFrom),
    /// It went wrong.
    Failed(Message),
}

/// The thread's work.
pub fn work(job: JobId, request: Request, cancel: &Cancel, outbox: &Outbox) {
    let answer = |answer| outbox.send(job, Event::Training(answer));
    let done = match &request {
        Request::Train(trainer, run) => train(trainer, run, cancel, &answer).map(|()| Answer::Rests),
        Request::Use(trainer, run, making) => put(trainer, run, making).map(|source| {
            outbox.send(job, Event::Models(adding::listed(making)));
            Answer::Net(source)
        }),
    };
    answer(done.unwrap_or_else(Answer::Failed));
}

fn train(trainer: &Trainer, run: &Run, cancel: &Cancel, answer: &dyn Fn(Answer) -> bool) -> Result<(), Message> {
    let mut drawn: Option<SystemTime> = None;
    let mut tell = |told: Told| {
        if let Some((path, time)) = told.sheet.as_ref().filter(|(_, time)| drawn != Some(*time)) {
            drawn = Some(*time);
            picture(path).map(|image| answer(Answer::Sheet(Arc::new(image))));
        }
        answer(Answer::Told(told));
    };
    trainer.train(run, &Job { cancel, sink: &() }, &mut tell).map_err(|error| said(&error))
}

fn put(trainer: &Trainer, run: &Run, making: &Making) -> Result<DepthFrom, Message> {
    let shelf = making.shelf.as_ref().ok_or(message!("no-folder-for-nets"))?;
    let tag = trainer.export(run, shelf).map_err(|error| said(&error))?;
    Ok(DepthFrom::Net(tag))
}

fn said(error: &TrainingError) -> Message {
    sentence(error).into()
}

/// The sheet, as it is; none while it cannot be read.
fn picture(path: &Path) -> Option<ColorImage> {
    let picture = image::open(path).ok()?.to_rgba8();
    let size = [picture.width() as usize, picture.height() as usize];
    Some(ColorImage::from_rgba_unmultiplied(size, picture.as_raw()))
}

impl Training {
    /// Whether the trainer is at work.
    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }
}

/// A folder of light fields was chosen.
pub fn choose(window: &mut Window, data: &Path) {
    match window.making().shelf.and_then(|shelf| Run::of(data, &shelf)) {
        Some(run) if window.training.running.is_none() => {
            window.training = Training { told: run.told(), run: Some(run), ..Training::default() };
            window.dialog = Some(Dialog::Training);
        }
        Some(_) => window.toasts.error(message!("training-another")),
        None => window.toasts.error(message!("no-folder-for-nets")),
    }
}

/// Does what is wanted.
pub fn obey(window: &mut Window, wanted: Wanted) {
    let Some(run) = window.training.run.clone() else { return };
    let trainer = match window.trainer() {
        Ok(trainer) => trainer,
        Err(error) => return window.toasts.error(said(&error)),
    };
    match wanted {
        Wanted::Train if !window.training.is_running() => {
            let job = window.workers.trainer.push(Request::Train(trainer, run));
            window.training.running = Some((job, false));
        }
        Wanted::Rest => {
            if let Some((job, is_ending)) = &mut window.training.running {
                *is_ending = true;
                if window.workers.trainer.cancel(*job) {
                    window.training.running = None;
                }
            }
        }
        Wanted::Use if !window.training.is_running() => {
            let job = window.workers.trainer.push(Request::Use(trainer, run, Box::new(window.making())));
            window.training.running = Some((job, false));
        }
        Wanted::Train | Wanted::Use => {}
    }
}

/// Takes in what the thread tells; gives the net that is to be used.
pub fn take(window: &mut Window, answer: Answer, ctx: &Context) -> Option<DepthFrom> {
    let training = &mut window.training;
    match answer {
        Answer::Told(told) => {
            training.told = told;
            return None;
        }
        Answer::Sheet(image) => {
            training.sheet = Some(ctx.load_texture("training", image, TextureOptions::LINEAR));
            return None;
        }
        Answer::Rests => {}
        Answer::Failed(why) => window.toasts.error(why),
        Answer::Net(source) => {
            training.running = None;
            window.dialog = None;
            return Some(source);
        }
    }
    training.running = None;
    None
}
