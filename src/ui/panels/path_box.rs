//! A box for a path, where the system shows no file dialogs.

use egui::{Context, RichText};

use crate::ui::app::{App, Dialog};
use crate::ui::dialogs::{PathFor, path_from_text};
use crate::ui::{theme, widgets};

/// Draws the box; false once it is to be closed.
pub fn show(app: &mut App, ctx: &Context, wanted: PathFor, mut text: String) -> bool {
    let colors = theme::palette(ctx);
    let mut is_open = true;
    let mut used = None;
    let modal = widgets::modal(ctx, "path");
    let shown = modal.show(ctx, |ui| {
        ui.set_width(440.0);
        ui.spacing_mut().item_spacing.y = 8.0;
        let (title, what, verb) = match wanted {
            PathFor::Open => ("Open", "a photo or light field", "Open"),
            PathFor::Export => ("Export photos", "a photo", "Go on"),
            PathFor::DepthMap => ("Depth map", "a PFM or grey picture", "Use"),
            PathFor::Models => ("Models", "a folder of models", "Use"),
        };
        ui.label(RichText::new(title).font(theme::title(16.0)).color(colors.strong));
        let line = format!("The system shows no file dialog here. Type or paste the path of {what}");
        ui.label(RichText::new(line).color(colors.weak));
        let edit =
            ui.add(egui::TextEdit::singleline(&mut text).hint_text("/home/me/photo.jpg").desired_width(f32::INFINITY));
        edit.request_focus();
        let is_enter = ui.input(|input| input.key_pressed(egui::Key::Enter));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if widgets::main_button(ui, verb).clicked() || is_enter {
                match path_from_text(&text) {
                    Some(path) => {
                        used = Some(path);
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
    app.dialog = Some(Dialog::Path(wanted, text));
    let stays = is_open && !shown.should_close();
    if let Some(path) = used {
        app.dialog = None;
        app.use_path(wanted, path);
        // What the path was for may ask something else.
        return app.dialog.is_some();
    }
    stays
}
