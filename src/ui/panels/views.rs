//! The grid of all views: the current one marked, a click goes there, a double click looks at it.

use egui::{Rect, Ui, vec2};

use crate::ui::app::App;
use crate::ui::state::Face;

/// Draws the grid in the canvas.
pub fn show(app: &mut App, ui: &Ui, canvas: Rect) {
    let (Some(grid), Some(size), Some(here)) = (app.document.grid(), app.picture_size(), app.nearest_view()) else {
        return;
    };
    let gap = 4.0;
    let (cols, rows) = (grid.cols() as f32, grid.rows() as f32);
    let scale = ((canvas.width() / cols - gap) / size.x).min((canvas.height() / rows - gap) / size.y);
    let cell = size * scale;
    let all = vec2((cell.x + gap) * cols - gap, (cell.y + gap) * rows - gap);
    let start = canvas.center() - all / 2.0;
    for view in grid.views() {
        let min = start + vec2(f32::from(view.u) * (cell.x + gap), f32::from(view.v) * (cell.y + gap));
        if super::strip::view_cell(app, ui, grid, view, Rect::from_min_size(min, cell), here) {
            app.face = Face::Picture;
        }
    }
}
