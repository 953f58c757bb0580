//! The status line: what runs, how far, how long, how to stop it; the zoom; what draws and what computes.

use egui::{Align2, Rect, Ui, pos2, vec2};

use crate::ui::action::Action;
use crate::ui::app::App;
use crate::ui::progress::Running;
use crate::ui::queue::State;
use crate::ui::state::Pose;
use crate::ui::theme;

/// Narrower than this, what draws and what computes is left out.
const TIGHT_WIDTH: f32 = 720.0;

/// Draws the line.
pub fn show(app: &mut App, ui: &Ui) {
    let rect = ui.max_rect().shrink2(vec2(14.0, 0.0));
    let colors = theme::palette(ui.ctx());
    let y = rect.center().y;
    let mut x = rect.left();
    if let Some(running) = &app.loading {
        x = job(ui, running, None, pos2(x, y)) + 24.0;
    }
    if let Some(task) = app.queue.current() {
        let start = x;
        x = match &task.state {
            State::Running(running) => job(ui, running, Some(&task.title), pos2(x, y)),
            _ => ui.painter().text(pos2(x, y), Align2::LEFT_CENTER, &task.title, theme::small(), colors.weak).right(),
        };
        let others = app.queue.open_count() - 1;
        if others > 0 {
            let text = format!("· {others} more");
            x = ui.painter().text(pos2(x + 6.0, y), Align2::LEFT_CENTER, text, theme::small(), colors.weak).right();
        }
        let all = Rect::from_x_y_ranges(start..=x, rect.y_range());
        let response = ui.interact(all, ui.scope_id().with("queue"), egui::Sense::click());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, "Queue"));
        let response = response.on_hover_cursor(egui::CursorIcon::PointingHand);
        if response.on_hover_text(Action::Queue.tip(ui.ctx())).clicked() {
            app.is_queue_open = !app.is_queue_open;
        }
    }
    if app.is_busy() {
        ui.ctx().request_repaint_after(std::time::Duration::from_millis(200));
    } else {
        let text = idle_text(app);
        ui.painter().text(pos2(x, y), Align2::LEFT_CENTER, text, theme::small(), colors.weak);
    }
    let drawn = app.stage.as_ref().map_or("no device", |stage| stage.adapter.as_str());
    let threads = app.threads;
    let is_tight = rect.width() < TIGHT_WIDTH;
    let right = match threads {
        _ if is_tight => String::new(),
        0 => format!("drawn by {drawn}"),
        1 => format!("drawn by {drawn} · nets on 1 CPU thread"),
        _ => format!("drawn by {drawn} · nets on {threads} CPU threads"),
    };
    let shown = ui.painter().text(rect.right_center(), Align2::RIGHT_CENTER, right, theme::small(), colors.weak);
    if let Some(size) = app.picture_size() {
        let per_pixel = Pose::fit(app.canvas, size).x * app.pose.zoom * ui.ctx().pixels_per_point() / size.x;
        let zoom = format!("zoom {:.0} %", per_pixel * 100.0);
        let at = pos2(shown.left() - 24.0, y);
        ui.painter().text(at, Align2::RIGHT_CENTER, zoom, theme::small(), colors.weak);
    }
}

fn idle_text(app: &App) -> &'static str {
    match (app.picture_size(), app.document.field.is_some(), app.document.depths.is_some()) {
        (None, ..) => "Everything stays on this computer",
        (Some(_), true, true) => "Drag to look round · click to focus · wheel to zoom · F1 for all keys",
        (Some(_), true, false) => "Drag to look round · wheel to zoom · F1 for all keys",
        (Some(_), false, _) => "No light field · wheel to zoom",
    }
}

/// A job with its bar; returns where it ends.
fn job(ui: &Ui, running: &Running, title: Option<&str>, at: egui::Pos2) -> f32 {
    let colors = theme::palette(ui.ctx());
    let label = title.map_or_else(|| running.label(), |title| format!("{title} · {}", running.label()));
    let text = ui.painter().text(at, Align2::LEFT_CENTER, label, theme::small(), colors.text);
    let bar = Rect::from_min_size(pos2(text.right() + 16.0, at.y - 1.5), vec2(160.0, 3.0));
    ui.painter().rect_filled(bar, 2, colors.control);
    let done = Rect::from_min_size(bar.min, vec2(bar.width() * running.share(), bar.height()));
    ui.painter().rect_filled(done, 2, colors.accent);
    let time = format!("{} · Esc stops", running.time());
    let at = pos2(bar.right() + 16.0, at.y);
    ui.painter().text(at, Align2::LEFT_CENTER, time, theme::small(), colors.weak).right()
}
