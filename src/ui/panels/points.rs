//! The scene as points in space: a drag turns it, the wheel brings it nearer, a double click turns it back.

use egui::{Align2, Rect, Response, Sense, Ui, vec2};

use crate::scene::dots::Turn;
use crate::ui::open::Open;
use crate::ui::points::Points;
use crate::ui::words::{self, t};
use crate::ui::{theme, widgets};

/// A drag across the shorter side turns by this, in radians.
const ACROSS: f32 = 2.2;

/// Draws the points that are there, and listens to the pointer. `generation`: of the light field that is shown.
pub fn show(open: &Open, points: &mut Points, generation: u64, ui: &mut Ui, area: Rect) {
    if open.scene().is_none() {
        let weak = theme::palette(ui.ctx()).weak;
        ui.painter().text(area.center(), Align2::CENTER_CENTER, t!("points-none"), theme::text(), weak);
        return;
    }
    let response = ui.interact(area, ui.scope_id().with("points"), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, t!("points-canvas")));
    points.turn_to(turned(points.turn(), ui, &response, area));
    let Some((shown, texture)) = points.picture(generation) else { return };
    ui.painter_at(area).image(texture.id(), area, widgets::WHOLE, theme::AS_IS);
    let Turn { yaw, pitch, near } = points.turn();
    let degrees = |angle: f32| words::signed(angle.to_degrees(), 0);
    let near = words::fixed(near, 1);
    let mut text = t!("points-readout", count = shown.count, yaw = degrees(yaw), pitch = degrees(pitch), zoom = near);
    if !shown.has_all {
        text += t!("points-filling");
    }
    widgets::veil_label(ui, area.left_bottom() + vec2(8.0, -8.0), Align2::LEFT_BOTTOM, &text);
}

fn turned(turn: Turn, ui: &Ui, response: &Response, area: Rect) -> Turn {
    if response.double_clicked() {
        return Turn::default();
    }
    let by = response.drag_delta() * (ACROSS / area.size().min_elem());
    let turn = if response.dragged() { turn.by(by.x, by.y) } else { turn };
    match response.hover_pos() {
        Some(_) => {
            let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
            turn.nearer(pinch * (scroll / 480.0).exp())
        }
        None => turn,
    }
}
