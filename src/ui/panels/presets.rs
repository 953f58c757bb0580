//! Lenses and exports by name.

use egui::{Context, RichText};

use crate::ui::action::Action;
use crate::ui::ask::{Ask, Preset};
use crate::ui::words::t;
use crate::ui::{theme, widgets};

/// Draws the dialog.
pub fn show(names: &[String], new: &mut String, ctx: &Context) -> Vec<Action> {
    let colors = theme::palette(ctx);
    let mut actions = Vec::new();
    let shown = widgets::modal(ctx, "presets").show(ctx, |ui| {
        ui.set_width(420.0);
        ui.spacing_mut().item_spacing.y = 2.0 * theme::GRID;
        ui.label(RichText::new(t!("presets")).font(theme::title(16.0)).color(colors.strong));
        let text = if names.is_empty() { t!("presets-none") } else { t!("presets-some") };
        ui.label(RichText::new(text).color(colors.weak));
        egui::ScrollArea::vertical().max_height(320.0).show(ui, |ui| {
            for name in names {
                actions.extend(row(ui, name));
            }
        });
        ui.horizontal(|ui| {
            let edit = egui::TextEdit::singleline(new).hint_text(t!("preset-name")).desired_width(240.0);
            let field = ui.add(edit);
            let is_enter = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
            // A name can be typed at once. Enter takes the keyboard from the field, which has to be heard first.
            if !is_enter && ui.memory(|memory| memory.focused().is_none()) {
                field.request_focus();
            }
            let has_name = !new.trim().is_empty();
            ui.add_enabled_ui(has_name, |ui| {
                if (widgets::main_button(ui, t!("keep")).clicked() || is_enter) && has_name {
                    actions.push(Action::KeepPreset(new.trim().to_owned()));
                }
            });
            if widgets::button(ui, t!("close")).clicked() {
                actions.push(Action::CloseDialog);
            }
        });
    });
    if shown.should_close() {
        actions.push(Action::CloseDialog);
    }
    actions
}

fn row(ui: &mut egui::Ui, name: &str) -> Option<Action> {
    let mut action = None;
    ui.horizontal(|ui| {
        ui.set_width(ui.available_width());
        ui.add(egui::Label::new(name).truncate());
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let button = |ui: &mut egui::Ui, verb: &str| {
                let response = widgets::button(ui, verb);
                response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, format!("{verb} {name}")));
                response.clicked()
            };
            if button(ui, t!("remove")) {
                action = Some(Action::Ask(Ask::Presets(Preset::Remove(name.to_owned()))));
            }
            if button(ui, t!("apply")) {
                action = Some(Action::Ask(Ask::Presets(Preset::Take(name.to_owned()))));
            }
        });
    });
    action
}
