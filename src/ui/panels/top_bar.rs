//! The top bar: menu, Open, what is open, the faces, before/after, Export.

use std::path::PathBuf;

use egui::{Align, Layout, Rect, RichText, Ui, UiBuilder, pos2, vec2};

use crate::ui::action::Action;
use crate::ui::command::{self, Command};
use crate::ui::document::Document;
use crate::ui::jobs::OpenFrom;
use crate::ui::look::{Face, Look};
use crate::ui::words::{Id, t};
use crate::ui::{theme, widgets};

/// Least width of the faces.
const FACES_WIDTH: f32 = 312.0;
/// Narrower than this, what the menu has as well goes.
const TIGHT_WIDTH: f32 = 820.0;
const TINY_WIDTH: f32 = 700.0;
const GAP: f32 = 12.0;

/// What the bar shows and sets.
pub struct TopBar<'a> {
    /// What is open.
    pub document: Option<&'a Document>,
    /// The face of the canvas.
    pub look: &'a mut Look,
    /// What can be done now; the menu greys out the rest.
    pub possible: &'a [Command],
    /// Opened last.
    pub recent: &'a [PathBuf],
    /// Whether the inspector is a drawer.
    pub is_narrow: bool,
}

/// Draws the bar.
pub fn show(shown: TopBar, ui: &mut Ui) -> Vec<Action> {
    let rect = ui.max_rect().shrink2(vec2(14.0, 0.0));
    let mut actions = Vec::new();
    let left_end = left(&shown, ui, rect, &mut actions);
    let Some(document) = shown.document else { return actions };
    let right_start = right(&shown, ui, rect, &mut actions);
    let faces = [
        (Face::Picture, t!("face-picture")),
        (Face::Views, t!("face-views")),
        (Face::Depths, t!("face-depths")),
        (Face::Points, t!("face-points")),
    ];
    let width = widgets::segmented_width(ui, &faces).max(FACES_WIDTH);
    let middle = rect.center().x.min(right_start - GAP - width / 2.0).max(left_end + width / 2.0);
    let place = Rect::from_center_size(pos2(middle, rect.center().y), vec2(width, rect.height()));
    ui.scope_builder(UiBuilder::new().max_rect(place).layout(Layout::left_to_right(Align::Center)), |ui| {
        widgets::segmented(ui, t!("face"), &mut shown.look.face, &faces);
    });
    let room = Rect::from_min_max(pos2(left_end, rect.top()), pos2(place.left() - GAP, rect.bottom()));
    if room.width() > 48.0 {
        ui.scope_builder(UiBuilder::new().max_rect(room).layout(Layout::left_to_right(Align::Center)), |ui| {
            name_and_facts(document, ui);
        });
    }
    actions
}

/// A command, once its button is clicked.
fn done(response: egui::Response, command: Command) -> Option<Action> {
    let tip = command.tip(&response.ctx);
    response.on_hover_text(tip).clicked().then_some(Action::Do(command))
}

/// Menu and Open…; returns where they end.
fn left(shown: &TopBar, ui: &mut Ui, rect: Rect, actions: &mut Vec<Action>) -> f32 {
    let row = UiBuilder::new().max_rect(rect).layout(Layout::left_to_right(Align::Center));
    let inner = ui.scope_builder(row, |ui| {
        ui.spacing_mut().item_spacing.x = GAP;
        menu(shown, ui, actions);
        if shown.document.is_none() || rect.width() >= TINY_WIDTH {
            actions.extend(done(widgets::button(ui, t!("open")), Command::Open));
        }
        ui.cursor().left()
    });
    inner.inner
}

/// Export, before/after, the inspector's button; returns where they begin.
fn right(shown: &TopBar, ui: &mut Ui, rect: Rect, actions: &mut Vec<Action>) -> f32 {
    let colors = theme::palette(ui.ctx());
    let row = UiBuilder::new().max_rect(rect).layout(Layout::right_to_left(Align::Center));
    let inner = ui.scope_builder(row, |ui| {
        ui.spacing_mut().item_spacing.x = GAP;
        ui.add_enabled_ui(shown.possible.contains(&Command::Export), |ui| {
            actions.extend(done(widgets::main_button(ui, t!("export-open")), Command::Export));
        });
        if rect.width() >= TIGHT_WIDTH && shown.possible.contains(&Command::BeforeAfter) {
            let label = RichText::new(t!("before-after"));
            let label = if shown.look.split.is_shown { label.color(colors.accent_text) } else { label };
            let button = egui::Button::new(label).min_size(vec2(0.0, 26.0)).selected(false);
            actions.extend(done(ui.add(button), Command::BeforeAfter));
        }
        if shown.is_narrow {
            actions.extend(done(widgets::button(ui, t!("inspector")), Command::ToggleInspector));
        }
        ui.cursor().right()
    });
    inner.inner
}

/// What is open; what it is where there is room for all of that, else under the pointer.
fn name_and_facts(document: &Document, ui: &mut Ui) {
    let (name, facts) = (&document.subject.name, document.facts());
    let colors = theme::palette(ui.ctx());
    ui.spacing_mut().item_spacing.x = GAP;
    let name = egui::Label::new(RichText::new(name).color(colors.strong)).truncate();
    ui.add(name).on_hover_text(&facts);
    let galley = ui.painter().layout_no_wrap(facts.clone(), theme::text(), colors.weak);
    if galley.size().x <= ui.available_width() {
        ui.label(RichText::new(facts).color(colors.weak));
    }
}

/// The program's name is its menu.
fn menu(shown: &TopBar, ui: &mut Ui, actions: &mut Vec<Action>) {
    let colors = theme::palette(ui.ctx());
    let name = RichText::new("Plenoscope").font(theme::title(14.0)).color(colors.strong);
    ui.menu_button(name, |ui| {
        ui.set_min_width(230.0);
        // What is done with files is most of it; all else folds.
        let (first, others) = Command::GROUPS.split_at(1);
        first.iter().for_each(|group| actions.extend(commands(shown.possible, ui, *group)));
        actions.extend(recent(shown.recent, ui));
        ui.separator();
        for group in others {
            ui.menu_button(group.text(), |ui| {
                ui.set_min_width(230.0);
                actions.extend(commands(shown.possible, ui, *group));
            });
        }
    });
}

fn commands(possible: &[Command], ui: &mut Ui, group: Id) -> Option<Action> {
    let mut chosen = None;
    for command in Command::of_group(group) {
        let spec = command.spec();
        let mut button = egui::Button::new(spec.label());
        if let Some(keys) = spec.shortcut {
            button = button.shortcut_text(command::spelled(&keys, ui.ctx()));
        }
        if ui.add_enabled(possible.contains(&command), button).on_hover_text(spec.hint()).clicked() {
            chosen = Some(Action::Do(command));
            ui.close();
        }
    }
    chosen
}

fn recent(files: &[PathBuf], ui: &mut Ui) -> Option<Action> {
    let mut chosen = None;
    if files.is_empty() {
        return None;
    }
    ui.menu_button(t!("recent"), |ui| {
        for path in files {
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
            if ui.button(name).on_hover_text(path.display().to_string()).clicked() {
                chosen = Some(Action::Open(OpenFrom::File(path.clone())));
                ui.close();
            }
        }
    });
    chosen
}
