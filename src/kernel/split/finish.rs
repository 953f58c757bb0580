//! What is done with sums on their way into the result.

use super::TILE;
use super::product::Sums;
use crate::kernel::tile::{Activation, activate};
use crate::kernel::vector::Vector;

/// Sums of 16 results at neighbouring pixels.
pub(in crate::kernel) struct Finish<'a> {
    pub(super) sums: &'a Sums,
    /// The first pixel, counted through padded rows of `outer` columns.
    pub(super) first: usize,
    pub(super) outer: usize,
    /// Rows and columns that are written.
    pub(super) size: [usize; 2],
    /// Values from one pixel of the result to the next.
    pub(super) step: usize,
    /// What the sums of each of the 16 are multiplied by,
    pub(super) factors: *const f32,
    /// and what is added then.
    pub(super) bias: *const f32,
    pub(super) activation: Activation,
    /// What is added behind the activation, laid out as the result; or null.
    pub(super) residual: *const f32,
    /// The results at the first pixel of the first row.
    pub(super) out: *mut f32,
}

/// Writes the results of all pixels that are inside.
///
/// # Safety
/// The pointers are good for what the sizes say; the processor has the instructions of `V`.
#[inline(always)]
pub(in crate::kernel) unsafe fn run<V: Vector>(finish: &Finish) {
    let [rows, columns] = finish.size;
    let (mut y, mut x) = (finish.first / finish.outer, finish.first % finish.outer);
    for sums in finish.sums.0.as_chunks::<TILE>().0 {
        if x < columns && y < rows {
            let at = (y * columns + x) * finish.step;
            // SAFETY: the caller's word; the pixel is inside.
            unsafe {
                for lane in (0..TILE).step_by(V::LANES) {
                    let (factor, bias) = (V::load(finish.factors.add(lane)), V::load(finish.bias.add(lane)));
                    let sum = V::load(sums.as_ptr().add(lane)).mul_add(factor, bias);
                    let mut value = activate(sum, finish.activation);
                    if !finish.residual.is_null() {
                        value = value.add(V::load(finish.residual.add(at + lane)));
                    }
                    value.store(finish.out.add(at + lane));
                }
            }
        }
        x += 1;
        if x == finish.outer {
            (y, x) = (y + 1, 0);
        }
    }
}
