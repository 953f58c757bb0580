//! How deep the scene is: one number for views, epipolar images, ray depths and lens.

use egui::{RichText, Ui};

use crate::field::Strength;
use crate::scene::Edit;
use crate::ui::open::Open;
use crate::ui::words::{self, t};
use crate::ui::{
    theme,
    widgets::{self, Number},
};

/// The number and its slider, where there is depth.
pub fn show(open: &Open, edit: &mut Edit, ui: &mut Ui) {
    let Some(subject) = open.subject().filter(|_| open.rays().is_some()) else { return };
    let most = subject.strength(Strength(Strength::MOST)).0;
    let mut value = subject.strength(edit.strength).0;
    let before = value;
    let hint = match subject.photo() {
        Some(_) => t!("strength-hint"),
        None => t!("strength-hint-field"),
    };
    let spec = Number {
        label: t!("strength"),
        range: [Strength::LEAST, most],
        speed: 0.01,
        decimals: 2,
        prefix: "",
        suffix: "×",
        reset: Strength::AS_MADE.0,
        hint,
    };
    widgets::number(ui, &mut value, &spec);
    let scale = Scale { most };
    let mut place = scale.place(value);
    let reset = scale.place(Strength::AS_MADE.0);
    let response = widgets::slider(ui, t!("strength-slider"), &mut place, reset);
    // Who scrolls the inspector over it does not mean it.
    if response.changed() && (response.is_pointer_button_down_on() || response.clicked() || response.double_clicked()) {
        value = scale.value(place);
    }
    if let Some(found) = open.scene().and_then(|scene| scene.as_made().several()) {
        let percent = 100.0 * found.share as f32 * value;
        let text = t!("baseline-reach", percent = words::fixed(percent, 0));
        ui.label(RichText::new(text).color(theme::palette(ui.ctx()).weak)).on_hover_text(t!("baseline-reach-hint"));
    }
    if value != before {
        edit.strength = Strength(value);
    }
}

/// Strengths along the slider: equal steps for equal ratios.
struct Scale {
    most: f32,
}

impl Scale {
    /// The slider stays on the scene's own strength a little.
    const HOLD: f32 = 0.012;

    fn place(&self, value: f32) -> f32 {
        (value / Strength::LEAST).ln() / (self.most / Strength::LEAST).ln()
    }

    fn value(&self, place: f32) -> f32 {
        if (place - self.place(Strength::AS_MADE.0)).abs() < Self::HOLD {
            return Strength::AS_MADE.0;
        }
        Strength::LEAST * (self.most / Strength::LEAST).powf(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slider_goes_to_both_ends_and_holds_what_was_made() {
        for most in [Strength::MOST, 1.0] {
            let scale = Scale { most };
            assert!((scale.value(0.0) - Strength::LEAST).abs() < 1e-6 && (scale.value(1.0) - most).abs() < 1e-5);
            assert_eq!(scale.value(scale.place(1.0) - 0.01), 1.0);
            assert!((scale.value(scale.place(0.5)) - 0.5).abs() < 1e-5);
        }
    }
}
