//! Sixteen channels of one picture and the components of its tiles: there and back, values and gradients.
//!
//! Pixels lie channel-last, so that a vector holds channels and no transform ever moves a lane.
//! Loops are written out: a closure would be compiled without the instructions of the function around it.

#![allow(clippy::needless_range_loop, reason = "see above")]

use super::super::plane::firsts;
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
    /// Where the tiles lie.
    pub(super) places: &'a Places,
    /// The first tile's first component, 16 values for each tile.
    pub(super) components: *mut f32,
    /// Values from one component to the next.
    pub(super) step: usize,
}

/// Where the pixels of all tiles of a picture lie, `[y, x, 16]`.
pub(super) struct Places {
    /// For each row and each column of tiles, those of its results.
    results: [Vec<[u32; RESULTS]>; 2],
    /// Those that the results are made of.
    inputs: [Vec<[u32; POINTS]>; 2],
    /// What stands outside.
    outside: u32,
}

impl Places {
    /// With `edge`, the nearest pixel stands outside.
    pub(super) fn new(size: [usize; 2], dilation: usize, edge: bool) -> Self {
        let outside = (size[0] * size[1] * GROUP) as u32;
        let step = [size[1] * GROUP, GROUP];
        let place = |axis: usize, at: isize, edge: bool| {
            let inside = at.clamp(0, size[axis] as isize - 1);
            if inside == at || edge { (inside as usize * step[axis]) as u32 } else { outside }
        };
        let first = |axis: usize| firsts(size[axis], dilation).into_iter().map(|at| at as isize);
        let d = dilation as isize;
        let result = |axis: usize, at: isize| [0, 1, 2, 3].map(|i| place(axis, at + i * d, false));
        let input = |axis: usize, at: isize| [-1, 0, 1, 2, 3, 4].map(|i| place(axis, at + i * d, edge));
        Self {
            results: [0, 1].map(|axis| first(axis).map(|at| result(axis, at)).collect()),
            inputs: [0, 1].map(|axis| first(axis).map(|at| input(axis, at)).collect()),
            outside,
        }
    }

    /// The `row`-th row of tiles of a picture, in a strip of six rows: of inputs the ones round the tiles, of results the
    /// tiles' four and two that stand for nothing.
    pub(super) fn strip([height, width]: [usize; 2], row: usize, edge: bool) -> Self {
        let columns = Self::new([1, width], 1, edge);
        let (step, outside) = ((width * GROUP) as u32, (POINTS * width * GROUP) as u32);
        let result = |i: usize| if RESULTS * row + i < height { i as u32 * step } else { outside };
        let input = |i: usize| match RESULTS * row + i {
            0 if edge => step,
            at if (1..=height).contains(&at) => i as u32 * step,
            at if at > height && edge => (height - RESULTS * row) as u32 * step,
            _ => outside,
        };
        // Columns that stand outside of one row must do so for all rows.
        let wide = |at: u32| if at == columns.outside { outside } else { at };
        let results = columns.results[1].iter().map(|c| c.map(wide));
        let inputs = columns.inputs[1].iter().map(|c| c.map(wide));
        Self {
            results: [vec![[0, 1, 2, 3].map(result)], results.collect()],
            inputs: [vec![[0, 1, 2, 3, 4, 5].map(input)], inputs.collect()],
            outside,
        }
    }

    /// Tiles of a picture.
    pub(super) fn tiles(&self) -> usize {
        self.results[0].len() * self.results[1].len()
    }
}

/// Transforms all tiles of these channels.
///
/// # Safety
/// The pointers are good for what the sizes say; the processor has the instructions of `V`.
#[inline(always)]
pub(in crate::kernel) unsafe fn run<V: Vector>(channels: &Channels) {
    // A macro, as a function that took `gather` or `scatter` would call them without the instructions of this one.
    macro_rules! each_tile {
        ($axes:ident, $n:ident, $f:expr) => {{
            let ([rows, columns], mut components) = (&channels.places.$axes, channels.components);
            for row in rows {
                for column in columns {
                    let mut places = [[0; $n]; $n];
                    for i in 0..$n {
                        for j in 0..$n {
                            places[i][j] = (row[i] + column[j]).min(channels.places.outside);
                        }
                    }
                    $f(channels, &places, components);
                    components = components.add(GROUP);
                }
            }
        }};
    }
    // SAFETY: the caller's word.
    unsafe {
        match channels.pass {
            Pass::Input => each_tile!(inputs, POINTS, gather::<Input, V, POINTS>),
            Pass::ResultGradient => each_tile!(results, RESULTS, gather::<ResultGradient, V, RESULTS>),
            Pass::Results => each_tile!(results, RESULTS, scatter::<Results, V, RESULTS, false>),
            Pass::InputGradient => each_tile!(inputs, POINTS, scatter::<InputGradient, V, POINTS, true>),
        }
    }
}

#[inline(always)]
unsafe fn gather<T: Along<N, POINTS>, V: Vector, const N: usize>(
    channels: &Channels,
    places: &[[u32; N]; N],
    components: *mut f32,
) {
    // SAFETY: the caller's word.
    unsafe {
        for part in (0..GROUP).step_by(V::LANES) {
            let mut tile = [[V::splat(0.0); N]; N];
            for i in 0..N {
                for j in 0..N {
                    tile[i][j] = V::load(channels.pixels.add(places[i][j] as usize + part));
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
    places: &[[u32; N]; N],
    components: *mut f32,
) {
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
                    let to = channels.pixels.add(places[i][j] as usize + part);
                    // One after the other: on the edge, several pixels of a tile are the same.
                    let value = if ADD { V::load(to).add(tile[i][j]) } else { tile[i][j] };
                    value.store(to);
                }
            }
        }
    }
}
