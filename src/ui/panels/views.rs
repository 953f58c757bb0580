//! The grid of all views: the current one marked, a click goes there, a double click looks at it.

use egui::{Rect, Ui, vec2};

use super::strip::{Views, view_cell};
use crate::ui::action::Action;
use crate::ui::command::Command;

/// Draws the grid in the canvas.
pub fn show(views: &Views, ui: &Ui, canvas: Rect) -> Vec<Action> {
    let Views { grid, picture, .. } = *views;
    let gap = 4.0;
    let (cols, rows) = (grid.cols() as f32, grid.rows() as f32);
    let scale = ((canvas.width() / cols - gap) / picture.x).min((canvas.height() / rows - gap) / picture.y);
    let cell = picture * scale;
    let all = vec2((cell.x + gap) * cols - gap, (cell.y + gap) * rows - gap);
    let start = canvas.center() - all / 2.0;
    let mut actions = Vec::new();
    for view in grid.views() {
        let min = start + vec2(f32::from(view.u) * (cell.x + gap), f32::from(view.v) * (cell.y + gap));
        let response = view_cell(views, ui, view, Rect::from_min_size(min, cell));
        actions.extend(response.clicked().then(|| Action::LookFrom(grid.offset(view))));
        actions.extend(response.double_clicked().then_some(Action::Do(Command::Picture)));
    }
    actions
}
