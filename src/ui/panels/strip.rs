//! The views strip: the row of views that the eye is in, one click from the whole grid.

use egui::{Align2, CursorIcon, Rect, Sense, StrokeKind, Ui, pos2, vec2};

use crate::field::{ViewGrid, ViewIndex};
use crate::ui::action::Action;
use crate::ui::app::App;
use crate::ui::state::Face;
use crate::ui::{theme, widgets};

/// Draws the strip.
pub fn show(app: &mut App, ui: &mut Ui) {
    let Some(grid) = app.document.grid() else { return };
    let rect = ui.max_rect().shrink2(vec2(16.0, 10.0));
    let colors = theme::palette(ui.ctx());
    let top = rect.top() + 6.0;
    ui.painter().text(pos2(rect.left(), top), Align2::LEFT_CENTER, "Views", theme::head(), colors.weak);
    let text = format!("all {} ▶", grid.count());
    let all = Rect::from_min_max(pos2(rect.right() - 50.0, rect.top() - 4.0), pos2(rect.right(), rect.top() + 16.0));
    let response =
        ui.interact(all, ui.scope_id().with("all views"), Sense::click()).on_hover_cursor(CursorIcon::PointingHand);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, "All views"));
    let color = if response.hovered() { colors.strong } else { colors.weak };
    ui.painter().text(pos2(rect.right(), top), Align2::RIGHT_CENTER, text, theme::small(), color);
    if response.on_hover_text(Action::Views.tip(ui.ctx())).clicked() {
        app.face = Face::Views;
    }
    let Some(here) = app.nearest_view() else { return };
    // As many views of the row as fit, with the current one among them.
    let area = Rect::from_min_max(pos2(rect.left(), rect.top() + 18.0), rect.max);
    let first_row = here.v.min(grid.rows().saturating_sub(2) as u8);
    for (line, v) in (first_row..grid.rows() as u8).take(2).enumerate() {
        for u in 0..grid.cols() as u8 {
            cell(app, ui, (grid, area, line), ViewIndex { v, u }, here);
        }
    }
}

fn cell(app: &mut App, ui: &Ui, (grid, area, line): (ViewGrid, Rect, usize), view: ViewIndex, here: ViewIndex) {
    let width = area.width() / grid.cols() as f32;
    let height = area.height() / 2.0;
    let min = area.min + vec2(f32::from(view.u) * width, line as f32 * height);
    let rect = Rect::from_min_size(min, vec2(width, height)).shrink(1.0);
    view_cell(app, ui, grid, view, rect, here);
}

/// One view as a picture that can be clicked; shared with the grid of all views.
pub fn view_cell(app: &mut App, ui: &Ui, grid: ViewGrid, view: ViewIndex, rect: Rect, here: ViewIndex) -> bool {
    let colors = theme::palette(ui.ctx());
    let id = ui.scope_id().with(("view", rect.min.x.to_bits(), view));
    let response = ui.interact(rect, id, Sense::click()).on_hover_cursor(CursorIcon::PointingHand);
    response.widget_info(|| {
        egui::WidgetInfo::selected(egui::Role::Button, true, view == here, format!("View {}, {}", view.v, view.u))
    });
    match app.stage.as_ref().and_then(|stage| stage.view(grid, view)) {
        Some(texture) => widgets::picture(ui.painter(), texture, rect, cover(app, rect), 1.0),
        None => {
            ui.painter().rect_filled(rect, theme::PICTURE_RADIUS, colors.control);
        }
    }
    if view == here {
        ui.painter().rect_stroke(rect, theme::PICTURE_RADIUS, (2.0, colors.accent), StrokeKind::Outside);
    } else if response.hovered() {
        ui.painter().rect_stroke(rect, theme::PICTURE_RADIUS, (1.5, colors.strong), StrokeKind::Inside);
    }
    if response.clicked() {
        app.is_circling = false;
        app.look_from(grid.offset(view));
    }
    let is_double = response.double_clicked();
    let step = grid.offset(view);
    response.on_hover_text(format!("u {}, v {}", widgets::signed(step.du, 0), widgets::signed(step.dv, 0)));
    is_double
}

/// The part of a view that fills a cell without being squeezed.
fn cover(app: &App, rect: Rect) -> Rect {
    let Some(size) = app.picture_size() else { return widgets::WHOLE };
    widgets::covering(size, rect.size())
}
