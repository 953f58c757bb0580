//! What the data engine makes.

use super::Kind;
use super::raster::{Raster, Rgb};

/// One light field, or some of its views.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Layers in `[v, u]` order; the first is the reference view, 36.
    pub views: Vec<usize>,
    /// `[view, channel, y, x]`, sRGB 0 … 1.
    pub rgb: Vec<f32>,
    /// `[view, y, x]`, pixels per view step of this size; NaN where unknown.
    pub disparity: Vec<f32>,
    /// `[y, x]`, subject of the reference view, 255 inside.
    pub subject: Option<Vec<u8>>,
    /// Where the crop lies in its picture: y of the first and last row, x of the first and last column, where the
    /// whole picture runs from −1 to 1.
    pub yx: [f32; 4],
    /// How it was made.
    pub kind: Kind,
    /// The picture that it was made of.
    pub origin: String,
    /// What its truth is worth, 0 … 1: measured, drawn and masked depths 1, maps of other nets less.
    pub worth: f32,
}

impl Sample {
    /// All 64 views in `[v, u]` order; none of a sample that has fewer.
    pub fn pictures(&self) -> Option<Vec<Rgb>> {
        let count = self.size[0] * self.size[1];
        let view = |rgb: &[f32]| (0..count).map(|i| [0, 1, 2].map(|c| rgb[c * count + i])).collect();
        let of_layer =
            |layer| Some(Raster { size: self.size, px: view(part(&self.rgb, self.place(layer)?, 3 * count)) });
        (0..64).map(of_layer).collect()
    }

    /// Their ray depths, `[y, x]` each.
    pub fn depths(&self) -> Option<Vec<&[f32]>> {
        (0..64).map(|layer| Some(part(&self.disparity, self.place(layer)?, self.size[0] * self.size[1]))).collect()
    }

    fn place(&self, layer: usize) -> Option<usize> {
        self.views.iter().position(|&own| own == layer)
    }
}

/// Part `i` of an array of equal parts.
fn part(values: &[f32], i: usize, length: usize) -> &[f32] {
    &values[i * length..(i + 1) * length]
}
