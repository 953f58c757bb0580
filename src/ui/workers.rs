//! The threads behind the window.

use std::path::PathBuf;
use std::sync::Arc;

use super::ask::Ask;
use super::field_pictures::FieldPictures;
use super::history::Keep;
use super::jobs::Load;
use super::neighbours::{self, Ahead};
use super::saver::Order;
use super::worker::{Outbox, Worker};
use super::{
    adding, dialogs, finals, history, jobs, mending, peaking, points, recents, saver, strength, training, trust,
};
use crate::scene::Maker;
use crate::synth::cache::Cache;

/// The threads behind the window.
pub struct Workers {
    /// Opens and synthesizes.
    pub loader: Worker<Load>,
    /// Writes.
    pub saver: Worker<Order>,
    /// Draws pictures at rest.
    pub finisher: Worker<finals::Request>,
    /// Tints what was invented.
    pub truster: Worker<trust::Request>,
    /// Draws scenes as points.
    pub points: Worker<points::Request>,
    /// Mends light fields.
    pub mender: Worker<mending::Request>,
    /// Finds the pixels of things, for whoever mends.
    pub outliner: Worker<mending::Request>,
    /// Makes the light field deeper or flatter.
    pub shaper: Worker<strength::Request>,
    /// Marks edges in focus.
    pub peaker: Worker<peaking::Request>,
    /// Shows the system's dialogs.
    pub asker: Worker<Ask>,
    /// Goes to the next photo.
    pub folder: Worker<neighbours::Request>,
    /// Opens the photos on both sides.
    pub ahead: Worker<neighbours::Request>,
    /// Keeps edits.
    pub sidecar: Worker<Keep>,
    /// Listens to the trainer.
    pub trainer: Worker<training::Request>,
    /// Tries and keeps depth nets.
    pub adder: Worker<adding::Request>,
    /// Finds small pictures of recent files.
    pub recents: Worker<Vec<PathBuf>>,
}

impl Workers {
    /// Starts them. `remembers`: whether what was opened is kept for the next time.
    pub fn spawn(outbox: &Outbox, pictures: Option<&FieldPictures>, remembers: bool) -> Self {
        let out = || outbox.clone();
        let ahead = Ahead::default();
        // The nets stay warm once, for what is opened and for what is exported.
        let maker = Arc::new(Maker::new(Cache::user().filter(|_| remembers)));
        Self {
            loader: Worker::spawn("synth", out(), jobs::loader(Arc::clone(&maker), ahead.clone(), remembers)),
            adder: Worker::spawn("nets", out(), adding::worker(Arc::clone(&maker))),
            truster: Worker::spawn("trust", out(), trust::worker(Arc::clone(&maker))),
            saver: Worker::spawn("export", out(), saver::worker(maker)),
            finisher: Worker::spawn("final", out(), finals::worker(pictures.and_then(FieldPictures::at_rest))),
            points: Worker::spawn("points", out(), points::worker()),
            mender: Worker::spawn("mend", out(), mending::work),
            outliner: Worker::spawn("outline", out(), mending::work),
            shaper: Worker::spawn("strength", out(), strength::work),
            peaker: Worker::spawn("peaking", out(), peaking::work),
            asker: Worker::spawn("dialog", out(), dialogs::work),
            folder: Worker::spawn("folder", out(), neighbours::worker(ahead.clone())),
            ahead: Worker::spawn("ahead", out(), neighbours::worker(ahead)),
            trainer: Worker::spawn("train", out(), training::work),
            sidecar: Worker::spawn("sidecar", out(), history::keep),
            recents: Worker::spawn("recents", out(), recents::work),
        }
    }
}
