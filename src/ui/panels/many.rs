//! Several files were dropped at once: look at the first, or export them all.

use std::path::{Path, PathBuf};

use egui::{Context, RichText};

use crate::ui::action::Action;
use crate::ui::dialog::Dialog;
use crate::ui::jobs::OpenFrom;
use crate::ui::{theme, widgets};

/// Names that are listed.
const LISTED: usize = 6;

/// Draws the question.
pub fn show(files: &[PathBuf], ctx: &Context) -> Vec<Action> {
    let colors = theme::palette(ctx);
    let mut actions = Vec::new();
    let modal = widgets::modal(ctx, "many");
    let shown = modal.show(ctx, |ui| {
        ui.set_width(420.0);
        ui.spacing_mut().item_spacing.y = 8.0;
        let title = format!("{} files", files.len());
        ui.label(RichText::new(title).font(theme::title(16.0)).color(colors.strong));
        let name = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let mut names: Vec<String> = files.iter().take(LISTED).map(|path| name(path)).collect();
        if files.len() > LISTED {
            names.push(format!("and {} more", files.len() - LISTED));
        }
        ui.label(RichText::new(names.join(", ")).color(colors.weak));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if widgets::main_button(ui, "Open the first").clicked() {
                actions.push(Action::CloseDialog);
                actions.extend(files.first().map(|first| Action::Open(OpenFrom::File(first.clone()))));
            }
            let hint = "Each one becomes a light field and is written with the lens that is set now";
            if widgets::button(ui, "Export all…").on_hover_text(hint).clicked() {
                actions.push(Action::Show(Dialog::Export(files.to_vec())));
            }
            if widgets::button(ui, "Cancel").clicked() {
                actions.push(Action::CloseDialog);
            }
        });
    });
    if shown.should_close() {
        actions.push(Action::CloseDialog);
    }
    actions
}
