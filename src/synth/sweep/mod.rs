//! Ray depths of a light field that came without, measured from all its views.
//!
//! In the manner of Jeon et al. 2015: for each disparity the views are shifted onto the reference view by exact fractions of
//! pixels; where their colours and gradients agree, a surface is there. How badly they agree is smoothed over even
//! regions of the reference view (cost-volume filtering, Rhemann et al. 2011), each pixel's neighbours are heard, and the
//! least is found between two disparities. A small sweep finds the range, a larger one the map.

mod cost;
mod shift;

use rayon::prelude::*;

use super::upsample;
use super::{SynthError, lift};
use crate::field::{DisparityMap, LightField, RayDepths, Size, ViewGrid, ViewIndex, disparity_scale, fit_long_side};
use crate::job::{Cancelled, Job, Stage};
use crate::semiglobal::{Changes, DIRECTIONS, Volume, lowest};
use cost::Views;

/// Long side of the sweep that finds the range.
const COARSE_LONG_SIDE: u32 = 160;
/// Rows and columns of views that the two sweeps look at, at most.
const COARSE_VIEWS: usize = 4;
const FINE_VIEWS: usize = 9;
/// Disparities that are looked for: ± this share of the width per step (± 8 px at 540).
const WIDEST_SHARE: f32 = 8.0 / 540.0;
/// Long side of the sweep that finds the map.
const FINE_LONG_SIDE: u32 = 540;
/// Shift of the outermost view between two planes, in px.
const PLANE_STEP_PX: f32 = 0.5;
/// How far agreement flows over even colour, as a share of the long side: in the sweep that finds the range, and in the
/// other, where neighbours are heard as well.
const COARSE_REACH_SHARE: f32 = 0.025;
const REACH_SHARE: f32 = 0.002;
/// Difference of cost between the worst and the best plane from which a disparity counts as found.
const TELLING: f32 = 0.002;
/// What a plane costs more for each pixel of disparity: where nothing tells, 0 is taken.
const COST_PER_PX: f32 = 1e-4;
/// What the neighbour's next disparity costs, and what any other does where no colour changes.
const NEXT: f32 = 0.003;
const OTHER: f32 = 0.015;
/// A change of colour (mean of the channels, 0 … 1) at which a break costs half as much.
const HALVING: f32 = 0.02;

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
    view_map(field, field.grid().reference(), WIDEST_SHARE, job)
}

/// The disparity of any view; `widest_share` of the width per step is looked for at most.
///
/// # Errors
/// Cancelled; a map that is none.
pub fn view_map(field: &LightField, at: ViewIndex, widest_share: f32, job: &Job) -> Result<DisparityMap, SynthError> {
    let full = field.size();
    let size = fit_long_side(full, COARSE_LONG_SIDE);
    let widest = widest_share * size[0].max(size[1]) as f32;
    let some = spread(field.grid(), COARSE_VIEWS, at);
    let coarse = Sweep::new(field, (at, &some), size, [-widest, widest], COARSE_REACH_SHARE);
    let [lo, hi] = coarse.range(&coarse.costs(job)?, job)?;
    let fine = fit_long_side(full, FINE_LONG_SIDE);
    let ratio = disparity_scale(size, fine);
    let margin = 2.0 * coarse.step;
    let others = spread(field.grid(), FINE_VIEWS, at);
    let fine = Sweep::new(field, (at, &others), fine, [(lo - margin) * ratio, (hi + margin) * ratio], REACH_SHARE);
    let map = fine.map(&fine.costs(job)?, job)?;
    Ok(if map.size() == full { map } else { upsample::to_guide(&map, field.view(at), job)? })
}

/// A sweep over some views at one size: planes from the farthest on.
struct Sweep {
    views: Views,
    first: f32,
    step: f32,
    count: usize,
}

/// At most so many rows and columns of views, evenly spread, the outermost among them; without one view.
fn spread(grid: ViewGrid, most: usize, but: ViewIndex) -> Vec<ViewIndex> {
    let some = |n: usize| {
        let mut some: Vec<usize> = (0..most).map(|i| (2 * i * (n - 1) + most - 1) / (2 * (most - 1))).collect();
        some.dedup();
        some
    };
    let columns = some(grid.cols());
    let layers = some(grid.rows()).into_iter().flat_map(|v| columns.iter().map(move |u| v * grid.cols() + u));
    layers.map(|layer| grid.view_from_layer(layer)).filter(|at| *at != but).collect()
}

impl Sweep {
    fn new(
        field: &LightField,
        views: (ViewIndex, &[ViewIndex]),
        size: Size,
        [lo, hi]: [f32; 2],
        reach_share: f32,
    ) -> Self {
        let reach = reach_share * size[0].max(size[1]) as f32;
        let views = Views::new(field, views, size, lo.abs().max(hi.abs()), reach);
        let step = PLANE_STEP_PX / views.reach_steps();
        let count = ((hi - lo) / step).ceil().max(2.0) as usize + 1;
        Self { views, first: lo, step: (hi - lo) / (count - 1) as f32, count }
    }

    fn disparity(&self, plane: f32) -> f32 {
        self.first + self.step * plane
    }

    /// The cost of each plane, `[y, x]`.
    fn costs(&self, job: &Job) -> Result<Vec<Vec<f32>>, Cancelled> {
        let batch = rayon::current_num_threads().max(1);
        let mut costs = Vec::with_capacity(self.count);
        while costs.len() < self.count {
            job.advance(Stage::Sweep, costs.len() as u32, self.count as u32)?;
            let planes = costs.len()..(costs.len() + batch).min(self.count);
            let made = planes.into_par_iter().map(|plane| {
                let d = self.disparity(plane as f32);
                let mut cost = self.views.cost(d, job.cancel)?;
                cost.iter_mut().for_each(|cost| *cost += COST_PER_PX * d.abs());
                Ok(cost)
            });
            costs.extend(made.collect::<Result<Vec<_>, Cancelled>>()?);
        }
        job.advance(Stage::Sweep, self.count as u32, self.count as u32)?;
        Ok(costs)
    }

    /// The disparity of each pixel, its neighbours heard.
    fn map(&self, costs: &[Vec<f32>], job: &Job) -> Result<DisparityMap, SynthError> {
        let (heard, reference) = (self.heard(costs, job)?, &self.views.reference);
        let of = |pixel: usize| self.best(heard.of(pixel));
        let disparity_px = (0..reference.pixels().len()).into_par_iter().map(of).collect();
        Ok(DisparityMap::new(reference.size(), disparity_px)?)
    }

    /// The disparity of least cost, between planes by a parabola.
    fn best(&self, costs: &[f32]) -> f32 {
        let (plane, beside) = lowest(costs);
        self.disparity(plane as f32 + beside)
    }

    /// The costs by pixel, neighbours heard.
    fn heard(&self, costs: &[Vec<f32>], job: &Job) -> Result<Volume<f32>, Cancelled> {
        let reference = &self.views.reference;
        let difference = |a: usize, b: usize| (reference.pixels()[a] - reference.pixels()[b]).abs().element_sum() / 6.0;
        let changes = Changes { next: NEXT, other: |a, b| OTHER / (1.0 + difference(a, b) / HALVING) };
        let mut heard = Volume::of_planes(reference.sides(), costs).heard(&changes, job.cancel)?;
        heard.costs.iter_mut().for_each(|cost| *cost /= DIRECTIONS as f32);
        Ok(heard)
    }

    /// Least and greatest disparity of the pixels that tell it, a few outliers left out.
    fn range(&self, costs: &[Vec<f32>], job: &Job) -> Result<[f32; 2], Cancelled> {
        let heard = self.heard(costs, job)?;
        let found = |pixel: usize| {
            let of = || costs.iter().map(|plane| plane[pixel]);
            let (least, most) = of().fold((f32::MAX, 0.0f32), |(least, most), c| (least.min(c), most.max(c)));
            (most - least > TELLING).then(|| self.best(heard.of(pixel)))
        };
        let mut sorted: Vec<f32> = (0..self.views.reference.pixels().len()).into_par_iter().filter_map(found).collect();
        sorted.par_sort_unstable_by(f32::total_cmp);
        if sorted.is_empty() {
            return Ok([0.0, 0.0]);
        }
        Ok([0.005, 0.995].map(|share| sorted[((sorted.len() - 1) as f32 * share) as usize]))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::field::View;
    use crate::job::Cancel;

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
    fn slanted_ground_is_found_between_two_planes_of_the_sweep() {
        let (cancel, grid) = (Cancel::default(), ViewGrid::PAPER);
        // view[y, x] = reference[y + v·d, x + u·d] with d = slope · (y + v·d) − 0.3.
        let texture = |x: f32, y: f32| 0.5 + 0.2 * (1.1 * x + 0.3 * y).sin() + 0.2 * (0.9 * y - 0.5 * x).cos();
        let (slope, first) = (0.6 / 53.0, -0.3);
        let view = |at| {
            let o = grid.offset(at);
            let pixel = |i: usize| {
                let (x, y) = ((i % 72) as f32, (i / 72) as f32);
                let d = (slope * y + first) / (1.0 - slope * o.dv);
                let value = texture(x + o.du * d, y + o.dv * d);
                [(value * 255.0) as u8, (value * 180.0) as u8, 60, 255]
            };
            Arc::new(View::new([72, 54], (0..72 * 54).flat_map(pixel).collect()).unwrap())
        };
        let field = LightField::new(grid, grid.views().map(view).collect()).unwrap();
        let map = reference_map(&field, &Job { cancel: &cancel, sink: &() }).unwrap();
        let inside = (5..49).flat_map(|y| (5..67).map(move |x| (x, y)));
        let errors: Vec<f32> = inside.map(|(x, y)| (map.at(x, y) - slope * y as f32 - first).abs()).collect();
        let mean = errors.iter().sum::<f32>() / errors.len() as f32;
        // Planes are 0.125 px apart.
        assert!(mean < 0.03, "off by {mean} px");
    }

    #[test]
    fn views_are_spread_evenly_and_hold_the_outermost() {
        let of = |rows, cols, most| {
            let grid = ViewGrid::new(rows, cols).unwrap();
            spread(grid, most, grid.reference()).iter().map(|at| (at.v, at.u)).collect::<Vec<_>>()
        };
        assert_eq!(of(1, 8, 4), [(0, 0), (0, 2), (0, 5), (0, 7)]);
        assert_eq!(of(9, 9, 9).len(), 80);
        assert_eq!(of(17, 1, 9).len(), 8);
        assert_eq!(of(1, 1, 4), []);
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
