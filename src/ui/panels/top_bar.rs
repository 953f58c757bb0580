//! The top bar: menu, Open, what is open, the three faces, before/after, Export.

use egui::{Align, Layout, Rect, RichText, Ui, UiBuilder, pos2, vec2};

use crate::ui::action::Action;
use crate::ui::app::App;
use crate::ui::state::Face;
use crate::ui::{theme, widgets};

/// Width of the three faces.
const FACES_WIDTH: f32 = 252.0;
/// Narrower than this, what the menu has as well goes.
const TIGHT_WIDTH: f32 = 820.0;
const TINY_WIDTH: f32 = 700.0;
const GAP: f32 = 12.0;

/// Draws the bar.
pub fn show(app: &mut App, ui: &mut Ui, is_narrow: bool) {
    let rect = ui.max_rect().shrink2(vec2(14.0, 0.0));
    let has_picture = app.picture_size().is_some();
    let left_end = left(app, ui, rect, has_picture);
    if !has_picture {
        return;
    }
    let right_start = right(app, ui, rect, is_narrow);
    let half = FACES_WIDTH / 2.0;
    let middle = rect.center().x.min(right_start - GAP - half).max(left_end + half);
    let faces = [(Face::Picture, "Picture"), (Face::Views, "Views"), (Face::Depths, "Ray depths")];
    let place = Rect::from_center_size(pos2(middle, rect.center().y), vec2(FACES_WIDTH, rect.height()));
    ui.scope_builder(UiBuilder::new().max_rect(place).layout(Layout::left_to_right(Align::Center)), |ui| {
        widgets::segmented(ui, "Face", &mut app.face, &faces);
    });
    let room = Rect::from_min_max(pos2(left_end, rect.top()), pos2(place.left() - GAP, rect.bottom()));
    if room.width() > 48.0 {
        ui.scope_builder(UiBuilder::new().max_rect(room).layout(Layout::left_to_right(Align::Center)), |ui| {
            name_and_facts(app, ui);
        });
    }
}

/// Menu and Open…; returns where they end.
fn left(app: &mut App, ui: &mut Ui, rect: Rect, has_picture: bool) -> f32 {
    let ctx = ui.ctx().clone();
    let row = UiBuilder::new().max_rect(rect).layout(Layout::left_to_right(Align::Center));
    let inner = ui.scope_builder(row, |ui| {
        ui.spacing_mut().item_spacing.x = GAP;
        menu(app, ui);
        let has_room = !has_picture || rect.width() >= TINY_WIDTH;
        if has_room && widgets::button(ui, "Open…").on_hover_text(Action::Open.tip(&ctx)).clicked() {
            app.apply(Action::Open, &ctx);
        }
        ui.cursor().left()
    });
    inner.inner
}

/// Export, before/after, the inspector's button; returns where they begin.
fn right(app: &mut App, ui: &mut Ui, rect: Rect, is_narrow: bool) -> f32 {
    let colors = theme::palette(ui.ctx());
    let ctx = ui.ctx().clone();
    let row = UiBuilder::new().max_rect(rect).layout(Layout::right_to_left(Align::Center));
    let inner = ui.scope_builder(row, |ui| {
        ui.spacing_mut().item_spacing.x = GAP;
        ui.add_enabled_ui(app.can(Action::Export), |ui| {
            if widgets::main_button(ui, "Export…").on_hover_text(Action::Export.tip(&ctx)).clicked() {
                app.apply(Action::Export, &ctx);
            }
        });
        if rect.width() >= TIGHT_WIDTH && app.can(Action::BeforeAfter) {
            let label = RichText::new("Before / after");
            let label = if app.is_before_after { label.color(colors.accent_text) } else { label };
            let button = egui::Button::new(label).min_size(vec2(0.0, 26.0)).selected(false);
            if ui.add(button).on_hover_text(Action::BeforeAfter.tip(&ctx)).clicked() {
                app.apply(Action::BeforeAfter, &ctx);
            }
        }
        if is_narrow && widgets::button(ui, "Inspector").on_hover_text(Action::ToggleInspector.tip(&ctx)).clicked() {
            app.apply(Action::ToggleInspector, &ctx);
        }
        ui.cursor().right()
    });
    inner.inner
}

/// What is open; what it is where there is room for all of that, else under the pointer.
fn name_and_facts(app: &App, ui: &mut Ui) {
    let colors = theme::palette(ui.ctx());
    ui.spacing_mut().item_spacing.x = GAP;
    let name = egui::Label::new(RichText::new(&app.document.name).color(colors.strong)).truncate();
    ui.add(name).on_hover_text(&app.document.facts);
    let facts = ui.painter().layout_no_wrap(app.document.facts.clone(), theme::text(), colors.weak);
    if facts.size().x <= ui.available_width() {
        ui.label(RichText::new(&app.document.facts).color(colors.weak));
    }
}

/// The program's name is its menu.
fn menu(app: &mut App, ui: &mut Ui) {
    let colors = theme::palette(ui.ctx());
    let name = RichText::new("Plenoscope").font(theme::title(14.0)).color(colors.strong);
    ui.menu_button(name, |ui| {
        ui.set_min_width(230.0);
        // What is done with files is most of it; all else folds.
        let (first, others) = Action::GROUPS.split_at(1);
        first.iter().for_each(|group| actions(app, ui, group));
        recent(app, ui);
        ui.separator();
        for group in others {
            ui.menu_button(*group, |ui| {
                ui.set_min_width(230.0);
                actions(app, ui, group);
            });
        }
    });
}

fn actions(app: &mut App, ui: &mut Ui, group: &str) {
    let ctx = ui.ctx().clone();
    for action in Action::of_group(group) {
        let spec = action.spec();
        let mut button = egui::Button::new(spec.label);
        if let Some(keys) = spec.shortcut {
            button = button.shortcut_text(ctx.format_shortcut(&keys));
        }
        if ui.add_enabled(app.can(action), button).on_hover_text(spec.hint).clicked() {
            app.apply(action, &ctx);
            ui.close();
        }
    }
}

fn recent(app: &mut App, ui: &mut Ui) {
    if app.settings.recent.is_empty() {
        return;
    }
    ui.menu_button("Recent", |ui| {
        for path in app.settings.recent.clone() {
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
            if ui.button(name).on_hover_text(path.display().to_string()).clicked() {
                app.open(crate::ui::jobs::From::File(path));
                ui.close();
            }
        }
    });
}
