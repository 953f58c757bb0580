//! The three small matrices of F(4, 3) with the points 0, ±1, ±2, ∞.

use crate::kernel::vector::Vector;

/// Products of one transform.
pub(super) const POINTS: usize = 6;
/// Results of one transform.
pub(super) const RESULTS: usize = 4;

/// Six neighbouring inputs, transformed (Bᵀd).
///
/// # Safety
/// The processor has the instructions of `V`.
#[inline(always)]
pub(super) unsafe fn of_input<V: Vector>(d: [V; POINTS]) -> [V; POINTS] {
    // SAFETY: the caller's word; no memory is touched.
    unsafe {
        let (two, four, minus_four, minus_five) = (V::splat(2.0), V::splat(4.0), V::splat(-4.0), V::splat(-5.0));
        let (even, odd) = (d[2].mul_add(minus_four, d[4]), d[1].mul_add(minus_four, d[3]));
        let (near, far) = (d[4].sub(d[2]), d[3].sub(d[1]).mul(two));
        [
            d[0].mul_add(four, d[2].mul_add(minus_five, d[4])),
            even.add(odd),
            even.sub(odd),
            near.add(far),
            near.sub(far),
            d[1].mul_add(four, d[3].mul_add(minus_five, d[5])),
        ]
    }
}

/// Four results from six sums of products (Aᵀm).
///
/// # Safety
/// The processor has the instructions of `V`.
#[inline(always)]
pub(super) unsafe fn of_sums<V: Vector>(m: [V; POINTS]) -> [V; RESULTS] {
    // SAFETY: the caller's word; no memory is touched.
    unsafe {
        let (near, near_odd) = (m[1].add(m[2]), m[1].sub(m[2]));
        let (far, far_odd) = (m[3].add(m[4]), m[3].sub(m[4]));
        [
            m[0].add(near).add(far),
            far_odd.mul_add(V::splat(2.0), near_odd),
            far.mul_add(V::splat(4.0), near),
            far_odd.mul_add(V::splat(8.0), near_odd).add(m[5]),
        ]
    }
}

/// Three weights, transformed (Gg).
pub(super) fn of_weights(g: [f32; 3]) -> [f32; POINTS] {
    let [a, b, c] = g.map(f64::from);
    [a / 4.0, -(a + b + c) / 6.0, -(a - b + c) / 6.0, a / 24.0 + b / 12.0 + c / 6.0, a / 24.0 - b / 12.0 + c / 6.0, c]
        .map(|value| value as f32)
}
