//! The shape of the lens's opening: which there are, and their numbers.

use egui::{Color32, Rect, RichText, Sense, Ui, vec2};

use crate::field::{LensShape, Opening};
use crate::ui::action::Action;
use crate::ui::ask::Ask;
use crate::ui::theme;
use crate::ui::widgets::{self, Number};
use crate::ui::words::t;

/// Side of the small picture of an opening, in points, and its cells.
const PREVIEW: f32 = 64.0;
const PREVIEW_CELLS: usize = 32;

/// The menu; returns the shape that was chosen, or asks for a picture.
pub fn menu(ui: &mut Ui, shape: &LensShape) -> (Option<LensShape>, Option<Action>) {
    let (name, _) = described(shape);
    let all = [
        LensShape::Disc,
        LensShape::Square,
        LensShape::Blades { count: 6, rotation_deg: 0.0, roundness: 0.2 },
        LensShape::Ring { inner: 0.5 },
        LensShape::CatEye { strength: 0.5 },
    ];
    let (mut chosen, mut action) = (None, None);
    let text = RichText::new(format!("{name} ▼")).small().color(theme::palette(ui.ctx()).weak);
    ui.menu_button(text, |ui| {
        for choice in all {
            let (own, hint) = described(&choice);
            if ui.selectable_label(own == name, own).on_hover_text(hint).clicked() {
                chosen = Some(choice);
                ui.close();
            }
        }
        let is_picture = matches!(shape, LensShape::Picture(_));
        if ui.selectable_label(is_picture, t!("opening-own")).on_hover_text(t!("opening-own-hint")).clicked() {
            action = Some(Action::Ask(Ask::Opening));
            ui.close();
        }
    });
    (chosen, action)
}

fn described(shape: &LensShape) -> (&'static str, &'static str) {
    match shape {
        LensShape::Disc => (t!("disc"), t!("disc-hint")),
        LensShape::Square => (t!("square"), t!("square-hint")),
        LensShape::Blades { .. } => (t!("blades"), t!("blades-hint")),
        LensShape::Ring { .. } => (t!("ring"), t!("ring-hint")),
        LensShape::CatEye { .. } => (t!("cats-eye"), t!("cats-eye-hint")),
        LensShape::Picture(_) => (t!("opening-picture"), t!("opening-picture-hint")),
    }
}

/// The numbers of a shape.
pub fn numbers(ui: &mut Ui, shape: &mut LensShape) {
    let part = |label, hint| Number {
        label,
        range: [0.0, 1.0],
        speed: 0.005,
        decimals: 2,
        prefix: "",
        suffix: "",
        reset: 0.5,
        hint,
    };
    match shape {
        LensShape::Disc | LensShape::Square => {}
        LensShape::Blades { count, rotation_deg, roundness } => {
            let mut blades = f32::from(*count);
            let spec = Number {
                range: LensShape::BLADES.map(f32::from),
                speed: 0.05,
                decimals: 0,
                reset: 6.0,
                ..part(t!("blade-count"), t!("blade-count-hint"))
            };
            if widgets::number(ui, &mut blades, &spec) {
                *count = blades.round() as u8;
            }
            let spec = Number {
                range: [-180.0, 180.0],
                speed: 0.5,
                decimals: 0,
                suffix: "°",
                reset: 0.0,
                ..part(t!("rotation"), t!("rotation-hint"))
            };
            widgets::number(ui, rotation_deg, &spec);
            widgets::number(ui, roundness, &part(t!("roundness"), t!("roundness-hint")));
        }
        LensShape::Ring { inner } => {
            widgets::number(ui, inner, &Number { range: [0.0, 0.9], ..part(t!("hole"), t!("hole-hint")) });
        }
        LensShape::CatEye { strength } => {
            widgets::number(ui, strength, &part(t!("cats-eye-strength"), t!("cats-eye-strength-hint")));
        }
        LensShape::Picture(opening) => preview(ui, opening),
    }
}

/// The picture that is the opening, as points behind the focus show it.
fn preview(ui: &mut Ui, opening: &Opening) {
    let (rect, response) = ui.allocate_exact_size(vec2(PREVIEW, PREVIEW), Sense::hover());
    ui.painter().rect_filled(rect, 2, Color32::BLACK);
    let cell = PREVIEW / PREVIEW_CELLS as f32;
    for (y, x) in (0..PREVIEW_CELLS).flat_map(|y| (0..PREVIEW_CELLS).map(move |x| (y, x))) {
        let place = [x, y].map(|at| (at as f32 + 0.5) / PREVIEW_CELLS as f32 * 2.0 - 1.0);
        let light = opening.at(place);
        if light > 0.0 {
            let min = rect.min + vec2(x as f32, y as f32) * cell;
            ui.painter().rect_filled(
                Rect::from_min_size(min, vec2(cell, cell)),
                0,
                Color32::from_gray((light * 255.0) as u8),
            );
        }
    }
    response.on_hover_text(t!("opening-preview"));
}
