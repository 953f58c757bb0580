//! The right matrix of a product, cut into panels as wide as a tile.

use super::tile::VECTORS;
use crate::kernel::Isa;

/// A constant right matrix `[depth, columns]`, packed as `[panel][depth][column of the panel]`; columns that fill no panel
/// are 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Panels {
    pub(super) values: Vec<f32>,
    pub(super) depth: usize,
    pub(super) columns: usize,
    pub(super) width: usize,
}

impl Panels {
    /// Packs the matrix whose value at (depth, column) is `value`, for the instructions of `isa`.
    pub fn of(isa: Isa, [depth, columns]: [usize; 2], value: impl Fn(usize, usize) -> f32) -> Self {
        let width = VECTORS * isa.lanes();
        let mut values = vec![0.0; columns.div_ceil(width) * depth * width];
        for (panel, target) in values.chunks_exact_mut((depth * width).max(1)).enumerate() {
            let first = panel * width;
            let count = width.min(columns - first);
            for (k, target) in target.chunks_exact_mut(width).enumerate() {
                for (column, target) in target[..count].iter_mut().enumerate() {
                    *target = value(k, first + column);
                }
            }
        }
        Self { values, depth, columns, width }
    }

    /// Products in a sum.
    pub fn depth(&self) -> usize {
        self.depth
    }

    /// Columns of the result.
    pub fn columns(&self) -> usize {
        self.columns
    }
}
