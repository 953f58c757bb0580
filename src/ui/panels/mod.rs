//! What lies where: the picture takes all the room there is, its other faces lie in line with it.

mod canvas;
mod depths;
mod empty;
mod epi;
mod inspector;
pub mod many;
pub mod path_box;
pub mod queue;
mod ruler;
pub mod settings;
pub mod sheet;
mod source;
mod status;
mod strip;
mod top_bar;
mod views;

use egui::{Rect, Ui, UiBuilder, pos2};

use super::app::App;
use super::state::Face;
use super::theme;

const TOP_HEIGHT: f32 = 44.0;
const STATUS_HEIGHT: f32 = 26.0;
const RULER_HEIGHT: f32 = 96.0;
const MARGIN: f32 = 10.0;
const GAP: f32 = 6.0;

/// Draws the whole window.
pub fn layout(app: &mut App, ui: &mut Ui) {
    let all = ui.max_rect();
    let colors = theme::palette(ui.ctx());
    let is_narrow = all.width() < theme::NARROW_WIDTH;
    let is_empty = app.picture_size().is_none();
    let top = Rect::from_min_max(all.min, pos2(all.right(), all.top() + TOP_HEIGHT));
    let status = Rect::from_min_max(pos2(all.left(), all.bottom() - STATUS_HEIGHT), all.max);
    let mut main = Rect::from_min_max(top.left_bottom(), status.right_top());

    if !is_empty {
        let is_shown = if is_narrow { app.is_drawer_open } else { app.settings.has_inspector };
        let side = Rect::from_min_max(pos2(main.right() - theme::INSPECTOR_WIDTH, main.top()), main.max);
        // A drawer lies over the canvas, so it is drawn last; a panel has its own room.
        if is_shown && !is_narrow {
            main.max.x = side.left();
        }
        picture_area(app, ui, main, is_narrow);
        if is_shown {
            panel(ui, side, colors.panel, |ui| inspector::show(app, ui));
        }
    } else {
        inside(ui, main, |ui| empty::show(app, ui));
    }
    panel(ui, top, colors.panel, |ui| top_bar::show(app, ui, is_narrow));
    inside(ui, status, |ui| status::show(app, ui));
    empty::drop_hint(app, ui, all);
}

/// Picture, epipolar images and ruler.
fn picture_area(app: &mut App, ui: &mut Ui, area: Rect, is_narrow: bool) {
    let colors = theme::palette(ui.ctx());
    let ruler = Rect::from_min_max(pos2(area.left(), area.bottom() - RULER_HEIGHT), area.max);
    let work = Rect::from_min_max(area.min, pos2(area.right(), ruler.top())).shrink(MARGIN);
    let has_epis = !is_narrow && app.face == Face::Picture;
    let canvas = if has_epis {
        let room = theme::EPI_THICKNESS + GAP;
        Rect::from_min_max(work.min, work.max - egui::vec2(room, room))
    } else {
        work
    };
    app.canvas = canvas;
    match app.face {
        Face::Picture => inside(ui, canvas, |ui| canvas::show(app, ui, canvas)),
        Face::Views => inside(ui, canvas, |ui| views::show(app, ui, canvas)),
        Face::Depths => inside(ui, canvas, |ui| depths::show(app, ui, canvas)),
    }
    if has_epis {
        let row = Rect::from_min_max(pos2(canvas.left(), canvas.bottom() + GAP), pos2(canvas.right(), work.bottom()));
        let column = Rect::from_min_max(pos2(canvas.right() + GAP, canvas.top()), pos2(work.right(), canvas.bottom()));
        let corner = Rect::from_min_max(pos2(column.left(), row.top()), work.max);
        inside(ui, work, |ui| epi::show(app, ui, [row, column, corner]));
    }
    panel(ui, ruler, colors.panel, |ui| ruler::show(app, ui));
}

fn panel(ui: &mut Ui, rect: Rect, fill: egui::Color32, add: impl FnOnce(&mut Ui)) {
    ui.painter().rect_filled(rect, 0, fill);
    inside(ui, rect, add);
}

fn inside(ui: &mut Ui, rect: Rect, add: impl FnOnce(&mut Ui)) {
    ui.scope_builder(UiBuilder::new().max_rect(rect), |ui| {
        ui.set_clip_rect(rect.intersect(ui.clip_rect()));
        add(ui);
    });
}
