//! A short hint where it applies, over the picture.

use egui::{Align2, Context, Frame, Margin, Order, Pos2, RichText, vec2};

use crate::ui::action::Action;
use crate::ui::hints::Hint;
use crate::ui::look::{Face, Look};
use crate::ui::window::Window;
use crate::ui::words::t;
use crate::ui::{theme, widgets};

/// Room between a hint and the picture's rim.
const GAP: f32 = 14.0;

/// Draws the hint that applies now, while nothing else asks for attention.
pub fn show(window: &Window, ctx: &Context) -> Option<Action> {
    let is_quiet = window.dialog.is_none() && !window.is_busy() && window.compare.at().is_none();
    // While something is mended, a click does not focus and a drag does not look round.
    let is_quiet = is_quiet && !window.mending.is_on;
    let hint = window.settings.hints.next().filter(|_| is_quiet && window.open.field().is_some())?;
    let (at, pivot) = place(hint, window)?;
    let colors = theme::palette(ctx);
    let area = egui::Area::new(egui::Id::unique("hint")).order(Order::Middle).pivot(pivot).fixed_pos(at);
    let frame = Frame::new()
        .fill(colors.panel)
        .stroke((1.0, colors.accent))
        .corner_radius(8)
        .inner_margin(Margin::symmetric(12, 8));
    let shown = area.show(ctx, |ui| {
        let inside = frame.show(ui, |ui| {
            ui.horizontal(|ui| {
                ui.label(RichText::new(hint.text()).color(colors.strong));
                widgets::link(ui, t!("got-it")).clicked()
            })
            .inner
        });
        inside.inner
    });
    shown.inner.then_some(Action::Learn(hint))
}

/// Where a hint lies, and which of its corners there.
fn place(hint: Hint, window: &Window) -> Option<(Pos2, Align2)> {
    let Look { canvas, face, .. } = window.look;
    match hint {
        _ if face != Face::Picture => None,
        Hint::Look => Some((canvas.center_top() + vec2(0.0, GAP), Align2::CENTER_TOP)),
        Hint::Focus => Some((canvas.center_bottom() - vec2(0.0, GAP), Align2::CENTER_BOTTOM)),
        // Beside the inspector, whose headings it would hide.
        Hint::Export => Some((canvas.right_top() + vec2(-GAP, GAP), Align2::RIGHT_TOP)),
    }
}
