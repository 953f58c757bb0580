//! Edits: undone and redone, kept beside the photo, copied and pasted.

use std::path::PathBuf;
use std::time::Duration;

use egui::util::undoer::Undoer;

use super::app::App;
use super::state::Edit;
use super::worker::{Event, JobId, Outbox};
use crate::errors::sentence;
use crate::field::ViewPoint;
use crate::job::Cancel;
use crate::recipe::Recipe;

/// What was done to a photo, and what of it lies beside the photo.
#[derive(Default)]
pub struct History {
    undoer: Undoer<Edit>,
    /// The edit as it lies beside the photo, or as it was when the photo was opened; none before ray depths are there.
    kept: Option<Edit>,
}

impl History {
    /// A photo is there: this is what can be returned to.
    pub fn begin(&mut self, edit: Edit) {
        self.kept = Some(edit);
        self.undoer = Undoer::default();
        self.undoer.add_undo(&edit);
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

    /// The edit after this one.
    pub fn redo(&mut self, edit: &Edit) -> Edit {
        self.undoer.redo(edit).copied().unwrap_or(*edit)
    }
}

/// An edit that is to lie beside its photo.
#[derive(Debug)]
pub struct Keep {
    photo: PathBuf,
    recipe: Recipe,
}

/// The work of the thread that keeps edits.
pub fn keep(job: JobId, keep: Keep, _: &Cancel, outbox: &Outbox) {
    if let Err(error) = keep.recipe.write(&Recipe::sidecar(&keep.photo)) {
        let why = sentence(&error);
        outbox.send(
            job,
            Event::Failed(format!(
                "the edit is not kept beside the photo — {why} — copy the photo to a folder of yours, or turn this off in the settings"
            )),
        );
    }
}

impl App {
    /// Takes note of edits; once the hand rests, they are kept beside the photo.
    pub(super) fn keep_history(&mut self, ctx: &egui::Context) {
        let time = ctx.input(|input| input.time);
        self.history.undoer.feed_state(time, &self.edit);
        if self.history.undoer.is_in_flux() {
            ctx.request_repaint_after(Duration::from_millis(500));
        } else if !self.is_moving {
            self.keep_now();
        }
    }

    /// Puts the edit beside the photo, if it has changed.
    pub(super) fn keep_now(&mut self) {
        if let Some(keep) = self.take_unkept() {
            self.workers.sidecar.push(keep);
        }
    }

    /// The last edit, while the window closes: a few hundred bytes, written before the threads are gone.
    pub(super) fn keep_at_exit(&mut self) {
        if let Some(Keep { photo, recipe }) = self.take_unkept()
            && let Err(error) = recipe.write(&Recipe::sidecar(&photo))
        {
            log::warn!("{}", sentence(&error));
        }
    }

    fn take_unkept(&mut self) -> Option<Keep> {
        let is_new = self.history.kept.is_some_and(|kept| kept != self.edit);
        let photo = self.document.path.clone().filter(|_| self.document.photo.is_some())?;
        if !is_new || !self.settings.keeps_edits || self.is_circling {
            return None;
        }
        self.history.kept = Some(self.edit);
        let recipe = self.recipe();
        self.document.recipe = Some(Box::new(recipe.clone()));
        Some(Keep { photo, recipe })
    }

    /// The edit as a recipe, with what else its file held.
    fn recipe(&self) -> Recipe {
        let mut recipe = self.document.recipe.as_deref().cloned().unwrap_or_default();
        self.edit.put_into(&mut recipe);
        recipe.export = self.settings.export.picture.clone();
        recipe
    }

    /// Puts the edit into the clipboard, as text.
    pub(super) fn copy_edit(&mut self, ctx: &egui::Context) {
        ctx.copy_text(self.recipe().to_json());
        self.toasts.info("Copied the edit: paste it over another photo");
    }

    /// Applies an edit of another photo.
    pub(super) fn paste_edit(&mut self, recipe: &Recipe) {
        if self.picture_size().is_none() {
            self.toasts.error("the edit cannot be applied — nothing is open — open a photo first");
            return;
        }
        self.edit = Edit::of_recipe(recipe);
        if let Some(grid) = self.document.grid() {
            self.edit.viewpoint = ViewPoint(grid.clamp(self.edit.viewpoint.0));
        }
        if let Some(place) = self.edit.focus_at {
            self.focus_on(place);
        }
        self.toasts.info("Applied the edit");
    }
}
