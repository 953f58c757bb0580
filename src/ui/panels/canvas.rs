//! The picture: drag to look round, click to focus, wheel to zoom.

use egui::{Align2, CursorIcon, Key, PointerButton, Pos2, Rect, Response, Sense, Ui, Vec2, pos2, vec2};

use crate::field::ViewOffset;
use crate::render::gpu::Draw;
use crate::ui::app::App;
use crate::ui::stage::{Slot, Stage};
use crate::ui::{theme, widgets};

/// Seconds in which the picture takes the photo's place.
const FADE_SECS: f32 = 0.15;

/// Draws the picture and listens to the pointer.
pub fn show(app: &mut App, ui: &mut Ui, canvas: Rect) {
    let Some(size) = app.picture_size() else { return };
    let response = ui.interact(canvas, ui.scope_id().with("canvas"), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Picture canvas"));
    move_picture(app, ui, &response, canvas, size);
    look_and_focus(app, ui, &response, canvas, size);
    let rect = app.pose.screen_rect(canvas, size);
    probe(app, &response, rect);
    paint(app, ui, canvas, rect);
    cross_hairs(app, ui, canvas, rect);
    read_out(app, ui, canvas, size);
}

/// Wheel, middle drag and space + drag: zoom and pan. Shared with the depth face.
pub fn move_picture(app: &mut App, ui: &Ui, response: &Response, canvas: Rect, size: Vec2) {
    let is_pan = response.dragged_by(PointerButton::Middle)
        || response.dragged_by(PointerButton::Primary) && ui.input(|input| input.key_down(Key::Space));
    if is_pan {
        app.pose.pan(canvas, size, response.drag_delta());
    }
    if let Some(at) = response.hover_pos() {
        let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        let factor = pinch * (scroll / 240.0).exp();
        if factor != 1.0 {
            app.pose.zoom_at(canvas, size, at, factor);
        }
    }
}

fn look_and_focus(app: &mut App, ui: &Ui, response: &Response, canvas: Rect, size: Vec2) {
    let is_pan = ui.input(|input| input.key_down(Key::Space));
    if response.hover_pos().is_some_and(|at| is_on_split(app, at, canvas)) {
        ui.set_cursor_icon(CursorIcon::ResizeHorizontal);
    }
    if response.drag_started() {
        let origin = ui.input(|input| input.pointer.press_origin());
        app.is_splitting = origin.is_some_and(|at| is_on_split(app, at, canvas));
    }
    if app.is_splitting && response.dragged_by(PointerButton::Primary) {
        if let Some(at) = response.interact_pointer_pos() {
            app.split = ((at.x - canvas.left()) / canvas.width()).clamp(0.02, 0.98);
        }
    } else if response.dragged_by(PointerButton::Primary) && !is_pan {
        app.is_circling = false;
        if let Some(grid) = app.document.grid() {
            // Across the shorter side the eye goes through all views; near things follow the hand.
            let per_point = grid.rows().max(grid.cols()) as f32 / canvas.size().min_elem();
            let by = -response.drag_delta() * per_point;
            let at = app.edit.viewpoint.0;
            app.look_from(ViewOffset { dv: at.dv + by.y, du: at.du + by.x });
        }
    }
    if response.clicked()
        && let Some(at) = response.interact_pointer_pos()
    {
        focus_at(app, at, app.pose.screen_rect(canvas, size));
    }
}

/// Focuses on what is under a point of the screen.
pub fn focus_at(app: &mut App, at: Pos2, rect: Rect) {
    let place = (at - rect.min) / rect.size();
    if !Rect::from_min_size(Pos2::ZERO, Vec2::splat(1.0)).contains(place.to_pos2()) {
        return;
    }
    app.probe = place;
    let Some(view) = app.nearest_view() else { return };
    if let Some(disparity) = app.document.disparity_at(view, [place.x, place.y]) {
        let tilt = app.edit.lens.focus.at(place.x, place.y) - app.edit.lens.focus.disparity_px;
        app.edit.lens.focus.disparity_px = disparity - tilt;
        app.edit.focus_at = app.document.place_in_reference(view, [place.x, place.y], disparity);
    }
}

/// What the cross-hairs go through: the pointer, or the last click.
pub fn probe(app: &mut App, response: &Response, rect: Rect) {
    app.hovered_px = None;
    let Some(at) = response.hover_pos() else { return };
    let place = (at - rect.min) / rect.size();
    if place.x >= 0.0 && place.y >= 0.0 && place.x < 1.0 && place.y < 1.0 {
        app.probe = place;
        let view = app.nearest_view();
        app.hovered_px = view.and_then(|view| app.document.disparity_at(view, [place.x, place.y]));
    }
}

fn paint(app: &mut App, ui: &Ui, canvas: Rect, rect: Rect) {
    let painter = ui.painter_at(canvas.intersect(rect));
    let holds_photo = ui.input(|input| input.key_down(Key::Backslash)) && app.document.photo.is_some();
    let is_photo_itself = app.shows_photo_itself();
    let is_complete = app.stage.as_ref().and_then(Stage::arrived).is_some_and(|(have, all)| have == all);
    let shows_field = is_complete && !holds_photo && !(is_photo_itself && app.photo.is_some());
    let opacity = ui.ctx().animate_bool_with_time(ui.scope_id().with("field"), shows_field, FADE_SECS);
    let has_photo = app.photo.is_some();
    if let Some(photo) = &mut app.photo
        && (opacity < 1.0 || app.is_before_after)
    {
        photo.paint(&painter, rect);
    }
    if opacity > 0.0 || !has_photo {
        let mut after = painter.clone();
        if app.is_before_after && has_photo {
            let x = split_x(app, canvas);
            after.set_clip_rect(Rect::from_min_max(pos2(x, canvas.top()), canvas.max).intersect(painter.clip_rect()));
        }
        paint_field(app, ui, &after, rect, if has_photo { opacity } else { 1.0 });
    }
    if let Some(peaks) = app.peaks().filter(|_| !holds_photo) {
        painter.image(peaks.id(), rect, widgets::WHOLE, theme::AS_IS);
    }
    if app.is_before_after && has_photo {
        split_line(app, ui, canvas);
    }
}

/// The light field through the lens: the picture at rest where it is there, the draft else.
fn paint_field(app: &mut App, ui: &Ui, painter: &egui::Painter, rect: Rect, opacity: f32) {
    let key = app.key_at_rest(ui.ctx().pixels_per_point());
    let at_rest = key.filter(|_| opacity >= 1.0).and_then(|key| app.rest.picture(key));
    let covers_all = at_rest.is_some_and(|(have, _)| have.is_whole_at(have.size));
    if !covers_all {
        paint_draft(app, painter, rect, opacity);
    }
    // What the lens renderer drew lies over the draft where it is what is asked for.
    if let Some((have, tiled)) = key.filter(|_| opacity >= 1.0).and_then(|key| app.rest.picture(key)) {
        tiled.paint(painter, have.on_screen(rect));
    }
}

/// The light field through the lens, at its own size.
fn paint_draft(app: &mut App, painter: &egui::Painter, rect: Rect, opacity: f32) {
    let edit = app.edit;
    let (is_moving, has_photo) = (app.is_moving, app.document.photo.is_some());
    let Some(stage) = &mut app.stage else { return };
    let draw = if edit.lens.f_number.added_views() == 0.0 {
        Draw::View(edit.viewpoint)
    } else {
        // Of a photo the lens renderer's picture comes anyway.
        let is_draft = stage.is_software() && (is_moving || has_photo);
        Draw::Refocus { lens: edit.lens, center: edit.viewpoint, is_draft }
    };
    if let Some(id) = stage.show(Slot::Picture, draw) {
        painter.image(id, rect, widgets::WHOLE, theme::AS_IS.gamma_multiply(opacity));
    }
}

fn split_x(app: &App, canvas: Rect) -> f32 {
    canvas.left() + app.split * canvas.width()
}

/// Whether a place of the screen is on the line between photo and picture.
fn is_on_split(app: &App, at: Pos2, canvas: Rect) -> bool {
    app.is_before_after && app.document.photo.is_some() && (at.x - split_x(app, canvas)).abs() < 8.0
}

fn split_line(app: &App, ui: &Ui, canvas: Rect) {
    let x = split_x(app, canvas);
    let painter = ui.painter_at(canvas);
    widgets::hair_line(&painter, pos2(x, canvas.top()), pos2(x, canvas.bottom()));
    painter.circle(pos2(x, canvas.center().y), 9.0, theme::VEIL, (1.5, theme::ON_VEIL));
    widgets::veil_label(ui, pos2(x - 8.0, canvas.top() + 8.0), Align2::RIGHT_TOP, "Photo");
    widgets::veil_label(ui, pos2(x + 8.0, canvas.top() + 8.0), Align2::LEFT_TOP, "Refocused");
}

/// Lines through the probe into both epipolar images, and a ring where the focus is set.
fn cross_hairs(app: &App, ui: &Ui, canvas: Rect, rect: Rect) {
    if app.document.field.is_none() {
        return;
    }
    let painter = ui.painter_at(canvas.intersect(rect));
    let at = rect.min + app.probe * rect.size();
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

fn read_out(app: &App, ui: &Ui, canvas: Rect, size: Vec2) {
    let (x, y) = ((app.probe.x * size.x) as u32, (app.probe.y * size.y) as u32);
    let mut text = format!("x {x}, y {y}");
    if app.document.grid().is_some() {
        let at = app.edit.viewpoint.0;
        text += &format!(" · view ({}, {})", widgets::signed(at.du, 1), widgets::signed(at.dv, 1));
    }
    let view = app.nearest_view();
    if let (Some(view), Some(field)) = (view, &app.document.field) {
        let [w, h] = field.size();
        let inside = |p: f32, n: u32| ((p * n as f32) as u32).min(n - 1);
        let [r, g, b, _] = field.view(view).pixel(inside(app.probe.x, w), inside(app.probe.y, h));
        text += &format!(" · #{r:02X}{g:02X}{b:02X}");
    }
    if let Some(d) = view.and_then(|view| app.document.disparity_at(view, [app.probe.x, app.probe.y])) {
        text += &format!(" · {} px/view", widgets::signed(d, 2));
    }
    widgets::veil_label(ui, canvas.left_bottom() + vec2(8.0, -8.0), Align2::LEFT_BOTTOM, &text);
}
