//! The disparity of every ray.

use super::disparity_map::range;
use super::{DisparityMap, FieldError, Raster, Size, ViewGrid, ViewIndex, check_finite, check_len, pixels};

/// Disparity of every ray: pixels that a point moves per view step, not metres. Larger is nearer;
/// every value is a number.
///
/// # Shapes
/// - `disparity_px`: `[v, u, y, x]`, in pixels of this size
#[derive(Clone, Debug, PartialEq)]
pub struct RayDepths {
    grid: ViewGrid,
    size: Size,
    disparity_px: Vec<f32>,
}

impl RayDepths {
    /// Ray depths of a grid of views of `[width, height]` pixels.
    pub fn new(grid: ViewGrid, size: Size, disparity_px: Vec<f32>) -> Result<Self, FieldError> {
        let plane = pixels(size);
        check_len("the ray depths", grid.count() * plane, disparity_px.len())?;
        check_finite("the ray depths", &disparity_px)?;
        Ok(Self { grid, size, disparity_px })
    }

    /// Rows and columns of views.
    pub fn grid(&self) -> ViewGrid {
        self.grid
    }

    /// Width and height of one map, in pixels.
    pub fn size(&self) -> Size {
        self.size
    }

    /// All maps, `[v, u, y, x]`.
    pub fn disparity_px(&self) -> &[f32] {
        &self.disparity_px
    }

    /// The map of one view, `[y, x]`.
    pub fn view(&self, at: ViewIndex) -> &[f32] {
        let plane = pixels(self.size);
        let start = self.grid.layer_from_view(at) * plane;
        &self.disparity_px[start..start + plane]
    }

    /// The map of the reference view, `[y, x]`.
    pub fn reference(&self) -> &[f32] {
        self.view(self.grid.reference())
    }

    /// The map of the reference view, on its own.
    pub fn reference_map(&self) -> DisparityMap {
        self.map(self.grid.reference())
    }

    /// The map of one view, on its own.
    pub fn map(&self, at: ViewIndex) -> DisparityMap {
        DisparityMap::of_rays(Raster { size: self.size, pixels: self.view(at).to_vec() })
    }

    /// Disparity of one ray.
    pub fn at(&self, view: ViewIndex, x: u32, y: u32) -> f32 {
        self.view(view)[y as usize * self.size[0] as usize + x as usize]
    }

    /// Least and greatest disparity over all rays.
    pub fn range_px(&self) -> [f32; 2] {
        range(&self.disparity_px)
    }
}
