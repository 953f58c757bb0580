//! The lens in a photographer's numbers: what real lens it is, where it is sharp, how wide the blur is.

use egui::{RichText, Ui};

use crate::scene::real::{DISTANCES_M, FORMATS, Format, KnownLens, Scale};
use crate::scene::{Edit, Scene};
use crate::ui::action::Action;
use crate::ui::look::{Look, Measure};
use crate::ui::settings::Settings;
use crate::ui::theme;
use crate::ui::widgets::{self, Number};
use crate::ui::words::{self, Message, heard, id, message, t};

/// Lengths that can be given, and the one that a new line has where no distance is known, in metres.
const LENGTHS_M: [f32; 2] = [0.0005, 1000.0];
const USUAL_LENGTH_M: f32 = 0.2;

/// What the section shows and sets.
pub struct RealLens<'a> {
    /// What is open.
    pub scene: &'a Scene,
    /// Aperture, shape, and the distance that is known.
    pub edit: &'a mut Edit,
    /// The line over something of a known length.
    pub look: &'a mut Look,
    /// The sensor.
    pub settings: &'a mut Settings,
    /// Lenses that can be taken.
    pub lenses: &'a [KnownLens],
}

/// What the slider reads as, in one line.
pub fn title(scene: &Scene, edit: &Edit, settings: &Settings) -> String {
    let format = &FORMATS[settings.sensor.min(FORMATS.len() - 1)];
    heard(&scene.reading(edit, format, 1).headline()).into_owned()
}

/// Draws it.
pub fn show(shown: RealLens, ui: &mut Ui) -> Option<Action> {
    let RealLens { scene, edit, look, settings, lenses } = shown;
    let format = settings.sensor.min(FORMATS.len() - 1);
    let (mut chosen, mut action) = (format, None);
    let width = scene.picture_size(settings.export.picture.size)[0];
    let reading = scene.reading(edit, &FORMATS[format], width);
    widgets::section(
        ui,
        id!("section-real-lens"),
        |ui| format_menu(ui, &mut chosen),
        |ui| {
            let colors = theme::palette(ui.ctx());
            ui.label(RichText::new(heard(&reading.title())).color(colors.strong));
            for line in reading.lines() {
                ui.label(RichText::new(heard(&line)).small().color(colors.weak));
            }
            distance(ui, scene, edit, reading.focus_m.filter(|_| reading.scale != Scale::Relative));
            length(ui, scene, edit, look);
            if edit.distance.is_some() && widgets::link(ui, t!("distance-forget")).clicked() {
                (edit.distance, look.measure) = (None, Measure::Off);
            }
            action = lens_menu(ui, scene, edit, lenses, &FORMATS[format]);
        },
    );
    settings.sensor = chosen;
    action
}

fn format_menu(ui: &mut Ui, format: &mut usize) {
    let text = RichText::new(format!("{} ▼", FORMATS[*format].name)).small().color(theme::palette(ui.ctx()).weak);
    ui.menu_button(text, |ui| {
        for (at, choice) in FORMATS.iter().enumerate() {
            if ui.selectable_label(*format == at, choice.name).clicked() {
                *format = at;
                ui.close();
            }
        }
    });
}

/// The distance of what is in focus: as it is known, or as it is given.
fn distance(ui: &mut Ui, scene: &Scene, edit: &mut Edit, known: Option<f32>) {
    let Some(mut metres) = known else {
        let tip = t!("distance-tip");
        if widgets::link(ui, t!("distance-give")).on_hover_text(tip).clicked() {
            *edit = scene.with_distance(edit, Some(1.0));
        }
        return;
    };
    if in_metres(ui, &mut metres, (t!("distance"), t!("distance-hint")), DISTANCES_M, 2) {
        *edit = scene.with_distance(edit, Some(metres));
    }
}

/// A number of metres with what it is called and means; whether it was changed.
fn in_metres(ui: &mut Ui, metres: &mut f32, (label, hint): (&str, &str), range: [f32; 2], decimals: usize) -> bool {
    let (speed, reset) = (0.005 * *metres, *metres);
    let spec = Number { label, range, speed, decimals, prefix: "", suffix: t!("suffix-m"), reset, hint };
    widgets::number(ui, metres, &spec)
}

/// The length of something that a line is drawn over: its distance follows.
fn length(ui: &mut Ui, scene: &Scene, edit: &mut Edit, look: &mut Look) {
    let ends = match look.measure {
        Measure::Off => {
            if widgets::link(ui, t!("length-give")).on_hover_text(t!("length-tip")).clicked() {
                look.measure = Measure::Asked;
            }
            return;
        }
        Measure::Asked => {
            ui.label(RichText::new(t!("length-draw")).small().color(theme::palette(ui.ctx()).accent));
            return;
        }
        Measure::Drawn(ends) | Measure::Over(ends) => ends,
    };
    if edit.distance.is_none()
        && matches!(look.measure, Measure::Over(_))
        && let Some(proposed) = scene.with_length(edit, ends, USUAL_LENGTH_M)
    {
        *edit = proposed;
    }
    let mut metres = scene.length_of(edit, ends).unwrap_or(USUAL_LENGTH_M);
    if in_metres(ui, &mut metres, (t!("length"), t!("length-hint")), LENGTHS_M, 3)
        && let Some(known) = scene.with_length(edit, ends, metres)
    {
        *edit = known;
    }
    if widgets::link(ui, t!("length-done")).clicked() {
        look.measure = Measure::Off;
    }
}

/// Opens the lens as a known one does, all the way.
fn lens_menu(ui: &mut Ui, scene: &Scene, edit: &mut Edit, lenses: &[KnownLens], format: &Format) -> Option<Action> {
    let mut action = None;
    let text = RichText::new(t!("open-as")).small().color(theme::palette(ui.ctx()).weak);
    ui.menu_button(text, |ui| {
        for lens in lenses {
            let blades = lens.blades.map(|n| t!("lens-blades", count = n)).unwrap_or_default();
            let nearest = lens.nearest_m.map(|m| t!("lens-nearest", metres = words::shortest(m))).unwrap_or_default();
            let hint = {
                let [widest, narrowest] = lens.f_numbers.map(words::shortest);
                format!("f/{widest} … f/{narrowest}{blades}{nearest}")
            };
            if ui.button(&lens.name).on_hover_text(hint).clicked() {
                let (f_number, is_cut) = scene.f_number_of(edit, lens, lens.f_numbers[0]);
                *edit = Edit { f_number, shape: lens.shape(lens.f_numbers[0]), ..edit.clone() };
                let title = || scene.reading(edit, format, 1).title();
                let reading = || Message::heard(title());
                let text = || message!("lens-cut", lens = &lens.name, reading = reading());
                action = is_cut.then(|| Action::Tell(text()));
                ui.close();
            }
        }
    });
    action
}
