//! A box for a path, where the system shows no file dialogs.

use crate::ui::adding::Change;
use std::path::PathBuf;

use egui::{Context, RichText};

use crate::ui::action::Action;
use crate::ui::ask::{Ask, PathFor};
use crate::ui::dialog::Dialog;
use crate::ui::dialogs::path_from_text;
use crate::ui::jobs::OpenFrom;
use crate::ui::words::{message, t};
use crate::ui::{theme, widgets};

/// What such a path looks like.
fn example(wanted: PathFor) -> &'static str {
    match wanted {
        PathFor::Open | PathFor::Export => "/home/me/photo.jpg",
        PathFor::DepthMap => "/home/me/depth.png",
        PathFor::Opening => "/home/me/opening.png",
        PathFor::Models => "/home/me/models",
        PathFor::Net => "/home/me/net.onnx",
        PathFor::LightFields => "/home/me/light-fields",
    }
}

/// Draws the box.
pub fn show(wanted: PathFor, text: &mut String, ctx: &Context) -> Vec<Action> {
    let colors = theme::palette(ctx);
    let mut is_open = true;
    let mut actions = Vec::new();
    let modal = widgets::modal(ctx, "path");
    let shown = modal.show(ctx, |ui| {
        ui.set_width(440.0);
        ui.spacing_mut().item_spacing.y = 8.0;
        let (title, what, verb) = match wanted {
            PathFor::Open => (t!("path-open"), t!("path-open-what"), t!("verb-open")),
            PathFor::Export => (t!("path-export"), t!("path-export-what"), t!("verb-go-on")),
            PathFor::DepthMap => (t!("path-depth"), t!("path-depth-what"), t!("verb-use")),
            PathFor::Opening => (t!("path-opening"), t!("path-opening-what"), t!("verb-use")),
            PathFor::Models => (t!("path-models"), t!("path-models-what"), t!("verb-use")),
            PathFor::Net => (t!("path-net"), t!("path-net-what"), t!("verb-add")),
            PathFor::LightFields => (t!("path-fields"), t!("path-fields-what"), t!("verb-use")),
        };
        ui.label(RichText::new(title).font(theme::title(16.0)).color(colors.strong));
        let line = t!("path-ask", what = what);
        ui.label(RichText::new(line).color(colors.weak));
        let edit = ui.add(egui::TextEdit::singleline(text).hint_text(example(wanted)).desired_width(f32::INFINITY));
        edit.request_focus();
        let is_enter = ui.input(|input| input.key_pressed(egui::Key::Enter));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if widgets::main_button(ui, verb).clicked() || is_enter {
                match path_from_text(text) {
                    // What the path is for may ask something else.
                    Some(path) => actions.extend([Action::CloseDialog, action(wanted, path)]),
                    None => actions.push(Action::Refuse(message!("path-none"))),
                }
            }
            if widgets::button(ui, t!("cancel")).clicked() {
                is_open = false;
            }
        });
    });
    if !is_open || shown.should_close() {
        actions.push(Action::CloseDialog);
    }
    actions
}

/// What a typed path is for.
fn action(wanted: PathFor, path: PathBuf) -> Action {
    match wanted {
        PathFor::Open => Action::Open(OpenFrom::File(path)),
        PathFor::Export => Action::Show(Dialog::Export(vec![path])),
        PathFor::DepthMap => Action::Ask(Ask::ReadDepthMap(path)),
        PathFor::Opening => Action::Ask(Ask::ReadOpening(path)),
        PathFor::Models => Action::UseModels(path),
        PathFor::LightFields => Action::TrainOn(path),
        PathFor::Net => Action::ChangeNets(Change::Add(path)),
    }
}
