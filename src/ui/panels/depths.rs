//! Ray depths of the current view, large, with a scale and a read-out; a click focuses as in the picture.

use egui::{Align2, Rect, Sense, Ui, pos2, vec2};

use super::canvas;
use crate::render::cpu::Colormap;
use crate::render::gpu::Draw;
use crate::scene::Edit;
use crate::ui::field_pictures::{FieldPictures, Slot};
use crate::ui::look::Look;
use crate::ui::open::Open;
use crate::ui::words::{self, t};
use crate::ui::{theme, widgets};

/// What the map shows, and what the pointer changes in it.
pub struct Depths<'a> {
    /// What is open.
    pub open: &'a Open,
    /// The focus.
    pub edit: &'a mut Edit,
    /// Zoom and probe.
    pub look: &'a mut Look,
    /// The map on the device.
    pub pictures: Option<&'a mut FieldPictures>,
    /// Its colours.
    pub colormap: Colormap,
}

/// Draws the map in the canvas.
pub fn show(shown: Depths, ui: &mut Ui, area: Rect) {
    let Depths { open, edit, look, pictures, colormap } = shown;
    let (Some(size), Some(view), Some(rays)) = (open.picture_size(), open.nearest_view(edit.viewpoint), open.rays())
    else {
        let weak = theme::palette(ui.ctx()).weak;
        ui.painter().text(area.center(), Align2::CENTER_CENTER, t!("no-depths-yet"), theme::text(), weak);
        return;
    };
    let range = rays.survey.range_px;
    let response = ui.interact(area, ui.scope_id().with("depths"), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, t!("depths-canvas")));
    canvas::move_picture(look, ui, &response, area, size);
    let rect = look.pose.screen_rect(area, size);
    canvas::probe(open, edit, look, &response, rect);
    if response.clicked()
        && let Some(at) = response.interact_pointer_pos()
    {
        canvas::focus_at(open, edit, look, at, rect);
    }
    let draw = Draw::Depth { view, range, map: colormap };
    if let Some(id) = pictures.and_then(|pictures| pictures.show(Slot::Depth, draw)) {
        ui.painter_at(area.intersect(rect)).image(id, rect, widgets::WHOLE, theme::AS_IS);
    }
    scale_bar(ui, area, range, colormap, look.hovered_px);
    let place = look.probe;
    let mut text = t!("depths-view", v = view.v, u = view.u);
    if let Some(d) = open.disparity_at(Some(view), place) {
        let [x, y] = [place.x * size.x, place.y * size.y].map(|at| at as u32);
        text = t!("depths-readout", x = x, y = y, view = text, disparity = words::signed(d, 2));
    }
    widgets::veil_label(ui, area.left_bottom() + vec2(8.0, -8.0), Align2::LEFT_BOTTOM, &text);
}

fn scale_bar(ui: &Ui, area: Rect, range: [f32; 2], colormap: Colormap, hovered_px: Option<f32>) {
    let back = Rect::from_min_size(pos2(area.right() - 74.0, area.top() + 12.0), vec2(62.0, 212.0));
    ui.painter().rect_filled(back, 6, theme::VEIL);
    let bar = Rect::from_min_size(back.min + vec2(8.0, 16.0), vec2(12.0, 180.0));
    let steps = 60;
    let part = bar.height() / steps as f32;
    for i in 0..steps {
        let place = 1.0 - (i as f32 + 0.5) / steps as f32;
        let [r, g, b] = colormap.srgb(place).map(|c| (c * 255.0 + 0.5) as u8);
        let min = pos2(bar.left(), bar.top() + i as f32 * part);
        // A little overlap, so that no seam shows.
        let cell = Rect::from_min_size(min, vec2(bar.width(), part + 0.5));
        ui.painter().rect_filled(cell, 0, egui::Color32::from_rgb(r, g, b));
    }
    for (place, value) in [(0.0, range[1]), (0.5, (range[0] + range[1]) / 2.0), (1.0, range[0])] {
        let at = pos2(bar.right() + 5.0, bar.top() + place * bar.height());
        ui.painter().text(at, Align2::LEFT_CENTER, words::with_sign(value, 2), theme::small(), theme::ON_VEIL);
    }
    if let Some(hovered) = hovered_px {
        let place = ((hovered - range[0]) / (range[1] - range[0])).clamp(0.0, 1.0);
        let y = bar.bottom() - place * bar.height();
        ui.painter().hline(bar.x_range().expand(3.0), y, (2.0, theme::ON_VEIL));
    }
}
