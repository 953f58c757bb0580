//! The photo's colours at a map's size: what tells one thing from another.

use crate::field::{Filter, Raster, Size, View};

/// Colours as they are encoded, 0 … 1, at the size of a map.
#[derive(Clone, Debug)]
pub struct Guide {
    rgb: Raster<[f32; 3]>,
}

impl Guide {
    /// Of a picture of the photo, for maps of a size.
    pub fn new(view: &View, size: Size) -> Self {
        let rgb = view.map(|[r, g, b, _]| [r, g, b].map(|c| f32::from(c) / 255.0));
        Self { rgb: if view.size() == size { rgb } else { rgb.resized(size, Filter::Area) } }
    }

    /// Columns and rows.
    pub fn sides(&self) -> [usize; 2] {
        self.rgb.sides()
    }

    /// The colour of a pixel.
    #[inline]
    pub(super) fn colour(&self, i: usize) -> [f32; 3] {
        self.rgb.pixels()[i]
    }

    /// How much two pixels differ: mean of the channels, 0 … 1.
    #[inline]
    pub(super) fn difference(&self, a: usize, b: usize) -> f32 {
        apart(self.colour(a), self.colour(b))
    }

    /// The mean colour of some pixels; none of none.
    pub(super) fn mean(&self, of: impl Iterator<Item = usize>) -> Option<[f32; 3]> {
        let (mut sum, mut count) = ([0.0; 3], 0.0f32);
        for i in of {
            (0..3).for_each(|c| sum[c] += self.colour(i)[c]);
            count += 1.0;
        }
        (count > 0.0).then(|| sum.map(|light| light / count))
    }
}

/// Difference of two colours, mean of the channels.
#[inline]
pub(super) fn apart(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|c| (a[c] - b[c]).abs()).sum::<f32>() / 3.0
}
