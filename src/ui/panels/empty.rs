//! Nothing is open: one sentence, one drop target, and the ways in. And the veil while a file is dragged over.

use egui::{Align, Align2, Layout, Rect, RichText, StrokeKind, Ui, UiBuilder, vec2};

use crate::ui::action::Action;
use crate::ui::app::App;
use crate::ui::jobs::From;
use crate::ui::{theme, widgets};

/// Draws the empty canvas.
pub fn show(app: &mut App, ui: &mut Ui) {
    let area = ui.max_rect().shrink(32.0);
    let colors = theme::palette(ui.ctx());
    let ctx = ui.ctx().clone();
    dashed(ui, area);
    let recent: Vec<_> = app.settings.recent.iter().take(5).cloned().collect();
    let height = 150.0 + if recent.is_empty() { 0.0 } else { 40.0 + recent.len() as f32 * 24.0 };
    let middle = Rect::from_center_size(area.center(), vec2(area.width().min(520.0), height));
    let builder = UiBuilder::new().max_rect(middle).layout(Layout::top_down(Align::Center));
    ui.scope_builder(builder, |ui| {
        ui.label(RichText::new("Drop a photo to look into it").font(theme::title(24.0)).color(colors.strong));
        ui.add_space(6.0);
        ui.label(
            RichText::new("One photo becomes a light field: look round, focus anywhere, open the lens")
                .color(colors.weak),
        );
        ui.add_space(20.0);
        ui.horizontal(|ui| {
            ui.add_space((ui.available_width() - 268.0).max(0.0) / 2.0);
            if widgets::main_button(ui, "Open…").on_hover_text(Action::Open.tip(&ctx)).clicked() {
                app.apply(Action::Open, &ctx);
            }
            if widgets::button(ui, "Paste").on_hover_text(Action::Paste.tip(&ctx)).clicked() {
                app.apply(Action::Paste, &ctx);
            }
            if widgets::button(ui, "Try the sample").on_hover_text(Action::OpenSample.tip(&ctx)).clicked() {
                app.apply(Action::OpenSample, &ctx);
            }
        });
        if !recent.is_empty() {
            ui.add_space(28.0);
            ui.label(RichText::new("Recent").font(theme::head()).color(colors.weak));
            ui.add_space(4.0);
        }
        for path in recent {
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
            let button = egui::Button::new(RichText::new(name).color(colors.text)).frame(false);
            if ui.add(button).on_hover_text(path.display().to_string()).clicked() {
                app.open(From::File(path));
            }
        }
    });
}

fn dashed(ui: &Ui, area: Rect) {
    let color = theme::palette(ui.ctx()).control;
    let corners = [area.left_top(), area.right_top(), area.right_bottom(), area.left_bottom(), area.left_top()];
    ui.painter().extend(egui::Shape::dashed_line(&corners, (1.5, color), 6.0, 6.0));
}

/// While a file is dragged over the window: the whole of it is the target.
pub fn drop_hint(app: &App, ui: &Ui, all: Rect) {
    if ui.input(|input| input.raw.hovered_files.is_empty()) {
        return;
    }
    let colors = theme::palette(ui.ctx());
    let painter = ui.ctx().layer_painter(egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("drop")));
    painter.rect_filled(all, 0, theme::VEIL);
    painter.rect_stroke(all.shrink(12.0), 10, (2.0, colors.accent), StrokeKind::Inside);
    let text = if app.picture_size().is_some() { "Drop to open instead" } else { "Drop to open" };
    painter.text(all.center(), Align2::CENTER_CENTER, text, theme::title(22.0), theme::ON_VEIL);
}
