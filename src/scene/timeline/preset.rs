//! Timelines ready made, for the scene that is open.

use std::f32::consts::TAU;

use super::{Ease, Key, Run, Timeline};
use crate::field::{FNumber, Strength, ViewGrid};
use crate::scene::{Edit, Focus, Scene};

/// Keys of a circle; between them the eye goes straight.
const CIRCLE: u8 = 32;
/// How much a breathing lens closes: two and a half stops.
const CLOSED: f32 = 2.378;
/// How much deeper a dolly makes the scene.
const DEEPER: f32 = 1.8;

/// What a timeline does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Preset {
    /// The focus, from far to near.
    #[default]
    Pull,
    /// The focus, from one thing that is to be sharp to the next.
    Subjects,
    /// The eye, once round.
    Circle,
    /// The lens closes and opens again.
    Breathing,
    /// The scene grows deeper while its subject stays sharp.
    Dolly,
}

impl Preset {
    /// Its timeline for a scene.
    pub fn timeline(self, scene: &Scene, edit: &Edit) -> Timeline {
        let focus = |at: f32, focus: Focus| Key { at, focus: Some(focus), ..Key::default() };
        let [far, near] = scene.ends().map(Focus::Disparity);
        let (keys, run, ease) = match self {
            Self::Pull => (vec![focus(0.0, far), focus(1.0, near)], Run::Once, Ease::Smooth),
            Self::Subjects => (subjects(edit.focus, far), Run::PingPong, Ease::Smooth),
            Self::Circle => (circle(scene), Run::Loop, Ease::Linear),
            Self::Breathing => {
                let wide = edit.f_number.0;
                let closed = (wide * CLOSED).min(FNumber::PHOTO.0);
                let key = |at: f32, f: f32| Key { at, f_number: Some(FNumber(f)), ..Key::default() };
                (vec![key(0.0, wide), key(1.0, closed)], Run::PingPong, Ease::Smooth)
            }
            Self::Dolly => {
                let key = |at: f32, strength: f32| Key {
                    strength: Some(Strength(edit.strength.0 * strength).clamped()),
                    ..focus(at, edit.focus)
                };
                (vec![key(0.0, 1.0), key(1.0, DEEPER)], Run::PingPong, Ease::Smooth)
            }
        };
        Timeline { keys, run, ease, ..Timeline::default() }
    }
}

/// From place to place, where the edit has several; else from what is sharp to the far end.
fn subjects(focus: Focus, far: Focus) -> Vec<Key> {
    let places: Vec<Focus> = match focus {
        Focus::Through(places) if places.all().len() > 1 => places.all().iter().copied().map(Focus::At).collect(),
        one => vec![one, far],
    };
    let last = (places.len() - 1) as f32;
    let key = |(number, focus)| Key { at: number as f32 / last, focus: Some(focus), ..Key::default() };
    places.into_iter().enumerate().map(key).collect()
}

fn circle(scene: &Scene) -> Vec<Key> {
    let radius = scene.views().map_or(ViewGrid::PAPER, |views| views.field.grid()).inner_radius();
    let key = |number: u8| {
        let at = f32::from(number) / f32::from(CIRCLE);
        Key { at, eye: Some([radius * (at * TAU).cos(), radius * (at * TAU).sin()]), ..Key::default() }
    };
    (0..CIRCLE).map(key).collect()
}
