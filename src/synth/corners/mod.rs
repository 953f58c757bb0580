//! The views between four: a light field from those at its corners.
//!
//! In the manner of Kalantari et al. 2016: [`between`] needs no net, [`CornerNets`] are two that were trained. What these are
//! given is in [`Between`], for the trainer too.

mod nets;
mod one;
mod swept;

pub use nets::{COLOUR_FILE, CornerNets};
pub use one::{Between, CORNERS, LEVELS, RANGE_PX, RESIDUAL_GAIN};
pub use swept::between;

use crate::field::{ViewGrid, ViewIndex};

/// Which of the given views a place of the grid is.
fn given_at(grid: ViewGrid, at: ViewIndex) -> Option<usize> {
    let end = |step: u8, count: usize| match usize::from(step) {
        0 => Some(0),
        last if last + 1 == count => Some(1),
        _ => None,
    };
    Some(2 * end(at.v, grid.rows())? + end(at.u, grid.cols())?)
}
