//! The depth ruler: how many rays lie at which depth, the focus as a handle, what is kept sharp as a band.

use egui::{Align2, CursorIcon, Rangef, Rect, Sense, Ui, pos2, vec2};

use crate::field::Lens;
use crate::ui::action::Action;
use crate::ui::rays::Survey;
use crate::ui::words::{self, t};
use crate::ui::{theme, widgets};

/// What the ruler shows and sets.
pub struct Ruler<'a> {
    /// How the rays are spread over depths; none before they are there.
    pub survey: Option<&'a Survey>,
    /// Focus, and what is kept sharp.
    pub lens: &'a mut Lens,
    /// The disparity under the pointer.
    pub hovered_px: Option<f32>,
    /// Whether something is being made.
    pub is_loading: bool,
}

/// Draws the ruler and listens to drags; a double click asks for the subject.
pub fn show(shown: Ruler, ui: &mut Ui) -> Option<Action> {
    let Ruler { survey, lens, hovered_px, is_loading } = shown;
    let rect = ui.max_rect().shrink2(vec2(14.0, 10.0));
    let colors = theme::palette(ui.ctx());
    let top = rect.top() + 5.0;
    ui.painter().text(pos2(rect.left(), top), Align2::LEFT_CENTER, t!("ruler-far"), theme::small(), colors.weak);
    ui.painter().text(pos2(rect.right(), top), Align2::RIGHT_CENTER, t!("ruler-near"), theme::small(), colors.weak);
    let Some(survey) = survey else {
        let text = if is_loading { t!("depths-coming") } else { t!("depths-none") };
        ui.painter().text(rect.center(), Align2::CENTER_CENTER, text, theme::small(), colors.weak);
        return None;
    };
    let bars = Rect::from_min_max(pos2(rect.left(), rect.top() + 14.0), pos2(rect.right(), rect.bottom() - 16.0));
    let scale = Scale { bars, range: survey.range_px };
    let hint = t!("ruler-hint");
    ui.painter().text(pos2(rect.center().x, top), Align2::CENTER_CENTER, hint, theme::small(), colors.weak);
    let is_shown = ui.ctx().animate_bool(ui.scope_id().with("ruler"), true);
    let action = drag_focus(&mut lens.focus.disparity_px, ui, &scale);
    band(lens, ui, &scale);
    histogram(lens, ui, survey, &scale, is_shown);
    ticks(ui, &scale);
    handle(lens.focus.disparity_px, ui, &scale);
    if let Some(hovered) = hovered_px {
        widgets::marker(ui.painter(), pos2(scale.x(hovered), bars.top() + 2.0), colors.strong);
    }
    action
}

/// Disparities along the ruler.
struct Scale {
    bars: Rect,
    range: [f32; 2],
}

impl Scale {
    fn x(&self, disparity: f32) -> f32 {
        let place = (disparity - self.range[0]) / (self.range[1] - self.range[0]);
        self.bars.left() + place.clamp(0.0, 1.0) * self.bars.width()
    }

    fn disparity(&self, x: f32) -> f32 {
        self.range[0] + (x - self.bars.left()) / self.bars.width() * (self.range[1] - self.range[0])
    }
}

fn drag_focus(focus: &mut f32, ui: &mut Ui, scale: &Scale) -> Option<Action> {
    let area = scale.bars.expand2(vec2(8.0, 8.0));
    let response = ui.interact(area, ui.scope_id().with("focus"), Sense::click_and_drag());
    let value = f64::from(*focus);
    response.widget_info(|| egui::WidgetInfo::slider(true, value, t!("focus")));
    if let Some(at) = response.interact_pointer_pos() {
        *focus = scale.disparity(at.x).clamp(scale.range[0], scale.range[1]);
    }
    let step = (scale.range[1] - scale.range[0]) / 100.0;
    *focus =
        (*focus + widgets::arrows(ui, &response) * step).clamp(scale.range[0].min(*focus), scale.range[1].max(*focus));
    if response.hovered() {
        let scroll = ui.input(|input| input.smooth_scroll_delta().y);
        let step = (scale.range[1] - scale.range[0]) / 4000.0;
        *focus += scroll * step;
        ui.set_cursor_icon(CursorIcon::ResizeHorizontal);
    }
    response.double_clicked().then_some(Action::FocusOnSubject)
}

/// What stays sharp: an amber veil whose edges can be dragged. Without a width its edges lie beside the handle.
fn band(lens: &mut Lens, ui: &mut Ui, scale: &Scale) {
    let colors = theme::palette(ui.ctx());
    let focus = lens.focus.disparity_px;
    let bars = scale.bars;
    let keep = lens.keep_sharp_px;
    let sides = [(0, -1.0, t!("sharp-far-edge")), (1, 1.0, t!("sharp-near-edge"))];
    let edges: [f32; 2] = [scale.x(focus + keep[0].min(0.0)), scale.x(focus + keep[1].max(0.0))];
    let area = Rect::from_x_y_ranges(Rangef::new(edges[0], edges[1]), bars.y_range());
    ui.painter().rect_filled(area, 2, colors.accent.gamma_multiply(0.14));
    for (side, direction, name) in sides {
        // The grip lies a little outside of the edge, so that the handle in the middle can be taken as well.
        let x = edges[side] + direction * 6.0;
        let grip = Rect::from_center_size(pos2(x, bars.center().y), vec2(9.0, bars.height()));
        let response =
            ui.interact(grip, ui.scope_id().with(name), Sense::drag()).on_hover_cursor(CursorIcon::ResizeHorizontal);
        response.widget_info(|| egui::WidgetInfo::slider(true, f64::from(keep[side]), name));
        if response.dragged() {
            let by = response.drag_delta().x / bars.width() * (scale.range[1] - scale.range[0]);
            let value = &mut lens.keep_sharp_px[side];
            *value = if side == 0 { (*value + by).min(0.0) } else { (*value + by).max(0.0) };
        }
        let is_lit = response.hovered() || response.dragged();
        if is_lit || keep[side] != 0.0 {
            let color = if is_lit { colors.accent } else { colors.accent.gamma_multiply(0.5) };
            ui.painter().vline(edges[side], bars.y_range(), (1.5, color));
        }
    }
}

fn histogram(lens: &Lens, ui: &Ui, survey: &Survey, scale: &Scale, opacity: f32) {
    let colors = theme::palette(ui.ctx());
    let bars = scale.bars;
    let step = bars.width() / Survey::BINS as f32;
    let focus = lens.focus.disparity_px;
    let keep = lens.keep_sharp_px;
    for (i, &share) in survey.bins.iter().enumerate() {
        let x = bars.left() + (i as f32 + 0.5) * step;
        let away = scale.disparity(x) - focus;
        let is_sharp = away >= keep[0] - 0.02 && away <= keep[1] + 0.02;
        let color = if is_sharp { colors.text } else { colors.bar };
        let height = (share * (bars.height() - 8.0)).max(if share > 0.0 { 1.0 } else { 0.0 });
        let bar =
            Rect::from_min_max(pos2(x - step * 0.36, bars.bottom() - height), pos2(x + step * 0.36, bars.bottom()));
        ui.painter().rect_filled(bar, 1, color.gamma_multiply(opacity));
    }
}

/// Round numbers under the bars, not nearer to each other than a label needs.
fn ticks(ui: &Ui, scale: &Scale) {
    let colors = theme::palette(ui.ctx());
    let width = scale.range[1] - scale.range[0];
    let steps = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0];
    let fits = |step: &&f32| **step / width * scale.bars.width() >= 70.0;
    let step = *steps.iter().find(fits).unwrap_or(&10.0);
    let decimals = if step < 0.1 { 2 } else { 1 };
    let first = (scale.range[0] / step).ceil() as i32;
    let last = (scale.range[1] / step).floor() as i32;
    for i in first..=last {
        let x = scale.x(i as f32 * step);
        ui.painter().vline(x, Rangef::new(scale.bars.bottom(), scale.bars.bottom() + 3.0), (1.0, colors.control));
        let text = if i == 0 { t!("zero-px-view").to_owned() } else { words::with_sign(i as f32 * step, decimals) };
        let room = 28.0;
        if x > scale.bars.left() + room && x < scale.bars.right() - room {
            let at = pos2(x, scale.bars.bottom() + 11.0);
            ui.painter().text(at, Align2::CENTER_CENTER, text, theme::small(), colors.weak);
        }
    }
}

fn handle(focus: f32, ui: &Ui, scale: &Scale) {
    let colors = theme::palette(ui.ctx());
    let x = scale.x(focus);
    let bars = scale.bars;
    ui.painter().vline(x, Rangef::new(bars.top(), bars.bottom()), (2.0, colors.accent));
    ui.painter().circle_filled(pos2(x, bars.bottom() + 1.0), 5.5, colors.accent);
    let text = words::with_sign(focus, 2);
    let side = if x > bars.right() - 60.0 { (Align2::RIGHT_CENTER, -8.0) } else { (Align2::LEFT_CENTER, 8.0) };
    ui.painter().text(pos2(x + side.1, bars.top() + 5.0), side.0, text, theme::small(), colors.accent_text);
}
