//! The products of one component: tiles × channels matrices, forward and for both gradients.
//!
//! Everything lies in groups of 16 channels: values `[group][tile][16]`, weights `[group of results][row][16]`, one row for
//! each channel of the sources.
//! Loops are written out: a closure would be compiled without the instructions of the function around it.

#![allow(clippy::needless_range_loop, reason = "see above")]

use super::GROUP;
use crate::kernel::vector::Vector;

/// Tiles come in whole multiples of it, and the rows of a source's weights too.
pub(super) const TILES: usize = 8;

/// A few neighbouring channels that are read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source {
    /// `[tile]`, 16 values apart.
    pub(super) values: *const f32,
    pub(super) channels: usize,
    /// The row of the first one's weights.
    pub(super) row: usize,
}

/// One component of all tiles.
pub(in crate::kernel) struct Products<'a> {
    pub(super) sources: &'a [Source],
    /// `[group][row][16]`; read forward, added to by the weight gradient.
    pub(super) weights: *mut f32,
    /// Rows of a group's weights.
    pub(super) rows: usize,
    /// Groups of results.
    pub(super) groups: usize,
    /// Tiles, a multiple of [`TILES`].
    pub(super) tiles: usize,
    /// `[group][tile][16]`; written forward, read by the weight gradient.
    pub(super) results: *mut f32,
}

/// results = sources · weights.
///
/// # Safety
/// The pointers are good for what the sizes say; the processor has the instructions of `V`.
#[inline(always)]
pub(in crate::kernel) unsafe fn forward<V: Vector>(products: &Products) {
    let mut group = 0;
    // SAFETY: the caller's word.
    unsafe {
        while group < products.groups {
            let count = together::<V>(products.groups - group);
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

/// weights += sourcesᵀ · results.
///
/// # Safety
/// As of [`forward`].
#[inline(always)]
pub(in crate::kernel) unsafe fn weight_gradient<V: Vector>(products: &Products) {
    let mut group = 0;
    // SAFETY: the caller's word.
    unsafe {
        while group < products.groups {
            let count = together::<V>(products.groups - group);
            for source in products.sources {
                for channel in (0..source.channels).step_by(8) {
                    match (V::LANES >= GROUP, count) {
                        (true, 3) => outer::<V, 3, 8>(products, group, source, channel),
                        (true, 2) => outer::<V, 2, 8>(products, group, source, channel),
                        (true, _) => outer::<V, 1, 8>(products, group, source, channel),
                        (false, _) => {
                            outer::<V, 2, 4>(products, group, source, channel);
                            outer::<V, 2, 4>(products, group, source, channel + 4);
                        }
                    }
                }
            }
            group += count;
        }
    }
}

/// Groups of results that are computed together, of so many that are left: 2 and 2 rather than 3 and 1.
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
    let parts = GROUP / V::LANES;
    // SAFETY: the caller's word.
    unsafe {
        let mut sums = [[V::splat(0.0); N]; ROWS];
        for source in products.sources {
            let mut weights = [products.weights.cast_const(); N];
            for n in 0..N {
                let row = (group + n / parts) * products.rows + source.row;
                weights[n] = weights[n].add(row * GROUP + n % parts * V::LANES);
            }
            let values = source.values.add(tile * GROUP);
            for channel in 0..source.channels {
                let mut vectors = [V::splat(0.0); N];
                for n in 0..N {
                    vectors[n] = V::load(weights[n].add(channel * GROUP));
                }
                for t in 0..ROWS {
                    let value = V::splat(*values.add(t * GROUP + channel));
                    for n in 0..N {
                        sums[t][n] = vectors[n].mul_add(value, sums[t][n]);
                    }
                }
            }
        }
        for t in 0..ROWS {
            for n in 0..N {
                let at = ((group + n / parts) * products.tiles + tile + t) * GROUP + n % parts * V::LANES;
                sums[t][n].store(products.results.add(at));
            }
        }
    }
}

/// `N` vectors of results from `group` on, for `ROWS` channels of a source: sums over all tiles.
#[inline(always)]
unsafe fn outer<V: Vector, const N: usize, const ROWS: usize>(
    products: &Products,
    group: usize,
    source: &Source,
    channel: usize,
) {
    let parts = GROUP / V::LANES;
    // SAFETY: the caller's word.
    unsafe {
        let mut gradients = [products.results.cast_const(); N];
        let mut weights = [products.weights; N];
        for n in 0..N {
            let part = n % parts * V::LANES;
            gradients[n] = gradients[n].add((group + n / parts) * products.tiles * GROUP + part);
            let row = (group + n / parts) * products.rows + source.row + channel;
            weights[n] = weights[n].add(row * GROUP + part);
        }
        let values = source.values.add(channel);
        let mut sums = [[V::splat(0.0); N]; ROWS];
        for c in 0..ROWS {
            for n in 0..N {
                sums[c][n] = V::load(weights[n].add(c * GROUP));
            }
        }
        for tile in 0..products.tiles {
            let mut vectors = [V::splat(0.0); N];
            for n in 0..N {
                vectors[n] = V::load(gradients[n].add(tile * GROUP));
            }
            for c in 0..ROWS {
                let value = V::splat(*values.add(tile * GROUP + c));
                for n in 0..N {
                    sums[c][n] = vectors[n].mul_add(value, sums[c][n]);
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
