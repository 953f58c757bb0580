//! The three small matrices of F(4, 3) with the points 0, ±1, ±2, ∞, and their transposes for the gradients.
//!
//! Loops are written out: a closure would be compiled without the instructions of the function around it.

#![allow(clippy::needless_range_loop, reason = "see above")]

use crate::kernel::vector::Vector;

/// Products of one transform.
pub(super) const POINTS: usize = 6;
/// Results of one transform.
pub(super) const RESULTS: usize = 4;
/// Weights of one transform.
pub(super) const TAPS: usize = 3;

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

/// A transform along one axis: `I` values become `O`.
pub(super) trait Along<const I: usize, const O: usize> {
    /// # Safety
    /// The processor has the instructions of `V`.
    unsafe fn along<V: Vector>(values: [V; I]) -> [V; O];
}

/// Bᵀ: inputs to components.
pub(super) struct Input;
/// Aᵀ: sums of products to results.
pub(super) struct Results;
/// G: weights to components.
pub(super) struct Weights;
/// A: gradients of results to those of the sums.
pub(super) struct ResultGradient;
/// B: gradients of components to those of inputs.
pub(super) struct InputGradient;
/// Gᵀ: gradients of components to those of weights.
pub(super) struct WeightGradient;

impl Along<POINTS, POINTS> for Input {
    #[inline(always)]
    unsafe fn along<V: Vector>(d: [V; POINTS]) -> [V; POINTS] {
        // SAFETY: the caller's word.
        unsafe { of_input(d) }
    }
}

impl Along<POINTS, RESULTS> for Results {
    #[inline(always)]
    unsafe fn along<V: Vector>(m: [V; POINTS]) -> [V; RESULTS] {
        // SAFETY: the caller's word.
        unsafe { of_sums(m) }
    }
}

impl Along<TAPS, POINTS> for Weights {
    #[inline(always)]
    unsafe fn along<V: Vector>([a, b, c]: [V; TAPS]) -> [V; POINTS] {
        // SAFETY: the caller's word; no memory is touched.
        unsafe {
            let (sixth, minus_sixth) = (V::splat(1.0 / 6.0), V::splat(-1.0 / 6.0));
            let (ends, middle) = (a.add(c).mul(minus_sixth), b.mul(sixth));
            let (far, far_middle) = (a.mul(V::splat(1.0 / 24.0)).add(c.mul(sixth)), b.mul(V::splat(1.0 / 12.0)));
            let quarter = a.mul(V::splat(0.25));
            [quarter, ends.sub(middle), ends.add(middle), far.add(far_middle), far.sub(far_middle), c]
        }
    }
}

impl Along<RESULTS, POINTS> for ResultGradient {
    #[inline(always)]
    unsafe fn along<V: Vector>([a, b, c, d]: [V; RESULTS]) -> [V; POINTS] {
        // SAFETY: the caller's word; no memory is touched.
        unsafe {
            let (even, odd) = (a.add(c), b.add(d));
            let far = c.mul_add(V::splat(4.0), a);
            let far_odd = d.mul(V::splat(8.0)).add(b.add(b));
            [a, even.add(odd), even.sub(odd), far.add(far_odd), far.sub(far_odd), d]
        }
    }
}

impl Along<POINTS, POINTS> for InputGradient {
    #[inline(always)]
    unsafe fn along<V: Vector>(g: [V; POINTS]) -> [V; POINTS] {
        // SAFETY: the caller's word; no memory is touched.
        unsafe {
            let (two, four, minus_four, minus_five) = (V::splat(2.0), V::splat(4.0), V::splat(-4.0), V::splat(-5.0));
            let (near, near_odd) = (g[1].add(g[2]), g[1].sub(g[2]));
            let (far, far_odd) = (g[3].add(g[4]), g[3].sub(g[4]).mul(two));
            [
                g[0].mul(four),
                near_odd.mul_add(minus_four, g[5].mul(four)).sub(far_odd),
                g[0].mul_add(minus_five, near.mul(minus_four)).sub(far),
                g[5].mul_add(minus_five, near_odd).add(far_odd),
                g[0].add(near).add(far),
                g[5],
            ]
        }
    }
}

impl Along<POINTS, TAPS> for WeightGradient {
    #[inline(always)]
    unsafe fn along<V: Vector>(g: [V; POINTS]) -> [V; TAPS] {
        // SAFETY: the caller's word; no memory is touched.
        unsafe {
            let near = g[1].add(g[2]).mul(V::splat(-1.0 / 6.0));
            let (far, far_odd) = (g[3].add(g[4]), g[3].sub(g[4]));
            [
                g[0].mul_add(V::splat(0.25), near).add(far.mul(V::splat(1.0 / 24.0))),
                g[2].sub(g[1]).mul(V::splat(1.0 / 6.0)).add(far_odd.mul(V::splat(1.0 / 12.0))),
                far.mul_add(V::splat(1.0 / 6.0), near).add(g[5]),
            ]
        }
    }
}

/// A transform along both axes.
///
/// # Safety
/// The processor has the instructions of `V`.
#[inline(always)]
pub(super) unsafe fn both<T: Along<I, O>, V: Vector, const I: usize, const O: usize>(
    tile: &[[V; I]; I],
) -> [[V; O]; O] {
    // SAFETY: the caller's word; no memory is touched.
    unsafe {
        let mut half = [[V::splat(0.0); I]; O];
        for j in 0..I {
            let mut column = [V::splat(0.0); I];
            for i in 0..I {
                column[i] = tile[i][j];
            }
            let column = T::along(column);
            for i in 0..O {
                half[i][j] = column[i];
            }
        }
        let mut whole = [[V::splat(0.0); O]; O];
        for i in 0..O {
            whole[i] = T::along(half[i]);
        }
        whole
    }
}
