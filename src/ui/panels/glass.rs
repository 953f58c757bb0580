//! What a lens does beside being wide: four numbers, none of them by default.

use egui::Ui;

use crate::field::Glass;
use crate::ui::widgets::{self, Number};
use crate::ui::words::{id, t};

/// The numbers.
pub fn show(glass: &mut Glass, ui: &mut Ui) {
    let numbers = [
        (&mut glass.anamorphic, t!("anamorphic"), 0.0, t!("anamorphic-hint")),
        (&mut glass.spherical, t!("spherical"), -1.0, t!("spherical-hint")),
        (&mut glass.fringes, t!("fringes"), 0.0, t!("fringes-hint")),
        (&mut glass.swirl, t!("swirl"), 0.0, t!("swirl-hint")),
    ];
    widgets::section(
        ui,
        id!("section-glass"),
        |_| {},
        |ui| {
            for (value, label, least, hint) in numbers {
                let (range, speed, decimals) = ([least, 1.0], 0.005, 2);
                let spec = Number { label, range, speed, decimals, prefix: "", suffix: "", reset: 0.0, hint };
                widgets::number(ui, value, &spec);
            }
        },
    );
}
