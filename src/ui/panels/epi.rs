//! Epipolar images in line with the picture: the row's under it, the column's beside it.

use egui::{Align2, Painter, Rect, Ui, Vec2, pos2, vec2};

use super::repair::{self, SlopeLine};
use crate::field::{EpiLine, ViewGrid, ViewIndex};
use crate::render::gpu::Draw;
use crate::repair::{Operation, Region, Repair};
use crate::scene::Edit;
use crate::ui::action::Action;
use crate::ui::field_pictures::{FieldPictures, Slot};
use crate::ui::look::Look;
use crate::ui::open::Open;
use crate::ui::words::{self, t};
use crate::ui::{theme, widgets};

/// Pixels that a view is thick in the texture.
const SCALE: u32 = 4;

/// What the epipolar images show.
pub struct Epis<'a> {
    /// What is open.
    pub open: &'a Open,
    /// Where the eye is.
    pub edit: &'a Edit,
    /// Where the picture lies, and the probe.
    pub look: &'a Look,
    /// The images on the device.
    pub pictures: Option<&'a mut FieldPictures>,
    /// How far a thing reaches whose line is turned, as a share of the longer side.
    pub reach: f32,
}

/// Draws the row's image, the column's, and the slope in the corner between them. A line that is dragged to another slope
/// moves its thing to that depth.
pub fn show(shown: Epis, ui: &Ui, [row, column, corner]: [Rect; 3]) -> Option<Action> {
    let Epis { open, edit, look, pictures, reach } = shown;
    let colors = theme::palette(ui.ctx());
    for rect in [row, column, corner] {
        ui.painter().rect_filled(rect, theme::PICTURE_RADIUS, colors.panel);
    }
    let pictures = pictures?;
    // What has arrived is shown before the light field is complete.
    let arrived = pictures.shape();
    let (Some(size), Some(view), Some((grid, [w, h]))) =
        (open.picture_size(), open.nearest_view(edit.viewpoint), arrived)
    else {
        return None;
    };
    let picture = look.pose.screen_rect(look.canvas, size);
    let inside = |p: f32, n: u32| ((p * n as f32) as u32).min(n - 1);
    let (x, y) = (inside(look.probe.x, w), inside(look.probe.y, h));
    let lines = [
        (row, Slot::EpiRow, EpiLine::Row { y, v: view.v }),
        (column, Slot::EpiColumn, EpiLine::Column { x, u: view.u }),
    ];
    for (rect, slot, line) in lines {
        let Some(id) = pictures.show(slot, Draw::Epi { line, scale: SCALE }) else { continue };
        let (on_screen, uv) = in_line(rect, picture, slot == Slot::EpiRow);
        widgets::picture(ui.painter(), id, on_screen, uv, 1.0);
    }
    let disparity = open.disparity_at(Some(view), look.probe);
    slope_lines(look.probe, ui, [row, column], picture, (grid, w, view), disparity);
    let photo_line = |p: f32, n: f32| (p * n) as u32;
    widgets::veil_label(
        ui,
        row.left_top() + vec2(6.0, 6.0),
        Align2::LEFT_TOP,
        &t!("epi-row", row = photo_line(look.probe.y, size.y)),
    );
    widgets::veil_label(ui, column.left_top() + vec2(6.0, 6.0), Align2::LEFT_TOP, t!("epi-column"));
    if let Some(disparity) = disparity {
        let text = words::with_sign(disparity, 2);
        let middle = corner.center();
        ui.painter().text(middle - vec2(0.0, 12.0), Align2::CENTER_CENTER, t!("slope"), theme::small(), colors.weak);
        ui.painter().text(middle + vec2(0.0, 5.0), Align2::CENTER_CENTER, text, theme::medium(), colors.strong);
        ui.painter().text(middle + vec2(0.0, 21.0), Align2::CENTER_CENTER, t!("px-view"), theme::small(), colors.weak);
    }
    open.scene()?;
    let at = picture.min + look.probe * picture.size();
    let lies = Lies { grid, per_px: picture.width() / w as f32, view, range_px: open.rays()?.survey.range_px };
    let to_px = turned(ui, [row, column], at, &lies)?;
    let place = open.rays()?.place_in_reference(view, [look.probe.x, look.probe.y]);
    let what = Operation::To(to_px / (w as f32 * open.strength().0));
    Some(Action::Repair(Repair::Region { of: Region::Click { at: place, size: reach }, what }))
}

/// How epipolar images lie on the screen, and what of disparities there is.
struct Lies {
    grid: ViewGrid,
    /// Points of the screen for a pixel of a view.
    per_px: f32,
    view: ViewIndex,
    range_px: [f32; 2],
}

/// The disparity of the line that was let go, in pixels per view step; while it is held, it is drawn.
fn turned(ui: &Ui, [row, column]: [Rect; 2], at: egui::Pos2, lies: &Lies) -> Option<f32> {
    let Lies { grid, per_px, view, range_px: [far, near] } = *lies;
    // A small way of the hand is a large one of the slope: half a scene before and behind is room enough.
    let room = (near - far) / 2.0;
    let pitch = [row.height() / grid.cols() as f32, column.width() / grid.rows() as f32];
    let down = pos2(at.x, row.top() + (f32::from(view.u) + 0.5) * pitch[0]);
    let across = pos2(column.left() + (f32::from(view.v) + 0.5) * pitch[1], at.y);
    let lines = [
        (row, t!("the-row"), SlopeLine { through: down, pitch: pitch[0], per_px, is_row: true }),
        (column, t!("the-column"), SlopeLine { through: across, pitch: pitch[1], per_px, is_row: false }),
    ];
    for (strip, name, line) in lines {
        if let Some((disparity_px, is_let_go)) = repair::dragged_slope(ui, strip, name, line) {
            let disparity_px = disparity_px.clamp(far - room, near + room);
            repair::tentative(ui.painter(), line, disparity_px, strip);
            return is_let_go.then_some(disparity_px);
        }
    }
    None
}

/// Where the strip shows its image, and which part: the picture's own extent along the strip.
fn in_line(strip: Rect, picture: Rect, is_row: bool) -> (Rect, Rect) {
    let (mut on_screen, mut uv) = (strip, widgets::WHOLE);
    if is_row {
        (on_screen.min.x, on_screen.max.x) = (strip.left().max(picture.left()), strip.right().min(picture.right()));
        uv.min.x = (on_screen.min.x - picture.left()) / picture.width();
        uv.max.x = (on_screen.max.x - picture.left()) / picture.width();
    } else {
        (on_screen.min.y, on_screen.max.y) = (strip.top().max(picture.top()), strip.bottom().min(picture.bottom()));
        uv.min.y = (on_screen.min.y - picture.top()) / picture.height();
        uv.max.y = (on_screen.max.y - picture.top()) / picture.height();
    }
    (on_screen, uv)
}

/// The probe's point as it runs through the views: `x_u = x − (u − u0)·D` ([`crate::field`]).
fn slope_lines(
    probe: Vec2,
    ui: &Ui,
    [row, column]: [Rect; 2],
    picture: Rect,
    (grid, width, view): (ViewGrid, u32, ViewIndex),
    disparity: Option<f32>,
) {
    let Some(disparity) = disparity else { return };
    let at = picture.min + probe * picture.size();
    let per_px = picture.width() / width as f32;
    let along = |center: f32, steps: f32| center - steps * disparity * per_px;
    let accent = theme::palette(ui.ctx()).accent;
    let line = |painter: &Painter, from, to| {
        painter.line_segment([from, to], (3.0, theme::HAIR_RIM));
        painter.line_segment([from, to], (1.5, accent));
    };
    let cols = grid.cols() as f32;
    let (first, last) = (-f32::from(view.u) - 0.5, cols - 0.5 - f32::from(view.u));
    let top = pos2(along(at.x, first), row.top());
    line(&ui.painter_at(row), top, pos2(along(at.x, last), row.bottom()));
    let rows = grid.rows() as f32;
    let (first, last) = (-f32::from(view.v) - 0.5, rows - 0.5 - f32::from(view.v));
    let left = pos2(column.left(), along(at.y, first));
    line(&ui.painter_at(column), left, pos2(column.right(), along(at.y, last)));
    // The view that is looked at.
    let y = row.top() + (f32::from(view.u) + 0.5) / cols * row.height();
    ui.painter_at(row).circle_filled(pos2(at.x, y), 2.5, accent);
    let x = column.left() + (f32::from(view.v) + 0.5) / rows * column.width();
    ui.painter_at(column).circle_filled(pos2(x, at.y), 2.5, accent);
}
