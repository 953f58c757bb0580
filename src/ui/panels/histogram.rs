//! How bright the picture is, and what of it is clipped.

use egui::{Color32, Rect, RichText, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};

use crate::field::Histogram;
use crate::ui::words::{self, id, t};
use crate::ui::{theme, widgets};

const HEIGHT: f32 = 56.0;

/// Draws the section.
pub fn show(histogram: &Histogram, ui: &mut Ui) {
    widgets::section(
        ui,
        id!("section-histogram"),
        |_| {},
        |ui| {
            let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
            let colors = theme::palette(ui.ctx());
            ui.painter().rect_filled(rect, theme::RADIUS - 2, colors.well);
            for (bins, color) in histogram.bins.iter().zip(theme::CHANNELS) {
                curve(ui, rect.shrink(2.0), bins, color);
            }
            let text = t!("clipped", dark = share(histogram.dark), bright = share(histogram.bright));
            response.widget_info(|| WidgetInfo::labeled(egui::Role::Image, true, t!("histogram-said", text = &text)));
            ui.label(RichText::new(text).small().color(colors.weak));
        },
    );
}

/// One channel; the root keeps what is little visible.
fn curve(ui: &Ui, rect: Rect, bins: &[f32], color: Color32) {
    let step = rect.width() / (bins.len() - 1).max(1) as f32;
    let at =
        |(i, share): (usize, &f32)| pos2(rect.left() + i as f32 * step, rect.bottom() - share.sqrt() * rect.height());
    ui.painter().line(bins.iter().enumerate().map(at).collect(), Stroke::new(1.2, color));
}

/// "0.3 %"; what is there is never nothing.
fn share(share: f32) -> String {
    match share * 100.0 {
        0.0 => t!("percent", share = 0),
        percent if percent < 0.1 => t!("percent-below", share = words::fixed(0.1, 1)),
        percent => t!("percent", share = words::fixed(percent, 1)),
    }
}
