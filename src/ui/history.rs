//! The history of a photo's edits: undone and redone, and kept beside the photo.

use std::path::PathBuf;

use egui::util::undoer::Undoer;

use super::event::Event;
use super::worker::{JobId, Outbox};
use crate::errors::sentence;
use crate::job::Cancel;
use crate::scene::{DepthFrom, Edit, Recipe};

/// What was done to a photo, and what of it lies beside the photo.
#[derive(Default)]
pub struct History {
    undoer: Undoer<Edit>,
    /// The edit and the source of its depth as they lie beside the photo, or as they were when the photo was opened; none
    /// before there is one.
    kept: Option<(Edit, DepthFrom)>,
}

impl History {
    /// A photo is open: this is what can be returned to.
    pub fn new(edit: Edit, source: DepthFrom) -> Self {
        let mut undoer = Undoer::default();
        undoer.add_undo(&edit);
        Self { undoer, kept: Some((edit, source)) }
    }

    /// Whether there is something to take back.
    pub fn can_undo(&self, edit: &Edit) -> bool {
        self.undoer.has_undo(edit)
    }

    /// Whether there is something to do again.
    pub fn can_redo(&self, edit: &Edit) -> bool {
        self.undoer.has_redo(edit)
    }

    /// The edit before this one.
    pub fn undo(&mut self, edit: &Edit) -> Edit {
        self.undoer.undo(edit).copied().unwrap_or(*edit)
    }

    /// Takes note of an edit; true once the hand rests. Else it is to be asked again soon.
    pub fn has_settled(&mut self, time_secs: f64, edit: &Edit) -> bool {
        self.undoer.feed_state(time_secs, edit);
        !self.undoer.is_in_flux()
    }

    /// Whether an edit, or where its depth comes from, is not yet beside its photo; from then on it counts as kept.
    pub fn take_unkept(&mut self, edit: &Edit, source: &DepthFrom) -> bool {
        let is_new = self.kept.as_ref().is_some_and(|(kept, from)| kept != edit || from != source);
        if is_new {
            self.kept = Some((*edit, source.clone()));
        }
        is_new
    }

    /// The edit after this one.
    pub fn redo(&mut self, edit: &Edit) -> Edit {
        self.undoer.redo(edit).copied().unwrap_or(*edit)
    }
}

/// An edit that is to lie beside its photo.
#[derive(Debug)]
pub struct Keep {
    /// The photo.
    pub photo: PathBuf,
    /// The edit, with what else its file held.
    pub recipe: Recipe,
}

impl Keep {
    /// Writes it beside its photo.
    pub fn write(&self) -> Result<(), String> {
        self.recipe.write(&Recipe::sidecar(&self.photo)).map_err(|error| sentence(&error))
    }
}

/// The work of the thread that keeps edits.
pub fn keep(job: JobId, keep: Keep, _: &Cancel, outbox: &Outbox) {
    if let Err(why) = keep.write() {
        outbox.send(
            job,
            Event::Failed(format!(
                "the edit is not kept beside the photo — {why} — copy the photo to a folder of yours, or turn this off in the settings"
            )),
        );
    }
}
