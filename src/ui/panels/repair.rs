//! Mending depth in the picture: the pointer chooses, draws round or paints; what is chosen is tinted.

use egui::{Color32, CursorIcon, Key, PointerButton, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2};

use super::canvas;
use crate::render::cpu::Colormap;
use crate::repair::{Place, Region, Repair, Repairs};
use crate::scene::Edit;
use crate::ui::action::Action;
use crate::ui::look::Look;
use crate::ui::mending::{Mending, Tool};
use crate::ui::open::Open;
use crate::ui::words::t;
use crate::ui::{theme, widgets};

/// What the pointer meets.
pub struct Repairing<'a> {
    /// What is open.
    pub open: &'a Open,
    /// Where the eye is.
    pub edit: &'a Edit,
    /// Zoom and probe.
    pub look: &'a mut Look,
    /// The tool.
    pub mending: &'a mut Mending,
    /// What was done.
    pub repairs: &'a Repairs,
    /// The colours of depth.
    pub colormap: Colormap,
}

/// Listens to the pointer over the canvas, and draws what is chosen.
pub fn show(shown: Repairing, ui: &mut Ui, canvas: Rect) -> Option<Action> {
    let Repairing { open, edit, look, mending, repairs, colormap } = shown;
    let (size, rays) = (open.picture_size()?, open.rays()?);
    let response = ui.interact(canvas, ui.scope_id().with("repair"), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, t!("repair-canvas")));
    let is_pan = response.dragged_by(PointerButton::Middle) || ui.input(|input| input.key_down(Key::Space));
    if is_pan {
        look.pose.pan(canvas, size, response.drag_delta());
    }
    wheel(mending, look, ui, &response, canvas, size);
    let rect = look.pose.screen_rect(canvas, size);
    canvas::probe(open, edit, look, &response, rect);
    let painter = ui.painter_at(canvas.intersect(rect));
    let place = |at: Pos2| canvas::in_reference(open, edit, (at - rect.min) / rect.size());
    let range = rays.survey.range_px.map(|px| px / open.strength().0);
    let at = response.interact_pointer_pos().or(response.hover_pos());
    let done = match at.and_then(place) {
        Some(place) if !is_pan => hand(mending, &response, place, (range, colormap)),
        _ => None,
    };
    for texture in [mending.outline(), mending.draft()].into_iter().flatten() {
        painter.image(texture.id(), rect, widgets::WHOLE, theme::AS_IS);
    }
    marks(mending, repairs, &painter, rect);
    if let Some(at) = response.hover_pos() {
        pointer(mending, ui, &painter, at, rect);
    }
    done.map(Action::Repair)
}

/// The wheel grows and shrinks what the tool reaches; with Ctrl it zooms.
fn wheel(mending: &mut Mending, look: &mut Look, ui: &Ui, response: &egui::Response, canvas: Rect, size: egui::Vec2) {
    let Some(at) = response.hover_pos() else { return };
    let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
    if pinch != 1.0 {
        look.pose.zoom_at(canvas, size, at, pinch);
    } else if scroll != 0.0 {
        mending.grow((scroll / 240.0).exp());
    }
}

/// What the hand does at a place of the reference view.
fn hand(mending: &mut Mending, response: &egui::Response, place: Place, look: ([f32; 2], Colormap)) -> Option<Repair> {
    let is_down = response.is_pointer_button_down_on() && !response.dragged_by(PointerButton::Middle);
    match mending.tool {
        Tool::Thing => {
            if response.clicked() {
                mending.choose(Some(Region::Click { at: place, size: mending.reach }));
            }
            None
        }
        _ if is_down => {
            mending.draw_to(place, look, &response.ctx);
            None
        }
        _ => mending.finish(),
    }
}

/// The lasso, and the place of the repair that the pointer is on in the list.
fn marks(mending: &Mending, repairs: &Repairs, painter: &egui::Painter, rect: Rect) {
    let on_screen = |place: &Place| rect.min + egui::vec2(place[0], place[1]) * rect.size();
    if let Some(path) = mending.lasso() {
        let points: Vec<Pos2> = path.iter().map(on_screen).collect();
        painter.add(Shape::line(points.clone(), Stroke::new(3.0, theme::HAIR_RIM)));
        painter.add(Shape::line(points, Stroke::new(1.5, theme::PEAK)));
    }
    let pointed_at = mending.pointed_at.and_then(|number| repairs.entries().get(number));
    if let Some(place) = pointed_at.and_then(|entry| entry.repair()).and_then(Repair::place) {
        painter.circle(on_screen(&place), 7.0, Color32::TRANSPARENT, (3.0, theme::HAIR_RIM));
        painter.circle(on_screen(&place), 7.0, Color32::TRANSPARENT, (1.5, theme::PEAK));
    }
}

/// The brush's size at the pointer.
fn pointer(mending: &Mending, ui: &Ui, painter: &egui::Painter, at: Pos2, rect: Rect) {
    ui.set_cursor_icon(CursorIcon::Crosshair);
    if let Tool::Brush(_) = mending.tool {
        let radius = mending.brush * rect.size().max_elem() / 2.0;
        painter.circle_stroke(at, radius, (2.5, theme::HAIR_RIM));
        painter.circle_stroke(at, radius, (1.0, theme::HAIR));
    }
}

/// The line of an epipolar image that the hand has turned: its disparity in pixels per view step.
pub fn dragged_slope(ui: &Ui, strip: Rect, name: &str, line: SlopeLine) -> Option<(f32, bool)> {
    let response = ui.interact(strip, ui.scope_id().with(name), Sense::drag());
    let label = t!("slope-of", line = name);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &label));
    let response =
        response.on_hover_cursor(if line.is_row { CursorIcon::ResizeHorizontal } else { CursorIcon::ResizeVertical });
    let at = response.interact_pointer_pos().filter(|_| response.dragged() || response.drag_stopped())?;
    Some((line.disparity_px(at)?, response.drag_stopped()))
}

/// Where a line of an epipolar image goes through, and how it lies on the screen.
#[derive(Clone, Copy)]
pub struct SlopeLine {
    /// The point of the view that is looked at.
    pub through: Pos2,
    /// Points of the screen from view to view.
    pub pitch: f32,
    /// Points of the screen for a pixel of a view.
    pub per_px: f32,
    /// Views downwards and places to the right; else the other way round.
    pub is_row: bool,
}

impl SlopeLine {
    /// The disparity of the line through a point: `x_u = x − (u − u0)·D` ([`crate::field`]).
    fn disparity_px(self, at: Pos2) -> Option<f32> {
        let away = at - self.through;
        let (along, steps) = if self.is_row { (away.x, away.y) } else { (away.y, away.x) };
        let steps = steps / self.pitch;
        // So close to the view itself every slope goes through.
        (steps.abs() > 0.3).then(|| -along / self.per_px / steps)
    }
}

/// A ring on the canvas where a slope was taken.
pub fn tentative(painter: &egui::Painter, line: SlopeLine, disparity_px: f32, strip: Rect) {
    let on_line = |steps: f32| {
        let along = -steps * disparity_px * line.per_px;
        let away = steps * line.pitch;
        if line.is_row {
            pos2(line.through.x + along, line.through.y + away)
        } else {
            pos2(line.through.x + away, line.through.y + along)
        }
    };
    let reach = strip.size().max_elem() / line.pitch;
    painter.with_clip_rect(strip).line_segment([on_line(-reach), on_line(reach)], (1.5, theme::PEAK));
}
