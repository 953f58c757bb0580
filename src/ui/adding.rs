//! The thread that tries depth nets of other people and keeps them.

use std::path::PathBuf;
use std::sync::Arc;

use egui::{Color32, ColorImage};

use super::event::{Event, Listed};
use super::jobs::ToWindow;
use super::near_end;
use super::words::{self, Id, Message, id, message};
use super::worker::{JobId, Outbox, Work};
use crate::errors::sentence;
use crate::job::{Cancel, Job};
use crate::scene::{DepthFrom, Maker, Making, Salience, Subject, models};
use crate::synth::adopt::{AdoptError, Adopted, Shelf, Shelved};
use crate::synth::{ModelTag, reference_view};

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

/// A net that was added, as the window shows it.
pub struct Card {
    /// The net as a source of depth.
    pub source: DepthFrom,
    /// Its name.
    pub name: String,
    /// Name and value of what a person wants to know: family, size, time, licence, correlation.
    pub facts: Vec<(Id, Message)>,
    /// What a person must know before using its pictures.
    pub warning: Option<&'static str>,
    /// The sample, and what the net says of it; small, near is yellow.
    pub pictures: [Arc<ColorImage>; 2],
}

impl Card {
    fn new(net: &Adopted) -> Self {
        let licence = match net.manifest.licence.as_str() {
            "" => message!("licence-unknown"),
            licence => Message::heard(licence),
        };
        let facts = vec![
            (id!("fact-family"), net.family.map_or(message!("unknown"), Message::heard)),
            (id!("fact-size"), message!("megabytes", size = words::fixed(net.bytes as f64 / 1e6, 0))),
            (id!("fact-time"), message!("seconds-a-photo", secs = words::fixed(net.seconds, 1))),
            (id!("fact-licence"), licence),
            (id!("fact-order"), message!("correlation", value = words::fixed(net.correlation, 2))),
        ];
        let source = DepthFrom::Net(net.manifest.tag());
        let pictures = [Arc::new(sample()), Arc::new(near_end::small(&net.depth.disparity()))];
        Self { source, name: net.manifest.id.clone(), facts, warning: net.warning, pictures }
    }
}

/// The sample, small. It is drawn by the program itself, so that it is always there.
fn sample() -> ColorImage {
    let view = Subject::sample().ok().and_then(|sample| {
        reference_view(sample.photo()?, near_end::PREVIEW, &Job { cancel: &Cancel::default(), sink: &() }).ok()
    });
    let Some(view) = view else { return ColorImage::filled([1, 1], Color32::BLACK) };
    ColorImage::from_rgba_unmultiplied(view.size().map(|side| side as usize), view.rgba())
}

/// The thread's work. The nets that are kept warm are forgotten, as one of them may be another now.
pub fn worker(maker: Arc<Maker>) -> impl Work<Request> {
    move |job: JobId, request: Request, cancel: &Cancel, outbox: &Outbox| {
        let sink = ToWindow { job, outbox, salience: Salience::even() };
        let task = Job { cancel, sink: &sink };
        let Some(shelf) = request.making.shelf.clone() else {
            outbox.send(job, Event::Failed(message!("no-folder-for-nets")));
            return;
        };
        let event = match change(&request.what, &shelf, &task) {
            Ok(event) => event,
            Err(AdoptError::Cancelled(_)) => Event::Stopped,
            Err(error) => Event::Failed(sentence(&error).into()),
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
            Ok(Event::Added(Box::new(Card::new(&net))))
        }
        Change::Prefer(name) => shelf.prefer(name.as_deref()).map(|()| Event::Stopped),
        Change::Remove(name) => shelf.remove(name).map(|()| Event::Stopped),
    }
}

/// All depth nets beside the pair's own, broken ones with their reason.
pub fn listed(making: &Making) -> Vec<Listed> {
    let plain = |tag: ModelTag| Listed {
        name: tag.id.clone(),
        tag: Some(tag),
        fault: None,
        is_preferred: false,
        is_added: false,
    };
    let mut nets: Vec<Listed> = making.models.further_tags().into_iter().map(plain).collect();
    for Shelved { name, manifest, is_preferred, .. } in making.shelf.iter().flat_map(Shelf::nets) {
        let (tag, fault) = match manifest {
            Ok(manifest) => (Some(manifest.tag()), None),
            Err(error) => (None, Some(sentence(&error))),
        };
        nets.push(Listed { name, tag, fault, is_preferred, is_added: true });
    }
    nets
}
