//! Keys as a person sets them, one by one.

use super::{Key, MOST_KEYS, Timeline};
use crate::scene::Edit;

/// Keys that are nearer to each other than this are one.
const SAME: f32 = 0.005;

/// Which values a key holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Holds {
    /// The focus.
    pub focus: bool,
    /// The aperture.
    pub aperture: bool,
    /// The eye.
    pub eye: bool,
    /// The strength.
    pub strength: bool,
}

impl Default for Holds {
    fn default() -> Self {
        Self { focus: true, aperture: true, eye: true, strength: false }
    }
}

impl Key {
    /// What an edit is, as a key at a moment.
    pub fn of(at: f32, edit: &Edit, holds: Holds) -> Self {
        let eye = edit.viewpoint.0;
        Self {
            at: at.clamp(0.0, 1.0),
            focus: holds.focus.then_some(edit.focus),
            f_number: holds.aperture.then_some(edit.f_number),
            strength: holds.strength.then_some(edit.strength),
            eye: holds.eye.then_some([eye.du, eye.dv]),
        }
    }

    /// What it holds, for people: "focus, eye".
    pub fn told(&self) -> String {
        let all = [
            (self.focus.is_some(), "focus"),
            (self.f_number.is_some(), "aperture"),
            (self.eye.is_some(), "eye"),
            (self.strength.is_some(), "strength"),
        ];
        let held: Vec<&str> = all.into_iter().filter(|(is_held, _)| *is_held).map(|(_, name)| name).collect();
        held.join(", ")
    }
}

impl Timeline {
    /// The key of a moment.
    pub fn key_at(&self, moment: f32) -> Option<usize> {
        self.keys.iter().position(|key| (key.at - moment).abs() < SAME)
    }

    /// The same with a key more, in place of one at its moment. False where there are as many as there can be.
    pub fn put(&mut self, key: Key) -> bool {
        match self.key_at(key.at) {
            Some(old) => self.keys[old] = key,
            None if self.keys.len() >= MOST_KEYS => return false,
            None => self.keys.insert(self.keys.partition_point(|other| other.at < key.at), key),
        }
        true
    }

    /// Moves a key to another moment, at most to its neighbours.
    pub fn shift(&mut self, number: usize, at: f32) {
        let before = number.checked_sub(1).and_then(|before| self.keys.get(before)).map_or(0.0, |key| key.at + SAME);
        let after = self.keys.get(number + 1).map_or(1.0, |key| key.at - SAME);
        if let Some(key) = self.keys.get_mut(number) {
            key.at = at.min(after).max(before).clamp(0.0, 1.0);
        }
    }

    /// The moment after so many seconds of a film that goes on and on; none once it is over.
    pub fn playing(&self, seconds: f32) -> Option<f32> {
        let through = seconds / self.seconds;
        match self.run {
            super::Run::Once => (through <= 1.0).then_some(through),
            super::Run::Loop => Some(through.fract()),
            super::Run::PingPong => Some(1.0 - (1.0 - 2.0 * through.fract()).abs()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::timeline::Run;

    fn moments(timeline: &Timeline) -> Vec<f32> {
        timeline.keys.iter().map(|key| key.at).collect()
    }

    #[test]
    fn keys_stay_in_their_order_and_one_a_moment() {
        let mut timeline = Timeline::default();
        for at in [0.5, 1.0, 0.0, 0.502, 7.0] {
            assert!(timeline.put(Key::of(at, &Edit::default(), Holds::default())));
        }
        assert_eq!(moments(&timeline), [0.0, 0.502, 1.0]);
        timeline.shift(1, 3.0);
        assert_eq!(moments(&timeline), [0.0, 1.0 - SAME, 1.0]);
        timeline.shift(0, -1.0);
        assert_eq!((timeline.keys[0].at, timeline.check()), (0.0, Ok(())));
        timeline.keys = (0..MOST_KEYS).map(|n| Key { at: n as f32 / MOST_KEYS as f32, ..Key::default() }).collect();
        assert!(!timeline.put(Key { at: 0.999, ..Key::default() }));
    }

    #[test]
    fn a_film_ends_goes_round_or_comes_back() {
        let of = |run| Timeline { seconds: 2.0, run, ..Timeline::default() };
        assert_eq!([1.0, 2.5].map(|secs| of(Run::Once).playing(secs)), [Some(0.5), None]);
        assert_eq!(of(Run::Loop).playing(2.5), Some(0.25));
        assert_eq!([0.5, 1.5].map(|secs| of(Run::PingPong).playing(secs)), [Some(0.5), Some(0.5)]);
    }
}
