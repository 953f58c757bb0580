//! The products of one component: tiles × channels matrices, forward and for both gradients.
//!
//! Everything lies in groups of 16 channels: values `[group][tile][16]`, weights `[group of results][channel][16]`.
//! Loops are written out: a closure would be compiled without the instructions of the function around it.

#![allow(clippy::needless_range_loop, reason = "see above")]

use super::GROUP;
use crate::kernel::vector::Vector;

/// Tiles come in whole multiples of it.
pub(super) const TILES: usize = 8;

/// One component of all tiles.
pub(in crate::kernel) struct Products {
    /// Groups of channels on either side.
    pub(super) groups: [usize; 2],
    /// Tiles, a multiple of [`TILES`].
    pub(super) tiles: usize,
    /// `[group in][tile][16]`
    pub(super) inputs: *const f32,
    /// `[group out][channel in][16]`; read forward, added to by the weight gradient.
    pub(super) weights: *mut f32,
    /// `[group out][tile][16]`; written forward, read by the weight gradient.
    pub(super) results: *mut f32,
}

/// results = inputs · weights.
///
/// # Safety
/// The pointers are good for what the sizes say; the processor has the instructions of `V`.
#[inline(always)]
pub(in crate::kernel) unsafe fn forward<V: Vector>(products: &Products) {
    let mut group = 0;
    // SAFETY: the caller's word.
    unsafe {
        while group < products.groups[1] {
            let count = together::<V>(products.groups[1] - group);
            for tile in (0..products.tiles).step_by(TILES) {
                match (V::LANES >= GROUP, count) {
                    (true, 3) => rows::<V, 3, 8>(products, group, tile),
                    (true, 2) => rows::<V, 2, 8>(products, group, tile),
                    (true, _) => rows::<V, 1, 8>(products, group, tile),
                    (false, _) => {
                        rows::<V, 2, 4>(products, group, tile);
                        rows::<V, 2, 4>(products, group, tile + 4);
                    }
                }
            }
            group += count;
        }
    }
}

/// weights += inputsᵀ · results.
///
/// # Safety
/// As of [`forward`].
#[inline(always)]
pub(in crate::kernel) unsafe fn weight_gradient<V: Vector>(products: &Products) {
    let mut group = 0;
    // SAFETY: the caller's word.
    unsafe {
        while group < products.groups[1] {
            let count = together::<V>(products.groups[1] - group);
            for channel in (0..products.groups[0] * GROUP).step_by(8) {
                match (V::LANES >= GROUP, count) {
                    (true, 3) => outer::<V, 3, 8>(products, group, channel),
                    (true, 2) => outer::<V, 2, 8>(products, group, channel),
                    (true, _) => outer::<V, 1, 8>(products, group, channel),
                    (false, _) => {
                        outer::<V, 2, 4>(products, group, channel);
                        outer::<V, 2, 4>(products, group, channel + 4);
                    }
                }
            }
            group += count;
        }
    }
}

/// Groups of results that are computed together, of so many that are left: 3 and 2 rather than 3 and 1.
fn together<V: Vector>(left: usize) -> usize {
    match left {
        _ if V::LANES < GROUP => 1,
        4 => 2,
        left => left.min(3),
    }
}

/// `N` vectors of results from `group` on, for `ROWS` tiles.
#[inline(always)]
unsafe fn rows<V: Vector, const N: usize, const ROWS: usize>(products: &Products, group: usize, tile: usize) {
    let Products { groups: [groups_in, _], tiles, .. } = *products;
    let parts = GROUP / V::LANES;
    // SAFETY: the caller's word.
    unsafe {
        let mut weights = [products.weights.cast_const(); N];
        for n in 0..N {
            weights[n] = weights[n].add((group + n / parts) * groups_in * GROUP * GROUP + n % parts * V::LANES);
        }
        let mut sums = [[V::splat(0.0); N]; ROWS];
        for g in 0..groups_in {
            let inputs = products.inputs.add((g * tiles + tile) * GROUP);
            for channel in 0..GROUP {
                let mut vectors = [V::splat(0.0); N];
                for n in 0..N {
                    vectors[n] = V::load(weights[n].add((g * GROUP + channel) * GROUP));
                }
                for t in 0..ROWS {
                    let input = V::splat(*inputs.add(t * GROUP + channel));
                    for n in 0..N {
                        sums[t][n] = vectors[n].mul_add(input, sums[t][n]);
                    }
                }
            }
        }
        for t in 0..ROWS {
            for n in 0..N {
                let at = ((group + n / parts) * tiles + tile + t) * GROUP + n % parts * V::LANES;
                sums[t][n].store(products.results.add(at));
            }
        }
    }
}

/// `N` vectors of output channels from `group` on, for `ROWS` input channels: sums over all tiles.
#[inline(always)]
unsafe fn outer<V: Vector, const N: usize, const ROWS: usize>(products: &Products, group: usize, channel: usize) {
    let Products { groups: [groups_in, _], tiles, .. } = *products;
    let parts = GROUP / V::LANES;
    // SAFETY: the caller's word.
    unsafe {
        let mut gradients = [products.results.cast_const(); N];
        let mut weights = [products.weights; N];
        for n in 0..N {
            let part = n % parts * V::LANES;
            gradients[n] = gradients[n].add((group + n / parts) * tiles * GROUP + part);
            weights[n] = weights[n].add(((group + n / parts) * groups_in * GROUP + channel) * GROUP + part);
        }
        let inputs = products.inputs.add(channel / GROUP * tiles * GROUP + channel % GROUP);
        let mut sums = [[V::splat(0.0); N]; ROWS];
        for c in 0..ROWS {
            for n in 0..N {
                sums[c][n] = V::load(weights[n].add(c * GROUP));
            }
        }
        for tile in 0..tiles {
            let mut vectors = [V::splat(0.0); N];
            for n in 0..N {
                vectors[n] = V::load(gradients[n].add(tile * GROUP));
            }
            for c in 0..ROWS {
                let input = V::splat(*inputs.add(tile * GROUP + c));
                for n in 0..N {
                    sums[c][n] = vectors[n].mul_add(input, sums[c][n]);
                }
            }
        }
        for c in 0..ROWS {
            for n in 0..N {
                sums[c][n].store(weights[n].add(c * GROUP));
            }
        }
    }
}
