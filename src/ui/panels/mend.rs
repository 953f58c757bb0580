//! Inspector section of the repair tool: what the hand does, what is done to the chosen thing, and what was done.

use egui::{Align, Button, Layout, RichText, ScrollArea, Ui, vec2};

use crate::repair::{Entry, Operation, Repairs};
use crate::scene::Making;
use crate::ui::action::Action;
use crate::ui::command::Command;
use crate::ui::mending::{Mending, Tool};
use crate::ui::theme::{self, GRID};
use crate::ui::widgets::{self, Number};
use crate::ui::words::{heard, id, t};

/// Buttons side by side.
const ROW: usize = 3;
/// Points of the list before it scrolls.
const LIST_HEIGHT: f32 = 120.0;

/// Draws the section, while the tool is held or something was mended.
pub fn show(mending: &mut Mending, repairs: &Repairs, ui: &mut Ui) -> Vec<Action> {
    mending.pointed_at = None;
    if !mending.is_on && repairs.is_empty() {
        return Vec::new();
    }
    let mut actions = Vec::new();
    let (mut leaves, tip) = (false, Command::Repair.tip(ui.ctx()));
    let word = if mending.is_on { t!("link-done") } else { t!("link-mend") };
    widgets::section(
        ui,
        id!("section-repair"),
        |ui| leaves = widgets::link(ui, word).on_hover_text(tip).clicked(),
        |ui| {
            if mending.is_on {
                tools(mending, ui);
                actions.extend(of_tool(mending, ui));
            }
            actions.extend(list(mending, repairs, ui));
        },
    );
    if leaves {
        actions.push(Action::Do(Command::Repair));
    }
    actions
}

fn tools(mending: &mut Mending, ui: &mut Ui) {
    let before = mending.tool;
    widgets::segmented(ui, t!("repair-tool"), &mut mending.tool, &Tool::ALL[..2]);
    ui.add_space(GRID);
    widgets::segmented(ui, t!("repair-brush"), &mut mending.tool, &Tool::ALL[2..]);
    ui.add_space(GRID);
    if before != mending.tool {
        mending.choose(None);
    }
}

/// Sizes, and what can be done.
fn of_tool(mending: &mut Mending, ui: &mut Ui) -> Vec<Action> {
    let share = |label, reset, hint| Number {
        label,
        range: Mending::SIZES.map(|size| size * 100.0),
        speed: 0.2,
        decimals: 1,
        prefix: "",
        suffix: " %",
        reset: reset * 100.0,
        hint,
    };
    if let Tool::Brush(_) = mending.tool {
        let mut percent = mending.brush * 100.0;
        widgets::number(ui, &mut percent, &share(t!("brush"), Mending::BRUSH, t!("brush-hint")));
        mending.brush = percent / 100.0;
        let spec = Number {
            label: t!("brush-strength"),
            range: [0.0, 1.0],
            speed: 0.01,
            decimals: 2,
            prefix: "",
            suffix: "",
            reset: Mending::STRENGTH,
            hint: t!("brush-strength-hint"),
        };
        widgets::number(ui, &mut mending.strength, &spec);
        return Vec::new();
    }
    let before = mending.reach * 100.0;
    let mut percent = before;
    if mending.tool == Tool::Thing {
        let hint = t!("reach-hint");
        widgets::number(ui, &mut percent, &share(t!("reach"), Mending::REACH, hint));
    }
    if percent != before {
        mending.grow(percent / before);
    }
    let spec = Number {
        label: t!("by"),
        range: [0.01, 5.0],
        speed: 0.005,
        decimals: 2,
        prefix: "",
        suffix: t!("suffix-px-view"),
        reset: Mending::BY_PX,
        hint: t!("by-hint"),
    };
    widgets::number(ui, &mut mending.by_px, &spec);
    operations(mending, ui)
}

fn operations(mending: &Mending, ui: &mut Ui) -> Vec<Action> {
    let by = mending.by_px / Making::LONG_SIDE as f32;
    let all = [
        (Operation::Nearer(by), t!("nearer"), t!("nearer-hint")),
        (Operation::Farther(by), t!("farther"), t!("farther-hint")),
        (Operation::Flatten, t!("flatten"), t!("flatten-hint")),
        (Operation::Stand, t!("stand"), t!("stand-hint")),
        (Operation::Lie, t!("lie"), t!("lie-hint")),
        (Operation::Join, t!("join"), t!("join-hint")),
    ];
    let mut actions = Vec::new();
    let has_thing = mending.chosen().is_some();
    for row in all.chunks(ROW) {
        ui.horizontal(|ui| {
            for (what, label, hint) in row {
                let button = Button::new(*label).min_size(vec2(0.0, 26.0));
                if ui.add_enabled(has_thing, button).on_hover_text(*hint).clicked() {
                    actions.extend(mending.repair(*what).map(Action::Repair));
                }
            }
        });
    }
    if !has_thing {
        let weak = theme::palette(ui.ctx()).weak;
        let text = match mending.tool {
            Tool::Lasso => t!("draw-round"),
            _ => t!("click-thing"),
        };
        ui.label(RichText::new(text).small().color(weak));
    }
    actions
}

/// What was done, one line each, to be taken away singly.
fn list(mending: &mut Mending, repairs: &Repairs, ui: &mut Ui) -> Option<Action> {
    let colors = theme::palette(ui.ctx());
    let mut action = None;
    ui.add_space(GRID);
    ScrollArea::vertical().id_salt("repairs").max_height(LIST_HEIGHT).show(ui, |ui| {
        for (number, entry) in repairs.entries().iter().enumerate() {
            let name = entry.repair().map_or(t!("repair-unknown").into(), |repair| heard(repair.label()));
            let row = ui.horizontal(|ui| {
                let weak = matches!(entry, Entry::Unknown(_));
                let color = if weak { colors.weak } else { colors.strong };
                ui.label(RichText::new(format!("{}  {name}", number + 1)).color(color));
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let remove = ui.small_button("×").on_hover_text(t!("repair-remove-hint"));
                    let label = t!("repair-remove", number = number + 1);
                    remove.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &label));
                    if remove.clicked() {
                        action = Some(Action::Unrepair(number));
                    }
                });
            });
            if row.response.contains_pointer() {
                mending.pointed_at = Some(number);
            }
        }
    });
    action
}
