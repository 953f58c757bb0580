//! The settings that are not part of an edit.

use egui::{Context, RichText, ThemePreference, Ui, WidgetInfo};

use crate::ui::action::Action;
use crate::ui::ask::Ask;
use crate::ui::settings::Settings;
use crate::ui::words::{self, Language, t};
use crate::ui::{theme, widgets};

/// Draws the dialog; `languages`: those that can be chosen.
pub fn show(settings: &mut Settings, languages: &[&'static Language], ctx: &Context) -> Vec<Action> {
    let colors = theme::palette(ctx);
    let before = (settings.long_side, settings.occlusion, settings.models_folder.clone());
    let mut actions = Vec::new();
    let modal = widgets::modal(ctx, "settings");
    let shown = modal.show(ctx, |ui| {
        ui.set_width(460.0);
        ui.spacing_mut().item_spacing.y = 8.0;
        ui.label(RichText::new(t!("settings")).font(theme::title(16.0)).color(colors.strong));
        widgets::labelled(ui, t!("theme"), |ui| {
            let themes = [
                (ThemePreference::Dark, t!("theme-dark")),
                (ThemePreference::Light, t!("theme-light")),
                (ThemePreference::System, t!("theme-system")),
            ];
            if widgets::segmented(ui, t!("theme"), &mut settings.theme, &themes) {
                ctx.set_theme(settings.theme);
            }
        });
        widgets::labelled(ui, t!("language"), |ui| language(settings, languages, ui));
        widgets::labelled(ui, t!("light-field"), |ui| {
            let sizes = [270, 360, 540, 720].map(|side| (side, t!("long-side-px", side = side)));
            widgets::segmented(ui, t!("light-field"), &mut settings.long_side, &sizes);
        });
        widgets::labelled(ui, t!("occlusions"), |ui| {
            ui.checkbox(&mut settings.occlusion, t!("occlusions-correct"));
        });
        widgets::labelled(ui, t!("edits"), |ui| {
            let hint = t!("edits-hint");
            ui.checkbox(&mut settings.keeps_edits, t!("edits-keep")).on_hover_text(hint);
        });
        widgets::labelled(ui, t!("models"), |ui| {
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if widgets::button(ui, t!("choose")).clicked() {
                    actions.push(Action::Ask(Ask::Models));
                }
                if settings.models_folder.is_some() && widgets::button(ui, t!("built-in")).clicked() {
                    settings.models_folder = None;
                }
                let text = settings
                    .models_folder
                    .as_ref()
                    .map_or(t!("models-own").to_owned(), |folder| folder.display().to_string());
                ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                    ui.add(egui::Label::new(RichText::new(text).color(colors.text)).truncate());
                });
            });
        });
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if widgets::main_button(ui, t!("done")).clicked() {
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

/// The language, which is spoken from the next text on.
fn language(settings: &mut Settings, languages: &[&'static Language], ui: &mut Ui) {
    let system = t!("language-system", name = words::best(languages, None).name());
    let chosen = settings.language.as_ref().map_or(&*system, |_| words::spoken().name()).to_owned();
    let before = settings.language.clone();
    let shown = egui::ComboBox::from_id_salt("language").selected_text(&chosen).width(180.0).show_ui(ui, |ui| {
        ui.selectable_value(&mut settings.language, None, &*system);
        for language in languages {
            ui.selectable_value(&mut settings.language, Some(language.tag().to_owned()), language.name());
        }
    });
    let said = t!("chosen-said", name = t!("language"), value = chosen);
    shown.response.widget_info(|| WidgetInfo::labeled(egui::Role::ComboBox, true, &said));
    if settings.language != before {
        words::speak(words::best(languages, settings.language.as_deref()));
        ui.ctx().request_repaint();
    }
}
