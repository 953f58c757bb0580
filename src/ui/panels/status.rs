//! The status line: what runs, how far, how long, how to stop it; the zoom; what draws and what computes.

use egui::{Align2, Rect, Ui, pos2, vec2};

use crate::ui::action::Action;
use crate::ui::command::Command;
use crate::ui::look::{Look, Pose};
use crate::ui::open::Open;
use crate::ui::progress::Running;
use crate::ui::queue::{Queue, State};
use crate::ui::theme;
use crate::ui::words::{self, t};

/// Narrower than this, what draws and what computes is left out.
const TIGHT_WIDTH: f32 = 720.0;

/// What the line shows.
pub struct Status<'a> {
    /// What is open.
    pub open: &'a Open,
    /// What is being opened or made.
    pub loading: Option<&'a Running>,
    /// The depth that is being mended; taking back a repair ends it.
    pub mending: Option<&'a Running>,
    /// What is being exported.
    pub queue: &'a Queue,
    /// The zoom.
    pub look: &'a Look,
    /// What draws.
    pub drawn_by: &'a str,
    /// Threads for the nets; 0 is one for each core.
    pub threads: usize,
}

/// Draws the line; a click on what is exported asks for the queue.
pub fn show(shown: &Status, ui: &Ui) -> Option<Action> {
    let mut action = None;
    let rect = ui.max_rect().shrink2(vec2(14.0, 0.0));
    let colors = theme::palette(ui.ctx());
    let y = rect.center().y;
    let mut x = rect.left();
    if let Some(running) = shown.loading {
        x = job(ui, running, None, pos2(x, y), stops(running)) + 24.0;
    }
    if let Some(running) = shown.mending {
        x = job(ui, running, None, pos2(x, y), running.time()) + 24.0;
    }
    if let Some(task) = shown.queue.current() {
        let start = x;
        x = match &task.state {
            State::Running(running) => job(ui, running, Some(&task.title), pos2(x, y), stops(running)),
            _ => ui.painter().text(pos2(x, y), Align2::LEFT_CENTER, &task.title, theme::small(), colors.weak).right(),
        };
        let others = shown.queue.open_count() - 1;
        if others > 0 {
            let text = t!("others-more", count = others);
            x = ui.painter().text(pos2(x + 6.0, y), Align2::LEFT_CENTER, text, theme::small(), colors.weak).right();
        }
        let all = Rect::from_x_y_ranges(start..=x, rect.y_range());
        let response = ui.interact(all, ui.scope_id().with("queue"), egui::Sense::click());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, t!("queue-name")));
        let response = response.on_hover_cursor(egui::CursorIcon::PointingHand);
        if response.on_hover_text(Command::Queue.tip(ui.ctx())).clicked() {
            action = Some(Action::Do(Command::Queue));
        }
    }
    if shown.loading.is_some() || shown.mending.is_some() || shown.queue.is_busy() {
        ui.ctx().request_repaint_after(std::time::Duration::from_millis(200));
    } else {
        let text = idle_text(shown.open);
        ui.painter().text(pos2(x, y), Align2::LEFT_CENTER, text, theme::small(), colors.weak);
    }
    let (drawn, threads) = (shown.drawn_by, shown.threads);
    let is_tight = rect.width() < TIGHT_WIDTH;
    let right = match threads {
        _ if is_tight => String::new(),
        0 => t!("drawn-by", device = drawn),
        _ => t!("drawn-by-threads", device = drawn, threads = threads),
    };
    let right = ui.painter().text(rect.right_center(), Align2::RIGHT_CENTER, right, theme::small(), colors.weak);
    if let Some(size) = shown.open.picture_size() {
        let per_pixel =
            Pose::fit(shown.look.canvas, size).x * shown.look.pose.zoom * ui.ctx().pixels_per_point() / size.x;
        let zoom = t!("zoom", percent = words::fixed(per_pixel * 100.0, 0));
        let at = pos2(right.left() - 24.0, y);
        ui.painter().text(at, Align2::RIGHT_CENTER, zoom, theme::small(), colors.weak);
    }
    action
}

/// How long it has taken, and how to stop it.
fn stops(running: &Running) -> String {
    t!("esc-stops", time = running.time())
}

fn idle_text(open: &Open) -> &'static str {
    match (open, open.field().is_some(), open.rays().is_some()) {
        (Open::Nothing, ..) => t!("idle-nothing"),
        (_, true, true) => t!("idle-photo"),
        (_, true, false) => t!("idle-field"),
        (_, false, _) => t!("idle-flat"),
    }
}

/// A job with its bar; returns where it ends.
fn job(ui: &Ui, running: &Running, title: Option<&str>, at: egui::Pos2, time: String) -> f32 {
    let colors = theme::palette(ui.ctx());
    let label = title.map_or_else(|| running.label(), |title| format!("{title} · {}", running.label()));
    let text = ui.painter().text(at, Align2::LEFT_CENTER, label, theme::small(), colors.text);
    let bar = Rect::from_min_size(pos2(text.right() + 16.0, at.y - 1.5), vec2(160.0, 3.0));
    ui.painter().rect_filled(bar, 2, colors.control);
    let done = Rect::from_min_size(bar.min, vec2(bar.width() * running.share(), bar.height()));
    ui.painter().rect_filled(done, 2, colors.accent);
    let at = pos2(bar.right() + 16.0, at.y);
    ui.painter().text(at, Align2::LEFT_CENTER, time, theme::small(), colors.weak).right()
}
