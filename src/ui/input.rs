//! Keys, drops and the clipboard.

use std::path::PathBuf;

use super::action::Action;
use super::app::{App, Dialog};
use super::dialogs::{self, Ask};
use super::jobs::From;

impl App {
    /// Does what keys, drops and the clipboard ask for.
    pub(super) fn read_input(&mut self, ctx: &egui::Context) {
        let dropped = ctx.input(|input| input.raw.dropped_files.clone());
        if !dropped.is_empty() {
            self.dropped(dropped.iter().map(|file| file.path().to_owned()).collect());
        }
        if ctx.text_edit_focused() {
            return;
        }
        self.read_clipboard(ctx);
        let is_modal = self.dialog.is_some() && self.dialog != Some(Dialog::Shortcuts);
        if is_modal {
            return;
        }
        // Keys with Shift come first: the same key without it would take them as well.
        let (with_shift, without) = Action::ALL
            .into_iter()
            .partition::<Vec<_>, _>(|action| action.spec().shortcut.is_some_and(|keys| keys.modifiers.shift));
        for action in with_shift.into_iter().chain(without) {
            let keys = action.spec().shortcut;
            if keys.is_some_and(|keys| ctx.input_mut(|input| input.consume_shortcut(&keys))) {
                match (action, self.dialog.take()) {
                    (Action::Stop, Some(_)) => {}
                    (Action::Shortcuts, Some(Dialog::Shortcuts)) => {}
                    _ => self.apply(action, ctx),
                }
            }
        }
    }

    /// One file is opened; a PFM over a photo is its depth; of several files a person says what they are for.
    fn dropped(&mut self, mut files: Vec<PathBuf>) {
        let is_pfm = |path: &PathBuf| path.extension().is_some_and(|suffix| suffix.eq_ignore_ascii_case("pfm"));
        if files.len() > 1 {
            files.sort_by(|a, b| crate::io::folder::natural_order(&a.to_string_lossy(), &b.to_string_lossy()));
            self.dialog = Some(Dialog::Many(files));
        } else if let Some(path) = files.pop() {
            if self.document.photo.is_some() && is_pfm(&path) {
                self.ask(Ask::ReadDepthMap(path));
            } else {
                self.open(From::File(path));
            }
        }
    }

    /// The system sends copying and pasting as events of their own, without Shift.
    fn read_clipboard(&mut self, ctx: &egui::Context) {
        for event in ctx.input(|input| input.events.clone()) {
            match event {
                egui::Event::Copy => self.apply(Action::CopyPicture, ctx),
                egui::Event::Paste(text) => {
                    if let Some(edit) = dialogs::edit_from_text(&text) {
                        self.paste_edit(&edit);
                    } else if let Some(path) = dialogs::path_from_text(&text) {
                        self.open(From::File(path));
                    } else {
                        self.apply(Action::Paste, ctx);
                    }
                }
                egui::Event::PasteImage(image) => {
                    let rgba = image.pixels.iter().flat_map(|pixel| pixel.to_srgba_unmultiplied()).collect();
                    self.open(From::Pixels(image.size.map(|side| side as u32), rgba));
                }
                _ => {}
            }
        }
    }
}
