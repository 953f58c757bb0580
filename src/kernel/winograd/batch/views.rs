//! A 3×3×3 kernel as plane kernels between groups of two views with up to 8 channels each.
//!
//! The results of two neighbouring views are made of four: of 16 lanes (view, channel) from 32 rows (view, channel). As a
//! plane kernel that is the same for all pairs of views but the first and the last, where edges are repeated.

use crate::kernel::shape::{ConvShape, Padding};

/// Views of a group.
pub(super) const VIEWS: usize = 2;
/// Channels of a view, at most.
pub(super) const CHANNELS: usize = 8;
/// Views that a group's results are made of.
pub(super) const SOURCES: usize = 4;
/// Channels of the plane kernels, in and out: the first group's, one of the middle, the last's.
pub(super) const PLANES: [usize; 2] = [SOURCES * CHANNELS, 3 * VIEWS * CHANNELS];
/// Taps of a plane kernel, and of one view of the volume kernel.
const TAPS: usize = 9;

/// Groups of a light field.
pub(super) fn groups(views: usize) -> usize {
    views.div_ceil(VIEWS)
}

/// Which of the plane kernels a group has.
pub(super) fn kernel_of(group: usize, groups: usize) -> usize {
    match group {
        0 => 0,
        group if group + 1 == groups => 2,
        _ => 1,
    }
}

/// The view that stands at the `source`-th place for a group.
pub(super) fn source(group: usize, source: usize, views: usize) -> Option<usize> {
    (group * VIEWS + source).checked_sub(1).filter(|view| *view < views)
}

/// The plane kernels of a volume kernel, `[c_out, c_in, 9]` of [`PLANES`] channels.
pub(super) fn planes(shape: &ConvShape, weights: &[f32], back: bool) -> Vec<f32> {
    let mut planes = vec![0.0; PLANES[0] * PLANES[1] * TAPS];
    each(shape, back, |plane, weight| {
        planes[plane..plane + TAPS].iter_mut().zip(&weights[weight..weight + TAPS]).for_each(|(p, w)| *p += w);
    });
    planes
}

/// The gradient of the volume kernel from that of its plane kernels.
pub(super) fn volume(shape: &ConvShape, planes: &[f32]) -> Vec<f32> {
    let mut weights = vec![0.0; shape.weights_len()];
    each(shape, false, |plane, weight| {
        weights[weight..weight + TAPS].iter_mut().zip(&planes[plane..plane + TAPS]).for_each(|(w, p)| *w += p);
    });
    weights
}

/// Calls `f` with the first taps of each plane kernel and of the part of the volume kernel that belongs into it.
/// Forward, lanes are output channels; `back`, input channels.
fn each(shape: &ConvShape, back: bool, mut f: impl FnMut(usize, usize)) {
    let (views, edge) = (shape.views, shape.padding == Padding::Edge);
    let count = groups(views);
    // Whether a tap leads from a view of the result to one of the input.
    let meets = |result: usize, tap: usize, input: usize| match (result + tap).checked_sub(1) {
        Some(view) if view < views => view == input,
        Some(_) => edge && input + 1 == views,
        None => edge && input == 0,
    };
    for (group, kernel) in [(0, 0), (1, 1), (count - 1, 2)].into_iter().filter(|&(g, k)| kernel_of(g, count) == k) {
        for (lane, place) in (0..VIEWS).flat_map(|lane| (0..SOURCES).map(move |place| (lane, place))) {
            let here = group * VIEWS + lane;
            let Some(there) = source(group, place, views).filter(|_| here < views) else { continue };
            let [result, input] = if back { [there, here] } else { [here, there] };
            for tap in (0..3).filter(|tap| meets(result, *tap, input)) {
                for (o, i) in (0..shape.channels_out).flat_map(|o| (0..shape.channels_in).map(move |i| (o, i))) {
                    let [c_lane, c_row] = if back { [i, o] } else { [o, i] };
                    let lane = (kernel * VIEWS + lane) * CHANNELS + c_lane;
                    let plane = lane * PLANES[0] + place * CHANNELS + c_row;
                    f(plane * TAPS, ((o * shape.channels_in + i) * 3 + tap) * TAPS);
                }
            }
        }
    }
}
