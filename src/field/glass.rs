//! What a lens does beside being wide: a small model of its faults, all of them none by default.

use serde::{Deserialize, Serialize};

/// The faults of a lens, as photographers look for them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Glass {
    /// Anamorphic: 0 round discs … 1 discs twice as tall as wide.
    pub anamorphic: f32,
    /// Spherical aberration: behind the focus −1 discs with a bright middle … 1 discs with a bright rim; before it the
    /// other way round.
    pub spherical: f32,
    /// Longitudinal colour: 0 none … 1 much: green rims behind the focus, magenta ones before it.
    pub fringes: f32,
    /// Swirl: 0 none … 1 much: the barrel cuts discs towards the corners, and the sharp surface is curved.
    pub swirl: f32,
}

/// By how much red and blue are sharp farther away than green, as a share of the width.
const FRINGES: f32 = 0.03 / 540.0;
/// By how much the sharp surface is nearer in the corners, as a share of the width.
const CURVE: f32 = 0.3 / 540.0;

impl Glass {
    /// A lens without faults.
    pub const PLAIN: Self = Self { anamorphic: 0.0, spherical: 0.0, fringes: 0.0, swirl: 0.0 };

    /// Whether it does nothing.
    pub fn is_plain(&self) -> bool {
        *self == Self::PLAIN
    }

    /// Names the number that cannot be, if there is one.
    pub fn out_of_range(&self) -> Option<&'static str> {
        let checks = [
            ("anamorphic", (0.0..=1.0).contains(&self.anamorphic)),
            ("spherical", (-1.0..=1.0).contains(&self.spherical)),
            ("fringes", (0.0..=1.0).contains(&self.fringes)),
            ("swirl", (0.0..=1.0).contains(&self.swirl)),
        ];
        checks.iter().find(|(_, is_good)| !is_good).map(|(name, _)| *name)
    }

    /// Width of a disc over its height.
    pub fn narrow(&self) -> f32 {
        1.0 / (1.0 + self.anamorphic.clamp(0.0, 1.0))
    }

    /// Disparity by which red and blue are sharp farther away than green, at a width.
    pub fn fringes_px(&self, width: f32) -> f32 {
        self.fringes * FRINGES * width
    }

    /// Disparity by which the sharp surface is nearer in the corners, at a width.
    pub fn curve_px(&self, width: f32) -> f32 {
        self.swirl * CURVE * width
    }
}
