//! Where one surface ends before another: near and far side of every edge, and how much of a pixel the near one covers.
//!
//! At the size of the disparity map each pixel gets a small model of its surroundings: the disparities and mean colours
//! of the near and of the far side. At photo size the model is read between its cells, and the photo's own colour says
//! how much of the pixel is near. So an edge of the picture follows the photo, not the map, and no pixel is given a
//! depth between the two sides.

use super::edges::{AXIS, Cell, EDGE, FAR, FAR_COLOR, FOREIGN, Grid, Models, NEAR, OWN, SOFT, SPREAD, TELLING};
use super::light::Light;
use super::sample::Axis;
use crate::field::{DisparityMap, Mix, Raster, Size, between, fit_long_side, nearest, ramp};
use crate::job::{Cancel, Cancelled};

/// Longest side of the grid of edge models.
const GRID_SIDE: u32 = 1024;

/// Part of a pixel beside the near side that must have the near side's colour before it counts as covered by it.
const FRINGE: [f32; 2] = [0.05, 0.2];
/// A mixture of both sides' colours lies between them; how far from there, relative and squared, it stops to be one.
const STRAY: [f32; 2] = [0.1, 0.4];
/// How strange a colour is that is stained, and one that is nothing else.
const STAIN: [f32; 2] = [0.04, 0.12];

/// A pixel is a mixture of its two sides where the near one covers more than the first part of it and less than the second.
pub(super) const MIXTURE: [f32; 2] = [0.01, 0.99];

/// The disparity map with the models of its edges.
pub(super) struct Surfaces {
    map: DisparityMap,
    cells: Models,
    /// What any of a cell's corners needs.
    care: Raster<Care>,
}

/// Whence the pixels of a cell have their disparity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Care {
    /// From the map.
    None,
    /// From the cells: they were given to another side than the map's.
    Moved,
    /// From the models of edges.
    Edge,
}

/// What a pixel sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Disparity of the near side, or of the only one.
    pub(super) near_px: f32,
    /// Disparity of the far side.
    pub(super) far_px: f32,
    /// How much of the pixel the near side covers; 1 where there is only one.
    pub(super) cover: f32,
    /// Whether there are two sides, 0 … 1.
    pub(super) edge: f32,
    /// Mean colours of the sides (linear light), and how well the far side's is told from the near one's.
    pub(super) near_rgb: [f32; 3],
    pub(super) far_rgb: [f32; 3],
    pub(super) foreign: f32,
    /// How far its colour is another than the far side's, 0 … 1: a camera's sharpening and its coarse colour put some of the
    /// near side into the far one.
    pub(super) stained: f32,
}

impl Seen {
    /// One surface alone.
    fn whole(disparity_px: f32) -> Self {
        let [near_px, far_px] = [disparity_px; 2];
        Self {
            near_px,
            far_px,
            cover: 1.0,
            edge: 0.0,
            near_rgb: [0.0; 3],
            far_rgb: [0.0; 3],
            foreign: 0.0,
            stained: 0.0,
        }
    }

    /// Disparity of the side that covers more of the pixel.
    pub(super) fn disparity_px(&self) -> f32 {
        if self.cover > 0.5 { self.near_px } else { self.far_px }
    }
}

impl Surfaces {
    pub(super) fn new(map: DisparityMap, light: &Light, cancel: &Cancel) -> Result<Self, Cancelled> {
        let size = fit_long_side(map.size(), GRID_SIDE);
        let read = nearest(map.disparity_px(), map.size(), size);
        let cells = Grid::new(&read, size, map.scale_to(size), light, cancel)?.settled(cancel)?.models();
        let care = care(&cells, &read);
        Ok(Self { map, cells, care })
    }

    pub(super) fn map_size(&self) -> [u32; 2] {
        self.map.size()
    }

    pub(super) fn range_px(&self) -> [f32; 2] {
        self.map.range_px()
    }

    /// Width and height of the grid of edge models.
    pub(super) fn cells_size(&self) -> Size {
        self.cells.size()
    }

    /// Calls for all disparities in columns and rows, from the first to the last: those of the map, and of the edges' grid.
    pub(super) fn each_disparity(&self, parts: [[[usize; 2]; 2]; 2], mut call: impl FnMut(f32)) {
        let [columns, rows] = parts[0];
        let width = self.map.size()[0] as usize;
        for y in rows[0]..=rows[1] {
            self.map.disparity_px()[y * width..][columns[0]..=columns[1]].iter().for_each(|px| call(*px));
        }
        let [columns, rows] = parts[1];
        let width = self.cells.size()[0] as usize;
        for at in (rows[0]..=rows[1]).flat_map(|y| (columns[0]..=columns[1]).map(move |x| y * width + x)) {
            call(self.cells.depth().pixels()[at]);
            self.cells.get(at).into_iter().flat_map(|cell| [cell[NEAR], cell[FAR]]).for_each(&mut call);
        }
    }

    /// Whether all cells in columns and rows, from the first to the last, are as the map has them.
    pub(super) fn are_plain(&self, [columns, rows]: [[usize; 2]; 2]) -> bool {
        let width = self.care.sides()[0];
        let row = |y: usize| &self.care.pixels()[y * width..][columns[0]..=columns[1]];
        (rows[0]..=rows[1]).all(|y| row(y).iter().all(|care| *care == Care::None))
    }

    /// Reads rows of pixels of a picture of `size`, from column `x0` on.
    pub(super) fn reader(&self, x0: i32, count: usize, size: Size) -> Reader<'_> {
        let map_x = Axis::new(x0, count, size[0], self.map.size()[0]);
        let grid_x = Axis::new(x0, count, size[0], self.cells.size()[0]);
        Reader { surfaces: self, map_x, grid_x, size }
    }
}

/// See [`Surfaces::reader`].
pub(super) struct Reader<'a> {
    surfaces: &'a Surfaces,
    map_x: Axis,
    grid_x: Axis,
    size: Size,
}

/// A row to be read.
pub(super) struct Row {
    map_y: (usize, usize, f32),
    grid_y: (usize, usize, f32),
}

impl Reader<'_> {
    pub(super) fn at_row(&self, y: i32) -> Row {
        let s = self.surfaces;
        let map_y = Axis::new(y, 1, self.size[1], s.map.size()[1]).get(0);
        Row { map_y, grid_y: Axis::new(y, 1, self.size[1], s.cells.size()[1]).get(0) }
    }

    /// Disparity at the `i`-th pixel of the row, as the map has it.
    #[inline]
    pub(super) fn disparity(&self, row: &Row, i: usize) -> f32 {
        let (x0, x1, tx) = self.map_x.get(i);
        let (y0, y1, ty) = row.map_y;
        let (map, width) = (self.surfaces.map.disparity_px(), self.surfaces.map.size()[0] as usize);
        let corners = [y0 * width + x0, y0 * width + x1, y1 * width + x0, y1 * width + x1];
        between(corners.map(|i| map[i]), [tx, ty])
    }

    /// What the `i`-th pixel of the row sees, with its colour.
    #[inline]
    pub(super) fn seen(&self, row: &Row, i: usize, color: &[f32; 3]) -> Seen {
        let s = self.surfaces;
        let grid_x = self.grid_x.get(i);
        let care = s.care.at(grid_x.0, row.grid_y.0);
        if care == Care::None {
            return Seen::whole(self.disparity(row, i));
        }
        let cell = s.cells.between(grid_x, row.grid_y);
        if care == Care::Moved { Seen::whole(cell[OWN]) } else { self.at_edge(cell[OWN], &cell, color) }
    }

    fn at_edge(&self, disparity: f32, cell: &Cell, color: &[f32; 3]) -> Seen {
        let (near, far, edge) = (cell[NEAR], cell[FAR], cell[EDGE]);
        let apart = near - far;
        if edge <= 0.0 || apart <= 1e-6 {
            return Seen::whole(disparity);
        }
        let by_map = (disparity - far) / apart;
        let soft = (cell[SOFT] - far) / apart;
        // One pixel of the map is many of the photo: the map's ramp becomes one of two photo pixels.
        let scale = self.size[0] as f32 / self.surfaces.cells.size()[0] as f32;
        let steep = 0.5 + (by_map - 0.5) * (scale / 2.0).max(1.0);
        let away: [f32; 3] = std::array::from_fn(|c| color[c].max(0.0).sqrt() - cell[FAR_COLOR + c]);
        let at: f32 = (0..3).map(|c| away[c] * cell[AXIS + c]).sum();
        let by_color = 0.5 + 1.6 * (at.clamp(-0.5, 1.5) - 0.5);
        let unsure = ramp(0.02, 0.2, soft.min(1.0 - soft));
        let cover = steep.clamp(0.0, 1.0).mix(by_color.clamp(0.0, 1.0), unsure * cell[TELLING]).clamp(0.0, 1.0);
        // Maps end where most of a pixel does. The fringe beyond, hair and what the lens made soft, has near light too.
        let foreign = edge * cell[FOREIGN];
        let ([near_rgb, far_rgb], part) = near_part(cell, color);
        let cover = cover.max(foreign * ramp(FRINGE[0], FRINGE[1], part) * part.min(1.0));
        // Well on one side the map's own value stands; between the sides it would be an invented depth, and near them a surface
        // would dip in a line along its edge.
        let near = near.mix(disparity, ramp(0.97, 0.995, by_map));
        let far = disparity.mix(far, ramp(0.005, 0.03, by_map));
        Seen {
            near_px: disparity.mix(near, edge),
            far_px: disparity.mix(far, edge),
            cover,
            edge,
            near_rgb,
            far_rgb,
            foreign,
            stained: foreign * ramp(STAIN[0], STAIN[1], strange(cell, &away)),
        }
    }
}

/// Colours of a cell's near and far side, and the part of the near side's in a colour; linear light, in which colours mix. A
/// colour that is no mixture of the two belongs to the far side.
fn near_part(cell: &Cell, color: &[f32; 3]) -> ([[f32; 3]; 2], f32) {
    let (far, axis) = (&cell[FAR_COLOR..FAR_COLOR + 3], &cell[AXIS..AXIS + 3]);
    let scale = axis.iter().map(|a| a * a).sum::<f32>().max(1e-6);
    let far_rgb: [f32; 3] = std::array::from_fn(|c| far[c] * far[c]);
    let apart: [f32; 3] = std::array::from_fn(|c| (far[c] + axis[c] / scale).max(0.0).powi(2) - far_rgb[c]);
    let away: [f32; 3] = std::array::from_fn(|c| color[c] - far_rgb[c]);
    let dot = |a: &[f32; 3], b: &[f32; 3]| (0..3).map(|c| a[c] * b[c]).sum::<f32>();
    let part = dot(&away, &apart) / dot(&apart, &apart).max(1e-9);
    let along2 = (part * part * dot(&apart, &apart)).max(1e-9);
    let beside = (dot(&away, &away) - along2).max(0.0) / along2;
    let near_rgb = std::array::from_fn(|c| far_rgb[c] + apart[c]);
    ([near_rgb, far_rgb], part * (1.0 - ramp(STRAY[0], STRAY[1], beside)))
}

/// How much farther a colour is `away` from the far side's than those vary, in parts of what the sides differ by.
#[inline]
fn strange(cell: &Cell, away: &[f32; 3]) -> f32 {
    let length = |v: &[f32]| v.iter().map(|a| a * a).sum::<f32>().sqrt();
    (length(away) - cell[SPREAD]) * length(&cell[AXIS..AXIS + 3])
}

/// What each cell needs; `read` is what the map says of them.
fn care(cells: &Models, read: &[f32]) -> Raster<Care> {
    let [width, height] = cells.depth().sides();
    let own = |x: usize, y: usize| {
        let at = y.min(height - 1) * width + x.min(width - 1);
        if cells.get(at).is_some() {
            Care::Edge
        } else if cells.depth().pixels()[at] != read[at] {
            Care::Moved
        } else {
            Care::None
        }
    };
    let of = |x: usize, y: usize| own(x, y).max(own(x + 1, y)).max(own(x, y + 1)).max(own(x + 1, y + 1));
    Raster::par_from_fn(cells.size(), of)
}
