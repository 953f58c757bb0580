//! Ray depths of a light field that came without: plane sweep over its views.
//!
//! For each disparity the views are shifted onto the reference view; where they agree, a surface is there. How badly
//! they agree is smoothed over the reference view's even regions before the best disparity is chosen (cost-volume
//! filtering, Rhemann et al. 2011). A small sweep finds the range, a larger one the map.

use glam::{Vec3, Vec4Swizzles};
use rayon::prelude::*;

use super::picture::Signed;
use super::upsample::{self, EdgeAware};
use super::{SynthError, lift};
use crate::field::{
    DisparityMap, Filter, LightField, RayDepths, Size, ViewIndex, ViewOffset, disparity_scale, fit_long_side, sides,
};
use crate::job::{Cancel, Cancelled, Job, Stage};

/// Long side of the sweep that finds the range.
const COARSE_LONG_SIDE: u32 = 160;
/// Disparities that are looked for: ± this share of the width per step (± 8 px at 540).
const WIDEST_SHARE: f32 = 8.0 / 540.0;
/// Long side of the sweep that finds the map.
const FINE_LONG_SIDE: u32 = 540;
/// Shift of the outermost view between two planes, in px.
const PLANE_STEP_PX: f32 = 0.5;
/// Half the side of the window over which agreement is averaged.
const WINDOW: usize = 2;
/// How far agreement flows over even colour, as a share of the long side.
const REACH_SHARE: f32 = 0.025;
/// Least brightness (0 … 2) that a view is brightened from.
const DARKEST: f32 = 0.01;
/// Difference of colour (mean, 0 … 1) between the worst and the best plane from which a disparity counts as found.
const TELLING: f32 = 0.002;
/// What a plane costs more for each pixel of disparity: where nothing tells, 0 is taken.
const COST_PER_PX: f32 = 1e-4;

/// The disparity of every ray of a light field, measured from its views.
///
/// # Errors
/// Cancelled; a map that is none.
pub fn ray_depths(field: &LightField, job: &Job) -> Result<RayDepths, SynthError> {
    Ok(lift::lifted(&reference_map(field, job)?, field.grid(), job)?)
}

/// The disparity of the reference view.
///
/// # Errors
/// Cancelled; a map that is none.
pub fn reference_map(field: &LightField, job: &Job) -> Result<DisparityMap, SynthError> {
    let full = field.size();
    let coarse = Sweep::new(field, fit_long_side(full, COARSE_LONG_SIDE));
    let [w, h] = coarse.reference.size();
    let widest = WIDEST_SHARE * w.max(h) as f32;
    let found = coarse.run([-widest, widest], job)?;
    let fine = Sweep::new(field, fit_long_side(full, FINE_LONG_SIDE));
    let ratio = disparity_scale([w, h], fine.reference.size());
    let margin = 2.0 * coarse.step();
    let [lo, hi] = found.range();
    let found = fine.run([(lo - margin) * ratio, (hi + margin) * ratio], job)?;
    let map = DisparityMap::new(fine.reference.size(), found.disparity_px)?;
    Ok(if map.size() == full { map } else { upsample::to_guide(&map, field.reference(), job)? })
}

/// Some views of a light field at one size, with the reference view.
struct Sweep {
    reference: Signed,
    others: Vec<(ViewOffset, Signed)>,
    edges: EdgeAware,
}

/// For each pixel the disparity at which the views agree best, and whether they agree less elsewhere.
struct Found {
    disparity_px: Vec<f32>,
    certain: Vec<bool>,
}

/// Four of `n` rows or columns, the outermost among them.
fn some_of(n: usize) -> Vec<usize> {
    let mut some = vec![0, n / 3, n - 1 - n / 3, n - 1];
    some.sort_unstable();
    some.dedup();
    some
}

impl Sweep {
    fn new(field: &LightField, size: Size) -> Self {
        let grid = field.grid();
        let columns = some_of(grid.cols());
        let chosen = some_of(grid.rows()).into_iter().flat_map(|v| columns.iter().map(move |u| v * grid.cols() + u));
        let chosen: Vec<_> =
            chosen.map(|layer| grid.view_from_layer(layer)).filter(|at| *at != grid.reference()).collect();
        let reference = Signed::resized(field.reference(), size, Filter::Lanczos3);
        let view = |at: &ViewIndex| balanced(Signed::resized(field.view(*at), size, Filter::Lanczos3), &reference);
        let others = chosen.par_iter().map(|at| (grid.offset(*at), view(at))).collect();
        let difference = |a: usize, b: usize| (reference.pixels()[a] - reference.pixels()[b]).abs().element_sum() / 6.0;
        let edges = EdgeAware::new(sides(size), REACH_SHARE * size[0].max(size[1]) as f32, difference);
        Self { reference, others, edges }
    }

    /// Disparity between two planes.
    fn step(&self) -> f32 {
        let reach = self.others.iter().map(|(o, _)| o.du.abs().max(o.dv.abs())).fold(1.0, f32::max);
        PLANE_STEP_PX / reach
    }

    fn run(&self, [lo, hi]: [f32; 2], job: &Job) -> Result<Found, Cancelled> {
        let count = ((hi - lo) / self.step()).ceil().max(2.0) as usize + 1;
        let step = (hi - lo) / (count - 1) as f32;
        let batch = rayon::current_num_threads().max(1);
        let mut costs = Vec::with_capacity(count);
        while costs.len() < count {
            job.advance(Stage::Sweep, costs.len() as u32, count as u32)?;
            let planes = costs.len()..(costs.len() + batch).min(count);
            let made = planes.into_par_iter().map(|i| self.cost(lo + step * i as f32, job.cancel));
            costs.extend(made.collect::<Result<Vec<_>, _>>()?);
        }
        job.advance(Stage::Sweep, count as u32, count as u32)?;
        Ok(self.best(&costs, lo, step))
    }

    /// How badly the views agree with the reference view at a disparity, averaged over a window.
    fn cost(&self, d: f32, cancel: &Cancel) -> Result<Vec<f32>, Cancelled> {
        let [w, h] = self.reference.sides();
        let mut cost = Vec::with_capacity(w * h);
        let mut halves = vec![[0.0f32; 4]; w];
        for y in 0..h {
            halves.fill([0.0; 4]);
            let mut views = [0.0f32; 4];
            for (offset, view) in &self.others {
                let sides = [offset.du <= 0.0, offset.du >= 0.0, offset.dv <= 0.0, offset.dv >= 0.0].map(f32::from);
                (0..4).for_each(|i| views[i] += sides[i]);
                for (x, sums) in halves.iter_mut().enumerate() {
                    // view[y, x] = reference[y + v·d, x + u·d], so the reference's pixel p is the view's p − u·d.
                    let seen = view.tap(x as f32 - offset.du * d, y as f32 - offset.dv * d);
                    let difference = (seen - self.reference.pixels()[y * w + x]).abs().element_sum();
                    (0..4).for_each(|i| sums[i] += sides[i] * difference);
                }
            }
            // Beside an edge half of the views see something else: the half that agrees best counts.
            let mean = |sums: &[f32; 4]| (0..4).map(|i| sums[i] / views[i].max(1.0)).fold(f32::MAX, f32::min) / 6.0;
            cost.extend(halves.iter().map(mean));
        }
        let mut cost = averaged(&cost, [w, h]);
        self.edges.smooth(cost.as_chunks_mut::<1>().0, cancel)?;
        Ok(cost)
    }

    /// The plane of least cost of each pixel, between planes by a parabola.
    fn best(&self, costs: &[Vec<f32>], lo: f32, step: f32) -> Found {
        let of = |i: usize| {
            let cost = |plane: usize| costs[plane][i] + COST_PER_PX * (lo + step * plane as f32).abs();
            let by_cost = |a: &usize, b: &usize| cost(*a).total_cmp(&cost(*b));
            let at = (0..costs.len()).min_by(by_cost).unwrap_or_default();
            let worst = costs.iter().map(|cost| cost[i]).fold(0.0, f32::max);
            let inside = at > 0 && at + 1 < costs.len();
            let shift = if inside { valley(cost(at - 1), cost(at), cost(at + 1)) } else { 0.0 };
            (lo + step * (at as f32 + shift), worst - costs[at][i] > TELLING)
        };
        let (disparity_px, certain) = (0..self.reference.pixels().len()).into_par_iter().map(of).unzip();
        Found { disparity_px, certain }
    }
}

/// Where between −½ and ½ the parabola through three costs is lowest.
fn valley(before: f32, here: f32, after: f32) -> f32 {
    let bend = before - 2.0 * here + after;
    if bend > 1e-9 { ((before - after) / (2.0 * bend)).clamp(-0.5, 0.5) } else { 0.0 }
}

/// A view made as bright as the reference view on average: the outer views of a plenoptic camera are darker, and even
/// surfaces would be matched by their shading.
fn balanced(view: Signed, reference: &Signed) -> Signed {
    let mean = |of: &Signed| of.pixels().iter().map(|pixel| pixel.xyz() + 1.0).sum::<Vec3>() / of.pixels().len() as f32;
    let gain = mean(reference) / mean(&view).max(Vec3::splat(DARKEST));
    view.map(|pixel| ((pixel.xyz() + 1.0) * gain - 1.0).extend(0.0))
}

/// The mean over a square window, separably; windows are cut at the picture's edge.
fn averaged(values: &[f32], [w, h]: [usize; 2]) -> Vec<f32> {
    let window = |i: usize, n: usize| i.saturating_sub(WINDOW)..(i + WINDOW + 1).min(n);
    let mut across = Vec::with_capacity(values.len());
    for row in values.chunks_exact(w) {
        across.extend((0..w).map(|x| row[window(x, w)].iter().sum::<f32>() / window(x, w).len() as f32));
    }
    let mut out = vec![0.0; values.len()];
    for (y, row) in out.chunks_exact_mut(w).enumerate() {
        let near = window(y, h);
        for from in across[near.start * w..near.end * w].chunks_exact(w) {
            row.iter_mut().zip(from).for_each(|(o, f)| *o += f / near.len() as f32);
        }
    }
    out
}

impl Found {
    /// Least and greatest disparity of certain pixels, a few outliers left out.
    fn range(&self) -> [f32; 2] {
        let sure = self.disparity_px.iter().zip(&self.certain).filter(|(_, certain)| **certain).map(|(d, _)| *d);
        let mut sorted: Vec<f32> = sure.collect();
        sorted.sort_by(f32::total_cmp);
        if sorted.is_empty() {
            return [0.0, 0.0];
        }
        [0.005, 0.995].map(|share| sorted[((sorted.len() - 1) as f32 * share) as usize])
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::field::{View, ViewGrid};

    /// A textured near square before a textured far plane, rendered exactly.
    fn scene(grid: ViewGrid, near: f32, far: f32) -> LightField {
        let texture = |x: f32, y: f32, k: f32| 0.5 + 0.25 * (x * 0.9 * k).sin() + 0.25 * (y * 0.7 + x * 0.3 * k).cos();
        let view = |at| {
            let o = grid.offset(at);
            let pixel = |i: usize| {
                let (x, y) = ((i % 72) as f32, (i / 72) as f32);
                let (nx, ny) = (x + o.du * near, y + o.dv * near);
                let inside = (24.0..48.0).contains(&nx) && (18.0..36.0).contains(&ny);
                let value = if inside { texture(nx, ny, 1.3) } else { texture(x + o.du * far, y + o.dv * far, 0.6) };
                [(value * 255.0) as u8, (value * 200.0) as u8, if inside { 220 } else { 30 }, 255]
            };
            Arc::new(View::new([72, 54], (0..72 * 54).flat_map(pixel).collect()).unwrap())
        };
        LightField::new(grid, grid.views().map(view).collect()).unwrap()
    }

    #[test]
    fn both_planes_are_found_with_the_right_sign_in_grids_of_any_shape() {
        for (rows, cols) in [(8, 8), (9, 9), (1, 7), (5, 1)] {
            let (cancel, grid) = (Cancel::default(), ViewGrid::new(rows, cols).unwrap());
            let job = Job { cancel: &cancel, sink: &() };
            let map = reference_map(&scene(grid, 0.6, -0.35), &job).unwrap();
            for (x, y, want) in [(36, 27, 0.6), (30, 24, 0.6), (10, 10, -0.35), (62, 44, -0.35)] {
                let got = map.at(x, y);
                assert!((got - want).abs() < 0.08, "{rows}×{cols} at {x},{y}: {got} where {want} was");
            }
        }
    }

    #[test]
    fn a_field_without_texture_or_with_one_view_is_flat_and_finite() {
        let cancel = Cancel::default();
        let job = Job { cancel: &cancel, sink: &() };
        for (rows, cols) in [(1, 1), (3, 3)] {
            let grid = ViewGrid::new(rows, cols).unwrap();
            let view = Arc::new(View::new([9, 7], vec![128; 9 * 7 * 4]).unwrap());
            let field = LightField::new(grid, vec![view; grid.count()]).unwrap();
            let depths = ray_depths(&field, &job).unwrap();
            assert!(depths.disparity_px().iter().all(|d| d.is_finite()));
        }
    }
}
