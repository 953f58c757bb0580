//! All that a person can turn on the lens: f-number, focus, shape, viewpoint.

use serde::{Deserialize, Serialize};

use super::{Glass, Opening, ViewOffset};

/// An aperture as photographers write it; the paper's are f/28, f/14, f/7 and f/3.5.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
pub struct FNumber(pub f32);

impl FNumber {
    /// One view: the photo as it was taken.
    pub const PHOTO: Self = Self(28.0);
    /// All 8 views across: the widest aperture of the paper.
    pub const PAPER_WIDEST: Self = Self(3.5);
    /// The widest synthetic lens.
    pub const WIDEST: Self = Self(1.0);

    /// Views across the aperture, `n = 28 / N`: 1 at f/28, 8 at f/3.5.
    pub fn views_across(self) -> f32 {
        28.0 / self.0.clamp(Self::WIDEST.0, Self::PHOTO.0)
    }

    /// Diameter of the blur that is added to the photo, in view steps: `√(n² − 1)`, as the photo has f/28 already.
    pub fn added_views(self) -> f32 {
        (self.views_across().powi(2) - 1.0).max(0.0).sqrt()
    }

    /// The aperture that adds so many view steps of blur; the inverse of [`added_views`](Self::added_views).
    pub fn adding(views: f32) -> Self {
        Self((Self::PHOTO.0 / (views * views + 1.0).sqrt()).clamp(Self::WIDEST.0, Self::PHOTO.0))
    }
}

impl Default for FNumber {
    fn default() -> Self {
        Self::PAPER_WIDEST
    }
}

/// The surface that is sharp: a disparity in the middle of the picture, and its tilt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FocalPlane {
    /// Disparity of sharp points in the picture's middle, in pixels per view step of the light field.
    pub disparity_px: f32,
    /// By how much that disparity grows from the left to the right edge, and from the top to the bottom.
    pub tilt_px: [f32; 2],
}

impl FocalPlane {
    /// Disparity that is sharp at a place of the picture, with x and y from 0 to 1.
    pub fn at(&self, x: f32, y: f32) -> f32 {
        self.disparity_px + self.tilt_px[0] * (x - 0.5) + self.tilt_px[1] * (y - 0.5)
    }
}

/// The shape of the aperture, and so of blurred highlights.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LensShape {
    /// A round lens.
    #[default]
    Disc,
    /// The square of the paper's view sets.
    Square,
    /// A polygon of straight blades.
    Blades {
        /// 5 … 9; renderers take [`LensShape::BLADES`].
        count: u8,
        /// Degrees.
        rotation_deg: f32,
        /// 0 straight … 1 a disc.
        roundness: f32,
    },
    /// A mirror lens.
    Ring {
        /// Radius of the hole over that of the lens, 0 … 0.9.
        inner: f32,
    },
    /// A disc cut by the barrel towards the corners.
    CatEye {
        /// 0 none … 1 half the disc in the corners.
        strength: f32,
    },
    /// A picture of one's own: white is open.
    Picture(Opening),
}

impl LensShape {
    /// How many blades a renderer draws at least and at most.
    pub const BLADES: [u8; 2] = [3, 12];

    /// A number of blades that can be drawn.
    pub fn blades(count: u8) -> u8 {
        count.clamp(Self::BLADES[0], Self::BLADES[1])
    }
}

/// Everything a refocus needs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Lens {
    /// How wide open.
    pub f_number: FNumber,
    /// The shape of the opening.
    pub shape: LensShape,
    /// Where it is sharp.
    pub focus: FocalPlane,
    /// Disparities that stay sharp too, around the focal plane: nearer ones and farther ones, relative to it (≤ 0, ≥ 0).
    pub keep_sharp_px: [f32; 2],
    /// How much clipped lights are brightened before they are blurred: 0 not at all … 1.
    pub highlights: f32,
    /// How much of the photo's grain is put back into blurred parts: 0 none … 1.
    pub grain: f32,
    /// Its faults.
    #[serde(skip_serializing_if = "Glass::is_plain")]
    pub glass: Glass,
    /// By how much the sharp surface is nearer in the corners, in pixels per view step.
    #[serde(skip)]
    pub curve_px: f32,
    /// By how much red and blue are sharp farther away than green, in pixels per view step.
    #[serde(skip)]
    pub fringes_px: f32,
}

impl Lens {
    /// The same lens in pixels of another width, which is `ratio` times as large.
    #[must_use]
    pub fn scaled(mut self, ratio: f32) -> Self {
        self.focus.disparity_px *= ratio;
        self.focus.tilt_px = self.focus.tilt_px.map(|px| px * ratio);
        self.keep_sharp_px = self.keep_sharp_px.map(|px| px * ratio);
        self.curve_px *= ratio;
        self.fringes_px *= ratio;
        self
    }

    /// The lens for red and blue, where that is another than for green.
    pub fn magenta(&self) -> Option<Self> {
        let mut magenta = self.clone();
        magenta.focus.disparity_px -= self.fringes_px;
        (self.fringes_px != 0.0).then_some(magenta)
    }

    /// Signed distance of a disparity from what is sharp at a place (x, y from 0 to 1), in pixels per view step.
    pub fn defocus_px(&self, disparity_px: f32, x: f32, y: f32) -> f32 {
        // Half is the corners' distance from the middle, squared.
        let corner = ((x - 0.5).powi(2) + (y - 0.5).powi(2)) / 0.5;
        let away = disparity_px - self.focus.at(x, y) - self.curve_px * corner;
        away - away.clamp(self.keep_sharp_px[0].min(0.0), self.keep_sharp_px[1].max(0.0))
    }

    /// The greatest distance from what is sharp that anything between two disparities has anywhere in the picture.
    pub fn widest_defocus_px(&self, ends_px: [f32; 2]) -> f32 {
        // The farthest from what is sharp lies in a corner, or in the middle of a curved surface.
        let places = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.5, 0.5]];
        let defocus = ends_px.into_iter().flat_map(|d| places.map(|[x, y]| self.defocus_px(d, x, y).abs()));
        defocus.fold(0.0, f32::max)
    }
}

/// Where the eye is: steps from the reference view, fractions between views.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ViewPoint(pub ViewOffset);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_apertures() {
        assert_eq!(FNumber::PHOTO.views_across(), 1.0);
        assert_eq!(FNumber::PHOTO.added_views(), 0.0);
        assert_eq!(FNumber::PAPER_WIDEST.views_across(), 8.0);
        assert!((FNumber::PAPER_WIDEST.added_views() - 7.937).abs() < 1e-3);
        for n in [28.0, 14.0, 3.5, 1.0] {
            assert!((FNumber::adding(FNumber(n).added_views()).0 - n).abs() < 1e-3);
        }
    }

    #[test]
    fn what_is_kept_sharp_has_no_defocus() {
        let lens = Lens { keep_sharp_px: [-0.1, 0.2], ..Lens::default() };
        assert_eq!(lens.defocus_px(0.15, 0.5, 0.5), 0.0);
        assert!((lens.defocus_px(0.5, 0.5, 0.5) - 0.3).abs() < 1e-6);
        assert!((lens.defocus_px(-0.5, 0.5, 0.5) + 0.4).abs() < 1e-6);
    }
}
