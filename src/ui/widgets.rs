//! The few controls that the window is made of, all in the theme's look and with names for screen readers.

use egui::{
    Align2, CursorIcon, FontId, Key, Modifiers, Rect, Response, RichText, Role, Sense, Shape, StrokeKind, Ui,
    UiBuilder, Vec2, WidgetInfo, epaint::RectShape, pos2, vec2,
};

use super::theme::{self, GRID};
use super::words::{self, Id, t};

/// Height of a row of the inspector.
const ROW_HEIGHT: f32 = 20.0;
/// Width of the names before a dialog's fields.
const LABEL_WIDTH: f32 = 96.0;

/// Draws in a part of the window, and nowhere else.
pub fn inside<T>(ui: &mut Ui, rect: Rect, add: impl FnOnce(&mut Ui) -> T) -> T {
    let part = ui.scope_builder(UiBuilder::new().max_rect(rect), |ui| {
        ui.set_clip_rect(rect.intersect(ui.clip_rect()));
        add(ui)
    });
    part.inner
}

/// As [`inside`], on a ground of its own.
pub fn panel<T>(ui: &mut Ui, rect: Rect, fill: egui::Color32, add: impl FnOnce(&mut Ui) -> T) -> T {
    ui.painter().rect_filled(rect, 0, fill);
    inside(ui, rect, add)
}

/// A ring round what has the keyboard, over everything, whatever it is.
pub fn show_focus(ctx: &egui::Context) {
    let Some(response) = ctx.memory(|memory| memory.focused()).and_then(|id| ctx.read_response(id)) else { return };
    let colors = theme::palette(ctx);
    let layer = egui::LayerId::new(egui::Order::Tooltip, egui::Id::unique("focus_ring"));
    let ring = response.rect.expand(1.0).intersect(ctx.content_rect().shrink(1.0));
    ctx.layer_painter(layer).rect_stroke(ring, theme::RADIUS, (2.0, colors.accent_text), StrokeKind::Outside);
}

/// By how much arrows turn what has the keyboard; commands do not hear of them then.
pub fn arrows(ui: &Ui, response: &Response) -> f32 {
    if !response.has_focus() {
        return 0.0;
    }
    ui.data_mut(|data| data.insert_temp(takes_arrows(), response.id));
    // Else the toolkit takes them for the way to the next thing.
    let arrows = egui::EventFilter { horizontal_arrows: true, vertical_arrows: true, ..egui::EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
    let turns = |key: Key| ui.input_mut(|input| input.count_and_consume_key(Modifiers::NONE, key)) as f32;
    turns(Key::ArrowRight) + turns(Key::ArrowUp) - turns(Key::ArrowLeft) - turns(Key::ArrowDown)
}

/// Whether arrows turn what has the keyboard.
pub fn has_arrows(ctx: &egui::Context) -> bool {
    let focused = ctx.memory(|memory| memory.focused());
    focused.is_some() && focused == ctx.data(|data| data.get_temp(takes_arrows()))
}

fn takes_arrows() -> egui::Id {
    egui::Id::unique("takes_arrows")
}

/// A plain button.
pub fn button(ui: &mut Ui, label: &str) -> Response {
    ui.add(egui::Button::new(label).min_size(vec2(0.0, 26.0)))
}

/// The main action: amber.
pub fn main_button(ui: &mut Ui, label: &str) -> Response {
    let colors = theme::palette(ui.ctx());
    let text = RichText::new(label).font(theme::title(13.0)).color(colors.on_accent);
    ui.add(egui::Button::new(text).fill(colors.accent).min_size(vec2(0.0, 26.0)))
}

/// Text that can be clicked.
pub fn link(ui: &mut Ui, label: &str) -> Response {
    let colors = theme::palette(ui.ctx());
    let galley = ui.painter().layout_no_wrap(label.to_owned(), theme::small(), colors.weak);
    let (rect, response) = ui.allocate_exact_size(galley.size(), Sense::click());
    let color = if response.hovered() || response.has_focus() { colors.strong } else { colors.weak };
    ui.painter().galley_with_override_text_color(rect.min, galley, color);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, label));
    response.on_hover_cursor(CursorIcon::PointingHand)
}

/// One of several, side by side in a well. True when the choice changed.
pub fn segmented<T: Clone + PartialEq>(
    ui: &mut Ui,
    name: &str,
    value: &mut T,
    choices: &[(T, impl AsRef<str>)],
) -> bool {
    let colors = theme::palette(ui.ctx());
    let pad = 3.0 * GRID;
    let galleys: Vec<_> = choices
        .iter()
        .map(|(_, label)| ui.painter().layout_no_wrap(label.as_ref().to_owned(), theme::text(), colors.weak))
        .collect();
    let width: f32 = galleys.iter().map(|galley| galley.size().x + 2.0 * pad).sum();
    let (rect, _) = ui.allocate_exact_size(vec2(width + 4.0, 26.0), Sense::hover());
    ui.painter().rect_filled(rect, theme::RADIUS, colors.well);
    let mut left = rect.left() + 2.0;
    let mut is_changed = false;
    for ((choice, label), galley) in choices.iter().zip(galleys) {
        let part = Rect::from_min_size(pos2(left, rect.top() + 2.0), vec2(galley.size().x + 2.0 * pad, 22.0));
        left = part.right();
        let id = ui.scope_id().with((name, label.as_ref()));
        let response = ui.interact(part, id, Sense::click()).on_hover_cursor(CursorIcon::PointingHand);
        let is_chosen = value == choice;
        response.widget_info(|| WidgetInfo::selected(Role::RadioButton, true, is_chosen, label.as_ref()));
        if is_chosen {
            ui.painter().rect_filled(part, theme::RADIUS - 2, colors.hovered);
        }
        if response.has_focus() {
            ui.painter().rect_stroke(part, theme::RADIUS - 2, (1.0, colors.accent), StrokeKind::Inside);
        }
        let is_lit = is_chosen || response.hovered();
        let color = if is_lit { colors.strong } else { colors.weak };
        ui.painter().galley_with_override_text_color(part.center() - galley.size() / 2.0, galley, color);
        if response.clicked() && !is_chosen {
            *value = choice.clone();
            is_changed = true;
        }
    }
    is_changed
}

/// How wide such a choice is.
pub fn segmented_width<T>(ui: &Ui, choices: &[(T, impl AsRef<str>)]) -> f32 {
    let width = |text: &str| ui.painter().layout_no_wrap(text.to_owned(), theme::text(), theme::AS_IS).size().x;
    choices.iter().map(|(_, label)| width(label.as_ref()) + 6.0 * GRID).sum::<f32>() + 4.0
}

/// A dialog of the window's own, with room round its content.
pub fn modal(ctx: &egui::Context, name: &str) -> egui::Modal {
    let frame = egui::Frame::window(&ctx.global_style()).inner_margin(5.0 * GRID).shadow(egui::Shadow::NONE);
    egui::Modal::new(egui::Id::unique(name)).frame(frame).backdrop_color(theme::VEIL.gamma_multiply(0.7))
}

/// Whether Enter was pressed for what stands out in a dialog: the keyboard is on nothing else.
pub fn takes_enter(ctx: &egui::Context) -> bool {
    let is_free = ctx.memory(|memory| memory.focused().is_none());
    is_free && ctx.input(|input| input.key_pressed(egui::Key::Enter))
}

/// A row of a dialog: name on the left, field on the right.
pub fn labelled(ui: &mut Ui, label: &str, field: impl FnOnce(&mut Ui)) {
    let weak = theme::palette(ui.ctx()).weak;
    ui.horizontal(|ui| {
        ui.set_min_height(26.0);
        let galley = ui.painter().layout_no_wrap(label.to_owned(), theme::text(), weak);
        let (rect, _) = ui.allocate_exact_size(vec2(LABEL_WIDTH.max(galley.size().x), 20.0), Sense::hover());
        ui.painter().galley(Align2::LEFT_CENTER.anchor_size(rect.left_center(), galley.size()).min, galley, weak);
        field(ui);
    });
}

/// How a number is shown and turned.
pub struct Number<'a> {
    /// Its name.
    pub label: &'a str,
    /// Least and greatest value.
    pub range: [f32; 2],
    /// Change for one point of dragging.
    pub speed: f32,
    /// Decimals.
    pub decimals: usize,
    /// Unit before the number.
    pub prefix: &'a str,
    /// Unit behind it.
    pub suffix: &'a str,
    /// Value after a double click on the name.
    pub reset: f32,
    /// What it does.
    pub hint: &'a str,
}

/// A named number: dragged, typed, or reset with a double click on its name. True when it changed.
pub fn number(ui: &mut Ui, value: &mut f32, spec: &Number) -> bool {
    let before = *value;
    ui.spacing_mut().interact_size.y = ROW_HEIGHT;
    ui.horizontal(|ui| {
        name(ui, spec, value);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| drag_value(ui, value, spec));
    });
    *value != before
}

fn name(ui: &mut Ui, spec: &Number, value: &mut f32) {
    let colors = theme::palette(ui.ctx());
    let label = ui.add(egui::Label::new(RichText::new(spec.label).color(colors.text)).sense(Sense::click()));
    if label.double_clicked() {
        *value = spec.reset;
    }
    label.on_hover_text(t!("resets", hint = spec.hint));
}

/// The number alone, without its name.
pub fn drag_value(ui: &mut Ui, value: &mut f32, spec: &Number) {
    let colors = theme::palette(ui.ctx());
    ui.scope(|ui| {
        // No box until the pointer is there: a box in a panel is noise.
        ui.visuals_mut().widgets.inactive.weak_bg_fill = egui::Color32::TRANSPARENT;
        ui.visuals_mut().widgets.inactive.fg_stroke.color = colors.strong;
        ui.spacing_mut().button_padding = vec2(GRID, 1.0);
        ui.spacing_mut().interact_size = vec2(20.0, 20.0);
        let decimals = spec.decimals;
        let drag = egui::DragValue::new(value)
            .range(spec.range[0]..=spec.range[1])
            .speed(spec.speed)
            .prefix(spec.prefix)
            .suffix(spec.suffix)
            .custom_formatter(move |n, _| words::number(n, decimals))
            .custom_parser(words::typed);
        let response = ui.add(drag).on_hover_text(spec.hint);
        let label = spec.label.to_owned();
        response.widget_info(|| WidgetInfo::labeled(Role::SpinButton, true, &label));
    });
}

/// A number of egui's own as the language writes it.
pub fn spoken(drag: egui::DragValue) -> egui::DragValue {
    let shown = |n, decimals| words::decimal(&egui::emath::format_with_decimals_in_range(n, decimals));
    drag.custom_formatter(shown).custom_parser(words::typed)
}

/// A slider over 0 to 1 with an amber part before the knob. Double-click asks for the reset value.
pub fn slider(ui: &mut Ui, label: &str, place: &mut f32, reset: f32) -> Response {
    let colors = theme::palette(ui.ctx());
    let (rect, mut response) = ui.allocate_exact_size(vec2(ui.available_width(), 16.0), Sense::click_and_drag());
    let track = Rect::from_center_size(rect.center(), vec2(rect.width() - 12.0, 4.0));
    let before = *place;
    if response.double_clicked() {
        *place = reset;
    } else if let Some(pointer) = response.interact_pointer_pos() {
        *place = ((pointer.x - track.left()) / track.width()).clamp(0.0, 1.0);
    }
    let mut steps = arrows(ui, &response);
    if response.hovered() {
        steps += ui.input(|input| input.smooth_scroll_delta().y) / 50.0;
    }
    *place = (*place + steps * 0.02).clamp(0.0, 1.0);
    if *place != before {
        response.mark_changed();
    }
    let knob = pos2(track.left() + *place * track.width(), track.center().y);
    ui.painter().rect_filled(track, 2, colors.control);
    ui.painter().rect_filled(Rect::from_min_max(track.min, pos2(knob.x, track.bottom())), 2, colors.accent);
    let is_lit = response.hovered() || response.dragged() || response.has_focus();
    let radius = if is_lit { 7.5 } else { 6.5 };
    ui.painter().circle(knob, radius, colors.strong, (1.0, colors.panel));
    let value = f64::from(*place);
    response.widget_info(|| WidgetInfo::slider(true, value, label));
    response.on_hover_cursor(CursorIcon::PointingHand)
}

/// A named thing that is on or off. True when it changed.
pub fn switch(ui: &mut Ui, label: &str, is_on: &mut bool, hint: &str) -> bool {
    let colors = theme::palette(ui.ctx());
    let (row, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW_HEIGHT), Sense::click());
    if response.clicked() {
        *is_on = !*is_on;
    }
    let is_lit = response.hovered() || response.has_focus();
    let color = if is_lit { colors.strong } else { colors.text };
    ui.painter().text(row.left_center(), Align2::LEFT_CENTER, label, theme::text(), color);
    let track = Rect::from_center_size(row.right_center() - vec2(14.0, 0.0), vec2(26.0, 14.0));
    let place = ui.ctx().animate_bool(response.id, *is_on);
    ui.painter().rect_filled(track, 7, colors.control.lerp_to_gamma(colors.accent, place));
    let knob = pos2(egui::lerp(track.left() + 7.0..=track.right() - 7.0, place), track.center().y);
    ui.painter().circle_filled(knob, 5.0, if is_lit { colors.strong } else { colors.knob });
    let now = *is_on;
    response.widget_info(|| WidgetInfo::selected(Role::CheckBox, true, now, label));
    let is_changed = response.clicked();
    response.on_hover_cursor(CursorIcon::PointingHand).on_hover_text(hint);
    is_changed
}

/// A section of the inspector: head, something beside it, and a body that folds away with a click on the head.
pub fn section(ui: &mut Ui, title: Id, beside: impl FnOnce(&mut Ui), body: impl FnOnce(&mut Ui)) {
    let colors = theme::palette(ui.ctx());
    let id = ui.scope_id().with(("section", title.0));
    let title = title.text();
    let is_open = ui.data_mut(|data| *data.get_persisted_mut_or(id, true));
    ui.horizontal(|ui| {
        let text = RichText::new(title).font(theme::head()).color(colors.weak);
        let head = ui.add(egui::Label::new(text).sense(Sense::click())).on_hover_cursor(CursorIcon::PointingHand);
        head.widget_info(|| WidgetInfo::labeled(Role::Button, true, title));
        if head.clicked() {
            ui.data_mut(|data| data.insert_persisted(id, !is_open));
        }
        if is_open {
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), beside);
        }
    });
    if is_open {
        ui.add_space(GRID);
        body(ui);
    }
    ui.add_space(4.0 * GRID);
}

/// A small label on a veil, over a picture.
pub fn veil_label(ui: &Ui, at: egui::Pos2, align: Align2, text: &str) -> Rect {
    veil_label_in(ui, at, align, text, theme::small())
}

/// As [`veil_label`], in another size.
pub fn veil_label_in(ui: &Ui, at: egui::Pos2, align: Align2, text: &str, font: FontId) -> Rect {
    let galley = ui.painter().layout_no_wrap(text.to_owned(), font, theme::ON_VEIL);
    let inside = align.anchor_size(at, galley.size() + vec2(12.0, 4.0));
    ui.painter().rect_filled(inside, 4, theme::VEIL);
    ui.painter().galley(inside.min + vec2(6.0, 2.0), galley, theme::ON_VEIL);
    inside
}

/// A picture with rounded corners.
pub fn picture(painter: &egui::Painter, id: egui::TextureId, rect: Rect, uv: Rect, opacity: f32) {
    let tint = theme::AS_IS.gamma_multiply(opacity);
    painter.add(RectShape::filled(rect, theme::PICTURE_RADIUS, tint).with_texture(id, uv));
}

/// The whole of a texture.
pub const WHOLE: Rect = Rect { min: egui::Pos2::ZERO, max: pos2(1.0, 1.0) };

/// The middle of a picture that fills a cell without being squeezed.
pub fn covering(picture: Vec2, cell: Vec2) -> Rect {
    let (wide, room) = (picture.x / picture.y, cell.x / cell.y);
    let cut = if wide > room { vec2((1.0 - room / wide) / 2.0, 0.0) } else { vec2(0.0, (1.0 - wide / room) / 2.0) };
    WHOLE.shrink2(cut)
}

/// A line that shows on anything: light on a dark rim.
pub fn hair_line(painter: &egui::Painter, from: egui::Pos2, to: egui::Pos2) {
    painter.line_segment([from, to], (2.5, theme::HAIR_RIM));
    painter.line_segment([from, to], (1.0, theme::HAIR));
}

/// A small triangle that points down with its tip at `at`.
pub fn marker(painter: &egui::Painter, at: egui::Pos2, color: egui::Color32) {
    let corners = vec![at, at + Vec2::new(-4.0, -6.0), at + Vec2::new(4.0, -6.0)];
    painter.add(Shape::convex_polygon(corners, color, egui::Stroke::NONE));
}
