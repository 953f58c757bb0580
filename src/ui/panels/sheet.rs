//! The shortcut sheet: what the mouse does, and all keys.

use egui::{Align2, Context, RichText, Sense, Ui, vec2};

use crate::ui::action::Action;
use crate::ui::command::{self, Command, MOUSE, SHEET};
use crate::ui::words::t;
use crate::ui::{theme, widgets};

/// Draws the sheet.
pub fn show(ctx: &Context) -> Vec<Action> {
    let colors = theme::palette(ctx);
    let modal = widgets::modal(ctx, "shortcuts");
    let shown = modal.show(ctx, |ui| {
        ui.set_width(640.0);
        ui.label(RichText::new(t!("shortcuts")).font(theme::title(16.0)).color(colors.strong));
        ui.add_space(10.0);
        let room = ctx.content_rect().height() - 120.0;
        egui::ScrollArea::vertical().max_height(room).show(ui, |ui| {
            ui.columns(2, |columns| {
                head(&mut columns[0], t!("mouse"));
                for keys in MOUSE {
                    line(&mut columns[0], keys.hint(), keys.text());
                }
                for (column, groups) in [(0, &SHEET.0[..]), (1, &SHEET.1[..])] {
                    for &group in groups {
                        head(&mut columns[column], group.text());
                        for command in Command::of_group(group) {
                            let spec = command.spec();
                            if let Some(keys) = spec.shortcut {
                                line(&mut columns[column], spec.label(), &command::spelled(&keys, ctx));
                            }
                        }
                    }
                }
            });
        });
    });
    if shown.should_close() { vec![Action::CloseDialog] } else { Vec::new() }
}

fn head(ui: &mut Ui, text: &str) {
    let weak = theme::palette(ui.ctx()).weak;
    ui.add_space(6.0);
    ui.label(RichText::new(text).font(theme::head()).color(weak));
}

fn line(ui: &mut Ui, what: &str, keys: &str) {
    let colors = theme::palette(ui.ctx());
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width() - 8.0, 19.0), Sense::hover());
    ui.painter().text(rect.left_center(), Align2::LEFT_CENTER, what, theme::text(), colors.text);
    ui.painter().text(rect.right_center(), Align2::RIGHT_CENTER, keys, theme::small(), colors.accent_text);
}
