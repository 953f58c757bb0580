//! What a lens does beside being wide: four numbers, none of them by default.

use egui::Ui;

use crate::field::Glass;
use crate::ui::widgets::{self, Number};

/// The numbers.
pub fn show(glass: &mut Glass, ui: &mut Ui) {
    let numbers = [
        (&mut glass.anamorphic, "Anamorphic", 0.0, "Discs taller than wide: 1 is twice as tall"),
        (&mut glass.spherical, "Spherical", -1.0, "Discs behind the focus: 1 a bright rim, −1 a bright middle"),
        (&mut glass.fringes, "Fringes", 0.0, "Rims green behind the focus, magenta before it"),
        (&mut glass.swirl, "Swirl", 0.0, "Discs cut towards the corners, and a curved sharp surface"),
    ];
    widgets::section(
        ui,
        "Glass",
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
