//! The views strip: the row of views that the eye is in, one click from the whole grid.

use egui::{Align2, CursorIcon, Rect, Response, Sense, StrokeKind, Ui, Vec2, pos2, vec2};

use crate::field::{ViewGrid, ViewIndex, ViewPoint};
use crate::ui::action::Action;
use crate::ui::command::Command;
use crate::ui::field_pictures::FieldPictures;
use crate::ui::open::Open;
use crate::ui::words::{self, t};
use crate::ui::{theme, widgets};

/// The views that can be gone to.
#[derive(Clone, Copy)]
pub struct Views<'a> {
    /// All of them.
    pub grid: ViewGrid,
    /// The one that is nearest to the eye.
    pub here: ViewIndex,
    /// Width and height of the picture.
    pub picture: Vec2,
    /// Their pictures.
    pub pictures: Option<&'a FieldPictures>,
}

impl<'a> Views<'a> {
    /// Those of what is open, once there are some.
    pub fn new(open: &Open, eye: ViewPoint, pictures: Option<&'a FieldPictures>) -> Option<Self> {
        let (grid, here, picture) = (open.grid()?, open.nearest_view(eye)?, open.picture_size()?);
        Some(Self { grid, here, picture, pictures })
    }
}

/// Draws the strip.
pub fn show(views: &Views, ui: &mut Ui) -> Vec<Action> {
    let Views { grid, here, .. } = *views;
    let mut actions = Vec::new();
    let rect = ui.max_rect().shrink2(vec2(16.0, 10.0));
    let colors = theme::palette(ui.ctx());
    let top = rect.top() + 6.0;
    ui.painter().text(pos2(rect.left(), top), Align2::LEFT_CENTER, t!("views"), theme::head(), colors.weak);
    let text = t!("views-all", count = grid.count());
    let galley = ui.painter().layout_no_wrap(text, theme::small(), colors.weak);
    let least = rect.right() - (galley.size().x + 4.0).max(50.0);
    let all = Rect::from_min_max(pos2(least, rect.top() - 4.0), pos2(rect.right(), rect.top() + 16.0));
    let response =
        ui.interact(all, ui.scope_id().with("all_views"), Sense::click()).on_hover_cursor(CursorIcon::PointingHand);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, t!("all-views")));
    let color = if response.hovered() { colors.strong } else { colors.weak };
    let at = Align2::RIGHT_CENTER.anchor_size(pos2(rect.right(), top), galley.size()).min;
    ui.painter().galley_with_override_text_color(at, galley, color);
    if response.on_hover_text(Command::Views.tip(ui.ctx())).clicked() {
        actions.push(Action::Do(Command::Views));
    }
    // As many views of the row as fit, with the current one among them.
    let area = Rect::from_min_max(pos2(rect.left(), rect.top() + 18.0), rect.max);
    let cell = vec2(area.width() / grid.cols() as f32, area.height() / 2.0);
    let first_row = here.v.min(grid.rows().saturating_sub(2) as u8);
    for (line, v) in (first_row..grid.rows() as u8).take(2).enumerate() {
        for view in (0..grid.cols() as u8).map(|u| ViewIndex { v, u }) {
            let min = area.min + vec2(f32::from(view.u), line as f32) * cell;
            let response = view_cell(views, ui, view, Rect::from_min_size(min, cell).shrink(1.0));
            actions.extend(response.clicked().then(|| Action::LookFrom(grid.offset(view))));
        }
    }
    actions
}

/// One view as a picture that can be clicked; shared with the grid of all views.
pub fn view_cell(views: &Views, ui: &Ui, view: ViewIndex, rect: Rect) -> Response {
    let Views { grid, here, picture, pictures } = *views;
    let colors = theme::palette(ui.ctx());
    let id = ui.scope_id().with(("view", rect.min.x.to_bits(), view));
    let response = ui.interact(rect, id, Sense::click()).on_hover_cursor(CursorIcon::PointingHand);
    response.widget_info(|| {
        egui::WidgetInfo::selected(egui::Role::Button, true, view == here, t!("view-at", v = view.v, u = view.u))
    });
    match pictures.and_then(|pictures| pictures.view(grid, view)) {
        Some(texture) => {
            widgets::picture(ui.painter(), texture, rect, widgets::covering(picture, rect.size()), 1.0);
        }
        None => {
            ui.painter().rect_filled(rect, theme::PICTURE_RADIUS, colors.control);
        }
    }
    if view == here {
        ui.painter().rect_stroke(rect, theme::PICTURE_RADIUS, (2.0, colors.accent), StrokeKind::Outside);
    } else if response.hovered() {
        ui.painter().rect_stroke(rect, theme::PICTURE_RADIUS, (1.5, colors.strong), StrokeKind::Inside);
    }
    let step = grid.offset(view);
    response.on_hover_text(t!("view-step", u = words::signed(step.du, 0), v = words::signed(step.dv, 0)))
}
