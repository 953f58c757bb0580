//! Weights to components, and gradients of components to those of weights: 16 channels at a time.

#![allow(clippy::needless_range_loop, reason = "closures would be compiled without the function's instructions")]

use super::super::transform::{POINTS, TAPS, WeightGradient, Weights, both};
use super::GROUP;
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
