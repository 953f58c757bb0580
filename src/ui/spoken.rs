//! What screen readers are told: what lens and eye do now, what runs, and what happened.

use egui::accesskit::Live;
use egui::{Rect, Role, Sense, Ui, WidgetInfo, vec2};

use super::window::Window;
use super::words::{self, t};
use crate::field::ViewOffset;
use crate::scene::layers;

/// Tells it, in a place that takes no room.
pub fn show(window: &Window, ui: &Ui) {
    let corner = Rect::from_min_size(ui.max_rect().left_bottom() - vec2(0.0, 1.0), vec2(1.0, 1.0));
    let all = [
        ("lens", Role::Status, Live::Polite, lens(window)),
        ("runs", Role::Status, Live::Polite, runs(window)),
        ("told", Role::Alert, Live::Assertive, window.toasts.last()),
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
    let f = words::shortest((window.edit.f_number.0 * 10.0).round() / 10.0);
    let mut text = t!("said-layer", number = number + 1, count = layers.len(), f = f);
    let ViewOffset { dv, du } = window.edit.viewpoint.0;
    let far = |steps: f32| steps.abs() >= 0.05;
    let steps = |steps: f32| words::fixed(steps.abs(), 1);
    match du {
        _ if !far(du) => {}
        _ if du < 0.0 => text += &t!("said-left", steps = steps(du)),
        _ => text += &t!("said-right", steps = steps(du)),
    }
    match dv {
        _ if !far(dv) => {}
        _ if dv < 0.0 => text += &t!("said-up", steps = steps(dv)),
        _ => text += &t!("said-down", steps = steps(dv)),
    }
    Some(text)
}

/// The job that runs. In steps of ten per cent, so that it is not said all the time.
fn runs(window: &Window) -> Option<String> {
    let running = window.loading.running().or(window.adding.as_ref())?;
    let tens = (running.share() * 10.0) as u32 * 10;
    Some(t!("said-runs", stage = running.stage(), percent = tens))
}
