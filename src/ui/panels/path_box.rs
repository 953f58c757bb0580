//! A box for a path, where the system shows no file dialogs.

use egui::{Context, RichText};

use crate::ui::app::{App, Dialog};
use crate::ui::dialogs::path_from_text;
use crate::ui::jobs::From;
use crate::ui::{theme, widgets};

/// Draws the box; false once it is to be closed.
pub fn show(app: &mut App, ctx: &Context, mut text: String) -> bool {
    let colors = theme::palette(ctx);
    let mut is_open = true;
    let modal = widgets::modal(ctx, "path");
    let shown = modal.show(ctx, |ui| {
        ui.set_width(440.0);
        ui.spacing_mut().item_spacing.y = 8.0;
        ui.label(RichText::new("Open").font(theme::title(16.0)).color(colors.strong));
        ui.label(
            RichText::new("The system shows no file dialog here. Type or paste the path of a photo or light field")
                .color(colors.weak),
        );
        let edit =
            ui.add(egui::TextEdit::singleline(&mut text).hint_text("/home/me/photo.jpg").desired_width(f32::INFINITY));
        edit.request_focus();
        let is_enter = ui.input(|input| input.key_pressed(egui::Key::Enter));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if widgets::main_button(ui, "Open").clicked() || is_enter {
                match path_from_text(&text) {
                    Some(path) => {
                        app.open(From::File(path));
                        is_open = false;
                    }
                    None => app.toasts.error("could not open — that is no path of a file — begin it with / or ~"),
                }
            }
            if widgets::button(ui, "Cancel").clicked() {
                is_open = false;
            }
        });
    });
    app.dialog = Some(Dialog::Path(text));
    is_open && !shown.should_close()
}
