//! What the data engine makes.

use super::Kind;
use super::raster::{Raster, Rgb, window};
use crate::rng::Rng;

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

    /// The upper left corner of a window: of three by chance, the one in which the reference view's depths spread most.
    pub(super) fn telling_window(&self, rng: &mut Rng, size: [usize; 2]) -> [usize; 2] {
        let corners: [[usize; 2]; 3] =
            std::array::from_fn(|_| [0, 1].map(|axis| rng.below(self.size[axis] - size[axis] + 1)));
        let spread = |corner: &[usize; 2]| {
            let depths = window(&self.disparity[..self.size[0] * self.size[1]], self.size[0], *corner, size);
            let mean = depths.iter().sum::<f32>() / depths.len() as f32;
            depths.iter().map(|d| (d - mean).abs()).sum::<f32>()
        };
        corners.into_iter().max_by(|a, b| spread(a).total_cmp(&spread(b))).unwrap_or_default()
    }

    /// A window of it, from a corner on.
    pub(super) fn cut(&self, corner: [usize; 2], size: [usize; 2]) -> Self {
        let each = |maps: &[f32]| -> Vec<f32> {
            let maps = maps.chunks_exact(self.size[0] * self.size[1]);
            maps.flat_map(|map| window(map, self.size[0], corner, size)).collect()
        };
        // Where a pixel lies in the picture, from −1 to 1 along an axis.
        let at = |axis: usize, [first, last]: [f32; 2], pixel: usize| {
            first + (last - first) * pixel as f32 / (self.size[axis] - 1).max(1) as f32
        };
        let ([top, bottom, left, right], [x, y]) = (self.yx, corner);
        let yx = [
            at(1, [top, bottom], y),
            at(1, [top, bottom], y + size[1] - 1),
            at(0, [left, right], x),
            at(0, [left, right], x + size[0] - 1),
        ];
        let subject = self.subject.as_ref().map(|map| window(map, self.size[0], corner, size));
        let (rgb, disparity) = (each(&self.rgb), each(&self.disparity));
        Self { size, rgb, disparity, subject, yx, views: self.views.clone(), origin: self.origin.clone(), ..*self }
    }

    fn place(&self, layer: usize) -> Option<usize> {
        self.views.iter().position(|&own| own == layer)
    }
}

/// Part `i` of an array of equal parts.
fn part(values: &[f32], i: usize, length: usize) -> &[f32] {
    &values[i * length..(i + 1) * length]
}
