//! The queue: what is being exported, how far, how long; what waits; how it went.

use egui::{Align, Align2, Context, Frame, Layout, Margin, Rect, RichText, ScrollArea, Sense, Ui, vec2};

use crate::ui::action::Action;
use crate::ui::command::Command;
use crate::ui::queue::{Queue, State, Task};
use crate::ui::toasts::show_in_folder;
use crate::ui::words::t;
use crate::ui::worker::JobId;
use crate::ui::{theme, widgets};

const WIDTH: f32 = 380.0;
const MOST_HEIGHT: f32 = 320.0;

/// Draws the panel with its lower right corner at a place, while it is open.
pub fn show(queue: &mut Queue, corner: egui::Pos2, ctx: &Context) -> Vec<Action> {
    let mut actions = Vec::new();
    if !queue.is_open {
        return actions;
    }
    let colors = theme::palette(ctx);
    let area = egui::Area::new(egui::Id::unique("queue")).pivot(Align2::RIGHT_BOTTOM).fixed_pos(corner);
    area.order(egui::Order::Middle).show(ctx, |ui| {
        let frame = Frame::new().fill(colors.panel).stroke((1.0, colors.control)).corner_radius(8);
        frame.inner_margin(Margin::symmetric(14, 12)).show(ui, |ui| {
            ui.set_width(WIDTH);
            ui.horizontal(|ui| {
                ui.label(RichText::new(t!("queue-name")).font(theme::title(14.0)).color(colors.strong));
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    queue.is_open = !widgets::link(ui, t!("close")).clicked();
                    if widgets::link(ui, t!("clear-ended")).clicked() {
                        queue.clear_ended();
                    }
                    if widgets::link(ui, t!("add-photos")).on_hover_text(Command::ExportPhotos.tip(ctx)).clicked() {
                        actions.push(Action::Do(Command::ExportPhotos));
                    }
                });
            });
            ui.add_space(6.0);
            if queue.tasks().is_empty() {
                ui.label(RichText::new(t!("queue-empty")).color(colors.weak));
            }
            ScrollArea::vertical().max_height(MOST_HEIGHT).min_scrolled_height(MOST_HEIGHT).show(ui, |ui| {
                for task in queue.tasks() {
                    actions.extend(row(ui, task).map(Action::StopTask));
                }
            });
        });
    });
    if queue.is_busy() {
        ctx.request_repaint_after(std::time::Duration::from_millis(200));
    }
    actions
}

/// One task; its job once a person wants it stopped.
fn row(ui: &mut Ui, task: &Task) -> Option<JobId> {
    let colors = theme::palette(ui.ctx());
    let mut stopped = None;
    ui.horizontal(|ui| {
        ui.set_min_height(22.0);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            match &task.state {
                State::Done(path) => {
                    if widgets::link(ui, t!("show-in-folder")).clicked() {
                        show_in_folder(path);
                    }
                }
                State::Waiting | State::Running(_) => {
                    if widgets::link(ui, t!("stop")).clicked() {
                        stopped = Some(task.job);
                    }
                }
                State::Skipped | State::Failed(_) | State::Stopped => {}
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                ui.add(egui::Label::new(RichText::new(&task.title).color(colors.strong)).truncate());
            });
        });
    });
    let (text, color) = match &task.state {
        State::Waiting => (t!("waits").to_owned(), colors.weak),
        State::Running(running) => (format!("{} · {}", running.label(), running.time()), colors.text),
        State::Done(_) => (t!("task-done").to_owned(), colors.weak),
        State::Skipped => (t!("was-there").to_owned(), colors.weak),
        State::Failed(why) => (why.text(), colors.error),
        State::Stopped => (t!("stopped").to_owned(), colors.weak),
    };
    ui.label(RichText::new(text).small().color(color));
    if let State::Running(running) = &task.state {
        let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 3.0), Sense::hover());
        ui.painter().rect_filled(rect, 2, colors.control);
        let done = Rect::from_min_size(rect.min, vec2(rect.width() * running.share(), rect.height()));
        ui.painter().rect_filled(done, 2, colors.accent);
    }
    ui.add_space(6.0);
    stopped
}
