//! Several files were dropped at once: photos of one subject, or each for itself. What was chosen the last time stands out.

use std::path::{Path, PathBuf};

use egui::{Context, RichText, Ui};

use crate::scene::SeveralAsked;
use crate::ui::action::Action;
use crate::ui::dialog::Dialog;
use crate::ui::jobs::OpenFrom;
use crate::ui::settings::Settings;
use crate::ui::words::t;
use crate::ui::{theme, widgets};

/// Names that are listed.
const LISTED: usize = 6;

/// Draws the question.
pub fn show(files: &[PathBuf], settings: &mut Settings, ctx: &Context) -> Vec<Action> {
    let colors = theme::palette(ctx);
    let mut actions = Vec::new();
    let Settings { drops_one_subject: is_one_subject, takes_mean, .. } = settings;
    let is_enter = widgets::takes_enter(ctx);
    let stands_out = *is_one_subject;
    let modal = widgets::modal(ctx, "many");
    let shown = modal.show(ctx, |ui| {
        ui.set_width(460.0);
        ui.spacing_mut().item_spacing.y = 8.0;
        let title = t!("files-count", count = files.len());
        ui.label(RichText::new(title).font(theme::title(16.0)).color(colors.strong));
        let name = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let mut names: Vec<String> = files.iter().take(LISTED).map(|path| name(path)).collect();
        if files.len() > LISTED {
            names.push(t!("and-more", count = files.len() - LISTED));
        }
        ui.label(RichText::new(names.join(", ")).color(colors.weak));
        ui.label(t!("many-ask"));
        ui.checkbox(takes_mean, t!("take-mean")).on_hover_text(t!("take-mean-hint"));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let button = |ui: &mut Ui, text: &str, is_main: bool| match is_main {
                true => widgets::main_button(ui, text),
                false => widgets::button(ui, text),
            };
            let hint = t!("one-subject-hint");
            if button(ui, t!("one-subject"), stands_out).on_hover_text(hint).clicked() || (is_enter && stands_out) {
                *is_one_subject = true;
                actions.push(Action::CloseDialog);
                let asked = SeveralAsked { denoise: *takes_mean, ..SeveralAsked::default() };
                actions.push(Action::Open(OpenFrom::Several(files.to_vec(), asked)));
            }
            if button(ui, t!("open-first"), !stands_out).clicked() || (is_enter && !stands_out) {
                *is_one_subject = false;
                actions.push(Action::CloseDialog);
                actions.extend(files.first().map(|first| Action::Open(OpenFrom::File(first.clone()))));
            }
            let hint = t!("export-all-hint");
            if widgets::button(ui, t!("export-all")).on_hover_text(hint).clicked() {
                *is_one_subject = false;
                actions.push(Action::Show(Dialog::Export(files.to_vec())));
            }
            if widgets::button(ui, t!("cancel")).clicked() {
                actions.push(Action::CloseDialog);
            }
        });
    });
    if shown.should_close() {
        actions.push(Action::CloseDialog);
    }
    actions
}
