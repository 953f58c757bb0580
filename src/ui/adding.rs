//! The thread that tries depth nets of other people and keeps them.

use std::path::PathBuf;
use std::sync::Arc;

use super::event::{Event, Listed};
use super::jobs::ToWindow;
use super::worker::{JobId, Outbox, Work};
use crate::errors::sentence;
use crate::job::{Cancel, Job};
use crate::scene::{Maker, Making, models};
use crate::synth::adopt::{AdoptError, Shelf};

/// What is done with nets, and where they lie.
pub struct Request {
    /// What is done.
    pub what: Change,
    /// How light fields are made: where the nets lie.
    pub making: Making,
}

/// What is done with nets.
pub enum Change {
    /// Try a file on the sample, and keep it.
    Add(PathBuf),
    /// Use one for all photos without depth of their own; none is the program's own.
    Prefer(Option<String>),
    /// Take one away.
    Remove(String),
}

/// The thread's work. The nets that are kept warm are forgotten, as one of them may be another now.
pub fn worker(maker: Arc<Maker>) -> impl Work<Request> {
    move |job: JobId, request: Request, cancel: &Cancel, outbox: &Outbox| {
        let sink = ToWindow { job, outbox };
        let task = Job { cancel, sink: &sink };
        let Some(shelf) = request.making.shelf.clone() else {
            let text = "the system names no folder for nets — set HOME — then add it again";
            outbox.send(job, Event::Failed(text.to_owned()));
            return;
        };
        let event = match change(&request.what, &shelf, &task) {
            Ok(event) => event,
            Err(AdoptError::Cancelled(_)) => Event::Stopped,
            Err(error) => Event::Failed(sentence(&error)),
        };
        maker.forget_nets();
        outbox.send(job, Event::Models(listed(&request.making)));
        outbox.send(job, event);
    }
}

fn change(what: &Change, shelf: &Shelf, job: &Job) -> Result<Event, AdoptError> {
    match what {
        Change::Add(file) => {
            let net = models::add(file, None, shelf, false, job)?;
            Ok(Event::Added { name: net.manifest.id.clone(), text: format!("Added {}", net.summary()) })
        }
        Change::Prefer(name) => shelf.prefer(name.as_deref()).map(|()| Event::Stopped),
        Change::Remove(name) => shelf.remove(name).map(|()| Event::Stopped),
    }
}

/// All depth nets beside the pair's own, broken ones with their reason.
pub fn listed(making: &Making) -> Vec<Listed> {
    let plain = |name: String| Listed { name, fault: None, is_preferred: false, is_added: false };
    let mut nets: Vec<Listed> = making.models.further_models().into_iter().map(plain).collect();
    for net in making.shelf.iter().flat_map(Shelf::nets) {
        let fault = net.manifest.err().map(|error| sentence(&error));
        nets.push(Listed { name: net.name, fault, is_preferred: net.is_preferred, is_added: true });
    }
    nets
}
