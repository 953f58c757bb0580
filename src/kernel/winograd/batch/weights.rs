//! Weights to components, and gradients of components to those of weights: 16 channels at a time.

#![allow(clippy::needless_range_loop, reason = "closures would be compiled without the function's instructions")]

use rayon::prelude::*;

use super::super::transform::{POINTS, TAPS, WeightGradient, Weights, both};
use super::GROUP;
use super::components::Components;
use crate::kernel::isa::{Isa, on_isa};
use crate::kernel::padded::SendPtr;
use crate::kernel::vector::Vector;

/// The weights between one channel and a group of 16 others.
pub(in crate::kernel) struct GroupWeights {
    /// Nine taps of each pair of channels.
    pub(super) taps: *mut f32,
    /// Values between the channels of the group.
    pub(super) lane_step: usize,
    /// Channels of the group that exist.
    pub(super) lanes: usize,
    /// The first of the components, 16 values each.
    pub(super) components: *mut f32,
    /// Values from one component to the next.
    pub(super) step: usize,
}

/// Room for the components of weights between channels `[from, to]`: a group for 16 of `to`, a "tile" for each of `from`.
pub(super) fn room([from, to]: [usize; 2]) -> Components {
    Components::new(to.div_ceil(GROUP), from.next_multiple_of(GROUP))
}

/// Components of `weights` `[to, from, 9]`.
pub(super) fn forward(isa: Isa, weights: &[f32], channels: [usize; 2]) -> Components {
    let components = room(channels);
    each(&components, weights.as_ptr().cast_mut(), channels, [1, channels[0]], |weights| {
        on_isa!(isa, winograd_weights(&weights));
    });
    components
}

/// Components of `weights` `[to, from, 9]`, for the way back: groups are of `from`.
pub(super) fn back(isa: Isa, weights: &[f32], [from, to]: [usize; 2]) -> Components {
    let components = room([to, from]);
    each(&components, weights.as_ptr().cast_mut(), [to, from], [from, 1], |weights| {
        on_isa!(isa, winograd_weights(&weights));
    });
    components
}

/// The weights' gradient `[to, from, 9]` from that of their components.
pub(super) fn gradient(isa: Isa, components: &Components, channels: [usize; 2]) -> Vec<f32> {
    let mut weights = vec![0.0; channels[0] * channels[1] * TAPS * TAPS];
    each(components, weights.as_mut_ptr(), channels, [1, channels[0]], |weights| {
        on_isa!(isa, winograd_weights_gradient(&weights));
    });
    weights
}

/// All weights between channels `[from, to]`: `taps` has those of a pair of channels `steps` · 9 values apart. Rows of
/// `components` that are no channel of `from` have no lanes.
fn each(
    components: &Components,
    taps: *mut f32,
    [from, to]: [usize; 2],
    steps: [usize; 2],
    f: impl Fn(GroupWeights) + Sync,
) {
    let (rows, count, taps) = (components.tiles, TAPS * TAPS, SendPtr(taps));
    (0..components.groups * rows).into_par_iter().with_min_len(GROUP).for_each(|i| {
        let (group, row) = (i / rows, i % rows);
        let first = (row.min(from - 1) * steps[0] + group * GROUP * steps[1]) * count;
        f(GroupWeights {
            // SAFETY: the taps of these two channels; each pair is one task's.
            taps: unsafe { taps.at(first) },
            lane_step: steps[1] * count,
            lanes: if row < from { (to - group * GROUP).min(GROUP) } else { 0 },
            components: components.at(0, group, row),
            step: components.step(),
        });
    });
}

/// G w Gᵀ.
///
/// # Safety
/// The pointers are good for what the sizes say; the processor has the instructions of `V`.
#[inline(always)]
pub(in crate::kernel) unsafe fn transform<V: Vector>(weights: &GroupWeights) {
    let mut lanes = [[0.0f32; GROUP]; TAPS * TAPS];
    // SAFETY: the caller's word.
    unsafe {
        for lane in 0..weights.lanes {
            for tap in 0..TAPS * TAPS {
                lanes[tap][lane] = *weights.taps.add(lane * weights.lane_step + tap);
            }
        }
        for part in (0..GROUP).step_by(V::LANES) {
            let mut taps = [[V::splat(0.0); TAPS]; TAPS];
            for i in 0..TAPS {
                for j in 0..TAPS {
                    taps[i][j] = V::load(lanes[i * TAPS + j].as_ptr().add(part));
                }
            }
            let components = both::<Weights, V, TAPS, POINTS>(&taps);
            for i in 0..POINTS {
                for j in 0..POINTS {
                    components[i][j].store(weights.components.add((i * POINTS + j) * weights.step + part));
                }
            }
        }
    }
}

/// Gᵀ g G.
///
/// # Safety
/// As of [`transform`].
#[inline(always)]
pub(in crate::kernel) unsafe fn transform_gradient<V: Vector>(weights: &GroupWeights) {
    let mut lanes = [[0.0f32; GROUP]; TAPS * TAPS];
    // SAFETY: the caller's word.
    unsafe {
        for part in (0..GROUP).step_by(V::LANES) {
            let mut components = [[V::splat(0.0); POINTS]; POINTS];
            for i in 0..POINTS {
                for j in 0..POINTS {
                    components[i][j] = V::load(weights.components.add((i * POINTS + j) * weights.step + part));
                }
            }
            let taps = both::<WeightGradient, V, POINTS, TAPS>(&components);
            for i in 0..TAPS {
                for j in 0..TAPS {
                    taps[i][j].store(lanes[i * TAPS + j].as_mut_ptr().add(part));
                }
            }
        }
        for lane in 0..weights.lanes {
            for tap in 0..TAPS * TAPS {
                *weights.taps.add(lane * weights.lane_step + tap) = lanes[tap][lane];
            }
        }
    }
}
