//! The settings that are not part of an edit.

use egui::{Context, RichText, ThemePreference};

use crate::ui::app::App;
use crate::ui::dialogs::Ask;
use crate::ui::{theme, widgets};

/// Draws the dialog; false once it is to be closed.
pub fn show(app: &mut App, ctx: &Context) -> bool {
    let colors = theme::palette(ctx);
    let before = (app.settings.long_side, app.settings.occlusion, app.settings.models_folder.clone());
    let mut asks = false;
    let mut is_open = true;
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
            if widgets::segmented(ui, "Theme", &mut app.settings.theme, &themes) {
                ctx.set_theme(app.settings.theme);
            }
        });
        widgets::labelled(ui, "Light field", |ui| {
            let sizes = [(270, "270 px"), (360, "360 px"), (540, "540 px"), (720, "720 px")];
            widgets::segmented(ui, "Light field", &mut app.settings.long_side, &sizes);
        });
        widgets::labelled(ui, "Occlusions", |ui| {
            ui.checkbox(&mut app.settings.occlusion, "Correct them by the second net");
        });
        widgets::labelled(ui, "Edits", |ui| {
            let hint = "A small file beside each photo: photo.jpg.plenoscope.json";
            ui.checkbox(&mut app.settings.keeps_edits, "Keep them beside their photos").on_hover_text(hint);
        });
        widgets::labelled(ui, "Models", |ui| {
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if widgets::button(ui, "Choose…").clicked() {
                    asks = true;
                }
                if app.settings.models_folder.is_some() && widgets::button(ui, "Built-in").clicked() {
                    app.settings.models_folder = None;
                }
                let text = app
                    .settings
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
                is_open = false;
            }
        });
    });
    if before != (app.settings.long_side, app.settings.occlusion, app.settings.models_folder.clone()) {
        app.make_again();
    }
    if asks {
        app.ask(Ask::Models);
    }
    is_open && !shown.should_close()
}
