//! Which side of an edge each place is on, at the size of a grid: first by the map, then by the photo's own colours.
//!
//! Maps miss edges by a few pixels, lose what is thin, and have specks. So every cell near a step is judged anew: how
//! well do the colours of the near and of the far side around it explain its own, and what does the map say there?

use rayon::prelude::*;

use super::light::Light;
use crate::field::{Raster, Size, between, ramp, sides};
use crate::job::{Cancel, Cancelled};

/// The window in which the two sides are looked for reaches so many cells from its middle.
const REACH: i32 = 3;
const SIDE: i32 = 2 * REACH + 1;
const WINDOW: usize = (SIDE * SIDE) as usize;
/// What the map says so many cells away counts for a cell, too: an edge may lie beside its place.
const CLOSE: i32 = 2;
/// An edge is where a plane misses the disparities of the window by this much (pixels per pixel: free of scale).
const NO_EDGE: f32 = 0.012;
const FULL_EDGE: f32 = 0.035;

/// Side of the blocks of cells that are looked at or left out.
const BLOCK: usize = 8;
/// No model.
const NONE: u32 = u32::MAX;

/// Times that all cells are judged; each can bring a side a little farther along what is thin.
const ROUNDS: usize = 3;
/// Colours farther apart than this are hardly alike (√light).
const ALIKE: f32 = 0.07;
/// No colour is impossible on a side.
const UNHEARD_OF: f32 = 0.02;
/// What the map says is never quite sure.
const UNSURE: f32 = 0.08;

// Numbers of one cell; disparities are the map's.

/// How sure it is that a colour which is not the far side's is the near side's, 0 … 1.
pub(super) const FOREIGN: usize = 0;
pub(super) const NEAR: usize = 1;
pub(super) const FAR: usize = 2;
pub(super) const EDGE: usize = 3;
/// Disparity averaged over 3×3 samples: how far inside the near side a place is.
pub(super) const SOFT: usize = 4;
/// How well colour tells the sides apart, 0 … 1.
pub(super) const TELLING: usize = 5;
/// Colour of the far side, and the direction from it to the near side's, scaled so that near is at 1. In √light.
pub(super) const FAR_COLOR: usize = 6;
pub(super) const AXIS: usize = 9;
/// How far the far side's colours are from their mean, √light.
pub(super) const SPREAD: usize = 12;
/// Its own disparity, on the side that it was given to.
pub(super) const OWN: usize = 13;
pub(super) const LEN: usize = 14;

/// Model of a cell.
pub(super) type Cell = [f32; LEN];

/// Disparities and colours of a grid.
pub(super) struct Grid {
    depth: Raster<f32>,
    /// √light, in which noise is even.
    colors: Vec<[f32; 3]>,
    /// From the map's disparities to those of the grid's own width.
    ratio: f32,
}

/// Near and far side of a window, and how sure it is that there are two.
#[derive(Clone, Copy)]
struct Two {
    near: f32,
    far: f32,
    edge: f32,
}

impl Two {
    /// How near a disparity is: 0 the far side's … 1.
    fn height(&self, depth: f32) -> f32 {
        ((depth - self.far) / (self.near - self.far)).clamp(0.0, 1.0)
    }
}

impl Grid {
    /// Of a map's values at the places of a grid; `ratio` is what they are multiplied by to be pixels of the grid.
    pub(super) fn new(read: &[f32], size: Size, ratio: f32, light: &Light, cancel: &Cancel) -> Result<Self, Cancelled> {
        let width = size[0] as usize;
        let depth = Raster::from_fn(size, |x, y| read[y * width + x]);
        let small = light.reduced([0, 1].map(|axis| size[axis].min(light.size()[axis])), cancel)?;
        let colors = colors(&small, size);
        Ok(Self { depth, colors, ratio })
    }

    /// Gives every cell near a step to the side that its colour and its place speak for.
    pub(super) fn settled(mut self, cancel: &Cancel) -> Result<Self, Cancelled> {
        let mut open = self.near_step();
        for _ in 0..ROUNDS {
            cancel.check()?;
            let judged = Raster::par_from_fn(self.depth.size(), |x, y| match open.at(x / BLOCK, y / BLOCK) {
                true => self.judged([x as i32, y as i32]),
                false => self.depth.at(x, y),
            });
            // Where nothing has changed, nothing will.
            let changed = self.blocks(false, |at| judged.pixels()[at] != self.depth.pixels()[at], |a, b| a || b);
            open = self.around(&changed, false, |a, b| a || b);
            self.depth = judged;
        }
        Ok(self)
    }

    /// What is said of the cells of each block together.
    fn blocks<T: Copy + Send + Sync>(
        &self,
        none: T,
        of: impl Fn(usize) -> T + Sync,
        join: impl Fn(T, T) -> T + Sync,
    ) -> Raster<T> {
        let [width, height] = self.depth.sides();
        let size = self.depth.size().map(|side| side.div_ceil(BLOCK as u32));
        Raster::par_from_fn(size, |x, y| {
            let columns = x * BLOCK..((x + 1) * BLOCK).min(width);
            let rows = y * BLOCK..((y + 1) * BLOCK).min(height);
            rows.flat_map(|y| columns.clone().map(move |x| y * width + x)).map(&of).fold(none, &join)
        })
    }

    /// The same of each block and all blocks that its cells' windows reach.
    fn around<T: Copy>(&self, blocks: &Raster<T>, none: T, join: impl Fn(T, T) -> T) -> Raster<T> {
        let reach = (REACH as usize + 1).div_ceil(BLOCK);
        let [columns, rows] = blocks.sides();
        Raster::from_fn(blocks.size(), |x, y| {
            let xs = x.saturating_sub(reach)..(x + reach + 1).min(columns);
            let ys = y.saturating_sub(reach)..(y + reach + 1).min(rows);
            ys.flat_map(|y| &blocks.pixels()[y * columns..][xs.clone()]).copied().fold(none, &join)
        })
    }

    /// Blocks of cells in whose windows there may be a step.
    fn near_step(&self) -> Raster<bool> {
        let join = |[low, high]: [f32; 2], [l, h]: [f32; 2]| [low.min(l), high.max(h)];
        let none = [f32::MAX, f32::MIN];
        let own = self.blocks(none, |at| [self.depth.pixels()[at]; 2], join);
        self.around(&own, none, join).map(|[low, high]| (high - low) * self.ratio > NO_EDGE)
    }

    /// Models of all cells.
    pub(super) fn models(self) -> Models {
        let near_step = self.near_step();
        let [width, height] = self.depth.sides();
        let soft = |x: usize, y: usize| match near_step.at(x / BLOCK, y / BLOCK) {
            true => self.soft([x as i32, y as i32]),
            false => self.depth.at(x, y),
        };
        let soft = Raster::par_from_fn(self.depth.size(), soft);
        let of_row = |y: usize| -> Vec<(u32, Cell)> {
            let near_step = (0..width).filter(|x| near_step.at(x / BLOCK, y / BLOCK));
            near_step.filter_map(|x| Some(((y * width + x) as u32, self.model([x as i32, y as i32], &soft)?))).collect()
        };
        let rows: Vec<_> = (0..height).into_par_iter().map(of_row).collect();
        let mut models =
            Models { index: Raster::filled(self.depth.size(), NONE), cells: Vec::new(), depth: self.depth };
        for (at, cell) in rows.into_iter().flatten() {
            models.index.pixels_mut()[at as usize] = models.cells.len() as u32;
            models.cells.push(cell);
        }
        models
    }

    /// Mean disparity of 3×3 samples.
    fn soft(&self, [x, y]: [i32; 2]) -> f32 {
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [dx, dy]));
        let at = |[dx, dy]: [i32; 2]| self.depth.pixels()[self.index([x + dx, y + dy])];
        around.map(at).sum::<f32>() / 9.0
    }

    #[inline]
    fn index(&self, [x, y]: [i32; 2]) -> usize {
        let [width, height] = self.depth.sides();
        y.clamp(0, height as i32 - 1) as usize * width + x.clamp(0, width as i32 - 1) as usize
    }

    /// Numbers of the cells in the window around a place, row by row.
    #[inline]
    fn window(&self, [x, y]: [i32; 2]) -> [u32; WINDOW] {
        let [width, height] = self.depth.size().map(|side| side as i32);
        let at = |x: i32, y: i32| (y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as u32;
        let is_inside = x >= REACH && y >= REACH && x + REACH < width && y + REACH < height;
        let first = (y - REACH) * width + x - REACH;
        std::array::from_fn(|i| match (i as i32 % SIDE, i as i32 / SIDE) {
            (dx, dy) if is_inside => (first + dy * width + dx) as u32,
            (dx, dy) => at(x + dx - REACH, y + dy - REACH),
        })
    }

    /// The two sides of a window, if there is a step in it.
    fn two(&self, depths: &[f32; WINDOW]) -> Option<Two> {
        // Maps are finite: nothing needs to be asked of what is no number.
        let wider = |[low, high]: [f32; 2], d: f32| [if d < low { d } else { low }, if d > high { d } else { high }];
        let [low, high] = depths.iter().fold([f32::MAX, f32::MIN], |ends, d| wider(ends, *d));
        if (high - low) * self.ratio <= NO_EDGE {
            return None;
        }
        let edge = ramp(NO_EDGE, FULL_EDGE, self.ratio * off_plane(depths));
        if edge <= 0.0 {
            return None;
        }
        let [mut near, mut far] = [[0.0; 2]; 2];
        for depth in depths {
            let height = (depth - low) / (high - low);
            for (side, height) in [(&mut near, height), (&mut far, 1.0 - height)] {
                let share = height.powi(4);
                *side = [side[0] + share * depth, side[1] + share];
            }
        }
        Some(Two { near: near[0] / near[1], far: far[0] / far[1], edge })
    }

    /// The disparity of a cell, on the side that it is given to.
    fn judged(&self, place: [i32; 2]) -> f32 {
        let own = self.depth.at(place[0] as usize, place[1] as usize);
        let window = self.window(place);
        let depths = window.map(|at| self.depth.pixels()[at as usize]);
        let Some(two) = self.two(&depths) else { return own };
        let color = self.colors[self.index(place)];
        // [far, near]: how often there is such a colour on the side, and what the map says of places around this one.
        let (mut alike, mut all, mut here) = ([0.0; 2], [1e-6; 2], [0.0; 2]);
        for (i, (at, depth)) in window.iter().zip(depths).enumerate() {
            let height = two.height(depth);
            let shares = [1.0 - height, height];
            let like = like(&color, &self.colors[*at as usize]);
            let is_close = [i as i32 % SIDE, i as i32 / SIDE].iter().all(|at| (at - REACH).abs() <= CLOSE);
            let close = f32::from(u8::from(is_close));
            for side in 0..2 {
                alike[side] += shares[side] * like;
                all[side] += shares[side];
                here[side] += close * shares[side];
            }
        }
        let said = here[1] / (here[0] + here[1]).max(1e-6);
        let prior = UNSURE + (1.0 - 2.0 * UNSURE) * said;
        let heard = [0, 1].map(|side| UNHEARD_OF + alike[side] / all[side]);
        let near = prior * heard[1] / (prior * heard[1] + (1.0 - prior) * heard[0]);
        let before = two.height(own);
        // What stays on its side keeps its own disparity.
        let side = if near > 0.5 { two.near } else { two.far };
        let moved = (near > 0.5) != (before > 0.5);
        if moved { own + (side - own) * two.edge } else { own }
    }

    /// The model of a cell with a step in its window.
    fn model(&self, place: [i32; 2], soft: &Raster<f32>) -> Option<Cell> {
        let window = self.window(place);
        let depths = window.map(|at| self.depth.pixels()[at as usize]);
        let two = self.two(&depths)?;
        let mut cell = [0.0; LEN];
        let own = self.index(place);
        [cell[OWN], cell[SOFT]] = [&self.depth, soft].map(|raster| raster.pixels()[own]);
        [cell[NEAR], cell[FAR], cell[EDGE]] = [two.near, two.far, two.edge];
        let mut sides = [Side::default(); 2];
        for (at, depth) in window.iter().map(|at| *at as usize).zip(depths) {
            let [height, inside] = [depth, soft.pixels()[at]].map(|d| two.height(d));
            let color = self.colors[at];
            sides[0].add([height, inside], color);
            sides[1].add([1.0 - height, 1.0 - inside], color);
        }
        let (near, far) = (sides[0].color(), sides[1].color());
        let apart: [f32; 3] = std::array::from_fn(|c| near[c] - far[c]);
        let apart2: f32 = apart.iter().map(|a| a * a).sum();
        let [near_spread, far_spread] = sides.each_ref().map(Side::spread);
        cell[FOREIGN] = apart2 / (apart2 + 20.0 * far_spread + 0.003);
        cell[SPREAD] = far_spread.sqrt();
        cell[TELLING] = apart2 / (apart2 + 6.0 * (near_spread + far_spread) + 0.003);
        for c in 0..3 {
            cell[FAR_COLOR + c] = far[c];
            cell[AXIS + c] = apart[c] / apart2.max(1e-6);
        }
        Some(cell)
    }
}

/// Models of the cells at edges, and the disparity of all.
pub(super) struct Models {
    /// Each cell's model, or [`NONE`].
    index: Raster<u32>,
    cells: Vec<Cell>,
    depth: Raster<f32>,
}

impl Models {
    /// Width and height of the grid.
    pub(super) fn size(&self) -> Size {
        self.depth.size()
    }

    /// Disparity of a cell, on the side that it was given to.
    pub(super) fn depth(&self) -> &Raster<f32> {
        &self.depth
    }

    /// A cell's model, if it is at an edge.
    #[inline]
    pub(super) fn get(&self, at: usize) -> Option<&Cell> {
        self.cells.get(self.index.pixels()[at] as usize)
    }

    /// Between four cells.
    #[inline]
    pub(super) fn between(&self, (x0, x1, tx): (usize, usize, f32), (y0, y1, ty): (usize, usize, f32)) -> Cell {
        let width = self.depth.sides()[0];
        let places = [y0 * width + x0, y0 * width + x1, y1 * width + x0, y1 * width + x1];
        let models = places.map(|at| self.get(at));
        // Where the models end, their colours go on.
        let known = models.iter().flatten().next();
        let corner = |i: usize| {
            models[i].copied().unwrap_or_else(|| {
                let mut cell = [0.0; LEN];
                [cell[OWN], cell[NEAR], cell[FAR], cell[SOFT]] = [self.depth.pixels()[places[i]]; 4];
                if let Some(known) = known {
                    cell[FAR_COLOR..OWN].copy_from_slice(&known[FAR_COLOR..OWN]);
                }
                cell
            })
        };
        between(std::array::from_fn(corner), [tx, ty])
    }
}

/// How alike two colours are, 0 … 1.
#[inline]
fn like(a: &[f32; 3], b: &[f32; 3]) -> f32 {
    let apart2: f32 = (0..3).map(|c| (a[c] - b[c]).powi(2)).sum();
    (1.0 / (1.0 + apart2 / (ALIKE * ALIKE))).powi(2)
}

/// Colours of the photo at the cells of a grid.
fn colors(light: &Light, size: Size) -> Vec<[f32; 3]> {
    let ([width, height], [columns, rows]) = (sides(light.size()), sides(size));
    let color = |i: usize| {
        let (x, y) = (i % columns, i / columns);
        let px = (x * width + width / 2) / columns;
        let py = (y * height + height / 2) / rows;
        light.at(px.min(width - 1), py.min(height - 1)).map(f32::sqrt)
    };
    (0..columns * rows).into_par_iter().with_min_len(columns).map(color).collect()
}

/// How far a window's values are from the plane that fits them best (root mean square).
fn off_plane(depths: &[f32; WINDOW]) -> f32 {
    let (mut sum, mut sum2, mut across, mut down) = (0.0f32, 0.0f32, 0.0f32, 0.0f32);
    for (i, depth) in depths.iter().enumerate() {
        let d = depth - depths[0];
        sum += d;
        sum2 += d * d;
        across += d * (i as i32 % SIDE - REACH) as f32;
        down += d * (i as i32 / SIDE - REACH) as f32;
    }
    // Of the whole window: the sum of the squares of one coordinate.
    let squares = (SIDE * 2 * (1..=REACH).map(|d| d * d).sum::<i32>()) as f32;
    let n = WINDOW as f32;
    ((sum2 - (sum * sum / n + (across * across + down * down) / squares)).max(0.0) / n).sqrt()
}

/// One side of an edge, gathered over a window.
#[derive(Clone, Copy, Default)]
struct Side {
    weight: f32,
    color: [f32; 3],
    color2: [f32; 3],
}

impl Side {
    /// `height` is 1 on this side, 0 on the other; `inside` the same of the mean around the cell. Cells beside the edge
    /// hardly count, as their colour is of both sides.
    fn add(&mut self, [height, inside]: [f32; 2], color: [f32; 3]) {
        let weight = ramp(0.6, 0.9, height) * (0.02 + ramp(0.6, 0.9, inside));
        self.weight += weight;
        for (c, value) in color.into_iter().enumerate() {
            self.color[c] += value * weight;
            self.color2[c] += value * value * weight;
        }
    }

    fn color(&self) -> [f32; 3] {
        self.color.map(|c| c / self.weight.max(1e-6))
    }

    fn spread(&self) -> f32 {
        let weight = self.weight.max(1e-6);
        (0..3).map(|c| (self.color2[c] / weight - (self.color[c] / weight).powi(2)).max(0.0)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_of_any_slant_is_no_edge() {
        let window = |f: fn(f32, f32) -> f32| {
            std::array::from_fn(|i| f((i as i32 % SIDE - REACH) as f32, (i as i32 / SIDE - REACH) as f32))
        };
        assert!(off_plane(&window(|x, y| 0.3 + 0.05 * x - 0.02 * y)) < 1e-3);
        assert!(off_plane(&window(|x, _| if x < 0.0 { 0.0 } else { 0.2 })) > FULL_EDGE);
    }
}
