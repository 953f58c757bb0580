//! Several files were dropped at once: look at the first, or export them all.

use std::path::{Path, PathBuf};

use egui::{Context, RichText};

use crate::ui::app::{App, Dialog};
use crate::ui::jobs::From;
use crate::ui::{theme, widgets};

/// Names that are listed.
const LISTED: usize = 6;

/// Draws the question; false once it is answered.
pub fn show(app: &mut App, ctx: &Context, files: &[PathBuf]) -> bool {
    let colors = theme::palette(ctx);
    let mut is_open = true;
    let mut exports = false;
    let modal = widgets::modal(ctx, "many");
    let shown = modal.show(ctx, |ui| {
        ui.set_width(420.0);
        ui.spacing_mut().item_spacing.y = 8.0;
        let title = format!("{} files", files.len());
        ui.label(RichText::new(title).font(theme::title(16.0)).color(colors.strong));
        let name = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let mut names: Vec<String> = files.iter().take(LISTED).map(|path| name(path)).collect();
        if files.len() > LISTED {
            names.push(format!("and {} more", files.len() - LISTED));
        }
        ui.label(RichText::new(names.join(", ")).color(colors.weak));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if widgets::main_button(ui, "Open the first").clicked() {
                if let Some(first) = files.first() {
                    app.open(From::File(first.clone()));
                }
                is_open = false;
            }
            let hint = "Each one becomes a light field and is written with the lens that is set now";
            if widgets::button(ui, "Export all…").on_hover_text(hint).clicked() {
                exports = true;
            }
            if widgets::button(ui, "Cancel").clicked() {
                is_open = false;
            }
        });
    });
    if exports {
        app.export_photos(files.to_vec());
        return app.dialog == Some(Dialog::Export);
    }
    is_open && !shown.should_close()
}
