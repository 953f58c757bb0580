//! A line over something whose length a person knows: "this is 20 cm".

use egui::{CursorIcon, PointerButton, Pos2, Rect, Response, Ui, vec2};

use crate::ui::look::{Look, Measure};
use crate::ui::{theme, widgets};

/// Lets the pointer draw the line, where it is asked for; whether the pointer is its.
pub fn drag(look: &mut Look, ui: &Ui, response: &Response, place: impl Fn(Pos2) -> Option<[f32; 2]>) -> bool {
    let is_dragged = response.dragged_by(PointerButton::Primary);
    match look.measure {
        Measure::Off | Measure::Over(_) => return false,
        // The next drag looks round again.
        Measure::Drawn(ends) if !is_dragged => {
            look.measure = Measure::Over(ends);
            return false;
        }
        Measure::Asked | Measure::Drawn(_) => {}
    }
    if response.hovered() {
        ui.set_cursor_icon(CursorIcon::Crosshair);
    }
    let origin = ui.input(|input| input.pointer.press_origin());
    let ends = origin.zip(response.interact_pointer_pos()).and_then(|(from, to)| place(from).zip(place(to)));
    if let Some((from, to)) = ends.filter(|_| is_dragged) {
        look.measure = Measure::Drawn([from, to]);
    }
    true
}

/// The line with its ends.
pub fn show(measure: Measure, ui: &Ui, canvas: Rect, rect: Rect) {
    let (Measure::Drawn(ends) | Measure::Over(ends)) = measure else { return };
    let painter = ui.painter_at(canvas.intersect(rect));
    let [from, to] = ends.map(|[x, y]| rect.min + vec2(x, y) * rect.size());
    widgets::hair_line(&painter, from, to);
    let accent = theme::palette(ui.ctx()).accent;
    for end in [from, to] {
        painter.circle_filled(end, 4.0, theme::HAIR_RIM);
        painter.circle_filled(end, 3.0, accent);
    }
}
