//! A line over something whose length a person knows: "this is 20 cm".

use egui::{CursorIcon, PointerButton, Pos2, Rect, Response, Ui, vec2};

use crate::ui::look::{Look, Measure};
use crate::ui::{theme, widgets};

/// Lets the pointer draw the line, where it is asked for; whether the pointer is its.
pub fn drag(look: &mut Look, ui: &Ui, response: &Response, place: impl Fn(Pos2) -> Option<[f32; 2]>) -> bool {
    let origin = ui.input(|input| input.pointer.press_origin());
    let is_asked = match look.measure {
        Measure::Off => return false,
        Measure::Asked => true,
        // The same drag goes on; the next one looks round again.
        Measure::Over(_) => look.is_measuring && response.dragged_by(PointerButton::Primary),
    };
    if !is_asked {
        look.is_measuring = false;
        return false;
    }
    if response.hovered() {
        ui.set_cursor_icon(CursorIcon::Crosshair);
    }
    let ends = origin.zip(response.interact_pointer_pos()).and_then(|(from, to)| place(from).zip(place(to)));
    if let Some((from, to)) = ends.filter(|_| response.dragged_by(PointerButton::Primary)) {
        (look.measure, look.is_measuring) = (Measure::Over([from, to]), true);
    }
    true
}

/// The line with its ends.
pub fn show(measure: Measure, ui: &Ui, canvas: Rect, rect: Rect) {
    let Measure::Over(ends) = measure else { return };
    let painter = ui.painter_at(canvas.intersect(rect));
    let [from, to] = ends.map(|[x, y]| rect.min + vec2(x, y) * rect.size());
    widgets::hair_line(&painter, from, to);
    let accent = theme::palette(ui.ctx()).accent;
    for end in [from, to] {
        painter.circle_filled(end, 4.0, theme::HAIR_RIM);
        painter.circle_filled(end, 3.0, accent);
    }
}
