//! What goes on behind near edges: the far side continues there, with its own colours and its own depth.
//!
//! A pyramid is built in which a coarse cell holds the farthest surface under it. A place near an edge takes, from fine
//! to coarse, what lies farther than its own surface: so the colours come from the far side only.

use crate::field::morphology::{extremes, square};
use crate::field::{Raster, Size, ramp, sides};

/// Cells from an edge up to which the far side's colours are not trusted: a camera's sharpening and its coarse colour mix
/// them with the near side's.
const MIXED: usize = 2;
/// How far behind an edge the far side is continued, as a part of the long side.
const REACH: f32 = 0.14;
/// How far beside an edge a deeper one counts for it, as a part of the long side: petals lie in steps before the sky, and
/// behind all of them is the sky.
const BESIDE: f32 = 0.006;

/// The far side of no edge.
const NO_EDGE: f32 = f32::MAX;

/// What can be seen: colours and their surfaces.
///
/// # Shapes
/// - `rgb` and `disparity_px`: `[y, x]`; colours of any space whose means make sense
pub struct Front {
    /// Width and height.
    pub size: Size,
    /// Colours.
    pub rgb: Vec<[f32; 3]>,
    /// Disparity, pixels per view step.
    pub disparity_px: Vec<f32>,
}

/// What is behind a place: colour (3) and disparity, both times the share, the share, and the distance.
pub type Hidden = [f32; 6];
/// How much is known of what is behind: 0 nothing … 1.
pub const SHARE: usize = 4;
/// How far inside the near side a place is: cells from the nearest edge.
pub const DISTANCE: usize = 5;

/// Colour and disparity times the weight, and the weight.
pub type Cell = [f32; 5];

/// Behind every place of a picture, `[y, x]`. A surface is behind another when it is farther by `apart_px`; `seen` is
/// what is known of a place from elsewhere, of weight 0 where nothing is.
pub fn behind(front: &Front, apart_px: f32, seen: impl Fn(usize, usize) -> Cell + Sync) -> Raster<Hidden> {
    let nearest = front.nearest();
    let edges = front.edges(&nearest, apart_px);
    let levels = pyramid(front.base(&nearest, apart_px), apart_px);
    let [width, height] = sides(front.size);
    let reach = REACH * width.max(height) as f32;
    Raster::par_from_fn(front.size, |x, y| {
        let i = y * width + x;
        let Edge { distance, far } = edges[i];
        let mut hidden = [0.0; 6];
        hidden[DISTANCE] = distance;
        if distance < reach {
            let farther = apart_px.max(0.5 * (nearest[i] - far));
            hidden[..DISTANCE].copy_from_slice(&fill(&levels, [x, y], [nearest[i], farther], seen(x, y)));
        }
        hidden
    })
}

/// The closest of a place's neighbours that is nearer than the place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beside {
    /// Its disparity.
    pub disparity_px: f32,
    /// Where it lies from the place.
    offset: [i8; 2],
}

impl Beside {
    /// Of a place of a map `[y, x]`, if one is nearer by `apart_px`.
    pub fn of(map_px: &[f32], size: [usize; 2], i: usize, apart_px: f32) -> Option<Self> {
        let place = |i: usize| [i % size[0], i / size[0]].map(|at| at as i32);
        let offset = |j: usize| [0, 1].map(|axis| (place(j)[axis] - place(i)[axis]) as i8);
        let steps = |j: usize| offset(j).map(i8::unsigned_abs).into_iter().max();
        let nearer = square(size, i, MIXED).filter(|&j| map_px[j] > map_px[i] + apart_px);
        nearer.min_by_key(|&j| steps(j)).map(|j| Self { disparity_px: map_px[j], offset: offset(j) })
    }

    /// A pixel beside a nearer one has some of its colour. It is seen for what it is, 0 … 1, once a viewpoint brings more
    /// pixels between the two. `shift`: pixels by which a disparity of 1 is displaced there; `own_px`: the pixel's own.
    pub fn bare(&self, own_px: f32, shift: [f32; 2]) -> f32 {
        let apart = self.disparity_px - own_px;
        let farthest = |[x, y]: [f32; 2]| x.abs().max(y.abs());
        let offset = self.offset.map(f32::from);
        let seen = farthest([0, 1].map(|axis| offset[axis] - shift[axis] * apart));
        ramp(0.0, 1.0, seen - farthest(offset))
    }
}

/// The edge that is nearest to a cell.
#[derive(Clone, Copy)]
struct Edge {
    /// How far away it is, in cells.
    distance: f32,
    /// Disparity of the farthest side beside it: what is behind a cell is there, not on a slope of the near side.
    far: f32,
}

impl Front {
    /// Per cell: the disparity of the nearest surface that may have its colours in it.
    fn nearest(&self) -> Vec<f32> {
        extremes(&self.disparity_px, sides(self.size), MIXED, f32::max)
    }

    /// Per cell: the nearest edge. Distance runs inward only: over the near side, and across the far one no farther than
    /// colours are mixed.
    fn edges(&self, nearest: &[f32], behind: f32) -> Vec<Edge> {
        let [width, height] = sides(self.size);
        let farthest = extremes(&self.disparity_px, [width, height], 1, f32::min);
        let own_far = |((own, far), nearest): ((&f32, f32), &f32)| {
            let is_edge = *nearest > own + behind || far < own - behind;
            if is_edge { far } else { NO_EDGE }
        };
        let own_fars: Vec<f32> = self.disparity_px.iter().zip(farthest).zip(nearest).map(own_far).collect();
        let beside = (BESIDE * width.max(height) as f32).round() as usize;
        let fars = extremes(&own_fars, [width, height], beside, f32::min);
        let edge = |(own, far)| Edge { distance: if own < NO_EDGE { 0.0 } else { f32::MAX / 4.0 }, far };
        let mut edges: Vec<Edge> = own_fars.into_iter().zip(fars).map(edge).collect();
        let ahead: [(isize, isize, f32); 4] = [(1, 0, 1.0), (0, 1, 1.0), (-1, 1, 1.414), (1, 1, 1.414)];
        for (sign, first) in [(1, 0), (-1, edges.len() - 1)] {
            for k in 0..edges.len() {
                let i = first.abs_diff(k);
                for (dx, dy, step) in ahead {
                    let (x, y) =
                        ((i % width).wrapping_add_signed(sign * dx), (i / width).wrapping_add_signed(sign * dy));
                    let j = y.wrapping_mul(width).wrapping_add(x);
                    let inside = x < width && y < height && self.disparity_px[j] > self.disparity_px[i] - behind;
                    if inside && edges[i].distance + step < edges[j].distance {
                        edges[j] = Edge { distance: edges[i].distance + step, far: edges[i].far };
                    }
                }
            }
        }
        edges
    }

    /// The finest level: all cells but those beside something nearer, whose colours may be mixed with it.
    fn base(&self, nearest: &[f32], behind: f32) -> Raster<Cell> {
        let width = self.size[0] as usize;
        Raster::par_from_fn(self.size, |x, y| {
            let i = y * width + x;
            let [r, g, b] = self.rgb[i];
            if nearest[i] > self.disparity_px[i] + behind { [0.0; 5] } else { [r, g, b, self.disparity_px[i], 1.0] }
        })
    }
}

/// Coarser and coarser levels, each cell the farthest of the surfaces under it.
fn pyramid(base: Raster<Cell>, behind: f32) -> Vec<Raster<Cell>> {
    let mut levels = vec![base];
    while let Some(fine) = levels.last()
        && fine.size().iter().any(|side| *side > 2)
    {
        let size = fine.size().map(|side| side.div_ceil(2));
        // Farther apart, one surface may have more depth.
        let one = behind * (1.0 + levels.len() as f32);
        let coarse = Raster::from_fn(size, |x, y| farthest(fine, x, y, one));
        levels.push(coarse);
    }
    levels
}

fn farthest(fine: &Raster<Cell>, x: usize, y: usize, one: f32) -> Cell {
    let [width, height] = fine.sides();
    let child = |dx: usize, dy: usize| {
        let (cx, cy) = (2 * x + dx, 2 * y + dy);
        (cx < width && cy < height).then(|| fine.at(cx, cy)).filter(|c| c[4] > 0.0)
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
fn fill(levels: &[Raster<Cell>], [x, y]: [usize; 2], [front, behind]: [f32; 2], seen: Cell) -> Cell {
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
            let inside = |axis: usize| (at[axis].max(0) as usize).min(level.sides()[axis] - 1);
            let cell = level.at(inside(0), inside(1));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn behind_petals_in_steps_is_the_sky_and_no_petal() {
        // From x = 400 on a petal before the sky, 4 cells farther inside another one, a little nearer.
        let size = [1000, 40];
        let petals = |x: u32| if x < 404 { 0.3 } else { 0.5 };
        let seen = |x: u32| if x < 400 { ([0.2, 0.3, 0.9], -1.0) } else { ([0.9, 0.6, 0.1], petals(x)) };
        let (rgb, disparity_px) = (0..size[0] * size[1]).map(|i| seen(i % size[0])).unzip();
        let hidden = behind(&Front { size, rgb, disparity_px }, 0.08, |_, _| [0.0; 5]);
        for x in 400..420 {
            let cell = hidden.at(x, 20);
            let [red, depth] = [0, 3].map(|c| cell[c] / cell[SHARE]);
            assert!(cell[SHARE] > 0.9 && red < 0.3 && depth < -0.9, "{x}: red {red}, depth {depth}");
        }
    }
}
