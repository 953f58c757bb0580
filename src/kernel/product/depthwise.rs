//! Convolutions of each channel by itself.

use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::patches::Patches;
use crate::job::Cancelled;
use crate::kernel::isa::{Isa, on_isa};
use crate::kernel::padded::SendPtr;
use crate::kernel::tile::{Activation, activate};
use crate::kernel::vector::Vector;

/// A convolution of each channel with a kernel of its own.
#[derive(Clone, Copy, Debug)]
pub struct DepthWise<'a> {
    /// Instructions.
    pub isa: Isa,
    /// Picture and kernel.
    pub patches: &'a Patches,
    /// `[channels, rows, columns]` of the kernels.
    pub weights: &'a [f32],
    /// One value a channel.
    pub bias: &'a [f32],
    /// What follows.
    pub activation: Activation,
}

/// A padded copy of one channel, in which every tap of neighbouring pixels lies one behind the other whatever the stride:
/// `[row][phase][column]`, the phase being the column modulo the stride.
struct Layout {
    rows: usize,
    phase_len: usize,
    row_len: usize,
    /// Where each tap of the first pixel lies.
    taps: Vec<usize>,
}

/// Rows that are computed together.
const ROWS: usize = 4;
/// Values that are read beyond the last pixel at most.
const SLACK: usize = 16;

/// One channel's result.
#[derive(Clone, Copy, Debug)]
pub(in crate::kernel) struct Plane<'a> {
    padded: *const f32,
    /// Values from a row of the result to the next one's taps.
    step: usize,
    taps: &'a [usize],
    weights: &'a [f32],
    bias: f32,
    activation: Activation,
    out: *mut f32,
    size: [usize; 2],
}

impl DepthWise<'_> {
    /// Writes `[channels, rows, columns]`.
    ///
    /// # Errors
    /// [`Cancelled`] once `cancel` is set.
    pub fn run(&self, x: &[f32], out: &mut [MaybeUninit<f32>], cancel: Option<&AtomicBool>) -> Result<(), Cancelled> {
        let patches = self.patches;
        let taps = patches.kernel[0] * patches.kernel[1];
        assert_eq!(
            (x.len(), out.len()),
            (patches.input_len(), patches.channels * patches.pixels()),
            "lengths of planes"
        );
        assert_eq!((self.weights.len(), self.bias.len()), (patches.channels * taps, patches.channels), "weights");
        let stopped = || cancel.is_some_and(|flag| flag.load(Ordering::Relaxed));
        let layout = Layout::of(patches);
        let out = SendPtr(out.as_mut_ptr().cast::<f32>());
        (0..patches.channels).into_par_iter().for_each_init(Vec::new, |padded, channel| {
            if stopped() {
                return;
            }
            let plane = patches.size[0] * patches.size[1];
            layout.fill(patches, &x[channel * plane..][..plane], padded);
            let plane = Plane {
                padded: padded.as_ptr(),
                step: patches.stride[0] * layout.row_len,
                taps: &layout.taps,
                weights: &self.weights[channel * taps..][..taps],
                bias: self.bias[channel],
                activation: self.activation,
                // SAFETY: each channel of the result is written by one task alone.
                out: unsafe { out.at(channel * patches.pixels()) },
                size: patches.output,
            };
            on_isa!(self.isa, depthwise_plane(&plane));
        });
        if stopped() { Err(Cancelled) } else { Ok(()) }
    }
}

impl Layout {
    fn of(patches: &Patches) -> Self {
        let reach = |axis: usize| {
            (patches.output[axis].max(1) - 1) * patches.stride[axis]
                + (patches.kernel[axis].max(1) - 1) * patches.dilation[axis]
                + 1
        };
        let phases = patches.stride[1];
        let phase_len = reach(1).div_ceil(phases) + SLACK;
        let row_len = phases * phase_len;
        let mut taps = Vec::new();
        for row in 0..patches.kernel[0] {
            for column in 0..patches.kernel[1] {
                let column = column * patches.dilation[1];
                taps.push(row * patches.dilation[0] * row_len + column % phases * phase_len + column / phases);
            }
        }
        // Rows that are computed together may reach beyond the last.
        Self { rows: reach(0), phase_len, row_len, taps }
    }

    fn fill(&self, patches: &Patches, plane: &[f32], padded: &mut Vec<f32>) {
        let [height, width] = patches.size;
        let phases = patches.stride[1];
        padded.clear();
        padded.resize(self.rows * self.row_len + SLACK, 0.0);
        for (row, target) in padded.chunks_exact_mut(self.row_len).enumerate().take(self.rows) {
            let y = row.wrapping_sub(patches.before[0]);
            if y >= height {
                continue;
            }
            let source = &plane[y * width..][..width];
            for (phase, target) in target.chunks_exact_mut(self.phase_len).enumerate() {
                // The column of the picture that stands at place i is phase + i · phases − before.
                let skipped = patches.before[1].saturating_sub(phase).div_ceil(phases);
                let first = phase + skipped * phases - patches.before[1];
                let source = source.get(first..).unwrap_or_default();
                let target = target.get_mut(skipped..).unwrap_or_default();
                if phases == 1 {
                    let n = source.len().min(target.len());
                    target[..n].copy_from_slice(&source[..n]);
                } else {
                    target.iter_mut().zip(source.iter().step_by(phases)).for_each(|(target, value)| *target = *value);
                }
            }
        }
    }
}

/// # Safety
/// All pointers are good for what the sizes and taps say; the processor has the instructions of `V`.
#[inline(always)]
pub(in crate::kernel) unsafe fn run<V: Vector>(plane: &Plane) {
    let mut y = 0;
    while y < plane.size[0] {
        // SAFETY: the caller's word.
        unsafe {
            y += if plane.size[0] - y >= ROWS { rows::<V, ROWS>(plane, y) } else { rows::<V, 1>(plane, y) };
        }
    }
}

/// `N` rows from `y` on; answers `N`.
#[inline(always)]
unsafe fn rows<V: Vector, const N: usize>(plane: &Plane, y: usize) -> usize {
    let width = plane.size[1];
    for x in (0..width).step_by(V::LANES) {
        // SAFETY: the caller's word; the padded rows go on for a vector behind the last pixel.
        unsafe {
            let mut sums = [V::splat(plane.bias); N];
            for (tap, weight) in plane.taps.iter().zip(plane.weights) {
                let (from, weight) = (plane.padded.add(y * plane.step + tap + x), V::splat(*weight));
                for (n, sum) in sums.iter_mut().enumerate() {
                    *sum = V::load(from.add(n * plane.step)).mul_add(weight, *sum);
                }
            }
            for (n, sum) in sums.into_iter().enumerate() {
                let (value, out) = (activate(sum, plane.activation), plane.out.add((y + n) * width + x));
                if width - x >= V::LANES { value.store(out) } else { value.store_first(out, width - x) }
            }
        }
    }
    N
}
