//! How a foreign grid of views lies: which way v and u run, and whether they are exchanged. Told by photo-consistency:
//! only in the right layout does one disparity for each point explain all views.
//!
//! Turning the grid upside down *and* left to right (both signs at once) changes nothing but the sign of every
//! disparity: colours cannot tell that. [`Layout::opposite`] is the toggle; the window asks the depth net for a guess.
//! (What hides what could tell it in principle; with the depths that a sweep finds it was right on seven scenes and wrong
//! on a statue before an even wall, whose outline the sweep gives to the wall.)

use std::sync::Arc;

use rayon::prelude::*;
use serde::Serialize;

use super::matching::{box_mean, gray};
use crate::field::{LightField, Raster, ViewGrid, ViewIndex};

/// What has to be done to the views to fit our convention, in this order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Layout {
    /// Every second row runs backwards (a gantry going to and fro).
    pub serpentine: bool,
    /// Rows are columns.
    pub transposed: bool,
    /// The first row is the lowest.
    pub flip_v: bool,
    /// The first column is the rightmost.
    pub flip_u: bool,
}

impl Layout {
    /// The same with every disparity's sign changed.
    #[must_use]
    pub fn opposite(self) -> Self {
        Self { flip_v: !self.flip_v, flip_u: !self.flip_u, ..self }
    }

    /// Where a view of the laid-out grid comes from.
    fn source(self, at: ViewIndex, stored: ViewGrid) -> ViewIndex {
        let (rows, cols) =
            if self.transposed { (stored.cols(), stored.rows()) } else { (stored.rows(), stored.cols()) };
        let v = if self.flip_v { rows as u8 - 1 - at.v } else { at.v };
        let u = if self.flip_u { cols as u8 - 1 - at.u } else { at.u };
        let (v, u) = if self.transposed { (u, v) } else { (v, u) };
        let back = self.serpentine && v % 2 == 1;
        ViewIndex { v, u: if back { stored.cols() as u8 - 1 - u } else { u } }
    }

    /// The light field laid out anew; no pixel is copied.
    pub fn apply(self, field: &LightField) -> LightField {
        let stored = field.grid();
        let (rows, cols) =
            if self.transposed { (stored.cols(), stored.rows()) } else { (stored.rows(), stored.cols()) };
        let grid = ViewGrid::new(rows, cols).unwrap_or(stored);
        let views = grid.views().map(|at| Arc::clone(field.view(self.source(at, stored)))).collect();
        LightField::new(grid, views).unwrap_or_else(|_same_views| field.clone())
    }

    /// The light field as it was before [`apply`](Self::apply).
    pub fn undo(self, laid_out: &LightField) -> LightField {
        let grid = laid_out.grid();
        let (rows, cols) = if self.transposed { (grid.cols(), grid.rows()) } else { (grid.rows(), grid.cols()) };
        let stored = ViewGrid::new(rows, cols).unwrap_or(grid);
        let mut views = laid_out.views().to_vec();
        for at in grid.views() {
            views[stored.layer_from_view(self.source(at, stored))] = Arc::clone(laid_out.view(at));
        }
        LightField::new(stored, views).unwrap_or_else(|_same_views| laid_out.clone())
    }
}

impl std::fmt::Display for Layout {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let said = [
            (self.serpentine, "every second row backwards"),
            (self.transposed, "rows and columns exchanged"),
            (self.flip_v, "upside down"),
            (self.flip_u, "left to right"),
        ];
        let words: Vec<_> = said.iter().filter(|(is, _)| *is).map(|(_, words)| *words).collect();
        f.write_str(if words.is_empty() { "as they are" } else { "" })?;
        f.write_str(&words.join(", "))
    }
}

/// A layout and how badly its views fit together: mean absolute difference, 0 … 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Guess {
    /// The layout.
    pub layout: Layout,
    /// What remains between the views and the reference view, moved by the best disparities.
    pub error: f32,
}

/// Width at which layouts are compared.
const WIDTH: u32 = 144;
/// Disparities that are tried, in pixels per view step at that width.
const RANGE: f32 = 3.0;
const STEP: f32 = 0.2;
/// Half the window over which differences are averaged.
const WINDOW: usize = 2;

/// All layouts that colours can tell apart, the best first.
pub fn guess(field: &LightField) -> Vec<Guess> {
    let grid = field.grid();
    let one_line = grid.rows() == 1 || grid.cols() == 1;
    let choices = [false, true];
    let mut guesses: Vec<Guess> = choices
        .iter()
        .flat_map(|&transposed| choices.iter().map(move |&flip_v| (transposed, flip_v)))
        .flat_map(|(transposed, flip_v)| {
            choices.iter().map(move |&serpentine| Layout { serpentine, transposed, flip_v, flip_u: false })
        })
        // One line of views has no second direction that could run wrongly.
        .filter(|layout| !one_line || !(layout.flip_v || layout.serpentine))
        .map(|layout| Guess { layout, error: error(&layout.apply(field)) })
        .collect();
    guesses.sort_by(|a, b| a.error.total_cmp(&b.error));
    guesses
}

/// Orders by chance that the order of the views is compared with.
const SHUFFLES: u64 = 8;
/// Views in their order leave less than this part of what others leave: 0.34 to 0.63 in eight recorded light fields, 0.8 to
/// 1.3 in photos by hand.
const TOLD_BY_ORDER: f32 = 0.72;

/// Whether the order of pictures says from where each was taken, as that of views does and that of photos by hand does not.
pub fn is_in_order(field: &LightField) -> bool {
    let Some(best) = guess(field).first().copied() else { return false };
    let by_chance: Vec<f32> = (1..=SHUFFLES).map(|seed| error(&shuffled(field, seed))).collect();
    let mean = by_chance.iter().sum::<f32>() / SHUFFLES as f32;
    // Chance may hit the order itself.
    let least = by_chance.iter().copied().fold(f32::INFINITY, f32::min) * 1.001;
    best.error <= least && best.error < TOLD_BY_ORDER * mean
}

/// The same views in another order.
fn shuffled(field: &LightField, seed: u64) -> LightField {
    let mut views: Vec<_> = field.grid().views().map(|at| Arc::clone(field.view(at))).collect();
    // Knuth's constants: any fixed order serves.
    let mut state = seed;
    for last in (1..views.len()).rev() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        views.swap(last, (state >> 33) as usize % (last + 1));
    }
    LightField::new(field.grid(), views).unwrap_or_else(|_| field.clone())
}

/// The guess that is clearly better than the views as they lie, if there is one.
pub fn better_than_stored(field: &LightField) -> Option<Guess> {
    let guesses = guess(field);
    let best = *guesses.first()?;
    let stored = guesses.iter().find(|guess| guess.layout == Layout::default())?;
    (best.layout != Layout::default() && best.error < 0.8 * stored.error).then_some(best)
}

/// The views around the reference view that are compared with it.
fn probes(grid: ViewGrid) -> Vec<ViewIndex> {
    let middle = grid.reference();
    let steps: [(i32, i32); 10] =
        [(0, 1), (0, -1), (1, 0), (-1, 0), (0, 2), (2, 0), (2, 2), (-2, 2), (1, -2), (-1, -2)];
    let inside = |(dv, du): (i32, i32)| {
        let (v, u) = (i32::from(middle.v) + dv, i32::from(middle.u) + du);
        let fits = (0..grid.rows() as i32).contains(&v) && (0..grid.cols() as i32).contains(&u);
        fits.then_some(ViewIndex { v: v as u8, u: u as u8 })
    };
    steps.into_iter().filter_map(inside).collect()
}

/// What the best disparity of each pixel leaves unexplained, in the layout as it is.
pub(super) fn error(field: &LightField) -> f32 {
    let costs = costs(field);
    let Some((_, first)) = costs.first() else { return 0.0 };
    let best = |at: usize| costs.iter().map(|(_, cost)| cost[at]).fold(f32::INFINITY, f32::min);
    (0..first.len()).map(best).sum::<f32>() / first.len() as f32
}

/// Mean difference of the probes from the reference view, for each disparity.
fn costs(field: &LightField) -> Vec<(f32, Vec<f32>)> {
    let grid = field.grid();
    let reference = gray(field.reference(), WIDTH);
    let [w, h] = reference.size();
    let probes: Vec<_> = probes(grid).into_iter().map(|at| (grid.offset(at), gray(field.view(at), WIDTH))).collect();
    let count = (2.0 * RANGE / STEP).round() as i32;
    (0..=count)
        .into_par_iter()
        .map(|n| {
            let d = n as f32 * STEP - RANGE;
            let cost = |at: usize| {
                let (x, y) = ((at as u32 % w) as f32, (at as u32 / w) as f32);
                // view(v, u)[y, x] = reference[y + dv·D, x + du·D], read from the view's side.
                let difference = |(steps, view): &(crate::field::ViewOffset, Raster<f32>)| {
                    (view.tap(x - steps.du * d, y - steps.dv * d) - reference.pixels()[at]).abs()
                };
                probes.iter().map(difference).sum::<f32>() / probes.len().max(1) as f32
            };
            let raw: Vec<f32> = (0..(w * h) as usize).map(cost).collect();
            (d, box_mean(&raw, [w, h], WINDOW))
        })
        .collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::field::View;
    use crate::io::formats::matching::tests::texture;

    /// Views of a slanted plane, disparity from −1 (left) to 1 (right) px at its own width, in our convention.
    pub(crate) fn scene(rows: usize, cols: usize, [w, h]: [u32; 2]) -> LightField {
        let grid = ViewGrid::new(rows, cols).unwrap();
        let view = |at: ViewIndex| {
            let steps = grid.offset(at);
            let pixel = |n: u32| {
                let (x, y) = ((n % w) as f32, (n / w) as f32);
                let d = 2.0 * x / w as f32 - 1.0;
                let value = (texture(x + steps.du * d, y + steps.dv * d) * 255.0) as u8;
                [value, value, 255 - value, 255]
            };
            Arc::new(View::new([w, h], (0..w * h).flat_map(pixel).collect()).unwrap())
        };
        LightField::new(grid, grid.views().map(view).collect()).unwrap()
    }

    #[test]
    fn every_wrong_layout_is_found_out() {
        let truth = scene(5, 5, [120, 90]);
        for (transposed, flip_v) in [(false, false), (false, true), (true, false), (true, true)] {
            // Each of these is its own inverse on a square grid, up to the common sign.
            let stored = Layout { transposed, flip_v, ..Layout::default() }.apply(&truth);
            let guesses = guess(&stored);
            let found = guesses[0].layout.apply(&stored);
            let same = found == truth || Layout::default().opposite().apply(&found) == truth;
            assert!(same, "{transposed} {flip_v}: {guesses:?}");
            assert_eq!(better_than_stored(&stored).is_some(), transposed || flip_v);
        }
    }

    #[test]
    fn a_serpentine_is_straightened() {
        let truth = scene(5, 5, [120, 90]);
        let wound = Layout { serpentine: true, ..Layout::default() }.apply(&truth);
        assert_ne!(wound, truth);
        let best = better_than_stored(&wound).unwrap();
        assert_eq!(best.layout.apply(&wound), truth);
    }

    #[test]
    fn what_was_laid_out_can_be_undone() {
        let stored = scene(3, 5, [24, 18]);
        for n in 0..16u8 {
            let bit = |k: u8| n >> k & 1 == 1;
            let layout = Layout { serpentine: bit(0), transposed: bit(1), flip_v: bit(2), flip_u: bit(3) };
            assert_eq!(layout.undo(&layout.apply(&stored)), stored, "{layout:?}");
        }
    }

    #[test]
    fn a_row_and_a_column_are_told_apart() {
        let column = Layout { transposed: true, ..Layout::default() }.apply(&scene(1, 7, [120, 90]));
        assert_eq!((column.grid().rows(), column.grid().cols()), (7, 1));
        assert!(better_than_stored(&column).unwrap().layout.transposed);
        assert!(better_than_stored(&scene(1, 7, [120, 90])).is_none());
    }

    #[test]
    fn views_are_in_order_and_every_third_is_not() {
        for (rows, cols) in [(1, 7), (4, 4)] {
            let field = scene(rows, cols, [96, 72]);
            assert!(is_in_order(&field), "{rows} x {cols}");
            let count = field.views().len();
            let thirds = (0..count).map(|n| Arc::clone(&field.views()[3 * n % count])).collect();
            assert!(!is_in_order(&LightField::new(field.grid(), thirds).unwrap()), "{rows} x {cols}");
        }
    }
}
