//! Sixteen channels of one picture and the components of its tiles: there and back, values and gradients.
//!
//! Pixels lie channel-last, so that a vector holds channels and no transform ever moves a lane.
//! Loops are written out: a closure would be compiled without the instructions of the function around it.

#![allow(clippy::needless_range_loop, reason = "see above")]

use super::super::transform::{Along, Input, InputGradient, POINTS, RESULTS, ResultGradient, Results, both};
use super::GROUP;
use crate::kernel::vector::Vector;

/// What is done with a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pass {
    /// 6×6 pixels become components: Bᵀ d B.
    Input,
    /// 4×4 results from their components: Aᵀ m A.
    Results,
    /// Components of 4×4 gradients of results: A g Aᵀ.
    ResultGradient,
    /// Components add to 6×6 gradients of pixels: B g Bᵀ.
    InputGradient,
}

/// Sixteen channels of one picture.
pub(in crate::kernel) struct Channels<'a> {
    pub(super) pass: Pass,
    /// `[y, x, 16]`, and one pixel more: zeros that stand outside, or what falls there.
    pub(super) pixels: *mut f32,
    /// Rows and columns.
    pub(super) size: [usize; 2],
    pub(super) dilation: usize,
    /// Whether the nearest pixel stands outside, rather than zeros.
    pub(super) edge: bool,
    /// Row and column of each tile's first result.
    pub(super) origins: &'a [[u32; 2]],
    /// The first tile's first component, 16 values for each tile.
    pub(super) components: *mut f32,
    /// Values from one component to the next.
    pub(super) step: usize,
}

/// Transforms all tiles of these channels.
///
/// # Safety
/// The pointers are good for what the sizes say; the processor has the instructions of `V`.
#[inline(always)]
pub(in crate::kernel) unsafe fn run<V: Vector>(channels: &Channels) {
    for (tile, &origin) in channels.origins.iter().enumerate() {
        // SAFETY: the caller's word.
        unsafe {
            let components = channels.components.add(tile * GROUP);
            match channels.pass {
                Pass::Input => gather::<Input, V, POINTS>(channels, origin, components),
                Pass::ResultGradient => gather::<ResultGradient, V, RESULTS>(channels, origin, components),
                Pass::Results => scatter::<Results, V, RESULTS, false>(channels, origin, components),
                Pass::InputGradient => scatter::<InputGradient, V, POINTS, true>(channels, origin, components),
            }
        }
    }
}

/// Where the `N`×`N` pixels of a tile lie: its results, or with a pixel more on each side what they are made of.
fn places<const N: usize>(channels: &Channels, origin: [u32; 2]) -> [[usize; N]; N] {
    let [height, width] = channels.size;
    let (before, edge) = (usize::from(N == POINTS) as isize, channels.edge && N == POINTS);
    let mut places = [[height * width * GROUP; N]; N];
    let inside = |axis: usize, i: usize| {
        let at = origin[axis] as isize + (i as isize - before) * channels.dilation as isize;
        let inside = at.clamp(0, channels.size[axis] as isize - 1);
        (inside == at || edge).then_some(inside as usize)
    };
    for (i, places) in places.iter_mut().enumerate() {
        for (j, place) in places.iter_mut().enumerate() {
            if let (Some(y), Some(x)) = (inside(0, i), inside(1, j)) {
                *place = (y * width + x) * GROUP;
            }
        }
    }
    places
}

#[inline(always)]
unsafe fn gather<T: Along<N, POINTS>, V: Vector, const N: usize>(
    channels: &Channels,
    origin: [u32; 2],
    components: *mut f32,
) {
    let places = places::<N>(channels, origin);
    // SAFETY: the caller's word.
    unsafe {
        for part in (0..GROUP).step_by(V::LANES) {
            let mut tile = [[V::splat(0.0); N]; N];
            for i in 0..N {
                for j in 0..N {
                    tile[i][j] = V::load(channels.pixels.add(places[i][j] + part));
                }
            }
            let tile = both::<T, V, N, POINTS>(&tile);
            for i in 0..POINTS {
                for j in 0..POINTS {
                    tile[i][j].store(components.add((i * POINTS + j) * channels.step + part));
                }
            }
        }
    }
}

#[inline(always)]
unsafe fn scatter<T: Along<POINTS, N>, V: Vector, const N: usize, const ADD: bool>(
    channels: &Channels,
    origin: [u32; 2],
    components: *mut f32,
) {
    let places = places::<N>(channels, origin);
    // SAFETY: the caller's word.
    unsafe {
        for part in (0..GROUP).step_by(V::LANES) {
            let mut tile = [[V::splat(0.0); POINTS]; POINTS];
            for i in 0..POINTS {
                for j in 0..POINTS {
                    tile[i][j] = V::load(components.add((i * POINTS + j) * channels.step + part));
                }
            }
            let tile = both::<T, V, POINTS, N>(&tile);
            for i in 0..N {
                for j in 0..N {
                    let to = channels.pixels.add(places[i][j] + part);
                    // One after the other: on the edge, several pixels of a tile are the same.
                    let value = if ADD { V::load(to).add(tile[i][j]) } else { tile[i][j] };
                    value.store(to);
                }
            }
        }
    }
}
