//! A 4-D light field: a grid of views of one size.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{FieldError, Size, View, ViewGrid, ViewIndex, check_len, pixels};

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

    /// A light field of views of one size that lie one after the other in a block, `[v, u, y, x, 4]`.
    pub fn from_block(grid: ViewGrid, size: Size, rgba: Vec<u8>) -> Result<Self, FieldError> {
        check_len("the light field", grid.count() * pixels(size) * 4, rgba.len())?;
        Ok(Self { grid, size, views: View::all_of(rgba.into(), size).map(Arc::new).collect() })
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

    /// The same light field with its views one after the other in one block of memory; itself where they lie so already.
    #[must_use]
    pub fn in_one_block(self: Arc<Self>) -> Arc<Self> {
        if self.block().is_some() {
            return self;
        }
        let mut block = Vec::with_capacity(self.grid.count() * pixels(self.size) * 4);
        self.views.iter().for_each(|view| block.extend_from_slice(view.rgba()));
        Self::from_block(self.grid, self.size, block).map_or(self, Arc::new)
    }

    /// All bytes, `[v, u, y, x, 4]`, where the views lie in one block.
    pub fn block(&self) -> Option<&[u8]> {
        let (block, _) = self.views[0].block();
        let bytes = pixels(self.size) * 4;
        let in_place = |(n, view): (usize, &Arc<View>)| {
            let (other, start) = view.block();
            Arc::ptr_eq(block, other) && start == n * bytes
        };
        let is_one = block.len() == bytes * self.views.len() && self.views.iter().enumerate().all(in_place);
        is_one.then_some(&***block)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_block_holds_all_views_in_order() {
        let grid = ViewGrid::new(2, 3).unwrap();
        let view = |n: u8| Arc::new(View::new([2, 1], vec![n; 8]).unwrap());
        let field = Arc::new(LightField::new(grid, (0..6).map(view).collect()).unwrap());
        assert!(field.block().is_none());
        let packed = Arc::clone(&field).in_one_block();
        assert_eq!(packed, field);
        assert_eq!(packed.block().unwrap(), (0..6).flat_map(|n| [n; 8]).collect::<Vec<u8>>());
        assert!(Arc::ptr_eq(&packed, &Arc::clone(&packed).in_one_block()), "what lies in one block stays where it is");
        let turned = LightField::new(grid, packed.views().iter().rev().cloned().collect()).unwrap();
        assert!(turned.block().is_none(), "another order is another block");
        assert_eq!(View::clone(packed.view(ViewIndex { v: 1, u: 0 })).into_rgba(), [3; 8]);
    }
}
