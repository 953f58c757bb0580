//! The history of a photo's edits: undone and redone, and kept beside the photo.

use std::path::{Path, PathBuf};

use egui::util::undoer::Undoer;

use super::event::Event;
use super::words::{Message, message};
use super::worker::{JobId, Outbox};
use crate::errors::sentence;
use crate::job::Cancel;
use crate::repair::Repairs;
use crate::scene::{DepthFrom, Edit, Found, Recipe, Timeline};

/// All that is undone as one: the edit, what was mended, and the timeline.
#[derive(Clone, Default, PartialEq)]
pub struct Step {
    /// Lens, focus and viewpoint.
    pub edit: Edit,
    /// What was done to the depth.
    pub repairs: Repairs,
    /// What moves in a film of it.
    pub timeline: Option<Timeline>,
}

/// What was done to a photo, and what of it lies beside the photo.
#[derive(Default)]
pub struct History {
    undoer: Undoer<Step>,
    /// The edit and the source of its depth as they lie beside the photo, or as they were when the photo was opened; none
    /// before there is one.
    kept: Option<(Step, DepthFrom)>,
}

impl History {
    /// A photo is open: this is what can be returned to.
    pub fn new(step: Step, source: DepthFrom) -> Self {
        let mut undoer = Undoer::default();
        undoer.add_undo(&step);
        Self { undoer, kept: Some((step, source)) }
    }

    /// Whether there is something to take back.
    pub fn can_undo(&self, step: &Step) -> bool {
        self.undoer.has_undo(step)
    }

    /// Whether there is something to do again.
    pub fn can_redo(&self, step: &Step) -> bool {
        self.undoer.has_redo(step)
    }

    /// What was there before this.
    pub fn undo(&mut self, step: Step) -> Step {
        self.undoer.undo(&step).cloned().unwrap_or(step)
    }

    /// Takes note of an edit; true once the hand rests. Else it is to be asked again soon.
    pub fn has_settled(&mut self, time_secs: f64, step: &Step) -> bool {
        self.undoer.feed_state(time_secs, step);
        !self.undoer.is_in_flux()
    }

    /// Whether an edit, or where its depth comes from, is not yet beside its photo; from then on it counts as kept.
    pub fn take_unkept(&mut self, step: &Step, source: &DepthFrom) -> bool {
        let is_new = self.kept.as_ref().is_some_and(|(kept, from)| kept != step || from != source);
        if is_new {
            self.kept = Some((step.clone(), source.clone()));
        }
        is_new
    }

    /// Begins a step of its own: what was done before it is undone apart from it.
    pub fn note(&mut self, step: &Step) {
        self.undoer.add_undo(step);
    }

    /// What was there after this.
    pub fn redo(&mut self, step: Step) -> Step {
        self.undoer.redo(&step).cloned().unwrap_or(step)
    }
}

/// An edit that is to lie beside its photo.
#[derive(Debug)]
pub struct Keep {
    /// The photo.
    pub photo: PathBuf,
    /// The edit, with what else its file held.
    pub recipe: Recipe,
    /// What its file held when it was read.
    pub found: Found,
}

impl Keep {
    /// Writes it beside its photo; says where an edit is now that somebody else put there meanwhile.
    pub fn write(&self) -> Result<Option<PathBuf>, String> {
        self.recipe.keep_beside(&self.photo, self.found).map_err(|error| sentence(&error))
    }
}

/// The work of the thread that keeps edits.
pub fn keep(job: JobId, keep: Keep, _: &Cancel, outbox: &Outbox) {
    let told = match keep.write() {
        Ok(None) => return,
        Ok(Some(theirs)) => Event::Warning(edited_elsewhere(&theirs)),
        Err(why) => Event::Failed(message!("edit-not-kept", why = Message::heard(why))),
    };
    outbox.send(job, told);
}

/// Where the edit of somebody else is.
pub fn edited_elsewhere(theirs: &Path) -> Message {
    message!("edited-elsewhere", name = &*theirs.file_name().unwrap_or_default().to_string_lossy())
}
