//! The ellipsoids of a scene.

use glam::{Mat3, Quat, Vec3};

use super::harmonics;

/// One soft ellipsoid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian {
    /// Its middle, in the world's unit.
    pub center: Vec3,
    /// Standard deviations along its own axes.
    pub scale: Vec3,
    /// World from its own axes; of length 1.
    pub rotation: Quat,
    /// How much of the light behind its middle it keeps off, 0 … 1.
    pub opacity: f32,
}

impl Gaussian {
    /// World from the unit ball: rotation after scale, so that the covariance is `M·Mᵀ`.
    pub fn ball(&self) -> Mat3 {
        let turn = Mat3::from_quat(self.rotation);
        Mat3::from_cols(turn.x_axis * self.scale.x, turn.y_axis * self.scale.y, turn.z_axis * self.scale.z)
    }

    /// Whether it is made of numbers that something can be drawn of.
    pub fn is_sound(&self) -> bool {
        let length = self.rotation.length_squared();
        let scale = self.scale.is_finite() && self.scale.min_element() >= 0.0;
        self.center.is_finite() && scale && self.opacity.is_finite() && (0.99..1.01).contains(&length)
    }
}

/// In which values the light of many Gaussians is put together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blend {
    /// In sRGB-encoded values, as the method was published: colours were found by training so.
    #[default]
    Encoded,
    /// In linear light; colours are stored sRGB-encoded.
    Linear,
    /// In linear light, in which colours are stored too.
    StoredLinear,
}

/// All Gaussians of a scene, with their colours.
///
/// # Shapes
/// - `harmonics`: `[n, (degree + 1)², 3]`
#[derive(Clone, Debug, PartialEq)]
pub struct Cloud {
    /// The Gaussians, in any order.
    pub gaussians: Vec<Gaussian>,
    /// Degree of the spherical harmonics, 0 … 3.
    degree: usize,
    harmonics: Vec<f32>,
    /// How light is put together.
    pub blend: Blend,
}

impl Cloud {
    /// The most Gaussians that a scene may have.
    pub const MOST: usize = 8_000_000;

    /// No Gaussians yet, but room for them.
    pub fn with_room(degree: usize, room: usize, blend: Blend) -> Self {
        let degree = degree.min(harmonics::MOST_DEGREE);
        let coefficients = harmonics::count(degree) * 3;
        Self { gaussians: Vec::with_capacity(room), degree, harmonics: Vec::with_capacity(room * coefficients), blend }
    }

    /// Adds a Gaussian with its coefficients, `[(degree + 1)², 3]`; missing ones are 0.
    pub fn push(&mut self, gaussian: Gaussian, coefficients: &[[f32; 3]]) {
        self.gaussians.push(gaussian);
        let count = harmonics::count(self.degree);
        let values = (0..count).map(|i| coefficients.get(i).copied().unwrap_or_default());
        self.harmonics.extend(values.flatten());
    }

    /// Adds all Gaussians of a cloud of the same degree.
    pub fn append(&mut self, mut other: Self) {
        debug_assert_eq!(self.degree, other.degree);
        self.gaussians.append(&mut other.gaussians);
        self.harmonics.append(&mut other.harmonics);
    }

    /// Degree of the spherical harmonics.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The coefficients of one Gaussian, `[(degree + 1)², 3]`.
    pub fn coefficients(&self, at: usize) -> &[[f32; 3]] {
        let count = harmonics::count(self.degree);
        &self.harmonics.as_chunks().0[at * count..(at + 1) * count]
    }

    /// The same, to be changed.
    pub fn coefficients_mut(&mut self, at: usize) -> &mut [[f32; 3]] {
        let count = harmonics::count(self.degree);
        &mut self.harmonics.as_chunks_mut().0[at * count..(at + 1) * count]
    }

    /// Every so-manieth Gaussian, for a first look: at most `most` of them.
    #[must_use]
    pub fn thinned(&self, most: usize) -> Self {
        let step = self.gaussians.len().div_ceil(most.max(1)).max(1);
        let mut thin = Self::with_room(0, self.gaussians.len() / step + 1, self.blend);
        // What is left stands for what was left out, so that surfaces stay closed.
        let grow = (step as f32).sqrt();
        for at in (0..self.gaussians.len()).step_by(step) {
            let gaussian = self.gaussians[at];
            thin.push(Gaussian { scale: gaussian.scale * grow, ..gaussian }, self.coefficients(at));
        }
        thin
    }
}
