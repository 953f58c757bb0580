//! A few tiles of 4×4 results of one layer: transformed, multiplied, transformed back. Activations lie channel-last, so
//! that a vector holds channels and no transform ever moves a lane.
//!
//! Loops are written out: a closure would be compiled without the instructions of the function around it.

#![allow(clippy::needless_range_loop, reason = "see above")]

use super::transform::{POINTS, RESULTS, of_input, of_sums};
use crate::kernel::tile::{Activation, activate};
use crate::kernel::vector::Vector;

/// Channels that lie together in the packed weights.
pub(super) const GROUP: usize = 16;
/// Tiles that are multiplied together.
pub(super) const TOGETHER: usize = 6;
/// Tiles of a block: its transformed inputs stay in the second-level cache.
pub(super) const TILES: usize = 24;
/// Components of a transformed tile.
pub(super) const COMPONENTS: usize = POINTS * POINTS;

/// Tiles of one layer.
#[derive(Clone, Copy)]
pub(in crate::kernel) struct Tiles<'a> {
    /// Input `[y, x, c]`.
    pub(super) x: *const f32,
    /// Result `[y, x, c]`.
    pub(super) out: *mut f32,
    /// Rows and columns.
    pub(super) size: [usize; 2],
    pub(super) channels: [usize; 2],
    pub(super) dilation: usize,
    /// A pixel of zeros, where zeros stand outside; else null.
    pub(super) outside: *const f32,
    /// Packed weights `[component][c_out / 16][c_in][16]`.
    pub(super) weights: &'a [f32],
    pub(super) bias: &'a [f32],
    pub(super) activation: Activation,
    /// Whether the input is added behind the activation.
    pub(super) is_residual: bool,
    /// Row and column of each tile's first result, at most [`TILES`].
    pub(super) origins: &'a [[u32; 2]],
}

// SAFETY: whoever computes tiles answers for disjoint places of the result.
unsafe impl Send for Tiles<'_> {}
// SAFETY: as above.
unsafe impl Sync for Tiles<'_> {}

/// Values of a block's scratch memory from one component to the next, for tiles of at most `channels`.
fn component_step(channels: [usize; 2]) -> usize {
    // One line more, lest all components of a tile fall into one set of the cache.
    TILES * row_step(channels) + 16
}

fn row_step(channels: [usize; 2]) -> usize {
    channels[0].max(channels[1])
}

/// Values of scratch memory that a block needs.
pub(super) fn scratch_len(channels: [usize; 2]) -> usize {
    COMPONENTS * component_step(channels) + TOGETHER * row_step(channels)
}

/// Computes the tiles.
///
/// # Safety
/// The pointers are good for what the sizes say, `scratch` for [`scratch_len`]; the processor has the instructions of `V`.
#[inline(always)]
pub(in crate::kernel) unsafe fn run<V: Vector>(tiles: &Tiles, scratch: *mut f32) {
    let (step, rows) = (component_step(tiles.channels), row_step(tiles.channels));
    // SAFETY: the caller's word.
    unsafe {
        for (i, origin) in tiles.origins.iter().enumerate() {
            transform_input::<V>(tiles, *origin, scratch.add(i * rows), step);
        }
        let results = scratch.add(COMPONENTS * step);
        for component in 0..COMPONENTS {
            let weights = tiles.weights.as_ptr().add(component * tiles.channels[0] * tiles.channels[1]);
            for first in (0..tiles.origins.len()).step_by(TOGETHER) {
                let inputs = scratch.add(component * step + first * rows);
                multiply::<V>(tiles.channels, rows, inputs, weights, results);
                // Sums take the place of the inputs they were made of.
                std::ptr::copy_nonoverlapping(results, inputs, TOGETHER.min(TILES - first) * rows);
            }
        }
        for (i, origin) in tiles.origins.iter().enumerate() {
            transform_output::<V>(tiles, *origin, scratch.add(i * rows), step);
        }
    }
}

/// Where transformed tiles lie: a tile in every `rows` values, a component of all in every `step`.
#[derive(Clone, Copy)]
pub(in crate::kernel) struct Transformed {
    pub(super) first: *mut f32,
    pub(super) rows: usize,
    pub(super) step: usize,
}

/// Transforms the inputs of all tiles.
///
/// # Safety
/// The pointers are good for what the sizes say; the processor has the instructions of `V`.
#[inline(always)]
pub(in crate::kernel) unsafe fn enter<V: Vector>(tiles: &Tiles, to: Transformed) {
    for (i, origin) in tiles.origins.iter().enumerate() {
        // SAFETY: the caller's word.
        unsafe { transform_input::<V>(tiles, *origin, to.first.add(i * to.rows), to.step) };
    }
}

/// The results of all tiles from their sums.
///
/// # Safety
/// As [`enter`].
#[inline(always)]
pub(in crate::kernel) unsafe fn leave<V: Vector>(tiles: &Tiles, from: Transformed) {
    for (i, origin) in tiles.origins.iter().enumerate() {
        // SAFETY: the caller's word.
        unsafe { transform_output::<V>(tiles, *origin, from.first.add(i * from.rows), from.step) };
    }
}

/// One component of `count` tiles, `rows` values from tile to tile in inputs and sums; both have room for whole
/// [`TOGETHER`].
pub(in crate::kernel) struct Component {
    pub(super) channels: [usize; 2],
    pub(super) rows: usize,
    pub(super) count: usize,
    pub(super) from: *const f32,
    pub(super) weights: *const f32,
    pub(super) to: *mut f32,
}

/// Sums over the input channels for all tiles of one component: some channels of the result at a time, so that their
/// weights stay in the fastest cache.
///
/// # Safety
/// As [`enter`].
#[inline(always)]
pub(in crate::kernel) unsafe fn component<V: Vector>(component: &Component) {
    let Component { channels: [c_in, c_out], rows, count, from, weights, to } = *component;
    let groups = c_out / GROUP;
    let mut group = 0;
    while group < groups {
        let wide = V::LANES == GROUP && groups - group >= 4;
        for first in (0..count).step_by(TOGETHER) {
            // SAFETY: the caller's word.
            unsafe {
                let (from, to) = (from.add(first * rows), to.add(first * rows + group * GROUP));
                let weights = weights.add(group * c_in * GROUP);
                match (wide, V::LANES == GROUP) {
                    (true, _) => sums::<V, 4>(c_in, rows, from, weights, 1, to),
                    (_, true) => sums::<V, 1>(c_in, rows, from, weights, 1, to),
                    _ => sums::<V, 2>(c_in, rows, from, weights, GROUP / V::LANES, to),
                }
            }
        }
        group += if wide { 4 } else { 1 };
    }
}

/// 6×6 pixels of the input around a tile, transformed, one component in every `step` values of `to`.
#[inline(always)]
unsafe fn transform_input<V: Vector>(tiles: &Tiles, origin: [u32; 2], to: *mut f32, step: usize) {
    let pixel = |i: usize, j: usize| {
        let [y, x] =
            [(0, i), (1, j)].map(|(axis, i)| origin[axis] as isize + (i as isize - 1) * tiles.dilation as isize);
        let inside = [(0, y), (1, x)].map(|(axis, at)| at.clamp(0, tiles.size[axis] as isize - 1));
        if inside != [y, x] && !tiles.outside.is_null() {
            return tiles.outside;
        }
        tiles.x.wrapping_add((inside[0] as usize * tiles.size[1] + inside[1] as usize) * tiles.channels[0])
    };
    let mut pixels = [[std::ptr::null(); POINTS]; POINTS];
    for (i, row) in pixels.iter_mut().enumerate() {
        for (j, place) in row.iter_mut().enumerate() {
            *place = pixel(i, j);
        }
    }
    // SAFETY: the caller's word: pixels have `c_in` values, `to` has room for every component.
    unsafe {
        for channel in (0..tiles.channels[0]).step_by(V::LANES) {
            let mut half = [[V::splat(0.0); POINTS]; POINTS];
            for j in 0..POINTS {
                let mut column = [V::splat(0.0); POINTS];
                for i in 0..POINTS {
                    column[i] = V::load(pixels[i][j].add(channel));
                }
                column = of_input(column);
                for i in 0..POINTS {
                    half[i][j] = column[i];
                }
            }
            for i in 0..POINTS {
                let row = of_input(half[i]);
                for j in 0..POINTS {
                    row[j].store(to.add((i * POINTS + j) * step + channel));
                }
            }
        }
    }
}

/// Sums over the input channels for [`TOGETHER`] tiles of one component.
#[inline(always)]
unsafe fn multiply<V: Vector>(
    [c_in, c_out]: [usize; 2],
    rows: usize,
    inputs: *const f32,
    weights: *const f32,
    to: *mut f32,
) {
    let group_vectors = GROUP / V::LANES;
    let groups = c_out / GROUP;
    // SAFETY: the caller's word.
    unsafe {
        let group = |group: usize| weights.add(group * c_in * GROUP);
        if V::LANES < GROUP {
            for g in 0..groups {
                sums::<V, 2>(c_in, rows, inputs, group(g), group_vectors, to.add(g * GROUP));
            }
            return;
        }
        let wide = groups / 4 * 4;
        for g in (0..wide).step_by(4) {
            sums::<V, 4>(c_in, rows, inputs, group(g), 1, to.add(g * GROUP));
        }
        for g in wide..groups {
            sums::<V, 1>(c_in, rows, inputs, group(g), 1, to.add(g * GROUP));
        }
    }
}

/// `N` vectors of output channels, for [`TOGETHER`] tiles; a group of 16 channels fills `group_vectors` vectors.
#[inline(always)]
unsafe fn sums<V: Vector, const N: usize>(
    c_in: usize,
    rows: usize,
    inputs: *const f32,
    weights: *const f32,
    group_vectors: usize,
    to: *mut f32,
) {
    // SAFETY: the caller's word.
    unsafe {
        let mut sums = [[V::splat(0.0); N]; TOGETHER];
        for channel in 0..c_in {
            let mut vectors = [V::splat(0.0); N];
            for (n, vector) in vectors.iter_mut().enumerate() {
                let (group, part) = (n / group_vectors, n % group_vectors);
                *vector = V::load(weights.add((group * c_in + channel) * GROUP + part * V::LANES));
            }
            for (t, sums) in sums.iter_mut().enumerate() {
                let input = V::splat(*inputs.add(t * rows + channel));
                for n in 0..N {
                    sums[n] = vectors[n].mul_add(input, sums[n]);
                }
            }
        }
        for (t, sums) in sums.iter().enumerate() {
            for (n, sum) in sums.iter().enumerate() {
                sum.store(to.add(t * rows + n * V::LANES));
            }
        }
    }
}

/// The 4×4 results of a tile from its sums, as many as are inside the picture.
#[inline(always)]
unsafe fn transform_output<V: Vector>(tiles: &Tiles, origin: [u32; 2], from: *const f32, step: usize) {
    let [y, x] = origin.map(|at| at as usize);
    let c_out = tiles.channels[1];
    // SAFETY: the caller's word; only pixels inside the picture are written.
    unsafe {
        for channel in (0..c_out).step_by(V::LANES) {
            let bias = V::load(tiles.bias.as_ptr().add(channel));
            let mut half = [[V::splat(0.0); POINTS]; RESULTS];
            for j in 0..POINTS {
                let mut column = [V::splat(0.0); POINTS];
                for i in 0..POINTS {
                    column[i] = V::load(from.add((i * POINTS + j) * step + channel));
                }
                let column = of_sums(column);
                for i in 0..RESULTS {
                    half[i][j] = column[i];
                }
            }
            for i in 0..RESULTS {
                let (y, row) = (y + i * tiles.dilation, of_sums(half[i]));
                for j in 0..RESULTS {
                    let x = x + j * tiles.dilation;
                    if y < tiles.size[0] && x < tiles.size[1] {
                        let at = (y * tiles.size[1] + x) * c_out + channel;
                        let mut value = activate(row[j].add(bias), tiles.activation);
                        if tiles.is_residual {
                            value = value.add(V::load(tiles.x.add(at)));
                        }
                        value.store(tiles.out.add(at));
                    }
                }
            }
        }
    }
}
