//! Disparity of one picture.

use super::{FieldError, check_len};

/// Disparity of one picture's pixels, in pixels per view step at the map's own width. Larger is nearer.
///
/// # Shapes
/// - `disparity_px`: `[y, x]`
#[derive(Clone, Debug, PartialEq)]
pub struct DisparityMap {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// `[y, x]`, width · height values.
    pub disparity_px: Vec<f32>,
}

impl DisparityMap {
    /// A map of `[width, height]` pixels.
    pub fn new(size: [u32; 2], disparity_px: Vec<f32>) -> Result<Self, FieldError> {
        check_len("the disparity map", size[0] as usize * size[1] as usize, disparity_px.len())?;
        Ok(Self { size, disparity_px })
    }

    /// The same disparity everywhere.
    pub fn constant(size: [u32; 2], disparity_px: f32) -> Self {
        Self { size, disparity_px: vec![disparity_px; size[0] as usize * size[1] as usize] }
    }

    /// One pixel.
    pub fn at(&self, x: u32, y: u32) -> f32 {
        self.disparity_px[y as usize * self.size[0] as usize + x as usize]
    }

    /// Least and greatest disparity.
    pub fn range_px(&self) -> [f32; 2] {
        self.disparity_px.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[lo, hi], &d| [lo.min(d), hi.max(d)])
    }
}
