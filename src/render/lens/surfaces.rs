//! Where one surface ends before another: near and far side of every edge, and how much of a pixel the near one covers.
//!
//! At the size of the disparity map each pixel gets a small model of its surroundings: the disparities and mean colours
//! of the near and of the far side. At photo size the model is read between its cells, and the photo's own colour says
//! how much of the pixel is near. So an edge of the picture follows the photo, not the map, and no pixel is given a
//! depth between the two sides.

use rayon::prelude::*;

use super::light::Light;
use super::sample::{Axis, bilinear};
use crate::field::{DisparityMap, Mix, Raster, Size, between, fit_long_side, nearest, ramp, sides};

/// Longest side of the grid of edge models.
const GRID_SIDE: u32 = 1024;
/// Half the window in which the two sides are looked for, in cells.
const REACH: i32 = 3;
/// An edge is where a plane misses the disparities of the window by this much (pixels per pixel: free of scale).
const NO_EDGE: f32 = 0.012;
const FULL_EDGE: f32 = 0.035;

/// Part of a pixel beside the near side that must have the near side's colour before it counts as covered by it.
const FRINGE: [f32; 2] = [0.05, 0.2];
/// A mixture of both sides' colours lies between them; how far from there, relative and squared, it stops to be one.
const STRAY: [f32; 2] = [0.1, 0.4];

// Numbers of one cell; disparities are the map's.

/// How sure it is that a colour which is not the far side's is the near side's, 0 … 1.
const FOREIGN: usize = 0;
const NEAR: usize = 1;
const FAR: usize = 2;
const EDGE: usize = 3;
/// Disparity averaged over 3×3 cells: how far inside the near side a place is.
const SOFT: usize = 4;
/// How well colour tells the sides apart, 0 … 1.
const TELLING: usize = 5;
/// Colour of the far side, and the direction from it to the near side's, scaled so that near is at 1. In √light.
const FAR_COLOR: usize = 6;
const AXIS: usize = 9;
const LEN: usize = 12;

/// A pixel is a mixture of its two sides where the near one covers more than the first part of it and less than the second.
pub(super) const MIXTURE: [f32; 2] = [0.01, 0.99];

/// The disparity map with the models of its edges.
pub(super) struct Surfaces {
    map: DisparityMap,
    cells: Raster<[f32; LEN]>,
    /// Whether any of a cell's corners is at an edge.
    busy: Raster<bool>,
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
    /// Mean colour of the far side (linear light), and how well it is told from the near side's.
    pub(super) far_rgb: [f32; 3],
    pub(super) foreign: f32,
}

impl Seen {
    /// One surface alone.
    fn whole(disparity_px: f32) -> Self {
        let [near_px, far_px] = [disparity_px; 2];
        Self { near_px, far_px, cover: 1.0, edge: 0.0, far_rgb: [0.0; 3], foreign: 0.0 }
    }

    /// Disparity of the side that covers more of the pixel.
    pub(super) fn disparity_px(&self) -> f32 {
        if self.cover > 0.5 { self.near_px } else { self.far_px }
    }
}

impl Surfaces {
    pub(super) fn new(map: DisparityMap, light: &Light) -> Self {
        let size = fit_long_side(map.size(), GRID_SIDE);
        let grid = nearest(map.disparity_px(), map.size(), size);
        let ratio = map.scale_to(size);
        let small = light.reduced([size[0].min(light.size()[0]), size[1].min(light.size()[1])]);
        let colors = Colors { light: &small, size };
        let soft = soft(&grid, size);
        let maps = [&grid[..], &soft];
        let cells = Raster::par_from_fn(size, |x, y| model(maps, size, [x as i32, y as i32], ratio, &colors));
        let busy = busy(&cells);
        Self { map, cells, busy }
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
        let width = self.cells.sides()[0];
        for y in rows[0]..=rows[1] {
            let cells = &self.cells.pixels()[y * width..][columns[0]..=columns[1]];
            cells.iter().flat_map(|cell| [cell[NEAR], cell[FAR]]).for_each(&mut call);
        }
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
        let disparity = self.disparity(row, i);
        let grid_x = self.grid_x.get(i);
        if !s.busy.at(grid_x.0, row.grid_y.0) {
            return Seen::whole(disparity);
        }
        let cell = bilinear(&s.cells, grid_x, row.grid_y);
        self.at_edge(disparity, &cell, color)
    }

    fn at_edge(&self, disparity: f32, cell: &[f32; LEN], color: &[f32; 3]) -> Seen {
        let (near, far, edge) = (cell[NEAR], cell[FAR], cell[EDGE]);
        let apart = near - far;
        if edge <= 0.0 || apart <= 1e-6 {
            return Seen::whole(disparity);
        }
        let by_map = (disparity - far) / apart;
        let soft = (cell[SOFT] - far) / apart;
        // One pixel of the map is many of the photo: the map's ramp becomes one of two photo pixels.
        let scale = self.size[0] as f32 / self.surfaces.map.size()[0] as f32;
        let steep = 0.5 + (by_map - 0.5) * (scale / 2.0).max(1.0);
        let at: f32 = (0..3).map(|c| (color[c].max(0.0).sqrt() - cell[FAR_COLOR + c]) * cell[AXIS + c]).sum();
        let by_color = 0.5 + 1.6 * (at.clamp(-0.5, 1.5) - 0.5);
        let unsure = ramp(0.02, 0.2, soft.min(1.0 - soft));
        let cover = steep.clamp(0.0, 1.0).mix(by_color.clamp(0.0, 1.0), unsure * cell[TELLING]).clamp(0.0, 1.0);
        // Maps end where most of a pixel does. The fringe beyond, hair and what the lens made soft, has near light too.
        let foreign = edge * cell[FOREIGN];
        let (far_rgb, part) = near_part(cell, color);
        let cover = cover.max(foreign * ramp(FRINGE[0], FRINGE[1], part) * part.min(1.0));
        // Well on one side the map's own value stands; between the sides it would be an invented depth.
        let near = near.mix(disparity, ramp(0.88, 0.99, by_map));
        let far = disparity.mix(far, ramp(0.01, 0.12, by_map));
        Seen { near_px: disparity.mix(near, edge), far_px: disparity.mix(far, edge), cover, edge, far_rgb, foreign }
    }
}

/// Colour of a cell's far side, and the part of the near side's in a colour; linear light, in which colours mix. A
/// colour that is no mixture of the two belongs to the far side.
fn near_part(cell: &[f32; LEN], color: &[f32; 3]) -> ([f32; 3], f32) {
    let (far, axis) = (&cell[FAR_COLOR..FAR_COLOR + 3], &cell[AXIS..AXIS + 3]);
    let scale = axis.iter().map(|a| a * a).sum::<f32>().max(1e-6);
    let far_rgb: [f32; 3] = std::array::from_fn(|c| far[c] * far[c]);
    let apart: [f32; 3] = std::array::from_fn(|c| (far[c] + axis[c] / scale).max(0.0).powi(2) - far_rgb[c]);
    let away: [f32; 3] = std::array::from_fn(|c| color[c] - far_rgb[c]);
    let dot = |a: &[f32; 3], b: &[f32; 3]| (0..3).map(|c| a[c] * b[c]).sum::<f32>();
    let part = dot(&away, &apart) / dot(&apart, &apart).max(1e-9);
    let along2 = (part * part * dot(&apart, &apart)).max(1e-9);
    let beside = (dot(&away, &away) - along2).max(0.0) / along2;
    (far_rgb, part * (1.0 - ramp(STRAY[0], STRAY[1], beside)))
}

/// Colours of the photo at the cells of the grid, as √light, in which noise is even.
struct Colors<'a> {
    light: &'a Light,
    size: Size,
}

impl Colors<'_> {
    fn at(&self, x: usize, y: usize) -> [f32; 3] {
        let [width, height] = self.light.size();
        let px = (x * width as usize + width as usize / 2) / self.size[0] as usize;
        let py = (y * height as usize + height as usize / 2) / self.size[1] as usize;
        self.light.at(px.min(width as usize - 1), py.min(height as usize - 1)).map(f32::sqrt)
    }
}

/// Means of 3×3 cells.
fn soft(grid: &[f32], size: Size) -> Vec<f32> {
    let [width, height] = sides(size);
    let mean = |i: usize| {
        let beside = |at: usize, side: usize| [at.saturating_sub(1), at, (at + 1).min(side - 1)];
        let rows = beside(i / width, height);
        rows.iter().flat_map(|y| beside(i % width, width).map(|x| grid[y * width + x])).sum::<f32>() / 9.0
    };
    (0..grid.len()).into_par_iter().with_min_len(width).map(mean).collect()
}

/// The model of one cell from the window around it.
fn model([grid, soft]: [&[f32]; 2], size: Size, [x, y]: [i32; 2], ratio: f32, colors: &Colors) -> [f32; LEN] {
    let [width, height] = size.map(|s| s as i32);
    let at = |dx: i32, dy: i32| ((y + dy).clamp(0, height - 1) * width + (x + dx).clamp(0, width - 1)) as usize;
    let disparity = grid[at(0, 0)];
    let mut cell = [0.0; LEN];
    [cell[NEAR], cell[FAR]] = [disparity; 2];
    let window = || (-REACH..=REACH).flat_map(|dy| (-REACH..=REACH).map(move |dx| (dx, dy)));
    let [low, high] = window().fold([f32::MAX, f32::MIN], |[low, high], (dx, dy)| {
        let d = grid[at(dx, dy)];
        [low.min(d), high.max(d)]
    });
    cell[SOFT] = soft[at(0, 0)];
    if (high - low) * ratio <= NO_EDGE {
        return cell;
    }
    cell[EDGE] = ramp(NO_EDGE, FULL_EDGE, ratio * off_plane(window().map(|(dx, dy)| (dx, dy, grid[at(dx, dy)]))));
    if cell[EDGE] <= 0.0 {
        return cell;
    }
    let mut sides = [Side::default(); 2];
    for (dx, dy) in window() {
        let i = at(dx, dy);
        let [height, inside] = [grid[i], soft[i]].map(|d| (d - low) / (high - low));
        let color = colors.at(i % width as usize, i / width as usize);
        sides[0].add(grid[i], [height, inside], color);
        sides[1].add(grid[i], [1.0 - height, 1.0 - inside], color);
    }
    cell[NEAR] = sides[0].disparity();
    cell[FAR] = sides[1].disparity();
    let (near, far) = (sides[0].color(), sides[1].color());
    let apart: [f32; 3] = std::array::from_fn(|c| near[c] - far[c]);
    let apart2: f32 = apart.iter().map(|a| a * a).sum();
    cell[FOREIGN] = apart2 / (apart2 + 20.0 * sides[1].spread() + 0.003);
    cell[TELLING] = apart2 / (apart2 + 6.0 * (sides[0].spread() + sides[1].spread()) + 0.003);
    for c in 0..3 {
        cell[FAR_COLOR + c] = far[c];
        cell[AXIS + c] = apart[c] / apart2.max(1e-6);
    }
    cell
}

/// How far the window's values are from the plane that fits them best (root mean square).
fn off_plane(window: impl Iterator<Item = (i32, i32, f32)>) -> f32 {
    let (mut n, mut sum, mut sum2, mut sx, mut sy, mut xx) = (0.0f32, 0.0f32, 0.0f32, 0.0f32, 0.0f32, 0.0f32);
    let mut first = None;
    for (dx, dy, d) in window {
        let d = d - *first.get_or_insert(d);
        n += 1.0;
        sum += d;
        sum2 += d * d;
        sx += d * dx as f32;
        sy += d * dy as f32;
        xx += (dx * dx) as f32;
    }
    ((sum2 - sum * sum / n - sx * sx / xx - sy * sy / xx).max(0.0) / n).sqrt()
}

/// One side of an edge, gathered over a window.
#[derive(Clone, Copy, Default)]
struct Side {
    disparity: [f32; 2],
    weight: f32,
    color: [f32; 3],
    color2: [f32; 3],
}

impl Side {
    /// `height` is 1 at the window's value that is farthest on this side, 0 at the other side's; `inside` the same of
    /// the mean around the cell. Cells beside the edge hardly count for colour, as theirs is of both sides.
    fn add(&mut self, disparity: f32, [height, inside]: [f32; 2], color: [f32; 3]) {
        let weight = height.powi(4);
        self.disparity[0] += disparity * weight;
        self.disparity[1] += weight;
        let weight = ramp(0.6, 0.9, height) * (0.02 + ramp(0.6, 0.9, inside));
        self.weight += weight;
        for (c, value) in color.into_iter().enumerate() {
            self.color[c] += value * weight;
            self.color2[c] += value * value * weight;
        }
    }

    fn disparity(&self) -> f32 {
        self.disparity[0] / self.disparity[1]
    }

    fn color(&self) -> [f32; 3] {
        self.color.map(|c| c / self.weight.max(1e-6))
    }

    fn spread(&self) -> f32 {
        let weight = self.weight.max(1e-6);
        (0..3).map(|c| (self.color2[c] / weight - (self.color[c] / weight).powi(2)).max(0.0)).sum()
    }
}

/// Marks cells one of whose corners is at an edge.
fn busy(cells: &Raster<[f32; LEN]>) -> Raster<bool> {
    let [width, height] = cells.sides();
    let edge = |x: usize, y: usize| cells.at(x.min(width - 1), y.min(height - 1))[EDGE] > 0.0;
    Raster::from_fn(cells.size(), |x, y| edge(x, y) || edge(x + 1, y) || edge(x, y + 1) || edge(x + 1, y + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_of_any_slant_is_no_edge() {
        let window = |f: fn(i32, i32) -> f32| (-3..=3).flat_map(move |y| (-3..=3).map(move |x| (x, y, f(x, y))));
        assert!(off_plane(window(|x, y| 0.3 + 0.05 * x as f32 - 0.02 * y as f32)) < 1e-3);
        assert!(off_plane(window(|x, _| if x < 0 { 0.0 } else { 0.2 })) > FULL_EDGE);
    }
}
