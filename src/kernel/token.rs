//! What is done to each token of a transformer by itself.

use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicBool, Ordering};

use super::isa::{Isa, on_isa};
use super::padded::SendPtr;
use super::team;
use super::vector::Vector;
use crate::job::Cancelled;

/// Tokens of a task.
const TASK_ROWS: usize = 32;

/// `(x − mean) / √(variance + ε) · scale + shift` of each row of `scale.len()` values.
///
/// # Errors
/// [`Cancelled`] once `cancel` is set.
pub fn layer_norm(
    isa: Isa,
    x: &[f32],
    epsilon: f32,
    [scale, shift]: [&[f32]; 2],
    out: &mut [MaybeUninit<f32>],
    cancel: Option<&AtomicBool>,
) -> Result<(), Cancelled> {
    let len = scale.len().max(1);
    assert_eq!((x.len() % len, shift.len(), out.len()), (0, scale.len(), x.len()), "lengths of a normalisation");
    let stopped = || cancel.is_some_and(|flag| flag.load(Ordering::Relaxed));
    let out = SendPtr(out.as_mut_ptr().cast::<f32>());
    team::each(x.len().div_ceil(TASK_ROWS * len), |task| {
        if stopped() {
            return;
        }
        let x = &x[task * TASK_ROWS * len..((task + 1) * TASK_ROWS * len).min(x.len())];
        for (row, x) in x.chunks_exact(len).enumerate() {
            // SAFETY: the rows of this task are written by it alone.
            let out = unsafe { out.at((task * TASK_ROWS + row) * len) };
            on_isa!(isa, layer_norm_row(&Row { x, scale, shift, epsilon, out }));
        }
    });
    if stopped() { Err(Cancelled) } else { Ok(()) }
}

/// One token.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row<'a> {
    x: &'a [f32],
    scale: &'a [f32],
    shift: &'a [f32],
    epsilon: f32,
    out: *mut f32,
}

/// # Safety
/// `out` has room for as many values as `x`; the processor has the instructions of `V`.
#[inline(always)]
pub(super) unsafe fn normalise<V: Vector>(row: &Row) {
    let Row { x, scale, shift, epsilon, out } = *row;
    // SAFETY: the caller's word; the slices are equally long.
    unsafe {
        let mean = sum::<V>(x, |x| x) / x.len() as f32;
        let centre = V::splat(mean);
        // The ragged end is summed by itself: what fills a vector up would not be 0 any more.
        let variance = sum::<V>(x, |x| x.sub(centre).mul(x.sub(centre))) / x.len() as f32;
        let factor = V::splat(1.0 / (variance + epsilon).sqrt());
        for at in (0..x.len()).step_by(V::LANES) {
            let n = (x.len() - at).min(V::LANES);
            let part = |from: &[f32]| {
                let from = from.as_ptr().add(at);
                if n == V::LANES { V::load(from) } else { V::load_first(from, n) }
            };
            let value = part(x).sub(centre).mul(factor).mul_add(part(scale), part(shift));
            if n == V::LANES { value.store(out.add(at)) } else { value.store_first(out.add(at), n) }
        }
    }
}

/// Σ f(x).
#[inline(always)]
unsafe fn sum<V: Vector>(x: &[f32], f: impl Fn(V) -> V) -> f32 {
    // SAFETY: the caller's word.
    unsafe {
        let mut sums = V::splat(0.0);
        let whole = x.len() / V::LANES * V::LANES;
        for at in (0..whole).step_by(V::LANES) {
            sums = sums.add(f(V::load(x.as_ptr().add(at))));
        }
        let mut ragged = [0.0; 16];
        for value in &x[whole..] {
            f(V::splat(*value)).store(ragged.as_mut_ptr());
            sums = sums.add(V::load_first(ragged.as_ptr(), 1));
        }
        sums.sum()
    }
}
