//! The program broke off the last time: the report is offered, and goes nowhere by itself.

use egui::{Context, RichText, ScrollArea};

use crate::ui::action::Action;
use crate::ui::dialog::Broke;
use crate::ui::words::t;
use crate::ui::{theme, toasts, widgets};

/// Room for a line of a report, in points.
const WIDTH: f32 = 560.0;

/// Draws the offer, and the report where it is wanted.
pub fn show(broke: &mut Broke, ctx: &Context) -> Vec<Action> {
    let colors = theme::palette(ctx);
    let mut actions = Vec::new();
    let drawn = widgets::modal(ctx, "broke").show(ctx, |ui| {
        ui.set_width(WIDTH);
        ui.spacing_mut().item_spacing.y = 8.0;
        ui.label(RichText::new(t!("broke-title")).font(theme::title(16.0)).color(colors.strong));
        let told = t!("broke-told");
        ui.label(RichText::new(told).color(colors.text));
        if broke.is_shown {
            ScrollArea::both().max_height(320.0).show(ui, |ui| {
                ui.label(RichText::new(&broke.report.text).monospace().small().color(colors.weak));
            });
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if widgets::main_button(ui, t!("go-on")).clicked() {
                actions.push(Action::CloseDialog);
            }
            if widgets::button(ui, t!("show-in-folder")).clicked() {
                toasts::show_in_folder(&broke.report.path);
            }
            if widgets::button(ui, t!("copy-report")).clicked() {
                ui.copy_text(broke.report.text.clone());
            }
            let label = if broke.is_shown { t!("hide-report") } else { t!("show-report") };
            if widgets::button(ui, label).clicked() {
                broke.is_shown = !broke.is_shown;
            }
        });
    });
    if drawn.should_close() {
        actions.push(Action::CloseDialog);
    }
    actions
}
