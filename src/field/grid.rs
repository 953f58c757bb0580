//! The angular grid of views: sizes, indices, offsets, and the order from the middle outward.

use glam::Vec2;
use serde::{Deserialize, Serialize};

use super::{FNumber, FieldError};

/// Views per angular axis. `v` runs down, `u` runs right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct ViewGrid {
    rows: u8,
    cols: u8,
}

/// One view of a grid: row `v`, column `u`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ViewIndex {
    /// Row, from the top.
    pub v: u8,
    /// Column, from the left.
    pub u: u8,
}

/// Steps from the reference view, fractions allowed: `du` to the right, `dv` down.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ViewOffset {
    /// Steps down.
    pub dv: f32,
    /// Steps to the right.
    pub du: f32,
}

/// The views of a rectangle of a grid, both ends among them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ViewBlock {
    /// Its upper left view.
    pub from: ViewIndex,
    /// Its lower right view.
    pub to: ViewIndex,
}

impl ViewBlock {
    /// Whether a view is of it.
    pub fn contains(self, at: ViewIndex) -> bool {
        (self.from.v..=self.to.v).contains(&at.v) && (self.from.u..=self.to.u).contains(&at.u)
    }
}

impl From<ViewIndex> for ViewBlock {
    fn from(at: ViewIndex) -> Self {
        Self { from: at, to: at }
    }
}

impl ViewOffset {
    /// `(du, dv)` as a vector in picture axes (x right, y down).
    pub fn to_vec2(self) -> Vec2 {
        Vec2::new(self.du, self.dv)
    }

    /// From a vector in picture axes.
    pub fn from_vec2(steps: Vec2) -> Self {
        Self { dv: steps.y, du: steps.x }
    }
}

impl ViewGrid {
    /// The grid of the paper.
    pub const PAPER: Self = Self { rows: 8, cols: 8 };
    /// The most rows or columns that are supported (Stanford's archives have 17).
    pub const MAX_SIDE: usize = 17;

    /// A grid of 1 … 17 rows and columns.
    pub fn new(rows: usize, cols: usize) -> Result<Self, FieldError> {
        let fits = |n: usize| (1..=Self::MAX_SIDE).contains(&n);
        if fits(rows) && fits(cols) {
            Ok(Self { rows: rows as u8, cols: cols as u8 })
        } else {
            Err(FieldError::Grid { rows, cols })
        }
    }

    /// Rows of views (angular v).
    pub fn rows(self) -> usize {
        self.rows.into()
    }

    /// Columns of views (angular u).
    pub fn cols(self) -> usize {
        self.cols.into()
    }

    /// Views in all.
    pub fn count(self) -> usize {
        self.rows() * self.cols()
    }

    /// Whether the views reach across a lens: as many in the shorter axis as its aperture is wide.
    pub fn spans(self, f_number: FNumber) -> bool {
        f_number.views_across() <= self.rows.min(self.cols).into()
    }

    /// The circle of viewpoints around the reference view that stays inside the grid, in view steps.
    pub fn inner_radius(self) -> f32 {
        f32::from((self.rows.min(self.cols) - 1) / 2)
    }

    /// The view that a photo becomes: `(rows / 2, cols / 2)`.
    pub fn reference(self) -> ViewIndex {
        ViewIndex { v: self.rows / 2, u: self.cols / 2 }
    }

    /// Number of a view in `[v, u]` order.
    pub fn layer_from_view(self, at: ViewIndex) -> usize {
        usize::from(at.v) * self.cols() + usize::from(at.u)
    }

    /// The view with a number in `[v, u]` order.
    pub fn view_from_layer(self, layer: usize) -> ViewIndex {
        ViewIndex { v: (layer / self.cols()) as u8, u: (layer % self.cols()) as u8 }
    }

    /// Steps of a view from the reference view.
    pub fn offset(self, at: ViewIndex) -> ViewOffset {
        let zero = self.reference();
        ViewOffset { dv: f32::from(at.v) - f32::from(zero.v), du: f32::from(at.u) - f32::from(zero.u) }
    }

    /// The offset clamped to what the grid covers.
    pub fn clamp(self, offset: ViewOffset) -> ViewOffset {
        let lo = self.offset(ViewIndex { v: 0, u: 0 });
        let hi = self.offset(ViewIndex { v: self.rows - 1, u: self.cols - 1 });
        ViewOffset { dv: offset.dv.clamp(lo.dv, hi.dv), du: offset.du.clamp(lo.du, hi.du) }
    }

    /// The view nearest to an offset.
    pub fn nearest(self, offset: ViewOffset) -> ViewIndex {
        let zero = self.reference();
        let inside = self.clamp(offset);
        ViewIndex { v: (f32::from(zero.v) + inside.dv).round() as u8, u: (f32::from(zero.u) + inside.du).round() as u8 }
    }

    /// The views around an offset, four at most.
    pub fn around(self, offset: ViewOffset) -> ViewBlock {
        let (zero, inside) = (self.reference(), self.clamp(offset));
        let [v, u] = [f32::from(zero.v) + inside.dv, f32::from(zero.u) + inside.du];
        let at = |round: fn(f32) -> f32| ViewIndex { v: round(v) as u8, u: round(u) as u8 };
        ViewBlock { from: at(f32::floor), to: at(f32::ceil) }
    }

    /// A row of views.
    pub fn row(self, v: u8) -> ViewBlock {
        ViewBlock { from: ViewIndex { v, u: 0 }, to: ViewIndex { v, u: self.cols - 1 } }
    }

    /// A column of views.
    pub fn column(self, u: u8) -> ViewBlock {
        ViewBlock { from: ViewIndex { v: 0, u }, to: ViewIndex { v: self.rows - 1, u } }
    }

    /// All views in `[v, u]` order.
    pub fn views(self) -> impl Iterator<Item = ViewIndex> {
        (0..self.count()).map(move |layer| self.view_from_layer(layer))
    }

    /// All views from the reference view outward, nearest first.
    pub fn spiral(self) -> Vec<ViewIndex> {
        let mut all: Vec<_> = self.views().collect();
        all.sort_by(|a, b| {
            let far = |at: &ViewIndex| self.offset(*at).to_vec2().length_squared();
            far(a).total_cmp(&far(b)).then(a.cmp(b))
        });
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_grid_runs_from_minus_four_to_three() {
        let grid = ViewGrid::PAPER;
        assert_eq!(grid.reference(), ViewIndex { v: 4, u: 4 });
        assert_eq!(grid.offset(ViewIndex { v: 0, u: 7 }), ViewOffset { dv: -4.0, du: 3.0 });
        assert_eq!(grid.layer_from_view(ViewIndex { v: 1, u: 2 }), 10);
        assert_eq!(grid.view_from_layer(10), ViewIndex { v: 1, u: 2 });
    }

    #[test]
    fn the_spiral_starts_at_the_reference_and_visits_every_view_once() {
        for (rows, cols) in [(8, 8), (1, 5), (17, 17), (1, 1)] {
            let grid = ViewGrid::new(rows, cols).unwrap();
            let mut order = grid.spiral();
            assert_eq!(order[0], grid.reference());
            order.sort();
            assert_eq!(order, grid.views().collect::<Vec<_>>());
        }
    }

    #[test]
    fn offsets_outside_the_grid_are_brought_to_its_rim() {
        let grid = ViewGrid::PAPER;
        assert_eq!(grid.nearest(ViewOffset { dv: 9.0, du: -9.0 }), ViewIndex { v: 7, u: 0 });
        assert!(ViewGrid::new(0, 3).is_err() && ViewGrid::new(18, 1).is_err());
    }
}
