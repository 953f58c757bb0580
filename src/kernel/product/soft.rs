//! The softmax of rows of scores, without the division: that is done to the far shorter rows of the answer.

use super::attention::Scores;
use crate::kernel::vector::{Vector, exp_of_negative};

/// Turns scores `s` into `exp(t − max t)`, `t = scale · s + Σ bias`, and notes 1 over the sum of each row.
///
/// # Safety
/// All pointers are good for what the sizes say; the processor has the instructions of `V`.
#[inline(always)]
pub(in crate::kernel) unsafe fn run<V: Vector>(scores: &Scores) {
    for row in 0..scores.rows {
        // SAFETY: the caller's word.
        unsafe {
            let values = scores.first.add(row * scores.step);
            // The last is added on the way, if its values lie one behind the other.
            let (last, others) = match scores.biases {
                [others @ .., (bias, steps)] if steps[1] <= 1 => {
                    (bias.get(row * steps[0]..).zip(Some(steps[1])), others)
                }
                others => (None, others),
            };
            for (bias, steps) in others {
                add::<V>(scores, values, &bias[row * steps[0]..], steps[1]);
            }
            *scores.over_sums.add(row) = 1.0 / row_of::<V>(scores, values, last);
        }
    }
}

/// Adds a row of a bias, divided by the scale that follows.
#[inline(always)]
unsafe fn add<V: Vector>(scores: &Scores, values: *mut f32, bias: &[f32], step: usize) {
    let whole = if step == 1 { scores.len / V::LANES * V::LANES } else { 0 };
    // SAFETY: the caller's word.
    unsafe {
        let factor = V::splat(1.0 / scores.scale);
        for at in (0..whole).step_by(V::LANES) {
            V::load(bias.as_ptr().add(at)).mul_add(factor, V::load(values.add(at))).store(values.add(at));
        }
        for at in whole..scores.len {
            *values.add(at) += *bias.as_ptr().add(at * step) / scores.scale;
        }
    }
}

/// The sum of a row, with a bias whose values are 0 or 1 apart.
#[inline(always)]
unsafe fn row_of<V: Vector>(scores: &Scores, values: *mut f32, bias: Option<(&[f32], usize)>) -> f32 {
    // SAFETY: the caller's word.
    unsafe {
        let whole = scores.len / V::LANES * V::LANES;
        let left = scores.len - whole;
        let scale = V::splat(scores.scale);
        let bias_at = |at: usize| match bias {
            None => V::splat(0.0),
            Some((bias, 0)) => V::splat(*bias.as_ptr()),
            Some((bias, _)) => V::load(bias.as_ptr().add(at)),
        };
        let mut most = V::splat(f32::NEG_INFINITY);
        for at in (0..whole).step_by(V::LANES) {
            let value = V::load(values.add(at)).mul_add(scale, bias_at(at));
            value.store(values.add(at));
            most = value.max(most);
        }
        let mut largest = greatest(most);
        for at in whole..scores.len {
            let bias = bias.map_or(0.0, |(bias, step)| *bias.as_ptr().add(at * step));
            let value = *values.add(at) * scores.scale + bias;
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

/// The greatest of all lanes.
#[inline(always)]
unsafe fn greatest<V: Vector>(values: V) -> f32 {
    let mut lanes = [f32::NEG_INFINITY; 16];
    // SAFETY: no vector has more lanes.
    unsafe { values.store(lanes.as_mut_ptr()) };
    lanes[..V::LANES].iter().copied().fold(f32::NEG_INFINITY, f32::max)
}
