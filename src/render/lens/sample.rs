//! Bilinear reading of a grid at the pixels of another, by the conventions of [`crate::field`]. Each axis is worked out
//! once for a tile: [`Raster::tap`] would do it for each pixel.

use crate::field::{Raster, between};

/// Where the pixels of one axis lie in a grid: the lower neighbour and the share of the upper one.
pub(super) struct Axis {
    at: Vec<(u32, f32)>,
    last: usize,
}

impl Axis {
    /// Pixels `first ..` (`count` of them) of an axis with `pixels` pixels, in a grid with `cells` along it.
    pub(super) fn new(first: i32, count: usize, pixels: u32, cells: u32) -> Self {
        let scale = cells as f32 / pixels as f32;
        let place = |i: usize| {
            let inside = (first + i as i32).clamp(0, pixels as i32 - 1) as f32;
            let at = ((inside + 0.5) * scale - 0.5).clamp(0.0, cells as f32 - 1.0);
            (at as u32, at - at.floor())
        };
        Self { at: (0..count).map(place).collect(), last: cells as usize - 1 }
    }

    /// Lower neighbour, upper neighbour, share of the upper.
    #[inline]
    pub(super) fn get(&self, i: usize) -> (usize, usize, f32) {
        let (low, share) = self.at[i];
        (low as usize, (low as usize + 1).min(self.last), share)
    }
}

/// All numbers of a cell, between four cells of a grid.
#[inline]
pub(super) fn bilinear<const N: usize>(
    grid: &Raster<[f32; N]>,
    (x0, x1, tx): (usize, usize, f32),
    (y0, y1, ty): (usize, usize, f32),
) -> [f32; N] {
    let (cells, width) = (grid.pixels(), grid.sides()[0]);
    let [a, b] = [&cells[y0 * width + x0], &cells[y0 * width + x1]];
    let [c, d] = [&cells[y1 * width + x0], &cells[y1 * width + x1]];
    std::array::from_fn(|i| between([a[i], b[i], c[i], d[i]], [tx, ty]))
}
