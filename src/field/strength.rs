//! How deep a scene is: the baseline of a view step, against the one that the scene was made with.

use serde::{Deserialize, Serialize};

/// Every disparity `D` of a scene becomes `s·D` (the conventions are in [`crate::field`]).
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Strength(pub f32);

impl Strength {
    /// As the scene was made: a real camera's, where its depth is in metres.
    pub const AS_MADE: Self = Self(1.0);
    /// The least that can be asked for.
    pub const LEAST: f32 = 0.2;
    /// The most that can be asked for.
    pub const MOST: f32 = 4.0;

    /// Whether it can be asked for.
    pub fn is_valid(self) -> bool {
        (Self::LEAST..=Self::MOST).contains(&self.0)
    }

    /// The nearest one that can be asked for; what is no number is that of the scene.
    #[must_use]
    pub fn clamped(self) -> Self {
        if self.0.is_finite() { Self(self.0.clamp(Self::LEAST, Self::MOST)) } else { Self::AS_MADE }
    }
}

impl Default for Strength {
    fn default() -> Self {
        Self::AS_MADE
    }
}
