//! What is behind near edges, for the lens: the far side goes on behind the near one ([`background`]). Where other views of
//! a recorded light field have seen behind the edge, theirs come first.

use rayon::prelude::*;

use super::light::Light;
use super::sample::{Axis, bilinear};
use super::surfaces::Surfaces;
use crate::background::{self, Cell, DISTANCE, Front, SHARE};
use crate::field::{Raster, Size, fit_long_side, sides};
use crate::job::{Cancel, Cancelled};

/// Longest side of the grid on which what is behind is made up.
const GRID_SIDE: u32 = 1024;
/// A surface is behind another when it is farther by this much, in cells per view step.
const BEHIND_PX: f32 = 0.08;

/// Colours that other views have seen behind the reference view's edges: red, green, blue (linear light), disparity, and
/// how sure it is (0: not seen).
pub type Revealed = Raster<Cell>;

/// The far side behind near edges.
pub(super) struct Behind {
    cells: Raster<background::Hidden>,
    is_empty: bool,
}

/// What is behind one pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hidden {
    pub(super) rgb: [f32; 3],
    pub(super) disparity_px: f32,
    /// 0 nothing known … 1.
    pub(super) share: f32,
    /// Pixels from the edge.
    pub(super) distance_px: f32,
}

impl Behind {
    /// Behind all edges of a picture of `light`'s size. `scale`: the light's pixels per pixel of the map.
    pub(super) fn new(
        surfaces: &Surfaces,
        light: &Light,
        revealed: Option<&Revealed>,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let size = fit_long_side(light.size(), GRID_SIDE);
        let front = front(surfaces, &light.reduced(size, cancel)?);
        cancel.check()?;
        let apart_px = BEHIND_PX * surfaces.map_size()[0] as f32 / size[0] as f32;
        let cells = background::behind(&front, apart_px, |x, y| seen(revealed, size, x, y));
        let is_empty = cells.pixels().iter().all(|cell| cell[SHARE] <= 0.0);
        Ok(Self { cells, is_empty })
    }

    /// All cells.
    pub(super) fn raster(&self) -> &Raster<background::Hidden> {
        &self.cells
    }

    /// Width and height of its grid.
    pub(super) fn size(&self) -> Size {
        self.cells.size()
    }

    /// Calls for all disparities in columns and rows of its grid, from the first to the last.
    pub(super) fn each_disparity(&self, [columns, rows]: [[usize; 2]; 2], mut call: impl FnMut(f32)) {
        let width = self.cells.sides()[0];
        for y in rows[0]..=rows[1] {
            let cells = &self.cells.pixels()[y * width..][columns[0]..=columns[1]];
            cells.iter().filter(|cell| cell[SHARE] > 0.0).for_each(|cell| call(cell[3] / cell[SHARE]));
        }
    }

    /// Whether nothing is known to be behind any of the cells in columns and rows, from the first to the last.
    pub(super) fn is_nothing(&self, [columns, rows]: [[usize; 2]; 2]) -> bool {
        let width = self.cells.sides()[0];
        let row = |y: usize| &self.cells.pixels()[y * width..][columns[0]..=columns[1]];
        self.is_empty || (rows[0]..=rows[1]).all(|y| row(y).iter().all(is_nothing))
    }

    /// Reads rows of a picture of `size` from column `x0` on.
    pub(super) fn reader(&self, x0: i32, count: usize, size: Size) -> Reader<'_> {
        Reader { behind: self, x: Axis::new(x0, count, size[0], self.cells.size()[0]), size }
    }
}

/// See [`Behind::reader`].
pub(super) struct Reader<'a> {
    behind: &'a Behind,
    x: Axis,
    size: Size,
}

impl Reader<'_> {
    pub(super) fn at_row(&self, y: i32) -> (usize, usize, f32) {
        Axis::new(y, 1, self.size[1], self.behind.cells.size()[1]).get(0)
    }

    /// What is behind the `i`-th pixel of a row, if anything is known.
    #[inline]
    pub(super) fn hidden(&self, row: (usize, usize, f32), i: usize) -> Option<Hidden> {
        let (x0, x1, tx) = self.x.get(i);
        if self.behind.is_empty || is_nothing(&self.behind.cells.at(x0, row.0)) {
            return None;
        }
        let cell = bilinear(&self.behind.cells, (x0, x1, tx), row);
        let share = cell[SHARE];
        (share > 0.02).then(|| Hidden {
            rgb: [cell[0] / share, cell[1] / share, cell[2] / share],
            disparity_px: cell[3] / share,
            share: share.min(1.0),
            distance_px: (cell[DISTANCE] - 1.0) * self.size[0] as f32 / self.behind.cells.size()[0] as f32,
        })
    }
}

/// Whether nothing is known to be behind a cell, and it is not beside one of which something is.
#[inline]
fn is_nothing(cell: &background::Hidden) -> bool {
    cell[SHARE] <= 0.0 && cell[DISTANCE] > 4.0
}

/// The visible surfaces at the light's size.
fn front(surfaces: &Surfaces, light: &Light) -> Front {
    let [width, height] = sides(light.size());
    let reader = surfaces.reader(0, width, light.size());
    let rows: Vec<(Vec<[f32; 3]>, Vec<f32>)> = (0..height)
        .into_par_iter()
        .map(|y| {
            let mut rgb = vec![[0.0; 3]; width];
            light.row(0, y as i32, &mut rgb);
            let row = reader.at_row(y as i32);
            let depth = |(i, color)| reader.seen(&row, i, color).disparity_px();
            let depths = rgb.iter().enumerate().map(depth).collect();
            (rgb, depths)
        })
        .collect();
    let (rgb, depth): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
    Front { size: light.size(), rgb: rgb.concat(), disparity_px: depth.concat() }
}

fn seen(revealed: Option<&Revealed>, size: Size, x: usize, y: usize) -> Cell {
    let Some(revealed) = revealed else { return [0.0; 5] };
    let x = Axis::new(x as i32, 1, size[0], revealed.size()[0]).get(0);
    let y = Axis::new(y as i32, 1, size[1], revealed.size()[1]).get(0);
    bilinear(revealed, x, y)
}
