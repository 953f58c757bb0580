//! A 4-D light field: a grid of views of one size.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{FieldError, Size, View, ViewGrid, ViewIndex, check_len};

/// A 4-D light field, in sRGB.
///
/// # Shapes
/// - `views`: `[v, u]` of [`View`], all of one size
#[derive(Clone, Debug, PartialEq)]
pub struct LightField {
    grid: ViewGrid,
    size: Size,
    views: Vec<Arc<View>>,
}

impl LightField {
    /// A light field from its views in `[v, u]` order.
    pub fn new(grid: ViewGrid, views: Vec<Arc<View>>) -> Result<Self, FieldError> {
        check_len("the light field", grid.count(), views.len())?;
        let size = views[0].size();
        for (layer, view) in views.iter().enumerate() {
            if view.size() != size {
                let at = grid.view_from_layer(layer);
                return Err(FieldError::ViewSize { v: at.v.into(), u: at.u.into(), want: size, got: view.size() });
            }
        }
        Ok(Self { grid, size, views })
    }

    /// Rows and columns of views.
    pub fn grid(&self) -> ViewGrid {
        self.grid
    }

    /// Width and height of a view, in pixels.
    pub fn size(&self) -> Size {
        self.size
    }

    /// One view.
    pub fn view(&self, at: ViewIndex) -> &Arc<View> {
        &self.views[self.grid.layer_from_view(at)]
    }

    /// The view that was the photo, or the middle one.
    pub fn reference(&self) -> &Arc<View> {
        self.view(self.grid.reference())
    }

    /// All views in `[v, u]` order.
    pub fn views(&self) -> &[Arc<View>] {
        &self.views
    }
}

/// A straight cut through a light field: an epipolar image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum EpiLine {
    /// Picture row `y` in all views of grid row `v`: an image `[u, x]`.
    Row {
        /// Picture row, in pixels.
        y: u32,
        /// Row of views.
        v: u8,
    },
    /// Picture column `x` in all views of grid column `u`: an image `[y, v]`.
    Column {
        /// Picture column, in pixels.
        x: u32,
        /// Column of views.
        u: u8,
    },
}
