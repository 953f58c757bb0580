//! `act(x · w + bias) + summand` for rows of activations.

use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicBool, Ordering};

use super::panels::Panels;
use super::tile::{Block, Finish};
use crate::job::Cancelled;
use crate::kernel::ending::Limits;
use crate::kernel::isa::{Isa, on_isa};
use crate::kernel::padded::SendPtr;
use crate::kernel::team;
use crate::kernel::tile::Activation;

/// A product with constant weights `[depth, columns]`.
#[derive(Clone, Copy, Debug)]
pub struct Dense<'a> {
    /// Instructions; those that the weights were packed for.
    pub isa: Isa,
    /// The weights.
    pub weights: &'a Panels,
    /// One value a column; empty means 0.
    pub bias: &'a [f32],
    /// What follows.
    pub activation: Activation,
    /// What the result is kept within, after something was added.
    pub limits: Limits,
}

/// Rows of a task at most: they stay in the cache while the weights go by.
const MOST_ROWS: usize = 240;
/// Rows of a task are a multiple of this.
const STEP: usize = 12;

impl Dense<'_> {
    /// Writes `[rows, columns]` of `x` `[rows, depth]`; `summand` `[rows, columns]` is added at the end.
    ///
    /// # Errors
    /// [`Cancelled`] once `cancel` is set.
    pub fn run(
        &self,
        x: &[f32],
        summand: Option<&[f32]>,
        out: &mut [MaybeUninit<f32>],
        cancel: Option<&AtomicBool>,
    ) -> Result<(), Cancelled> {
        let Panels { depth, columns, width, ref values } = *self.weights;
        let rows = out.len() / columns.max(1);
        assert_eq!((x.len(), out.len()), (rows * depth, rows * columns), "lengths of a product");
        assert!(summand.is_none_or(|summand| summand.len() == out.len()), "length of the summand");
        let mut bias = self.bias.to_vec();
        bias.resize(columns.next_multiple_of(width), 0.0);
        let tasks = 3 * rayon::current_num_threads();
        let block_rows = rows.div_ceil(tasks).next_multiple_of(STEP).min(MOST_ROWS);
        let out = SendPtr(out.as_mut_ptr().cast::<f32>());
        let stopped = || cancel.is_some_and(|flag| flag.load(Ordering::Relaxed));
        let (x, summand) =
            (SendPtr(x.as_ptr().cast_mut()), SendPtr(summand.map_or(std::ptr::null(), <[f32]>::as_ptr).cast_mut()));
        team::each(rows.div_ceil(block_rows.max(1)), |task| {
            if stopped() {
                return;
            }
            let first = task * block_rows;
            // SAFETY: the lengths were checked above; the rows of this task are written by it alone.
            let block = unsafe {
                Block {
                    a: x.at(first * depth),
                    a_step: depth,
                    panels: values.as_ptr(),
                    panel_step: depth * width,
                    depth,
                    rows: block_rows.min(rows - first),
                    columns,
                    out: out.at(first * columns),
                    out_step: columns,
                    finish: Finish {
                        column_bias: bias.as_ptr(),
                        activation: self.activation,
                        limits: self.limits,
                        summand: if summand.0.is_null() { summand.0 } else { summand.at(first * columns) },
                        ..Finish::PLAIN
                    },
                }
            };
            on_isa!(self.isa, product(&block));
        });
        if stopped() { Err(Cancelled) } else { Ok(()) }
    }
}
