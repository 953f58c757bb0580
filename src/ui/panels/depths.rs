//! Ray depths of the current view, large, with a scale and a read-out; a click focuses as in the picture.

use egui::{Align2, Rect, Sense, Ui, pos2, vec2};

use super::canvas;
use crate::render::gpu::Draw;
use crate::ui::app::App;
use crate::ui::stage::Slot;
use crate::ui::{theme, widgets};

/// Draws the map in the canvas.
pub fn show(app: &mut App, ui: &mut Ui, area: Rect) {
    let (Some(size), Some(view), Some(survey)) = (app.picture_size(), app.nearest_view(), app.document.survey.clone())
    else {
        let weak = theme::palette(ui.ctx()).weak;
        ui.painter().text(area.center(), Align2::CENTER_CENTER, "No ray depths yet", theme::text(), weak);
        return;
    };
    let response = ui.interact(area, ui.scope_id().with("depths"), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Ray depths canvas"));
    canvas::move_picture(app, ui, &response, area, size);
    let rect = app.pose.screen_rect(area, size);
    canvas::probe(app, &response, rect);
    if response.clicked()
        && let Some(at) = response.interact_pointer_pos()
    {
        canvas::focus_at(app, at, rect);
    }
    let draw = Draw::Depth { view, range: survey.range_px, map: app.settings.colormap };
    if let Some(id) = app.stage.as_mut().and_then(|stage| stage.show(Slot::Depth, draw)) {
        ui.painter_at(area.intersect(rect)).image(id, rect, widgets::WHOLE, theme::AS_IS);
    }
    scale_bar(app, ui, area, survey.range_px);
    let place = app.probe;
    let mut text = format!("view ({}, {})", view.v, view.u);
    if let Some(d) = app.document.disparity_at(view, [place.x, place.y]) {
        text = format!(
            "x {}, y {} · {text} · {} px/view",
            (place.x * size.x) as u32,
            (place.y * size.y) as u32,
            widgets::signed(d, 2)
        );
    }
    widgets::veil_label(ui, area.left_bottom() + vec2(8.0, -8.0), Align2::LEFT_BOTTOM, &text);
}

fn scale_bar(app: &App, ui: &Ui, area: Rect, range: [f32; 2]) {
    let back = Rect::from_min_size(pos2(area.right() - 74.0, area.top() + 12.0), vec2(62.0, 212.0));
    ui.painter().rect_filled(back, 6, theme::VEIL);
    let bar = Rect::from_min_size(back.min + vec2(8.0, 16.0), vec2(12.0, 180.0));
    let steps = 60;
    let part = bar.height() / steps as f32;
    for i in 0..steps {
        let place = 1.0 - (i as f32 + 0.5) / steps as f32;
        let [r, g, b] = app.settings.colormap.srgb(place).map(|c| (c * 255.0 + 0.5) as u8);
        let min = pos2(bar.left(), bar.top() + i as f32 * part);
        // A little overlap, so that no seam shows.
        let cell = Rect::from_min_size(min, vec2(bar.width(), part + 0.5));
        ui.painter().rect_filled(cell, 0, egui::Color32::from_rgb(r, g, b));
    }
    for (place, value) in [(0.0, range[1]), (0.5, (range[0] + range[1]) / 2.0), (1.0, range[0])] {
        let at = pos2(bar.right() + 5.0, bar.top() + place * bar.height());
        ui.painter().text(at, Align2::LEFT_CENTER, widgets::signed(value, 2), theme::small(), theme::ON_VEIL);
    }
    if let Some(hovered) = app.hovered_px {
        let place = ((hovered - range[0]) / (range[1] - range[0])).clamp(0.0, 1.0);
        let y = bar.bottom() - place * bar.height();
        ui.painter().hline(bar.x_range().expand(3.0), y, (2.0, theme::ON_VEIL));
    }
}
