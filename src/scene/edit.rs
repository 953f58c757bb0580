//! What a person does to a picture: an edit, whose numbers have no width.

use serde::{Deserialize, Serialize};

use super::real::Distance;
use super::sharp::{self, Places};
use super::{Salience, focus};
use crate::field::{DisparityMap, FNumber, FocalPlane, Glass, Lens, LensShape, Strength, ViewOffset, ViewPoint};
use crate::io::formats::stereo;

/// Where it is sharp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Focus {
    /// On what the picture most likely is about, each picture on its own.
    #[default]
    Subject,
    /// On what is seen at a place, x and y from 0 to 1.
    At([f32; 2]),
    /// On all of up to three places, by a plane through them or a band around them.
    Through(Places),
    /// At a disparity in the middle of the picture, as a share of its width per view step.
    Disparity(f32),
}

/// Everything that is done to a picture.
///
/// Disparities are shares of the picture's width per view step: the same edit is the same picture, however wide the
/// views are that its depth was made for. They are those of strength 1: who turns the strength keeps the same things in
/// focus. [`Edit::lens`] brings them to the pixels of a map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Edit {
    /// How wide open.
    pub f_number: FNumber,
    /// How deep the scene is.
    pub strength: Strength,
    /// The shape of the opening.
    pub shape: LensShape,
    /// Where it is sharp.
    pub focus: Focus,
    /// By how much the sharp disparity grows from the left to the right edge, and from the top to the bottom.
    pub tilt: [f32; 2],
    /// Disparities that stay sharp too: farther and nearer ones, relative to the focal plane (≤ 0, ≥ 0).
    pub keep_sharp: [f32; 2],
    /// How much clipped lights are brightened before they are blurred, 0 … 1.
    pub highlights: f32,
    /// How much of the photo's grain is put back into blurred parts, 0 … 1.
    pub grain: f32,
    /// The faults of the lens.
    pub glass: Glass,
    /// The disparity of what stays where it is while the eye goes round.
    pub pivot: f32,
    /// A distance that the person knows, where metres are read off the lens.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance: Option<Distance>,
    /// Where the lens stands, in steps from the reference view.
    #[serde(skip)]
    pub viewpoint: ViewPoint,
}

impl Edit {
    /// The lens for a map of a strength, which may be another than the edit's while that is being made: disparities in
    /// pixels of its width, the focal plane through what is to be sharp.
    pub fn lens(&self, map: &DisparityMap, strength: Strength) -> Lens {
        let width = map.size()[0] as f32 * strength.0;
        let tilted = FocalPlane { disparity_px: 0.0, tilt_px: self.tilt.map(|share| share * width) };
        let through = |place: [f32; 2]| focus::disparity_at(map, place) - tilted.at(place[0], place[1]);
        let keep_px = self.keep_sharp.map(|share| share * width);
        let at = |disparity_px: f32| (FocalPlane { disparity_px, ..tilted }, keep_px);
        let (focus, keep_sharp_px) = match self.focus {
            Focus::Subject => at(through(focus::subject(map, &Salience::even()))),
            Focus::At(place) => at(through(place)),
            Focus::Disparity(share) => at(share * width),
            Focus::Through(places) => match places.all() {
                [place] => at(through(*place)),
                _ => {
                    let solved = sharp::solve(map, &places, strength.0);
                    let [far, near] = solved.keep_px;
                    (solved.plane, [keep_px[0].min(far), keep_px[1].max(near)])
                }
            },
        };
        let Self { f_number, highlights, grain, glass, .. } = *self;
        let shape = self.shape.clone();
        let (curve_px, fringes_px) = (glass.curve_px(width), glass.fringes_px(width));
        Lens { f_number, shape, focus, keep_sharp_px, highlights, grain, glass, curve_px, fringes_px }
    }

    /// The same edit for both eyes, `apart` view steps from each other, left first.
    pub fn for_eyes(&self, apart: f32) -> [Self; 2] {
        stereo::eyes(apart).map(|ViewPoint(eye)| {
            let here = self.viewpoint.0;
            Self { viewpoint: ViewPoint(ViewOffset { du: here.du + eye.du, ..here }), ..self.clone() }
        })
    }

    /// What stays where it is while the eye goes round, in pixels of a width.
    pub fn pivot_px(&self, width: u32, strength: Strength) -> f32 {
        self.pivot * width as f32 * strength.0
    }

    /// The same edit with the disparities of a lens, which are in pixels of `width` and of a strength; the place in focus is
    /// given up.
    #[must_use]
    pub fn with_lens(self, lens: &Lens, width: u32, strength: Strength) -> Self {
        let share = |px: f32| px / (width as f32 * strength.0);
        Self {
            f_number: lens.f_number,
            shape: lens.shape.clone(),
            focus: Focus::Disparity(share(lens.focus.disparity_px)),
            tilt: lens.focus.tilt_px.map(share),
            keep_sharp: lens.keep_sharp_px.map(share),
            highlights: lens.highlights,
            grain: lens.grain,
            glass: lens.glass,
            ..self
        }
    }

    /// The edit for a photo that was never edited: lens and look of the last one, none of what belongs to its depth.
    #[must_use]
    pub fn for_new_photo(self) -> Self {
        let Self { f_number, shape, highlights, grain, glass, .. } = self;
        Self { f_number, shape, highlights, grain, glass, ..Self::default() }
    }

    /// Whether the picture is what the reference view shows: closed down, and seen from where the photo was taken.
    pub fn shows_photo_itself(&self) -> bool {
        self.f_number.added_views() == 0.0 && self.viewpoint == ViewPoint::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp from −1 to 1 px over 540 px, brought to other widths.
    fn ramp(width: u32) -> DisparityMap {
        let height = width * 2 / 3;
        let value = |i: u32| ((i % width) as f32 + 0.5) / width as f32 * 2.0 - 1.0;
        let px = (0..width * height).map(|i| value(i) * width as f32 / 540.0).collect();
        DisparityMap::new([width, height], px).unwrap()
    }

    #[test]
    fn the_same_edit_is_the_same_lens_at_every_width() {
        let edit =
            Edit { focus: Focus::At([0.75, 0.3]), tilt: [1e-3, -5e-4], keep_sharp: [-2e-4, 3e-4], ..Edit::default() };
        let share = |edit: &Edit, width: u32| {
            let lens = edit.lens(&ramp(width), Strength::AS_MADE);
            let all = [lens.focus.disparity_px, lens.focus.tilt_px[0], lens.keep_sharp_px[1]];
            all.map(|px| px / width as f32)
        };
        for edit in [
            edit.clone(),
            Edit { focus: Focus::Disparity(4e-4), ..edit.clone() },
            Edit { focus: Focus::Subject, ..edit },
        ] {
            let (wide, narrow) = (share(&edit, 540), share(&edit, 270));
            assert!(wide.iter().zip(narrow).all(|(a, b)| (a - b).abs() < 2e-5), "{wide:?} {narrow:?}");
        }
    }

    #[test]
    fn a_tilted_plane_goes_through_the_place_in_focus() {
        let edit = Edit { focus: Focus::At([0.25, 0.5]), tilt: [2e-3, 0.0], ..Edit::default() };
        let lens = edit.lens(&ramp(540), Strength::AS_MADE);
        assert!((lens.focus.at(0.25, 0.5) + 0.5).abs() < 0.01, "{:?}", lens.focus);
    }

    #[test]
    fn a_lens_comes_back_as_it_was() {
        let map = ramp(270);
        let edit = Edit { focus: Focus::Disparity(1e-3), tilt: [1e-3, 0.0], grain: 0.5, ..Edit::default() };
        assert_eq!(Edit::default().with_lens(&edit.lens(&map, Strength(1.0)), 270, Strength(1.0)), edit);
        // Halves and doubles are exact.
        let strong = Strength(2.0);
        assert_eq!(Edit::default().with_lens(&edit.lens(&map.at_strength(strong), strong), 270, strong), edit);
    }

    #[test]
    fn at_another_strength_the_same_things_are_sharp() {
        let (map, strong) = (ramp(540), Strength(2.0));
        let at = Edit { focus: Focus::At([0.25, 0.5]), tilt: [1e-3, 0.0], keep_sharp: [-2e-4, 0.0], ..Edit::default() };
        for edit in
            [at.clone(), Edit { focus: Focus::Disparity(4e-4), ..at.clone() }, Edit { focus: Focus::Subject, ..at }]
        {
            let (plain, deep) = (edit.lens(&map, Strength::AS_MADE), edit.lens(&map.at_strength(strong), strong));
            for x in [0.0, 0.3, 0.9] {
                let d = 2.0 * x - 1.0;
                let [plain, deep] = [plain.defocus_px(d, x, 0.5), deep.defocus_px(2.0 * d, x, 0.5)];
                assert!((deep - 2.0 * plain).abs() < 1e-5, "{edit:?} at {x}: {plain} and {deep}");
            }
        }
    }
}
