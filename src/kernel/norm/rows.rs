//! The loops over one row, for any vector type. All slices of a call have the same length.

use super::Channel;
use crate::kernel::ending::Limits;
use crate::kernel::tile::{self, Activation};
use crate::kernel::vector::{Vector, elu, elu_slope};

/// Calls `$body` with the start and the number of values of each vector of a row of `$len`.
macro_rules! for_vectors {
    ($vector:ty, $len:expr, |$at:ident, $n:ident| $body:block) => {
        let mut $at = 0;
        while $at < $len {
            let $n = ($len - $at).min(<$vector>::LANES);
            $body
            $at += <$vector>::LANES;
        }
    };
}

#[inline(always)]
unsafe fn load<V: Vector>(values: &[f32], at: usize, n: usize) -> V {
    // SAFETY: `at + n` ≤ length.
    unsafe {
        let from = values.as_ptr().add(at);
        if n == V::LANES { V::load(from) } else { V::load_first(from, n) }
    }
}

#[inline(always)]
unsafe fn store<V: Vector>(values: *mut f32, at: usize, n: usize, vector: V) {
    // SAFETY: the caller's word: `at + n` ≤ length.
    unsafe {
        let to = values.add(at);
        if n == V::LANES { vector.store(to) } else { vector.store_first(to, n) }
    }
}

/// Σ x and Σ x².
#[inline(always)]
pub(in crate::kernel) unsafe fn sum_and_squares<V: Vector>(values: &[f32]) -> [f64; 2] {
    // SAFETY: the processor has the instructions (caller's word); the rest is bounds-checked by the loop.
    unsafe {
        let (mut sum, mut squares) = (V::splat(0.0), V::splat(0.0));
        for_vectors!(V, values.len(), |at, n| {
            let x: V = load(values, at, n);
            sum = sum.add(x);
            squares = x.mul_add(x, squares);
        });
        [f64::from(sum.sum()), f64::from(squares.sum())]
    }
}

/// Σ a·b.
#[inline(always)]
pub(in crate::kernel) unsafe fn dot<V: Vector>(a: &[f32], b: &[f32]) -> f32 {
    // SAFETY: as above.
    unsafe {
        let mut sum = V::splat(0.0);
        for_vectors!(V, a.len(), |at, n| {
            sum = load::<V>(a, at, n).mul_add(load(b, at, n), sum);
        });
        sum.sum()
    }
}

/// An activation, in place.
#[inline(always)]
pub(in crate::kernel) unsafe fn activate<V: Vector>(values: &mut [f32], activation: Activation) {
    // SAFETY: as above.
    unsafe {
        for_vectors!(V, values.len(), |at, n| {
            let x: V = load(values, at, n);
            let y = tile::activate(x, activation);
            store(values.as_mut_ptr(), at, n, y);
        });
    }
}

/// Adds a summand, if there is one, and keeps the sums within limits.
#[inline(always)]
pub(in crate::kernel) unsafe fn end_row<V: Vector>(values: &mut [f32], summand: &[f32], limits: Limits) {
    // SAFETY: as above; a summand has as many values.
    unsafe {
        for_vectors!(V, values.len(), |at, n| {
            let mut x: V = load(values, at, n);
            if !summand.is_empty() {
                x = x.add(load(summand, at, n));
            }
            x = V::splat(limits.high).min(V::splat(limits.low).max(x));
            store(values.as_mut_ptr(), at, n, x);
        });
    }
}

/// `y = elu(scale·z + shift)`; `y` has room for as many values as `z`.
#[inline(always)]
pub(in crate::kernel) unsafe fn elu_row<V: Vector>(z: &[f32], y: *mut f32, scale: f32, shift: f32) {
    // SAFETY: as above.
    unsafe {
        for_vectors!(V, z.len(), |at, n| {
            let x = load::<V>(z, at, n).mul_add(V::splat(scale), V::splat(shift));
            store(y, at, n, elu(x));
        });
    }
}

/// Σ g and Σ g·z for `g = gy·elu'(scale·z + shift)`.
#[inline(always)]
pub(in crate::kernel) unsafe fn elu_gradient_sums<V: Vector>(
    z: &[f32],
    gy: &[f32],
    scale: f32,
    shift: f32,
) -> [f64; 2] {
    // SAFETY: as above.
    unsafe {
        let (mut sum, mut product) = (V::splat(0.0), V::splat(0.0));
        for_vectors!(V, z.len(), |at, n| {
            let z: V = load(z, at, n);
            let g = load::<V>(gy, at, n).mul(elu_slope(z.mul_add(V::splat(scale), V::splat(shift))));
            sum = sum.add(g);
            product = g.mul_add(z, product);
        });
        [f64::from(sum.sum()), f64::from(product.sum())]
    }
}

/// `gz = k0·g + k1·z + k2` for the same `g`.
#[inline(always)]
pub(in crate::kernel) unsafe fn elu_gradient_row<V: Vector>(z: &[f32], gy: &[f32], gz: &mut [f32], channel: Channel) {
    let Channel { scale, shift, k } = channel;
    // SAFETY: as above.
    unsafe {
        for_vectors!(V, z.len(), |at, n| {
            let z: V = load(z, at, n);
            let g = load::<V>(gy, at, n).mul(elu_slope(z.mul_add(V::splat(scale), V::splat(shift))));
            let rest = z.mul_add(V::splat(k[1]), V::splat(k[2]));
            store(gz.as_mut_ptr(), at, n, g.mul_add(V::splat(k[0]), rest));
        });
    }
}
