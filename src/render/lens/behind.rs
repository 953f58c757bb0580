//! What is behind near edges: the far side goes on behind the near one, with its own colours and its own depth.
//!
//! A pyramid is built in which a coarse cell holds the farthest surface under it. A place near an edge takes, from fine
//! to coarse, what lies farther than its own surface: so the colours come from the far side only. Where other
//! views of a recorded light field have seen behind the edge, theirs come first.

use rayon::prelude::*;

use super::light::Light;
use super::sample::{Axis, bilinear, ramp};
use super::surfaces::Surfaces;
use crate::field::fit_long_side;

/// Longest side of the grid on which what is behind is made up.
const GRID_SIDE: u32 = 1024;
/// A surface is behind another when it is farther by this much, in cells per view step.
const BEHIND_PX: f32 = 0.08;
/// Cells from an edge up to which the far side's colours are not trusted: a camera's sharpening and its coarse colour mix
/// them with the near side's.
const MIXED: usize = 2;
/// How far behind an edge the far side is continued, as a part of the grid's long side.
const REACH: f32 = 0.14;
/// Numbers of one cell: light (3), disparity, all times the share, and the share itself; distance from the edge.
const SHARE: usize = 4;
const DISTANCE: usize = 5;
const LEN: usize = 6;

/// Colours that other views have seen behind the reference view's edges.
///
/// # Shapes
/// - `cells`: `[y, x]` of red, green, blue (linear light), disparity, and how sure it is (0: not seen)
#[derive(Clone, Debug)]
pub struct Revealed {
    /// Width and height.
    pub size: [u32; 2],
    /// The cells.
    pub cells: Vec<[f32; 5]>,
}

/// The far side behind near edges.
pub(super) struct Behind {
    size: [u32; 2],
    cells: Vec<[f32; LEN]>,
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

/// A cell of the pyramid: light, disparity (both times the weight) and weight.
type Cell = [f32; 5];

struct Level {
    size: [usize; 2],
    cells: Vec<Cell>,
}

impl Behind {
    /// Behind all edges of a picture of `light`'s size. `scale`: the light's pixels per pixel of the map.
    pub(super) fn new(surfaces: &Surfaces, light: &Light, revealed: Option<&Revealed>) -> Self {
        let size = fit_long_side(light.size(), GRID_SIDE);
        let front = Front::new(surfaces, &light.reduced(size));
        let behind = BEHIND_PX * surfaces.map_size()[0] as f32 / size[0] as f32;
        let edges = front.edges(behind);
        let levels = pyramid(front.base(behind), behind);
        let reach = REACH * size[0].max(size[1]) as f32;
        let mut cells = vec![[0.0; LEN]; front.depth.len()];
        let width = size[0] as usize;
        cells.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for (x, cell) in row.iter_mut().enumerate() {
                let i = y * width + x;
                cell[DISTANCE] = edges[i].distance;
                if edges[i].distance < reach {
                    let own = front.nearest_around(x, y);
                    let farther = behind.max(0.5 * (own - edges[i].far));
                    let hidden = fill(&levels, [x, y], [own, farther], seen(revealed, size, x, y));
                    cell[..5].copy_from_slice(&hidden);
                }
            }
        });
        let is_empty = cells.iter().all(|cell| cell[SHARE] <= 0.0);
        Self { size, cells, is_empty }
    }

    /// Reads rows of a picture of `size` from column `x0` on.
    pub(super) fn reader(&self, x0: i32, count: usize, size: [u32; 2]) -> Reader<'_> {
        Reader { behind: self, x: Axis::new(x0, count, size[0], self.size[0]), size }
    }
}

/// See [`Behind::reader`].
pub(super) struct Reader<'a> {
    behind: &'a Behind,
    x: Axis,
    size: [u32; 2],
}

impl Reader<'_> {
    pub(super) fn at_row(&self, y: i32) -> (usize, usize, f32) {
        Axis::new(y, 1, self.size[1], self.behind.size[1]).get(0)
    }

    /// What is behind the `i`-th pixel of a row, if anything is known.
    #[inline]
    pub(super) fn hidden(&self, row: (usize, usize, f32), i: usize) -> Option<Hidden> {
        let (x0, x1, tx) = self.x.get(i);
        let width = self.behind.size[0] as usize;
        let nearest = &self.behind.cells[row.0 * width + x0];
        if self.behind.is_empty || (nearest[SHARE] <= 0.0 && nearest[DISTANCE] > 4.0) {
            return None;
        }
        let cell = bilinear(&self.behind.cells, width, (x0, x1, tx), row);
        let share = cell[SHARE];
        (share > 0.02).then(|| Hidden {
            rgb: [cell[0] / share, cell[1] / share, cell[2] / share],
            disparity_px: cell[3] / share,
            share: share.min(1.0),
            distance_px: (cell[DISTANCE] - 1.0) * self.size[0] as f32 / self.behind.size[0] as f32,
        })
    }
}

/// The edge that is nearest to a cell.
#[derive(Clone, Copy)]
struct Edge {
    /// How far away it is, in cells.
    distance: f32,
    /// Disparity of its far side: what is behind a cell is there, not on a slope of the near side.
    far: f32,
}

/// The visible surfaces at the grid's size.
struct Front {
    size: [usize; 2],
    rgb: Vec<[f32; 3]>,
    depth: Vec<f32>,
}

impl Front {
    fn new(surfaces: &Surfaces, light: &Light) -> Self {
        let [width, height] = light.size().map(|s| s as usize);
        let reader = surfaces.reader(0, width, light.size());
        let rows: Vec<(Vec<[f32; 3]>, Vec<f32>)> = (0..height)
            .into_par_iter()
            .map(|y| {
                let mut rgb = vec![[0.0; 3]; width];
                light.row(0, y as i32, &mut rgb);
                let row = reader.at_row(y as i32);
                let depth = |(i, color)| {
                    let seen = reader.seen(&row, i, color);
                    if seen.cover > 0.5 { seen.near_px } else { seen.far_px }
                };
                let depths = rgb.iter().enumerate().map(depth).collect();
                (rgb, depths)
            })
            .collect();
        let (rgb, depth): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
        Self { size: [width, height], rgb: rgb.concat(), depth: depth.concat() }
    }

    /// The cells up to `reach` from one.
    fn around(&self, x: usize, y: usize, reach: usize) -> impl Iterator<Item = usize> {
        let [width, height] = self.size;
        let xs = x.saturating_sub(reach)..(x + reach + 1).min(width);
        (y.saturating_sub(reach)..(y + reach + 1).min(height)).flat_map(move |y| xs.clone().map(move |x| y * width + x))
    }

    fn nearest_around(&self, x: usize, y: usize) -> f32 {
        self.around(x, y, 1).map(|i| self.depth[i]).fold(f32::MIN, f32::max)
    }

    /// Per cell: the nearest edge. Distance runs inward only: over the near side, never across the far one.
    fn edges(&self, behind: f32) -> Vec<Edge> {
        let [width, height] = self.size;
        let own_edge = |i: usize| {
            let own = self.depth[i];
            let widen = |[lo, hi]: [f32; 2], j: usize| [lo.min(self.depth[j]), hi.max(self.depth[j])];
            let [far, near] = self.around(i % width, i / width, 1).fold([own; 2], widen);
            let is_edge = near > own + behind || far < own - behind;
            Edge { distance: if is_edge { 0.0 } else { f32::MAX / 4.0 }, far }
        };
        let mut edges: Vec<Edge> = (0..self.depth.len()).into_par_iter().map(own_edge).collect();
        let ahead: [(isize, isize, f32); 4] = [(1, 0, 1.0), (0, 1, 1.0), (-1, 1, 1.414), (1, 1, 1.414)];
        for (sign, first) in [(1, 0), (-1, edges.len() - 1)] {
            for k in 0..edges.len() {
                let i = first.abs_diff(k);
                for (dx, dy, step) in ahead {
                    let (x, y) =
                        ((i % width).wrapping_add_signed(sign * dx), (i / width).wrapping_add_signed(sign * dy));
                    let j = y.wrapping_mul(width).wrapping_add(x);
                    let inside = x < width && y < height && self.depth[j] > self.depth[i] - behind;
                    if inside && edges[i].distance + step < edges[j].distance {
                        edges[j] = Edge { distance: edges[i].distance + step, far: edges[i].far };
                    }
                }
            }
        }
        edges
    }

    /// The finest level: all cells but those beside something nearer, whose colours may be mixed with it.
    fn base(&self, behind: f32) -> Level {
        let width = self.size[0];
        let cell = |i: usize| {
            let nearest = self.around(i % width, i / width, MIXED).map(|j| self.depth[j]).fold(f32::MIN, f32::max);
            let [r, g, b] = self.rgb[i];
            if nearest > self.depth[i] + behind { [0.0; 5] } else { [r, g, b, self.depth[i], 1.0] }
        };
        Level { size: self.size, cells: (0..self.depth.len()).into_par_iter().map(cell).collect() }
    }
}

/// Coarser and coarser levels, each cell the farthest of the surfaces under it.
fn pyramid(base: Level, behind: f32) -> Vec<Level> {
    let mut levels = vec![base];
    while let Some(fine) = levels.last()
        && fine.size[0].max(fine.size[1]) > 2
    {
        let size = fine.size.map(|s| s.div_ceil(2));
        // Farther apart, one surface may have more depth.
        let one = behind * (1.0 + levels.len() as f32);
        let mut cells = Vec::with_capacity(size[0] * size[1]);
        for y in 0..size[1] {
            for x in 0..size[0] {
                cells.push(farthest(fine, x, y, one));
            }
        }
        levels.push(Level { size, cells });
    }
    levels
}

fn farthest(fine: &Level, x: usize, y: usize, one: f32) -> Cell {
    let child = |dx: usize, dy: usize| {
        let (cx, cy) = (2 * x + dx, 2 * y + dy);
        (cx < fine.size[0] && cy < fine.size[1]).then(|| fine.cells[cy * fine.size[0] + cx]).filter(|c| c[4] > 0.0)
    };
    let children = [child(0, 0), child(1, 0), child(0, 1), child(1, 1)];
    let depth = |c: &Cell| c[3] / c[4];
    let least = children.iter().flatten().map(depth).fold(f32::MAX, f32::min);
    let mut sum = [0.0; 5];
    for cell in children.iter().flatten().filter(|c| depth(c) < least + one) {
        sum.iter_mut().zip(cell).for_each(|(s, v)| *s += v);
    }
    // A weight is a matter of yes or no as soon as one fine cell is known.
    if sum[4] > 1.0 {
        let weight = sum[4];
        sum.iter_mut().for_each(|s| *s /= weight);
    }
    sum
}

/// What is behind a cell whose surface has the disparity `front`, and farther by about `behind` at least; times its share.
fn fill(levels: &[Level], [x, y]: [usize; 2], [front, behind]: [f32; 2], seen: Cell) -> Cell {
    let mut sum = [0.0; 5];
    let mut add = |cell: Cell| {
        let cover = cell[4].min(1.0);
        if cover > 0.0 {
            let part = (1.0 - sum[4]) * cover / cell[4];
            sum.iter_mut().zip(cell).for_each(|(s, v)| *s += part * v);
        }
        sum[4] > 0.98
    };
    if seen[4] > 0.0 && seen[3] / seen[4] < front - behind && add(seen) {
        return sum;
    }
    for (n, level) in levels.iter().enumerate() {
        let scale = 1.0 / (1u32 << n) as f32;
        let place = [(x as f32 + 0.5) * scale - 0.5, (y as f32 + 0.5) * scale - 0.5];
        let corner = place.map(|p| p.floor());
        let mut found = [0.0; 5];
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let at = [corner[0] as i32 + dx, corner[1] as i32 + dy];
            let inside = |axis: usize| (at[axis].max(0) as usize).min(level.size[axis] - 1);
            let cell = &level.cells[inside(1) * level.size[0] + inside(0)];
            if cell[4] <= 0.0 {
                continue;
            }
            let share = (1.0 - (place[0] - at[0] as f32).abs()) * (1.0 - (place[1] - at[1] as f32).abs());
            let farther = ramp(0.5 * behind, 1.5 * behind, front - cell[3] / cell[4]);
            found.iter_mut().zip(cell).for_each(|(f, v)| *f += share * farther * v);
        }
        if add(found) {
            break;
        }
    }
    sum
}

fn seen(revealed: Option<&Revealed>, size: [u32; 2], x: usize, y: usize) -> Cell {
    let Some(revealed) = revealed else { return [0.0; 5] };
    let x = Axis::new(x as i32, 1, size[0], revealed.size[0]).get(0);
    let y = Axis::new(y as i32, 1, size[1], revealed.size[1]).get(0);
    bilinear(&revealed.cells, revealed.size[0] as usize, x, y)
}
