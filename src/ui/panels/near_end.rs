//! Which end of a depth map is near: both readings are shown, and a person points at the right one.

use egui::{Context, CursorIcon, RichText, Sense, StrokeKind, TextureHandle, Ui, vec2};

use crate::io::formats::depth_map::NearEnd;
use crate::ui::action::Action;
use crate::ui::near_end::{PREVIEW, Question, Reading};
use crate::ui::words::t;
use crate::ui::{theme, widgets};

/// Draws the question.
pub fn show(question: &Question, ctx: &Context) -> Vec<Action> {
    let colors = theme::palette(ctx);
    let mut answer = None;
    let mut is_open = true;
    let modal = widgets::modal(ctx, "near_end");
    let shown = modal.show(ctx, |ui| {
        ui.set_width(2.0 * PREVIEW as f32 + 16.0);
        ui.spacing_mut().item_spacing.y = 8.0;
        ui.label(RichText::new(t!("near-end-title")).font(theme::title(16.0)).color(colors.strong));
        let text = t!("near-end-ask", name = &question.name);
        ui.label(RichText::new(text).color(colors.weak));
        ui.horizontal_top(|ui| {
            ui.spacing_mut().item_spacing.x = 16.0;
            for (index, reading) in question.readings.iter().enumerate() {
                if preview(ui, reading, &question.textures[index], index == 0) {
                    answer = Some(reading);
                }
            }
        });
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if widgets::button(ui, t!("cancel")).clicked() {
                is_open = false;
            }
        });
    });
    let mut actions = Vec::new();
    if answer.is_some() || !is_open || shown.should_close() {
        actions.push(Action::CloseDialog);
    }
    actions.extend(answer.map(|reading| Action::TakeMap(reading.depth.clone())));
    actions
}

/// One reading; true once it is clicked.
fn preview(ui: &mut Ui, reading: &Reading, texture: &TextureHandle, is_likely: bool) -> bool {
    let colors = theme::palette(ui.ctx());
    let size = texture.size_vec2();
    let size = size * (PREVIEW as f32 / size.max_elem());
    ui.vertical(|ui| {
        let (rect, response) = ui.allocate_exact_size(vec2(PREVIEW as f32, size.y), Sense::click());
        let at = egui::Rect::from_center_size(rect.center(), size);
        widgets::picture(ui.painter(), texture.id(), at, widgets::WHOLE, 1.0);
        let name = if reading.end == NearEnd::White { t!("near-large") } else { t!("near-small") };
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
        if response.hovered() || response.has_focus() {
            ui.painter().rect_stroke(at, theme::PICTURE_RADIUS, (2.0, colors.accent), StrokeKind::Outside);
        }
        let label =
            RichText::new(if is_likely { t!("near-likely", name = name) } else { name.to_owned() }).color(colors.text);
        ui.vertical_centered(|ui| ui.label(label));
        response.on_hover_cursor(CursorIcon::PointingHand).clicked()
    })
    .inner
}
