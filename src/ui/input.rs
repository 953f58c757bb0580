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
        let times =
            keys.map_or(0, |keys| ctx.input_mut(|input| input.count_and_consume_key(keys.modifiers, keys.logical_key)));
        if times > 0 {
            if !(has_sheet && matches!(command, Command::Stop | Command::Shortcuts)) {
                let times = if is_step(command) { times } else { 1 };
                actions.extend(std::iter::repeat_n(command, times).map(Action::Do));
            }
            if std::mem::take(&mut has_sheet) {
                actions.insert(0, Action::CloseDialog);
            }
        }
    }
    actions
}

/// Whether each press counts, however many come between two pictures of the window.
fn is_step(command: Command) -> bool {
    use Command::{
        Earlier, Farther, Later, Nearer, Redo, StepDown, StepLeft, StepRight, StepUp, Undo, ZoomIn, ZoomOut,
    };
    let view = matches!(command, StepLeft | StepRight | StepUp | StepDown | ZoomIn | ZoomOut);
    view || matches!(command, Undo | Redo | Nearer | Farther | Earlier | Later)
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

#[cfg(test)]
mod tests {
    use egui::{Key, Modifiers, RawInput};

    use super::*;

    #[test]
    fn every_press_of_a_step_counts_and_a_switch_turns_once() {
        let press = |key, modifiers| Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers };
        let undo = Command::Undo.spec().shortcut.unwrap();
        let trust = Command::Trust.spec().shortcut.unwrap();
        let events = vec![
            press(undo.logical_key, undo.modifiers),
            press(undo.logical_key, undo.modifiers),
            press(undo.logical_key, undo.modifiers),
            press(trust.logical_key, trust.modifiers),
            press(trust.logical_key, trust.modifiers),
            press(Key::F35, Modifiers::NONE),
        ];
        let (ctx, mut done) = (Context::default(), Vec::new());
        let mut shown = ctx.run_ui(RawInput { events, ..RawInput::default() }, |ui| done = keys(ui.ctx(), false));
        shown.textures_delta.clear();
        let count =
            |wanted| done.iter().filter(|action| matches!(action, Action::Do(command) if *command == wanted)).count();
        assert_eq!((count(Command::Undo), count(Command::Trust), done.len()), (3, 1, 4));
    }
}
