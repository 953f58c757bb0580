//! Epipolar images: one line of the picture in all views of a row or column of the grid. Twin of `epi.wgsl`.

use super::tap;
use crate::field::{EpiLine, LightField, ViewIndex};
use crate::render::Picture;

/// The cut along `line`, with each view `scale` pixels thick.
///
/// # Shapes
/// - a row's picture: `[u · scale, x]`; a column's: `[y, v · scale]`
///
/// A point of disparity D moves by −D pixels from one view to the next ([`crate::field`]), which is its line's slope.
/// Lines outside the light field are brought to its edge.
pub fn epi(field: &LightField, line: EpiLine, scale: u32) -> Picture {
    let (grid, [w, h]) = (field.grid(), field.size());
    let scale = scale.max(1);
    match line {
        EpiLine::Row { y, v } => {
            let v = v.min(grid.rows() as u8 - 1);
            Picture::from_fn([w, grid.cols() as u32 * scale], |x, row| {
                tap(field.view(ViewIndex { v, u: (row / scale) as u8 }), x as f32, y as f32)
            })
        }
        EpiLine::Column { x, u } => {
            let u = u.min(grid.cols() as u8 - 1);
            Picture::from_fn([grid.rows() as u32 * scale, h], |column, y| {
                tap(field.view(ViewIndex { v: (column / scale) as u8, u }), x as f32, y as f32)
            })
        }
    }
}
