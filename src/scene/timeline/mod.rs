//! A timeline: what the lens and the eye do in a film, by keyframes.
//!
//! A key says when it is (0 … 1 of the film) and those values that it holds; each value goes its own way from key to key,
//! and stays what the edit says where no key has it. Focus goes evenly in disparity, the aperture in views across (as
//! blur does), the strength in ratios. A timeline knows no seconds but its own: how many frames that is, the film says.

mod keys;
mod preset;

use serde::{Deserialize, Serialize};

use super::export::Settings;
use super::{Edit, Focus, Scene};
use crate::field::{FNumber, Mix, Strength, ViewOffset, ViewPoint};

pub use keys::Holds;
pub use preset::Preset;

/// How many keys there can be.
pub const MOST_KEYS: usize = 64;
/// How long a film can be, in seconds.
pub const SECONDS: [f32; 2] = [0.1, 60.0];
/// How far from the reference view the eye can go, in view steps.
const FARTHEST: f32 = 16.0;

/// What lens and eye do in a film.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Timeline {
    /// How long it is.
    pub seconds: f32,
    /// How it goes from key to key.
    pub ease: Ease,
    /// How it goes on at its end.
    pub run: Run,
    /// The keys, in their order in time.
    pub keys: Vec<Key>,
}

/// What holds at a moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Key {
    /// When: 0 the beginning … 1 the end.
    pub at: f32,
    /// Where it is sharp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focus: Option<Focus>,
    /// How wide open.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub f_number: Option<FNumber>,
    /// How deep the scene is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strength: Option<Strength>,
    /// Where the eye is: steps to the right and down.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eye: Option<[f32; 2]>,
}

/// How values go from key to key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ease {
    /// Evenly.
    Linear,
    /// Slowly at both ends.
    #[default]
    Smooth,
    /// Slowly at the beginning.
    In,
    /// Slowly at the end.
    Out,
}

impl Ease {
    fn of(self, t: f32) -> f32 {
        match self {
            Self::Linear => t,
            Self::Smooth => t * t * (3.0 - 2.0 * t),
            Self::In => t * t,
            Self::Out => t * (2.0 - t),
        }
    }
}

/// How a film goes on at its end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Run {
    /// It ends with the last key.
    #[default]
    Once,
    /// The last key goes on with the first.
    Loop,
    /// There and back.
    PingPong,
}

impl Default for Timeline {
    fn default() -> Self {
        Self { seconds: 3.0, ease: Ease::default(), run: Run::default(), keys: Vec::new() }
    }
}

impl Timeline {
    /// Refuses what no film can be made of.
    ///
    /// # Errors
    /// What is wrong with it, as a part of a sentence.
    pub fn check(&self) -> Result<(), String> {
        if !(1..=MOST_KEYS).contains(&self.keys.len()) {
            return Err(format!("its timeline has {} keys, and 1 to {MOST_KEYS} are wanted", self.keys.len()));
        }
        if !(SECONDS[0]..=SECONDS[1]).contains(&self.seconds) {
            return Err(format!(
                "its timeline lasts {} s, and {} to {} are wanted",
                self.seconds, SECONDS[0], SECONDS[1]
            ));
        }
        if !self.keys.is_sorted_by(|a, b| a.at <= b.at) {
            return Err("the keys of its timeline are not in their order in time".to_owned());
        }
        match self.keys.iter().position(|key| !key.is_good()) {
            Some(at) => Err(format!("key {} of its timeline is out of range", at + 1)),
            None => Ok(()),
        }
    }

    /// How many frames it has at so many a second, as many as there can be.
    pub fn frames(&self, frames_per_second: u16) -> u16 {
        (self.seconds * f32::from(frames_per_second)).round().clamp(2.0, f32::from(Settings::MOST_FRAMES)) as u16
    }

    /// The moment of a frame, 0 … 1.
    pub fn moment(&self, frame: u32, frames: u32) -> f32 {
        let of = |count: u32| frame as f32 / count.max(1) as f32;
        match self.run {
            Run::Once => of(frames.saturating_sub(1)),
            Run::Loop => of(frames),
            Run::PingPong => 1.0 - (1.0 - 2.0 * of(frames)).abs(),
        }
    }

    /// What is done to the picture at a moment. `focused`: the sharp disparity of a focus, as a share of the width.
    pub fn edit_at(&self, moment: f32, edit: &Edit, focused: impl Fn(Focus) -> f32) -> Edit {
        let focus = self.track(moment, |key| key.focus.map(|focus| [focused(focus)]));
        let views = self.track(moment, |key| key.f_number.map(|n| [n.views_across()]));
        let strength = self.track(moment, |key| key.strength.map(|strength| [strength.0.ln()]));
        let eye = self.track(moment, |key| key.eye);
        Edit {
            focus: focus.map_or(edit.focus, |[share]| Focus::Disparity(share)),
            f_number: views.map_or(edit.f_number, |[views]| FNumber(FNumber::PHOTO.0 / views)),
            strength: strength.map_or(edit.strength, |[ln]| Strength(ln.exp()).clamped()),
            viewpoint: eye.map_or(edit.viewpoint, |[du, dv]| ViewPoint(ViewOffset { dv, du })),
            ..edit.clone()
        }
    }

    /// One value on its way between the keys that hold it.
    fn track<const N: usize>(&self, moment: f32, value: impl Fn(&Key) -> Option<[f32; N]>) -> Option<[f32; N]> {
        let held: Vec<(f32, [f32; N])> = self.keys.iter().filter_map(|key| Some((key.at, value(key)?))).collect();
        let (first, last) = (*held.first()?, *held.last()?);
        let after = held.partition_point(|(at, _)| *at <= moment);
        let (from, to) = match (self.run, after) {
            // Round the end: from the last key to the first of the next time.
            (Run::Loop, 0) => ((last.0 - 1.0, last.1), first),
            (Run::Loop, n) if n == held.len() => (last, (first.0 + 1.0, first.1)),
            (_, 0) => return Some(first.1),
            (_, n) if n == held.len() => return Some(last.1),
            (_, n) => (held[n - 1], held[n]),
        };
        let t = self.ease.of(((moment - from.0) / (to.0 - from.0).max(1e-6)).clamp(0.0, 1.0));
        Some(std::array::from_fn(|i| from.1[i].mix(to.1[i], t)))
    }
}

impl Key {
    fn is_good(&self) -> bool {
        let place = |focus: Focus| match focus {
            Focus::At(place) => place.into_iter().all(|share| (0.0..=1.0).contains(&share)),
            Focus::Disparity(share) => share.is_finite() && share.abs() < 1.0,
            Focus::Subject | Focus::Through(_) => true,
        };
        (0.0..=1.0).contains(&self.at)
            && self.focus.is_none_or(place)
            && self.f_number.is_none_or(|n| (0.5..=64.0).contains(&n.0))
            && self.strength.is_none_or(Strength::is_valid)
            && self.eye.is_none_or(|eye| eye.into_iter().all(|at| at.is_finite() && at.abs() <= FARTHEST))
    }
}

impl Scene {
    /// What is done to the picture at a moment of a timeline.
    pub fn edit_at(&self, timeline: &Timeline, moment: f32, edit: &Edit) -> Edit {
        let width = self.map().size()[0] as f32 * self.strength().0;
        let focused = |focus| self.lens(&Edit { focus, ..edit.clone() }).focus.disparity_px / width;
        timeline.edit_at(moment, edit, focused)
    }

    /// What is done to the picture in each frame of a timeline.
    pub fn frames_of(&self, timeline: &Timeline, edit: &Edit, frames: u32) -> Vec<Edit> {
        (0..frames).map(|frame| self.edit_at(timeline, timeline.moment(frame, frames), edit)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(at: f32, focus: f32) -> Key {
        Key { at, focus: Some(Focus::Disparity(focus)), ..Key::default() }
    }

    fn focus(timeline: &Timeline, moment: f32) -> f32 {
        let share = |focus| if let Focus::Disparity(share) = focus { share } else { f32::NAN };
        share(timeline.edit_at(moment, &Edit::default(), share).focus)
    }

    #[test]
    fn values_go_from_key_to_key_and_stay_where_no_key_has_them() {
        let linear =
            Timeline { ease: Ease::Linear, keys: vec![key(0.2, -0.01), key(0.6, 0.03)], ..Timeline::default() };
        for (moment, want) in [(0.0, -0.01), (0.2, -0.01), (0.4, 0.01), (0.6, 0.03), (1.0, 0.03)] {
            assert!((focus(&linear, moment) - want).abs() < 1e-6, "{moment}");
        }
        let edit = Edit { f_number: FNumber(5.6), ..Edit::default() };
        assert_eq!(linear.edit_at(0.4, &edit, |_| 0.0).f_number, edit.f_number);
        let looped = Timeline { run: Run::Loop, ..linear };
        assert!((focus(&looped, 0.9) - 0.01).abs() < 1e-6, "half way round from the last key to the first");
        let smooth = Timeline { ease: Ease::Smooth, run: Run::Once, ..looped };
        assert!(focus(&smooth, 0.25) < -0.007 && (focus(&smooth, 0.4) - 0.01).abs() < 1e-6);
    }

    #[test]
    fn a_loop_does_not_show_its_first_frame_twice_and_a_ping_pong_comes_back() {
        let of = |run| Timeline { run, ..Timeline::default() };
        assert_eq!((of(Run::Once).moment(0, 5), of(Run::Once).moment(4, 5)), (0.0, 1.0));
        assert_eq!(of(Run::Loop).moment(4, 5), 0.8);
        let back: Vec<f32> = (0..4).map(|frame| of(Run::PingPong).moment(frame, 4)).collect();
        assert_eq!(back, [0.0, 0.5, 1.0, 0.5]);
        assert_eq!(of(Run::Once).moment(0, 1), 0.0);
    }

    #[test]
    fn what_no_film_can_be_made_of_is_refused() {
        let good = Timeline { keys: vec![key(0.0, 0.0), key(1.0, 0.01)], ..Timeline::default() };
        assert_eq!(good.check(), Ok(()));
        let with = |keys: Vec<Key>| Timeline { keys, ..good.clone() };
        let eye = Key { eye: Some([f32::NAN, 0.0]), ..Key::default() };
        let bad = [
            with(Vec::new()),
            with(vec![key(0.0, 0.0); MOST_KEYS + 1]),
            with(vec![key(1.0, 0.0), key(0.0, 0.0)]),
            with(vec![key(2.0, 0.0)]),
            with(vec![key(f32::NAN, 0.0)]),
            with(vec![eye]),
            Timeline { seconds: 1e9, ..good.clone() },
        ];
        assert!(bad.iter().all(|timeline| timeline.check().is_err()));
    }
}
