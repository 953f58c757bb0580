//! What screen readers are told: what lens and eye do now, what runs, and what happened.

use egui::accesskit::Live;
use egui::{Rect, Role, Sense, Ui, WidgetInfo, vec2};

use super::window::Window;
use crate::scene::layers;

/// Tells it, in a place that takes no room.
pub fn show(window: &Window, ui: &Ui) {
    let corner = Rect::from_min_size(ui.max_rect().left_bottom() - vec2(0.0, 1.0), vec2(1.0, 1.0));
    let all = [
        ("lens", Role::Status, Live::Polite, lens(window)),
        ("runs", Role::Status, Live::Polite, runs(window)),
        ("told", Role::Alert, Live::Assertive, window.toasts.last().map(str::to_owned)),
    ];
    for (name, role, live, text) in all {
        let Some(text) = text else { continue };
        let response = ui.interact(corner, ui.scope_id().with(("spoken", name)), Sense::hover());
        response.widget_info(|| WidgetInfo::labeled(role, true, &text));
        ui.ctx().accesskit_node_builder(response.id, |node| node.set_live(live));
    }
}

/// "layer 2 of 5, f/3.5, view 1 right".
fn lens(window: &Window) -> Option<String> {
    let layers = &window.open.rays()?.survey.layers_px;
    let number = layers::nearest(layers, window.open.lens(&window.edit).focus.disparity_px);
    let f = format!("{:.1}", window.edit.f_number.0);
    let mut text = format!("layer {} of {}, f/{}", number + 1, layers.len(), f.strip_suffix(".0").unwrap_or(&f));
    let eye = window.edit.viewpoint.0;
    for (steps, ways) in [(eye.du, ["left", "right"]), (eye.dv, ["up", "down"])] {
        if steps.abs() >= 0.05 {
            text += &format!(", {:.1} {}", steps.abs(), ways[usize::from(steps > 0.0)]);
        }
    }
    Some(text)
}

/// The job that runs. In steps of ten per cent, so that it is not said all the time.
fn runs(window: &Window) -> Option<String> {
    let running = window.loading.running().or(window.adding.as_ref())?;
    let tens = (running.share() * 10.0) as u32 * 10;
    Some(format!("{}, {tens} per cent", running.stage()))
}
