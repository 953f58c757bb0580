//! The top bar: menu, Open, what is open, the three faces, before/after, Export.

use egui::{Align, Layout, RichText, Ui, UiBuilder, vec2};

use crate::ui::action::Action;
use crate::ui::app::App;
use crate::ui::state::Face;
use crate::ui::{theme, widgets};

/// Draws the bar.
pub fn show(app: &mut App, ui: &mut Ui, is_narrow: bool) {
    let rect = ui.max_rect().shrink2(vec2(14.0, 0.0));
    let colors = theme::palette(ui.ctx());
    let ctx = ui.ctx().clone();
    let has_picture = app.picture_size().is_some();
    let row = |layout| UiBuilder::new().max_rect(rect).layout(layout);

    let mut left_end = rect.left();
    ui.scope_builder(row(Layout::left_to_right(Align::Center)), |ui| {
        ui.spacing_mut().item_spacing.x = 12.0;
        menu(app, ui);
        if widgets::button(ui, "Open…").on_hover_text(Action::Open.tip(&ctx)).clicked() {
            app.apply(Action::Open, &ctx);
        }
        left_end = ui.cursor().left();
        if has_picture {
            let room = (rect.width() / 2.0 - 150.0 - (left_end - rect.left())).max(60.0);
            ui.allocate_ui_with_layout(vec2(room, 26.0), Layout::left_to_right(Align::Center), |ui| {
                ui.add(egui::Label::new(RichText::new(&app.document.name).color(colors.strong)).truncate());
                if !is_narrow {
                    ui.add(egui::Label::new(RichText::new(&app.document.facts).color(colors.weak)).truncate());
                }
            });
        }
    });
    if !has_picture {
        return;
    }
    let faces = [(Face::Picture, "Picture"), (Face::Views, "Views"), (Face::Depths, "Ray depths")];
    let middle = egui::Rect::from_center_size(rect.center(), vec2(252.0, rect.height()));
    ui.scope_builder(UiBuilder::new().max_rect(middle).layout(Layout::left_to_right(Align::Center)), |ui| {
        widgets::segmented(ui, "Face", &mut app.face, &faces);
    });
    ui.scope_builder(row(Layout::right_to_left(Align::Center)), |ui| {
        ui.spacing_mut().item_spacing.x = 12.0;
        let can_export = app.document.field.is_some();
        ui.add_enabled_ui(can_export, |ui| {
            if widgets::main_button(ui, "Export…").on_hover_text(Action::Export.tip(&ctx)).clicked() {
                app.apply(Action::Export, &ctx);
            }
        });
        let label = RichText::new("Before / after");
        let is_on = app.is_before_after;
        let label = if is_on { label.color(colors.accent_text) } else { label };
        let button = egui::Button::new(label).min_size(vec2(0.0, 26.0)).selected(false);
        if ui.add(button).on_hover_text(Action::BeforeAfter.tip(&ctx)).clicked() {
            app.apply(Action::BeforeAfter, &ctx);
        }
        if is_narrow && widgets::button(ui, "Inspector").on_hover_text(Action::ToggleInspector.tip(&ctx)).clicked() {
            app.apply(Action::ToggleInspector, &ctx);
        }
    });
}

/// The program's name is its menu.
fn menu(app: &mut App, ui: &mut Ui) {
    let colors = theme::palette(ui.ctx());
    let name = RichText::new("Plenoscope").font(theme::title(14.0)).color(colors.strong);
    let ctx = ui.ctx().clone();
    ui.menu_button(name, |ui| {
        ui.set_min_width(220.0);
        let mut group = Action::ALL[0].spec().group;
        for next in ["File", "Edit", "View", "Help"] {
            if next != group {
                ui.separator();
            }
            group = next;
            for action in Action::ALL.into_iter().filter(|action| action.spec().group == next) {
                let spec = action.spec();
                let mut button = egui::Button::new(spec.label);
                if let Some(keys) = spec.shortcut {
                    button = button.shortcut_text(ctx.format_shortcut(&keys));
                }
                if ui.add(button).on_hover_text(spec.hint).clicked() {
                    app.apply(action, &ctx);
                    ui.close();
                }
            }
            if next == "File" {
                recent(app, ui);
            }
        }
        ui.separator();
        if ui.button("Settings…").clicked() {
            app.dialog = Some(crate::ui::app::Dialog::Settings);
            ui.close();
        }
    });
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
