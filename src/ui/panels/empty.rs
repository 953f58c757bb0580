//! Nothing is open: one sentence, one drop target, and the ways in. And the veil while a file is dragged over.

use std::path::{Path, PathBuf};

use egui::{
    Align, Align2, CursorIcon, Layout, Rect, RichText, Sense, StrokeKind, TextureHandle, Ui, UiBuilder, Vec2, vec2,
};

use crate::ui::action::Action;
use crate::ui::command::Command;
use crate::ui::jobs::OpenFrom;
use crate::ui::words::t;
use crate::ui::{theme, widgets};

/// Recent files that are shown.
const MOST_RECENT: usize = 5;
/// A recent file's picture with its name under it.
const CARD: Vec2 = vec2(128.0, 108.0);
const GAP: f32 = 12.0;
/// Least width of the buttons.
const BUTTONS_WIDTH: f32 = 268.0;

/// Small pictures of recent files.
pub type Thumbnails = [(PathBuf, TextureHandle)];

/// Draws the empty canvas.
pub fn show(recent: &[PathBuf], thumbnails: &Thumbnails, ui: &mut Ui) -> Option<Action> {
    let mut action = None;
    let area = ui.max_rect().shrink(32.0);
    let colors = theme::palette(ui.ctx());
    dashed(ui, area);
    let recent = &recent[..recent.len().min(MOST_RECENT)];
    let height = 150.0 + if recent.is_empty() { 0.0 } else { 60.0 + CARD.y };
    let middle = Rect::from_center_size(area.center(), vec2(area.width().min(720.0), height));
    let builder = UiBuilder::new().max_rect(middle).layout(Layout::top_down(Align::Center));
    ui.scope_builder(builder, |ui| {
        ui.label(RichText::new(t!("empty-title")).font(theme::title(24.0)).color(colors.strong));
        ui.add_space(6.0);
        ui.label(RichText::new(t!("empty-promise")).color(colors.weak));
        ui.add_space(20.0);
        action = ways_in(ui);
        if !recent.is_empty() {
            ui.add_space(28.0);
            ui.label(RichText::new(t!("recent")).font(theme::head()).color(colors.weak));
            ui.add_space(4.0);
        }
        let width = recent.len() as f32 * (CARD.x + GAP) - GAP;
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = GAP;
            ui.add_space((ui.available_width() - width).max(0.0) / 2.0);
            for path in recent {
                let picture = thumbnails.iter().find(|(of, _)| of == path).map(|(_, picture)| picture);
                if card(picture, ui, path) {
                    action = Some(Action::Open(OpenFrom::File(path.clone())));
                }
            }
        });
    });
    action
}

/// Buttons in the middle.
fn ways_in(ui: &mut Ui) -> Option<Action> {
    let buttons = [(t!("open"), Command::Open), (t!("paste"), Command::Paste), (t!("try-sample"), Command::OpenSample)];
    let (ctx, mut action) = (ui.ctx().clone(), None);
    let text_width = |label: &str| ui.painter().layout_no_wrap(label.to_owned(), theme::text(), theme::AS_IS).size().x;
    let spacing = ui.spacing();
    let beside = 2.0 * spacing.button_padding.x * 3.0 + 2.0 * spacing.item_spacing.x;
    let width = beside + buttons.iter().map(|(label, _)| text_width(label)).sum::<f32>();
    ui.horizontal(|ui| {
        ui.add_space((ui.available_width() - width.max(BUTTONS_WIDTH)).max(0.0) / 2.0);
        for (label, command) in buttons {
            let button = if command == Command::Open { widgets::main_button } else { widgets::button };
            if button(ui, label).on_hover_text(command.tip(&ctx)).clicked() {
                action = Some(Action::Do(command));
            }
        }
    });
    action
}

/// A recent file: its small picture and its name. True once it is clicked.
fn card(texture: Option<&TextureHandle>, ui: &mut Ui, path: &Path) -> bool {
    let colors = theme::palette(ui.ctx());
    let (rect, response) = ui.allocate_exact_size(CARD, Sense::click());
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let picture = Rect::from_min_size(rect.min, vec2(CARD.x, CARD.y - 22.0));
    ui.painter().rect_filled(picture, theme::RADIUS, colors.panel);
    if let Some(texture) = texture {
        let uv = widgets::covering(texture.size_vec2(), picture.size());
        widgets::picture(ui.painter(), texture.id(), picture, uv, 1.0);
    }
    let is_lit = response.hovered() || response.has_focus();
    if is_lit {
        ui.painter().rect_stroke(picture, theme::PICTURE_RADIUS, (1.5, colors.strong), StrokeKind::Outside);
    }
    let color = if is_lit { colors.strong } else { colors.weak };
    let mut job = egui::text::LayoutJob::simple_singleline(name.clone(), theme::small(), color);
    job.wrap = egui::text::TextWrapping::truncate_at_width(CARD.x);
    let galley = ui.painter().layout_job(job);
    ui.painter().galley(rect.center_bottom() - vec2(galley.size().x / 2.0, 16.0), galley, color);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name.clone()));
    response.on_hover_cursor(CursorIcon::PointingHand).on_hover_text(path.display().to_string()).clicked()
}

fn dashed(ui: &Ui, area: Rect) {
    let color = theme::palette(ui.ctx()).control;
    let corners = [area.left_top(), area.right_top(), area.right_bottom(), area.left_bottom(), area.left_top()];
    ui.painter().extend(egui::Shape::dashed_line(&corners, (1.5, color), 6.0, 6.0));
}

/// While a file is dragged over the window: the whole of it is the target.
pub fn drop_hint(is_open: bool, ui: &Ui, all: Rect) {
    if ui.input(|input| input.raw.hovered_files.is_empty()) {
        return;
    }
    let colors = theme::palette(ui.ctx());
    let painter = ui.ctx().layer_painter(egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("drop")));
    painter.rect_filled(all, 0, theme::VEIL);
    painter.rect_stroke(all.shrink(12.0), 10, (2.0, colors.accent), StrokeKind::Inside);
    let text = if is_open { t!("drop-instead") } else { t!("drop") };
    painter.text(all.center(), Align2::CENTER_CENTER, text, theme::title(22.0), theme::ON_VEIL);
}
