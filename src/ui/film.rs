//! The timeline in the window: where its playhead stands, and its film, drawn by the draft renderer.

use super::window::Window;
use super::words::message;
use crate::scene::Edit;
use crate::scene::timeline::{Holds, Key, MOST_KEYS, Preset, Timeline};

/// How far the playhead goes at a press of a key.
const STEP: f32 = 0.05;

/// The timeline, as it is looked at.
#[derive(Default)]
pub struct Film {
    /// Whether its panel is shown.
    pub is_shown: bool,
    /// Where the playhead stands, 0 … 1.
    pub moment: f32,
    /// What a new key holds.
    pub holds: Holds,
    playing: Option<Playing>,
}

/// A film that runs.
struct Playing {
    /// Seconds of egui's clock at its beginning.
    since_secs: f64,
    /// The edit that comes back with its end.
    before: Edit,
}

/// What is done to a timeline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cut {
    /// A key of what is set now, at the playhead.
    Add,
    /// The key at the playhead goes.
    Remove,
    /// One that is ready made takes its place.
    Take(Preset),
    /// All of it goes.
    Clear,
    /// The playhead goes on, or back.
    Step(f32),
}

impl Film {
    /// Whether it runs.
    pub fn is_playing(&self) -> bool {
        self.playing.is_some()
    }

    /// Another photo is open: what ran is over.
    pub fn forget(&mut self) {
        (self.playing, self.moment) = (None, 0.0);
    }
}

/// Lets the film run, or ends it.
pub fn toggle(window: &mut Window, time_secs: f64) {
    if window.film.is_playing() {
        return stop(window);
    }
    let can = window.timeline.is_some() && window.open.scene().is_some();
    let before = window.edit.clone();
    window.film.playing = can.then_some(Playing { since_secs: time_secs, before });
}

/// Ends the film: the edit is again what it was.
pub fn stop(window: &mut Window) {
    if let Some(Playing { before, .. }) = window.film.playing.take() {
        window.edit = before;
    }
}

/// Shows the film's moment; false once it is over.
pub fn run(window: &mut Window, time_secs: f64) -> bool {
    let Window { film, timeline, open, edit, .. } = &mut *window;
    let (Some(playing), Some(timeline), Some(scene)) = (&film.playing, timeline, open.scene()) else {
        stop(window);
        return false;
    };
    match timeline.playing((time_secs - playing.since_secs) as f32) {
        Some(moment) => {
            *edit = scene.edit_at(timeline, moment, &playing.before);
            film.moment = moment;
            true
        }
        None => {
            stop(window);
            false
        }
    }
}

/// Puts the playhead somewhere: lens and eye are what the timeline says there.
pub fn go(window: &mut Window, moment: f32) {
    window.film.moment = moment.clamp(0.0, 1.0);
    if let (Some(timeline), Some(scene)) = (&window.timeline, window.open.scene()) {
        window.edit = scene.edit_at(timeline, window.film.moment, &window.edit);
    }
}

/// Changes the timeline; each change is undone apart from others.
pub fn cut(window: &mut Window, cut: Cut) {
    if let Cut::Step(steps) = cut {
        return go(window, window.film.moment + steps * STEP);
    }
    window.film.is_shown = true;
    window.history.note(&window.step());
    match cut {
        Cut::Add => add(window),
        Cut::Remove => {
            let at = window.film.moment;
            if let Some(timeline) = &mut window.timeline
                && let Some(number) = timeline.key_at(at)
            {
                timeline.keys.remove(number);
            }
            window.timeline.take_if(|timeline| timeline.keys.is_empty());
        }
        Cut::Take(preset) => {
            if let Some(scene) = window.open.scene() {
                window.timeline = Some(preset.timeline(scene, &window.edit));
            }
        }
        Cut::Clear => window.timeline = None,
        Cut::Step(_) => {}
    }
    window.history.note(&window.step());
}

/// A key of what is set now. The first one is put at the beginning.
fn add(window: &mut Window) {
    let at = if window.timeline.is_some() { window.film.moment } else { 0.0 };
    let key = Key::of(at, &window.edit, window.film.holds);
    let timeline = window.timeline.get_or_insert_with(Timeline::default);
    if !timeline.put(key) {
        window.toasts.error(message!("keys-most", most = MOST_KEYS));
    }
}
