//! The lens in a photographer's numbers: focal length and f-number on a real format, distances, blur on the sensor.
//!
//! Disparity and distance hang together as `D = g·(1/z − 1/z₀)` ([`Metric`]). With the focal length `f` in pixels the
//! baseline of a view step is `b = g/f`, the aperture is `A = n·b` wide with `n = 28/N`, and so the lens is a real one of
//! `f/A`. What lies within `δ = c/(n·g)` of `1/z` at the focus is sharp within a circle of confusion `c`; `1/δ` is the
//! hyperfocal distance `f²/(N·c)`. A strength `s` makes `b` and `g` `s` times as large ([`crate::field`]).
//!
//! Where nobody knows metres, one distance that a person gives fixes them: what lies farthest is taken for very far away.

mod known;

use serde::{Deserialize, Serialize};

use super::{Edit, Focus, Scene};
use crate::field::FNumber;
use crate::synth::range::{F35_MM, FILM_M, Metric, USUAL_F35_MM, VIEWS};

pub use known::{KnownLens, LensFileError, all as known_lenses, own_folder, published as published_lenses};

/// A sensor, by the length of its longer side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Format {
    /// How the command line calls it.
    pub id: &'static str,
    /// What it is called.
    pub name: &'static str,
    /// Length of its longer side, in millimetres.
    pub long_mm: f32,
}

/// The formats that lenses are read on.
pub const FORMATS: [Format; 5] = [
    Format { id: "full-frame", name: "full frame", long_mm: 36.0 },
    Format { id: "44x33", name: "44 × 33", long_mm: 43.8 },
    Format { id: "aps-c", name: "APS-C", long_mm: 23.5 },
    Format { id: "mft", name: "Micro Four Thirds", long_mm: 17.3 },
    Format { id: "1-inch", name: "1 inch", long_mm: 13.2 },
];

/// Circle of confusion on full frame, in millimetres: what counts as sharp in tables of depth of field.
const CONFUSION_MM: f32 = 0.03;
/// Part of the scene's depth by which a thing of known distance must lie before the far end.
const LEAST_DEPTH: f32 = 0.05;
/// Places of a known length are at least so far apart, in pixels of the photo.
const LEAST_LENGTH_PX: f32 = 4.0;
/// Distances that can be given, in metres.
pub const DISTANCES_M: [f32; 2] = [0.01, 10_000.0];

/// A distance that a person knows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Distance {
    /// Of what: as a focus is told.
    pub of: Focus,
    /// How far it is.
    pub metres: f32,
}

impl Distance {
    /// Whether it can be one.
    pub fn is_valid(&self) -> bool {
        (DISTANCES_M[0]..=DISTANCES_M[1]).contains(&self.metres)
    }
}

/// Where distances come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// The source of depth is in metres.
    Measured,
    /// A person gave one distance.
    Given,
    /// Nobody knows them: f-numbers are those of the scene as it was made.
    Relative,
}

/// A lens in numbers of a real one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reading {
    /// The sensor.
    pub format: &'static str,
    /// Focal length on it, in millimetres.
    pub focal_mm: f32,
    /// Whether the photo's file says it.
    pub focal_is_known: bool,
    /// The f-number on it.
    pub f_number: f32,
    /// Where distances come from.
    pub scale: Scale,
    /// Distance that is sharp in the picture's middle, in metres; none where it is not known or not finite.
    pub focus_m: Option<f32>,
    /// Where sharpness begins.
    pub near_m: Option<f32>,
    /// Where it ends; none where it does not end.
    pub far_m: Option<f32>,
    /// Focused there, all behind is sharp.
    pub hyperfocal_m: Option<f32>,
    /// Diameter of the blur of what lies farthest, in micrometres on the sensor.
    pub background_um: f32,
    /// The same in pixels of the picture.
    pub background_px: f32,
}

impl Scene {
    /// The lens of an edit on a format, for a picture of a width.
    pub fn reading(&self, edit: &Edit, format: &Format, picture_width: u32) -> Reading {
        let optics = Optics::of(self, edit);
        let long_mm = format.long_mm;
        let lens = self.lens_at(edit, 1);
        let strength = self.strength().0;
        let focus = lens.focus.disparity_px / strength;
        let blur = lens.defocus_px(self.ends()[0] * strength, 0.5, 0.5).abs() * edit.f_number.added_views();
        let metric = optics.metric.map(|(metric, _)| metric);
        let per_metre = metric.map(|metric| focus / metric.gain + metric.nearness);
        let confusion = CONFUSION_MM / 1000.0 / FILM_M * optics.long;
        let sharp = metric.map(|metric| confusion / (edit.f_number.views_across() * strength * metric.gain));
        let metres = |nearness: Option<f32>| nearness.filter(|n| *n > 1.0 / DISTANCES_M[1]).map(f32::recip);
        Reading {
            format: format.name,
            focal_mm: optics.f35_mm * long_mm / (FILM_M * 1000.0),
            focal_is_known: optics.focal_is_known,
            f_number: optics.real_from(edit.f_number) * long_mm / (FILM_M * 1000.0),
            scale: optics.metric.map_or(Scale::Relative, |(_, scale)| scale),
            focus_m: metres(per_metre),
            near_m: metres(per_metre.zip(sharp).map(|(at, sharp)| at + sharp)),
            far_m: metres(per_metre.zip(sharp).map(|(at, sharp)| at - sharp)),
            hyperfocal_m: metres(sharp),
            background_um: blur / optics.long * long_mm * 1000.0,
            background_px: blur * picture_width as f32,
        }
    }

    /// The f-number of the slider whose aperture is as wide as a lens's, and whether it had to be cut to what there is.
    pub fn f_number_of(&self, edit: &Edit, lens: &KnownLens, f_number: f32) -> (FNumber, bool) {
        let optics = Optics::of(self, edit);
        let real = optics.f35_mm * f_number / lens.focal_mm;
        let wanted = real / optics.real_from(FNumber(1.0));
        let cut = wanted.clamp(FNumber::WIDEST.0, FNumber::PHOTO.0);
        (FNumber(cut), (cut - wanted).abs() > 0.005 * wanted)
    }

    /// The camera's focal length over the picture's width, and a view step in metres; where nobody says them, the usual ones.
    pub fn camera(&self, edit: &Edit) -> (f32, f32) {
        let optics = Optics::of(self, edit);
        (optics.f35_mm / 1000.0 / FILM_M * optics.long, optics.step_m() * optics.strength)
    }

    /// The edit with the distance of what it focuses on.
    pub fn with_distance(&self, edit: &Edit, metres: Option<f32>) -> Edit {
        Edit { distance: metres.map(|metres| Distance { of: edit.focus, metres }), ..edit.clone() }
    }

    /// The edit with the distance of something whose length is known: `ends` are places of the photo, x and y from 0 to 1. A
    /// thing of length `L` that is `ℓ` long in the photo lies at `L·f/ℓ`, where it lies straight before the camera; `f` is the
    /// photo's focal length, or the usual one. None where the ends are too near to each other.
    pub fn with_length(&self, edit: &Edit, ends: [[f32; 2]; 2], metres: f32) -> Option<Edit> {
        let metres = self.lengths_per_distance(ends)?.recip() * metres;
        let [from, to] = ends;
        let middle = [0, 1].map(|axis| (from[axis] + to[axis]) / 2.0);
        let distance = Distance { of: Focus::At(middle), metres: metres.clamp(DISTANCES_M[0], DISTANCES_M[1]) };
        Some(Edit { distance: Some(distance), ..edit.clone() })
    }

    /// How long something between two places is whose distance was given by [`with_length`](Self::with_length), in metres.
    pub fn length_of(&self, edit: &Edit, ends: [[f32; 2]; 2]) -> Option<f32> {
        Some(self.lengths_per_distance(ends)? * edit.distance?.metres)
    }

    /// Length over distance of what lies between two places of the photo.
    fn lengths_per_distance(&self, [from, to]: [[f32; 2]; 2]) -> Option<f32> {
        let [w, h] = self.subject().size().map(|side| side as f32);
        let pixels = ((to[0] - from[0]) * w).hypot((to[1] - from[1]) * h);
        let focal = told_focal_of(self).unwrap_or(USUAL_F35_MM) / 1000.0 / FILM_M;
        (pixels >= LEAST_LENGTH_PX).then_some(pixels / w.max(h) / focal)
    }

    /// Disparity of what a focus means, as a share of the width at strength 1.
    fn share_at(&self, focus: &Focus) -> f32 {
        let plain = Edit { focus: *focus, ..Edit::default() };
        let made = self.as_made();
        made.lens(&plain).focus.disparity_px / made.map().size()[0] as f32
    }
}

/// What is known of the camera and of metres.
struct Optics {
    f35_mm: f32,
    focal_is_known: bool,
    /// Length of the longer side in widths of the picture.
    long: f32,
    /// At strength 1.
    metric: Option<(Metric, Scale)>,
    strength: f32,
}

impl Optics {
    fn of(scene: &Scene, edit: &Edit) -> Self {
        let measured = scene.metric();
        let told = told_focal_of(scene);
        let [w, h] = scene.subject().size().map(|side| side as f32);
        let given = edit.distance.and_then(|distance| given(scene, measured, &distance));
        Self {
            f35_mm: told.unwrap_or(USUAL_F35_MM),
            focal_is_known: told.is_some(),
            long: w.max(h) / w,
            metric: given.or(measured.map(|metric| (metric, Scale::Measured))),
            strength: scene.strength().0,
        }
    }

    /// The f-number on full frame of one on the slider.
    fn real_from(&self, f: FNumber) -> f32 {
        let f35_m = self.f35_mm / 1000.0;
        f.0 * f35_m / VIEWS / (self.step_m() * self.strength)
    }

    /// A view step at strength 1; the usual one where nothing is known of metres.
    fn step_m(&self) -> f32 {
        let f35_m = self.f35_mm / 1000.0;
        self.metric.map_or(f35_m / VIEWS, |(metric, _)| metric.gain * FILM_M / (self.long * f35_m))
    }
}

/// Focal length on full frame that the photo's file says, if it can be one: some say 0.
fn focal_of(scene: &Scene) -> Option<f32> {
    scene.subject().f35_mm().filter(|mm| (F35_MM[0]..=F35_MM[1]).contains(mm))
}

/// The same, or what the source of depth says.
fn told_focal_of(scene: &Scene) -> Option<f32> {
    focal_of(scene).or(scene.metric().map(|metric| metric.f35_mm))
}

/// Metres from one distance: those of the source brought to it, else with what lies farthest very far away. None for what
/// lies farthest itself.
fn given(scene: &Scene, measured: Option<Metric>, distance: &Distance) -> Option<(Metric, Scale)> {
    let share = scene.share_at(&distance.of);
    let f35_mm = focal_of(scene).unwrap_or(USUAL_F35_MM);
    let metric = match measured {
        Some(metric) => {
            let factor = 1.0 / (distance.metres * (share / metric.gain + metric.nearness));
            Metric { gain: metric.gain / factor, nearness: metric.nearness * factor, ..metric }
        }
        None => {
            let [far, near] = scene.ends();
            // What is hardly before the far end tells nothing.
            if share - far <= LEAST_DEPTH * (near - far) {
                return None;
            }
            let gain = (share - far) * distance.metres;
            Metric { gain, nearness: -far / gain, f35_mm }
        }
    };
    let is_good = metric.gain.is_finite() && metric.gain > 1e-7 && metric.nearness.is_finite();
    is_good.then_some((metric, Scale::Given))
}

impl Reading {
    /// "26 mm f/1.8 on full frame".
    pub fn title(&self) -> String {
        format!("{:.0} mm f/{} on {}", self.focal_mm, self.f(), self.format)
    }

    /// The same in a line that says what of it is assumed: "f/3.5 on full frame, if taken with 28 mm".
    pub fn headline(&self) -> String {
        let (format, mm) = (self.format, self.focal_mm);
        let title = match self.focal_is_known {
            true => self.title(),
            false => format!("f/{} on {format}, if taken with {mm:.0} mm", self.f()),
        };
        let relative = if self.scale == Scale::Relative { " · relative, as no distance is known" } else { "" };
        format!("{title}{relative}")
    }

    fn f(&self) -> String {
        let f = if self.f_number < 9.95 { format!("{:.1}", self.f_number) } else { format!("{:.0}", self.f_number) };
        f.strip_suffix(".0").unwrap_or(&f).to_owned()
    }

    /// What a person reads below it, a line each.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        match (self.scale, self.focus_m) {
            (Scale::Relative, _) => lines.push("relative: no distance is known here".to_owned()),
            (_, Some(focus)) => lines.push(format!("focus at {} · sharp {}", metres(focus), self.sharp())),
            (_, None) => lines.push(format!("focus very far away · sharp {}", self.sharp())),
        }
        if let Some(hyperfocal) = self.hyperfocal_m {
            lines.push(format!("hyperfocal distance {}", metres(hyperfocal)));
        }
        let (um, px) = (self.background_um, self.background_px);
        lines.push(format!("blur of what is farthest {um:.0} µm · {px:.0} px"));
        if !self.focal_is_known {
            lines.push(format!("the photo names no lens: {USUAL_F35_MM:.0} mm is assumed"));
        }
        lines
    }

    fn sharp(&self) -> String {
        match (self.near_m, self.far_m) {
            (Some(near), Some(far)) => format!("{} … {}", metres(near), metres(far)),
            (Some(near), None) => format!("from {} on", metres(near)),
            (None, _) => "all that is far".to_owned(),
        }
    }
}

/// "65 cm", "1.25 m", "12 m".
fn metres(m: f32) -> String {
    match m {
        m if m < 0.1 => format!("{:.0} mm", m * 1000.0),
        m if m < 0.995 => format!("{:.0} cm", m * 100.0),
        m if m < 10.0 => format!("{m:.2} m"),
        m if m < 1000.0 => format!("{m:.0} m"),
        m => format!("{:.0} km", m / 1000.0),
    }
}

#[cfg(test)]
mod tests;
