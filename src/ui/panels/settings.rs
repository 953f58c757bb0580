//! The settings that are not part of an edit.

use egui::{Context, RichText, ThemePreference};

use crate::ui::action::Action;
use crate::ui::ask::Ask;
use crate::ui::settings::Settings;
use crate::ui::{theme, widgets};

/// Draws the dialog.
pub fn show(settings: &mut Settings, ctx: &Context) -> Vec<Action> {
    let colors = theme::palette(ctx);
    let before = (settings.long_side, settings.occlusion, settings.models_folder.clone());
    let mut actions = Vec::new();
    let modal = widgets::modal(ctx, "settings");
    let shown = modal.show(ctx, |ui| {
        ui.set_width(460.0);
        ui.spacing_mut().item_spacing.y = 8.0;
        ui.label(RichText::new("Settings").font(theme::title(16.0)).color(colors.strong));
        widgets::labelled(ui, "Theme", |ui| {
            let themes = [
                (ThemePreference::Dark, "Dark"),
                (ThemePreference::Light, "Light"),
                (ThemePreference::System, "System"),
            ];
            if widgets::segmented(ui, "Theme", &mut settings.theme, &themes) {
                ctx.set_theme(settings.theme);
            }
        });
        widgets::labelled(ui, "Light field", |ui| {
            let sizes = [(270, "270 px"), (360, "360 px"), (540, "540 px"), (720, "720 px")];
            widgets::segmented(ui, "Light field", &mut settings.long_side, &sizes);
        });
        widgets::labelled(ui, "Occlusions", |ui| {
            ui.checkbox(&mut settings.occlusion, "Correct them by the second net");
        });
        widgets::labelled(ui, "Edits", |ui| {
            let hint = "A small file beside each photo: photo.jpg.plenoscope.json";
            ui.checkbox(&mut settings.keeps_edits, "Keep them beside their photos").on_hover_text(hint);
        });
        widgets::labelled(ui, "Models", |ui| {
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if widgets::button(ui, "Choose…").clicked() {
                    actions.push(Action::Ask(Ask::Models));
                }
                if settings.models_folder.is_some() && widgets::button(ui, "Built-in").clicked() {
                    settings.models_folder = None;
                }
                let text = settings
                    .models_folder
                    .as_ref()
                    .map_or("those in the program".to_owned(), |folder| folder.display().to_string());
                ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                    ui.add(egui::Label::new(RichText::new(text).color(colors.text)).truncate());
                });
            });
        });
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if widgets::main_button(ui, "Done").clicked() {
                actions.push(Action::CloseDialog);
            }
        });
    });
    if before != (settings.long_side, settings.occlusion, settings.models_folder.clone()) {
        actions.push(Action::MakeAgain);
    }
    if shown.should_close() {
        actions.push(Action::CloseDialog);
    }
    actions
}
