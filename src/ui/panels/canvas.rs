//! The picture: drag to look round, click to focus, wheel to zoom.

use egui::{Align2, Color32, CursorIcon, Key, PointerButton, Pos2, Rect, Response, Sense, Ui, Vec2, pos2, vec2};

use super::measure;
use crate::field::{ViewOffset, ViewPoint};
use crate::render::gpu::Draw;
use crate::scene::export::Settings;
use crate::scene::{Edit, Focus};
use crate::ui::field_pictures::{FieldPictures, Slot};
use crate::ui::look::{Look, Split, Stereo};
use crate::ui::open::Open;
use crate::ui::rest::{AtRest, Seen};
use crate::ui::sharp;
use crate::ui::tiles::Tiled;
use crate::ui::words::{self, t};
use crate::ui::{theme, widgets};

/// Seconds in which the picture takes the photo's place.
const FADE_SECS: f32 = 0.15;

/// What the canvas shows, and what the pointer changes in it.
pub struct Canvas<'a> {
    /// What is open.
    pub open: &'a Open,
    /// Focus and viewpoint.
    pub edit: &'a mut Edit,
    /// Zoom, probe, the line between photo and picture.
    pub look: &'a mut Look,
    /// The draft.
    pub pictures: Option<&'a mut FieldPictures>,
    /// The photo.
    pub photo: Option<&'a mut Tiled>,
    /// What takes the draft's place.
    pub rest: &'a mut AtRest,
    /// Whether edges in focus are marked.
    pub has_peaks: bool,
    /// Width of what is exported, in whose pixels things are kept sharp.
    pub picture_width: u32,
}

/// Draws the picture and listens to the pointer.
pub fn show(mut shown: Canvas, ui: &mut Ui, canvas: Rect) {
    let Some(size) = shown.open.picture_size() else { return };
    let response = ui.interact(canvas, ui.scope_id().with("canvas"), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, t!("picture-canvas")));
    move_picture(shown.look, ui, &response, canvas, size);
    look_and_focus(&mut shown, ui, &response, canvas, size);
    let rect = shown.look.pose.screen_rect(canvas, size);
    let turned = turned(shown.open, shown.edit, rect);
    probe(shown.open, shown.edit, shown.look, &response, turned);
    paint(&mut shown, ui, canvas, rect);
    cross_hairs(&shown, ui, canvas, turned);
    rings(&shown, ui, canvas, turned);
    measure::show(shown.look.measure, ui, canvas, turned);
    read_out(&shown, ui, canvas, size);
}

/// Wheel, middle drag and space + drag: zoom and pan. Shared with the depth face.
pub fn move_picture(look: &mut Look, ui: &Ui, response: &Response, canvas: Rect, size: Vec2) {
    let is_pan = response.dragged_by(PointerButton::Middle)
        || response.dragged_by(PointerButton::Primary) && ui.input(|input| input.key_down(Key::Space));
    if is_pan {
        look.pose.pan(canvas, size, response.drag_delta());
    }
    if let Some(at) = response.hover_pos() {
        let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        let factor = pinch * (scroll / 240.0).exp();
        if factor != 1.0 {
            look.pose.zoom_at(canvas, size, at, factor);
        }
    }
}

fn look_and_focus(shown: &mut Canvas, ui: &Ui, response: &Response, canvas: Rect, size: Vec2) {
    let Canvas { open, edit, look, picture_width, .. } = shown;
    let rect = turned(open, edit, look.pose.screen_rect(canvas, size));
    let is_pan = ui.input(|input| input.key_down(Key::Space));
    let in_photo = |at: Pos2| {
        let place = (at - rect.min) / rect.size();
        in_reference(open, edit, place.clamp(Vec2::ZERO, Vec2::splat(1.0)))
    };
    if measure::drag(look, ui, response, in_photo) {
        return;
    }
    let has_photo = open.photo().is_some();
    if response.hover_pos().is_some_and(|at| has_photo && is_on_split(&look.split, at, canvas)) {
        ui.set_cursor_icon(CursorIcon::ResizeHorizontal);
    }
    if response.drag_started() {
        let origin = ui.input(|input| input.pointer.press_origin());
        look.split.is_held = origin.is_some_and(|at| has_photo && is_on_split(&look.split, at, canvas));
        look.held_ring = origin.and_then(|at| sharp::ring_at(open, edit, at, rect)).filter(|_| !look.split.is_held);
    }
    if look.split.is_held && response.dragged_by(PointerButton::Primary) {
        if let Some(at) = response.interact_pointer_pos() {
            look.split.at = ((at.x - canvas.left()) / canvas.width()).clamp(0.02, 0.98);
        }
    } else if let (true, Some(ring)) = (response.dragged_by(PointerButton::Primary), look.held_ring) {
        if let Some(place) = response.interact_pointer_pos().and_then(|at| place_at(open, edit, look, at, rect)) {
            **edit = sharp::moved(open, edit, ring, place, *picture_width);
        }
    } else if response.dragged_by(PointerButton::Primary) && !is_pan {
        look.is_circling = false;
        if let Some(grid) = open.grid() {
            // Across the shorter side the eye goes through all views; near things follow the hand.
            let per_point = grid.rows().max(grid.cols()) as f32 / canvas.size().min_elem();
            let by = -response.drag_delta() * per_point;
            let at = edit.viewpoint.0;
            edit.viewpoint = ViewPoint(grid.clamp(ViewOffset { dv: at.dv + by.y, du: at.du + by.x }));
        }
    }
    if response.clicked()
        && let Some(at) = response.interact_pointer_pos()
    {
        let keys = ui.input(|input| input.modifiers);
        if keys.command {
            turn_around(open, edit, look, at, rect);
        } else if !keys.shift {
            focus_at(open, edit, look, at, rect);
        } else if let Some(place) = place_at(open, edit, look, at, rect) {
            let ring = sharp::ring_at(open, edit, at, rect);
            **edit = sharp::toggled(open, edit, place, ring, *picture_width);
        }
    }
}

/// The place of the reference view that is seen under a point of the screen; the cross-hairs go there.
fn place_at(open: &Open, edit: &Edit, look: &mut Look, at: Pos2, rect: Rect) -> Option<[f32; 2]> {
    let place = (at - rect.min) / rect.size();
    if !Rect::from_min_size(Pos2::ZERO, Vec2::splat(1.0)).contains(place.to_pos2()) {
        return None;
    }
    look.probe = place;
    in_reference(open, edit, place)
}

/// The place of the reference view that a place of the view at the eye's shows.
pub fn in_reference(open: &Open, edit: &Edit, place: Vec2) -> Option<[f32; 2]> {
    let (view, rays) = open.nearest_view(edit.viewpoint).zip(open.rays())?;
    Some(rays.place_in_reference(view, place.into()))
}

/// Focuses on what is under a point of the screen.
pub fn focus_at(open: &Open, edit: &mut Edit, look: &mut Look, at: Pos2, rect: Rect) {
    if let Some(place) = place_at(open, edit, look, at, rect) {
        edit.focus = Focus::At(place);
    }
}

/// Where a view of the eye's place lies on the screen, so that what is turned around stays where it is.
pub fn turned(open: &Open, edit: &Edit, rect: Rect) -> Rect {
    let eye = edit.viewpoint.0;
    let per_step = edit.pivot * open.strength().0 * rect.width();
    rect.translate(vec2(eye.du, eye.dv) * per_step)
}

/// What is under a point of the screen stays where it is from now on, while the eye goes round.
fn turn_around(open: &Open, edit: &mut Edit, look: &mut Look, at: Pos2, rect: Rect) {
    let view = open.nearest_view(edit.viewpoint);
    if place_at(open, edit, look, at, rect).is_some()
        && let (Some(px), Some(rays)) = (open.disparity_at(view, look.probe), open.rays())
    {
        edit.pivot = px / (rays.depths.size()[0] as f32 * open.strength().0);
    }
}

/// What the cross-hairs go through: the pointer, or the last click.
pub fn probe(open: &Open, edit: &Edit, look: &mut Look, response: &Response, rect: Rect) {
    look.hovered_px = None;
    let Some(at) = response.hover_pos() else { return };
    let place = (at - rect.min) / rect.size();
    if place.x >= 0.0 && place.y >= 0.0 && place.x < 1.0 && place.y < 1.0 {
        look.probe = place;
        look.hovered_px = open.disparity_at(open.nearest_view(edit.viewpoint), place);
    }
}

fn paint(shown: &mut Canvas, ui: &Ui, canvas: Rect, rect: Rect) {
    let painter = ui.painter_at(canvas.intersect(rect));
    let holds_photo = ui.input(|input| input.key_down(Key::Backslash)) && shown.open.photo().is_some();
    let arrived = shown.pictures.as_ref().and_then(|pictures| pictures.arrived());
    let is_complete = arrived.is_some_and(|(have, all)| have == all);
    let has_photo = shown.photo.is_some();
    if is_complete && !holds_photo && shown.look.stereo != Stereo::Off {
        return both_eyes(shown, &painter, rect);
    }
    let shows_field = is_complete && !holds_photo && !(shown.edit.shows_photo_itself() && has_photo);
    let opacity = ui.ctx().animate_bool_with_time(ui.scope_id().with("field"), shows_field, FADE_SECS);
    let is_split = shown.look.split.is_shown && has_photo;
    if let Some(photo) = &mut shown.photo
        && (opacity < 1.0 || is_split)
    {
        photo.paint(&painter, rect);
    }
    if opacity > 0.0 || !has_photo {
        let mut after = painter.clone();
        if is_split {
            let x = split_x(&shown.look.split, canvas);
            after.set_clip_rect(Rect::from_min_max(pos2(x, canvas.top()), canvas.max).intersect(painter.clip_rect()));
        }
        paint_field(shown, ui, &after, rect, if has_photo { opacity } else { 1.0 });
    }
    let seen = Seen { open: shown.open, edit: shown.edit, look: shown.look };
    if let Some(peaks) = shown.rest.peaks(&seen).filter(|_| shown.has_peaks && !holds_photo) {
        painter.image(peaks.id(), turned(shown.open, shown.edit, rect), widgets::WHOLE, theme::AS_IS);
    }
    if is_split {
        split_line(&shown.look.split, ui, canvas);
    }
}

/// The light field through the lens: the picture at rest where it is there, the draft else.
fn paint_field(shown: &mut Canvas, ui: &Ui, painter: &egui::Painter, rect: Rect, opacity: f32) {
    let seen = Seen { open: shown.open, edit: shown.edit, look: shown.look };
    let key = shown.rest.key(&seen, ui.ctx().pixels_per_point()).filter(|_| opacity >= 1.0);
    let follows = shown.rest.follows(&seen);
    let at_rest = key.as_ref().and_then(|key| shown.rest.picture(key, follows));
    let covers_all = at_rest.is_some_and(|(have, _)| have.is_whole_at(have.size));
    if !covers_all {
        paint_draft(shown, painter, rect, opacity);
    }
    // What the lens renderer drew lies over the draft where it is what is asked for.
    if let Some((have, tiled)) = key.as_ref().and_then(|key| shown.rest.picture(key, follows)) {
        tiled.paint(painter, have.on_screen(rect));
    }
}

/// What both eyes see, as they are shown at once.
fn both_eyes(shown: &mut Canvas, painter: &egui::Painter, rect: Rect) {
    let eyes = shown.edit.for_eyes(Settings::EYES_APART);
    let half = |side: f32| {
        let middle = pos2(rect.left() + rect.width() * (0.25 + 0.5 * side), rect.center().y);
        Rect::from_center_size(middle, rect.size() / 2.0)
    };
    let (places, tints) = match shown.look.stereo {
        Stereo::Off => return,
        Stereo::Anaglyph => ([rect; 2], theme::EYES),
        Stereo::Parallel => ([half(0.0), half(1.0)], [theme::AS_IS; 2]),
        Stereo::Crossed => ([half(1.0), half(0.0)], [theme::AS_IS; 2]),
    };
    for (((edit, slot), place), tint) in eyes.iter().zip([Slot::Picture, Slot::RightEye]).zip(places).zip(tints) {
        paint_eye(shown, edit, slot, &painter.with_clip_rect(painter.clip_rect().intersect(place)), place, tint);
    }
}

/// The light field through the lens, at its own size.
fn paint_draft(shown: &mut Canvas, painter: &egui::Painter, rect: Rect, opacity: f32) {
    let edit = shown.edit.clone();
    paint_eye(shown, &edit, Slot::Picture, painter, rect, theme::AS_IS.gamma_multiply(opacity));
}

/// What one eye sees of it.
fn paint_eye(shown: &mut Canvas, edit: &Edit, slot: Slot, painter: &egui::Painter, rect: Rect, tint: Color32) {
    let Some(pictures) = &mut shown.pictures else { return };
    let edit = shown.open.drafted(edit);
    let (lens, viewpoint) = (shown.open.lens(&edit), edit.viewpoint);
    let draw = if lens.f_number.added_views() == 0.0 {
        Draw::View(viewpoint)
    } else {
        // Of a photo the lens renderer's picture comes anyway.
        let is_draft = pictures.is_software() && (shown.look.is_moving || shown.open.photo().is_some());
        let is_strewn = shown.rest.has_copies(&Seen { open: shown.open, edit: &edit, look: shown.look });
        Draw::Refocus { lens, center: viewpoint, is_draft, is_strewn }
    };
    let rect = turned(shown.open, &edit, rect);
    if let Some(id) = pictures.show(slot, draw) {
        painter.image(id, rect, widgets::WHOLE, tint);
    }
}

fn split_x(split: &Split, canvas: Rect) -> f32 {
    canvas.left() + split.at * canvas.width()
}

/// Whether a place of the screen is on the line between photo and picture.
fn is_on_split(split: &Split, at: Pos2, canvas: Rect) -> bool {
    split.is_shown && (at.x - split_x(split, canvas)).abs() < 8.0
}

fn split_line(split: &Split, ui: &Ui, canvas: Rect) {
    let x = split_x(split, canvas);
    let painter = ui.painter_at(canvas);
    widgets::hair_line(&painter, pos2(x, canvas.top()), pos2(x, canvas.bottom()));
    painter.circle(pos2(x, canvas.center().y), 9.0, theme::VEIL, (1.5, theme::ON_VEIL));
    widgets::veil_label(ui, pos2(x - 8.0, canvas.top() + 8.0), Align2::RIGHT_TOP, t!("split-photo"));
    widgets::veil_label(ui, pos2(x + 8.0, canvas.top() + 8.0), Align2::LEFT_TOP, t!("split-refocused"));
}

/// Lines through the probe into both epipolar images, and a ring where the focus is set.
fn cross_hairs(shown: &Canvas, ui: &Ui, canvas: Rect, rect: Rect) {
    if shown.open.field().is_none() {
        return;
    }
    let painter = ui.painter_at(canvas.intersect(rect));
    let at = rect.min + shown.look.probe * rect.size();
    let hole = 11.0;
    for (from, to) in [
        (pos2(canvas.left(), at.y), pos2(at.x - hole, at.y)),
        (pos2(at.x + hole, at.y), pos2(canvas.right(), at.y)),
        (pos2(at.x, canvas.top()), pos2(at.x, at.y - hole)),
        (pos2(at.x, at.y + hole), pos2(at.x, canvas.bottom())),
    ] {
        widgets::hair_line(&painter, from, to);
    }
    painter.circle_stroke(at, hole, (2.5, theme::HAIR_RIM));
    painter.circle_stroke(at, hole, (1.2, theme::palette(ui.ctx()).accent));
}

/// A ring on everything that is kept sharp.
fn rings(shown: &Canvas, ui: &Ui, canvas: Rect, rect: Rect) {
    let painter = ui.painter_at(canvas.intersect(rect));
    let accent = theme::palette(ui.ctx()).accent;
    for (ring, at) in sharp::rings(shown.open, shown.edit, rect).into_iter().enumerate() {
        painter.circle_stroke(at, sharp::GRAB, (4.0, theme::HAIR_RIM));
        painter.circle_stroke(at, sharp::GRAB, (2.0, accent));
        painter.circle_filled(at, 2.0, accent);
        let id = ui.scope_id().with(("ring", ring));
        let response = ui.interact(Rect::from_center_size(at, Vec2::splat(2.0)), id, Sense::hover());
        response
            .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, t!("kept-sharp", number = ring + 1)));
    }
}

fn read_out(shown: &Canvas, ui: &Ui, canvas: Rect, size: Vec2) {
    let Canvas { open, edit, look, .. } = shown;
    let (x, y) = ((look.probe.x * size.x) as u32, (look.probe.y * size.y) as u32);
    let mut text = t!("readout-place", x = x, y = y);
    if open.grid().is_some() {
        let at = edit.viewpoint.0;
        text += &t!("readout-view", u = words::signed(at.du, 1), v = words::signed(at.dv, 1));
    }
    let view = open.nearest_view(edit.viewpoint);
    if let (Some(view), Some(field)) = (view, open.field()) {
        let [w, h] = field.size();
        let inside = |p: f32, n: u32| ((p * n as f32) as u32).min(n - 1);
        let [r, g, b, _] = field.view(view).pixel(inside(look.probe.x, w), inside(look.probe.y, h));
        text += &format!(" · #{r:02X}{g:02X}{b:02X}");
    }
    if let Some(d) = open.disparity_at(view, look.probe) {
        text += &t!("readout-depth", disparity = words::signed(d, 2));
    }
    widgets::veil_label(ui, canvas.left_bottom() + vec2(8.0, -8.0), Align2::LEFT_BOTTOM, &text);
}
