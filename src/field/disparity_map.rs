//! Disparity of one picture, and depth that only orders.

use super::{FieldError, Filter, Raster, Size, Strength, check_finite, nearest, resample};

/// Disparity of one picture's pixels, in pixels per view step at the map's own width. Larger is nearer; every value is
/// a number.
#[derive(Clone, Debug, PartialEq)]
pub struct DisparityMap(Raster<f32>);

impl DisparityMap {
    /// A map of `[width, height]` pixels; `disparity_px` holds width · height numbers, `[y, x]`.
    pub fn new(size: Size, disparity_px: Vec<f32>) -> Result<Self, FieldError> {
        check_finite("the disparity map", &disparity_px)?;
        Raster::named("the disparity map", size, disparity_px).map(Self)
    }

    /// The same disparity everywhere; one that is no number counts as 0, a side of 0 pixels as 1.
    pub fn constant(size: Size, disparity_px: f32) -> Self {
        Self(Raster::filled(size, if disparity_px.is_finite() { disparity_px } else { 0.0 }))
    }

    /// One of the maps that ray depths are made of, which are checked as this one is.
    pub(super) fn of_rays(map: Raster<f32>) -> Self {
        Self(map)
    }

    /// Width and height in pixels.
    pub fn size(&self) -> Size {
        self.0.size()
    }

    /// All pixels, `[y, x]`.
    pub fn disparity_px(&self) -> &[f32] {
        self.0.pixels()
    }

    /// Gives the pixels away.
    pub fn into_disparity_px(self) -> Vec<f32> {
        self.0.into_pixels()
    }

    /// One pixel.
    pub fn at(&self, x: u32, y: u32) -> f32 {
        self.0.at(x as usize, y as usize)
    }

    /// Least and greatest disparity.
    pub fn range_px(&self) -> [f32; 2] {
        range(self.disparity_px())
    }

    /// The map of a picture of another size. Shrinking takes the nearest values: means would invent depths.
    ///
    /// # Errors
    /// Values beyond all measure.
    pub fn resized(&self, size: Size) -> Result<Self, FieldError> {
        let (from, scale) = (self.size(), self.scale_to(size));
        let values = match from[0] >= size[0] {
            true => nearest(self.disparity_px(), from, size),
            false => resample::<1>(self.disparity_px(), from, size, Filter::Linear),
        };
        Self::new(size, values.into_iter().map(|d| d * scale).collect())
    }

    /// The map of the same scene seen with another baseline.
    #[must_use]
    pub fn at_strength(&self, strength: Strength) -> Self {
        Self(self.0.clone().map(|d| (d * strength.0).clamp(f32::MIN, f32::MAX)))
    }

    /// What this map's disparities are multiplied by in a picture of another size.
    pub fn scale_to(&self, size: Size) -> f32 {
        disparity_scale(self.size(), size)
    }
}

/// What disparities in pixels of one size are multiplied by in another: the ratio of the widths.
pub fn disparity_scale(from: Size, to: Size) -> f32 {
    to[0] as f32 / from[0] as f32
}

/// Least and greatest of values.
pub(super) fn range(values: &[f32]) -> [f32; 2] {
    values.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[lo, hi], &d| [lo.min(d), hi.max(d)])
}

/// Disparity of the far and the near end of a depth that only orders, per pixel of width: a flower before its garden.
const ORDER_RANGE_PER_WIDTH: [f32; 2] = [-0.8 / 540.0, 1.0 / 540.0];
/// Share of the pixels that may lie outside the range at either end.
const TAIL: f32 = 0.02;

/// Depth whose scale nobody knows: a phone's, a relative-depth net's, a grey picture's. Larger is nearer; what is no
/// number is not known.
#[derive(Clone, Debug, PartialEq)]
pub struct RelativeDepth(Raster<f32>);

impl RelativeDepth {
    /// A map of `[width, height]` pixels; `nearness` holds width · height values, `[y, x]`.
    pub fn new(size: Size, nearness: Vec<f32>) -> Result<Self, FieldError> {
        Raster::named("the depth map", size, nearness).map(Self)
    }

    /// A picture whose values order its pixels.
    pub fn of(nearness: Raster<f32>) -> Self {
        Self(nearness)
    }

    /// Width and height in pixels.
    pub fn size(&self) -> Size {
        self.0.size()
    }

    /// All pixels, `[y, x]`.
    pub fn nearness(&self) -> &[f32] {
        self.0.pixels()
    }

    /// The same depth told otherwise.
    #[must_use]
    pub fn map(self, nearness: impl FnMut(f32) -> f32) -> Self {
        Self(self.0.map(nearness))
    }

    /// Far and near end that are taken where nothing better is known, in pixels per view step at a width.
    pub fn usual_range_px(width: u32) -> [f32; 2] {
        ORDER_RANGE_PER_WIDTH.map(|per_width| per_width * width as f32)
    }

    /// The order as disparity over the usual range.
    pub fn disparity(&self) -> DisparityMap {
        self.stretched(Self::usual_range_px(self.size()[0]))
    }

    /// The order as disparity: the 2nd and 98th percentile become `far` and `near`, in pixels per view step of the map's
    /// own width. What is not known is far; 0 where nothing differs.
    pub fn stretched(&self, [far, near]: [f32; 2]) -> DisparityMap {
        let mut sorted: Vec<f32> = self.nearness().iter().copied().filter(|n| n.is_finite()).collect();
        sorted.sort_by(f32::total_cmp);
        let at = |share: f32| sorted.get((share * (sorted.len().max(1) - 1) as f32) as usize).copied().unwrap_or(0.0);
        let (low, high) = (at(TAIL), at(1.0 - TAIL));
        let scale = (near - far) / (high - low);
        if low >= high || !scale.is_finite() {
            return DisparityMap::constant(self.size(), 0.0);
        }
        let px = |n: f32| Some(far + (n - low) * scale).filter(|px| px.is_finite()).unwrap_or(far);
        DisparityMap(self.0.clone().map(px))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_holds_numbers_alone() {
        assert_eq!(DisparityMap::new([2, 1], vec![0.0, 1.0]).unwrap().range_px(), [0.0, 1.0]);
        for bad in [f32::NAN, f32::INFINITY] {
            let text = DisparityMap::new([2, 1], vec![0.0, bad]).unwrap_err().to_string();
            assert!(text.contains("not numbers") && text.contains("repair"), "{text}");
            assert_eq!(DisparityMap::constant([2, 1], bad).range_px(), [0.0, 0.0]);
        }
        assert!(DisparityMap::new([2, 2], vec![0.0; 3]).is_err() && DisparityMap::new([0, 2], vec![]).is_err());
    }

    #[test]
    fn an_order_is_stretched_over_a_range_and_the_unknown_is_far() {
        let ramp = (0..101).map(|i| if i == 50 { f32::NAN } else { i as f32 });
        let map = RelativeDepth::new([101, 1], ramp.collect()).unwrap().stretched([-1.0, 3.0]);
        assert!((map.at(2, 0) + 1.0).abs() < 0.05 && (map.at(98, 0) - 3.0).abs() < 0.05);
        assert!(map.at(100, 0) > map.at(98, 0), "a few values may lie outside");
        assert_eq!(map.at(50, 0), -1.0);
        for nothing in [[7.0; 4], [f32::NAN; 4]] {
            assert_eq!(RelativeDepth::new([2, 2], nothing.into()).unwrap().disparity().range_px(), [0.0, 0.0]);
        }
    }
}
