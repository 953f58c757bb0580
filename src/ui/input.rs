//! Keys, drops and the clipboard: what they ask for.

use super::adding::Change;
use std::path::PathBuf;

use egui::{Context, Event};

use super::action::Action;
use super::ask::Ask;
use super::command::Command;
use super::dialog::Dialog;
use super::dialogs;
use super::jobs::OpenFrom;
use super::widgets;

/// What keys, drops and the clipboard ask for, while a dialog is shown or none is. `has_photo`: whether one is open.
pub fn read(ctx: &Context, dialog: Option<&Dialog>, has_photo: bool) -> Vec<Action> {
    let files = ctx.input(|input| input.raw.dropped_files.iter().map(|file| file.path().to_owned()).collect());
    let mut actions: Vec<Action> = dropped(files, has_photo).into_iter().collect();
    if ctx.text_edit_focused() {
        return actions;
    }
    actions.extend(ctx.input(|input| input.events.clone()).into_iter().filter_map(clipboard));
    // A question about the dropped files takes the keys at once.
    let asks = actions.iter().any(|action| matches!(action, Action::Show(_)));
    match dialog {
        _ if asks => {}
        None => actions.extend(keys(ctx, false)),
        Some(Dialog::Shortcuts) => actions.extend(keys(ctx, true)),
        Some(_) => {}
    }
    actions
}

/// Commands whose keys were pressed. Any of them takes the sheet of keys away, if that is shown.
fn keys(ctx: &Context, mut has_sheet: bool) -> Vec<Action> {
    // Keys with Shift come first: the same key without it would take them as well.
    let (with_shift, without) = Command::ALL
        .into_iter()
        .partition::<Vec<_>, _>(|command| command.spec().shortcut.is_some_and(|keys| keys.modifiers.shift));
    let is_taken = widgets::has_arrows(ctx);
    let has_menu = egui::Popup::is_any_open(ctx);
    let mut actions = Vec::new();
    for command in with_shift.into_iter().chain(without) {
        let keys = command.spec().shortcut;
        if is_taken && matches!(command, Command::StepLeft | Command::StepRight | Command::StepUp | Command::StepDown) {
            continue;
        }
        // Escape closes an open menu first.
        if has_menu && command == Command::Stop {
            continue;
        }
        if keys.is_some_and(|keys| ctx.input_mut(|input| input.consume_shortcut(&keys))) {
            if !(has_sheet && matches!(command, Command::Stop | Command::Shortcuts)) {
                actions.push(Action::Do(command));
            }
            if std::mem::take(&mut has_sheet) {
                actions.insert(0, Action::CloseDialog);
            }
        }
    }
    actions
}

/// One file is opened; a PFM over a photo is its depth; of several files a person says what they are for.
fn dropped(mut files: Vec<PathBuf>, has_photo: bool) -> Option<Action> {
    let is_pfm = |path: &PathBuf| path.extension().is_some_and(|suffix| suffix.eq_ignore_ascii_case("pfm"));
    if files.len() > 1 {
        files.sort_by(|a, b| crate::io::folder::natural_order(&a.to_string_lossy(), &b.to_string_lossy()));
        return Some(Action::Show(Dialog::Many(files)));
    }
    let path = files.pop()?;
    if path.extension().is_some_and(|suffix| suffix.eq_ignore_ascii_case("onnx")) {
        return Some(Action::ChangeNets(Change::Add(path)));
    }
    if has_photo
        && path.extension().is_some_and(|suffix| suffix.eq_ignore_ascii_case("json"))
        && !crate::io::formats::is_index_file(&path)
    {
        return Some(Action::Ask(Ask::ReadEdit(path)));
    }
    let is_depth = has_photo && is_pfm(&path);
    Some(if is_depth { Action::Ask(Ask::ReadDepthMap(path)) } else { Action::Open(OpenFrom::File(path)) })
}

/// The system sends copying and pasting as events of their own, without Shift.
fn clipboard(event: Event) -> Option<Action> {
    match event {
        Event::Copy => Some(Action::Do(Command::CopyPicture)),
        Event::Paste(text) => Some(match (dialogs::edit_from_text(&text), dialogs::path_from_text(&text)) {
            (Some(edit), _) => Action::PasteEdit(edit),
            (None, Some(path)) => Action::Open(OpenFrom::File(path)),
            (None, None) => Action::Do(Command::Paste),
        }),
        Event::PasteImage(image) => {
            let rgba = image.pixels.iter().flat_map(|pixel| pixel.to_srgba_unmultiplied()).collect();
            Some(Action::Open(OpenFrom::pasted(image.size.map(|side| side as u32), rgba)))
        }
        _ => None,
    }
}
