//! The softmax of rows of scores, without the division: that is done to the far shorter rows of the answer.

use super::attention::Scores;
use crate::kernel::vector::{Vector, exp_of_negative};

/// Turns scores `s` into `exp(t − max t)`, `t = scale · s + bias`, and notes 1 over the sum of each row.
///
/// # Safety
/// All pointers are good for what the sizes say; the processor has the instructions of `V`.
#[inline(always)]
pub(in crate::kernel) unsafe fn run<V: Vector>(scores: &Scores) {
    for row in 0..scores.rows {
        // SAFETY: the caller's word.
        unsafe {
            let values = scores.first.add(row * scores.step);
            if scores.bias_steps[1] > 1 && !scores.bias.is_empty() {
                add_sparse(scores, values, row);
            }
            *scores.over_sums.add(row) = 1.0 / row_of::<V>(scores, values, row);
        }
    }
}

/// Adds a bias whose values do not lie one behind the other, divided by the scale that follows.
unsafe fn add_sparse(scores: &Scores, values: *mut f32, row: usize) {
    for column in 0..scores.len {
        // SAFETY: the caller's word.
        unsafe {
            let bias = *scores.bias.as_ptr().add(row * scores.bias_steps[0] + column * scores.bias_steps[1]);
            *values.add(column) += bias / scores.scale;
        }
    }
}

/// The sum of a row.
#[inline(always)]
unsafe fn row_of<V: Vector>(scores: &Scores, values: *mut f32, row: usize) -> f32 {
    // SAFETY: the caller's word.
    unsafe {
        let whole = scores.len / V::LANES * V::LANES;
        let left = scores.len - whole;
        let scale = V::splat(scores.scale);
        let dense = !scores.bias.is_empty() && scores.bias_steps[1] <= 1;
        let bias = |at: usize, n: usize| match scores.bias_steps[1] {
            _ if !dense => V::splat(0.0),
            0 => V::splat(*scores.bias.as_ptr().add(row * scores.bias_steps[0])),
            _ => load::<V>(scores.bias.as_ptr().add(row * scores.bias_steps[0] + at), n),
        };
        let mut most = V::splat(f32::NEG_INFINITY);
        for at in (0..whole).step_by(V::LANES) {
            let value = V::load(values.add(at)).mul_add(scale, bias(at, V::LANES));
            value.store(values.add(at));
            most = value.max(most);
        }
        let mut largest = greatest(most);
        for at in whole..scores.len {
            let value = *values.add(at) * scores.scale
                + if dense {
                    *scores.bias.as_ptr().add(row * scores.bias_steps[0] + at * scores.bias_steps[1])
                } else {
                    0.0
                };
            *values.add(at) = value;
            largest = if value > largest { value } else { largest };
        }
        let largest = V::splat(largest);
        let mut sums = V::splat(0.0);
        for at in (0..whole).step_by(V::LANES) {
            let value = exp_of_negative(V::load(values.add(at)).sub(largest));
            value.store(values.add(at));
            sums = sums.add(value);
        }
        let mut sum = sums.sum();
        if left > 0 {
            exp_of_negative(V::load_first(values.add(whole), left).sub(largest)).store_first(values.add(whole), left);
            sum += (whole..scores.len).map(|at| *values.add(at)).sum::<f32>();
        }
        sum
    }
}

#[inline(always)]
unsafe fn load<V: Vector>(from: *const f32, n: usize) -> V {
    // SAFETY: the caller's word.
    unsafe { if n == V::LANES { V::load(from) } else { V::load_first(from, n) } }
}

/// The greatest of all lanes.
#[inline(always)]
unsafe fn greatest<V: Vector>(values: V) -> f32 {
    let mut lanes = [f32::NEG_INFINITY; 16];
    // SAFETY: no vector has more lanes.
    unsafe { values.store(lanes.as_mut_ptr()) };
    lanes[..V::LANES].iter().copied().fold(f32::NEG_INFINITY, f32::max)
}
