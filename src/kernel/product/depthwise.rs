//! Convolutions of each channel by itself.

use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicBool, Ordering};

use super::patches::Patches;
use super::room;
use crate::job::Cancelled;
use crate::kernel::isa::{Isa, on_isa};
use crate::kernel::padded::SendPtr;
use crate::kernel::team;
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
pub(super) struct Layout {
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
    out: Places,
    size: [usize; 2],
    /// Whether rows of the kernel are as far from each other as rows of the result, so that they share what they read.
    shares: bool,
}

/// Where the pixels of a channel's result go.
#[derive(Clone, Copy, Debug)]
pub(in crate::kernel) struct Places {
    first: *mut f32,
    /// log₂ of the pixels of a panel.
    shift: u32,
    /// Values from one panel to the next.
    panel_step: usize,
}

impl Places {
    /// One behind the other, from `first` on.
    pub(super) fn plain(first: *mut f32) -> Self {
        Self { first, shift: usize::BITS - 1, panel_step: 0 }
    }

    /// As panels of a product that are `width` (a power of two) pixels wide.
    pub(super) fn panels(first: *mut f32, width: usize, panel_step: usize) -> Self {
        Self { first, shift: width.trailing_zeros(), panel_step }
    }

    #[inline(always)]
    fn at(self, pixel: usize) -> *mut f32 {
        let (panel, column) = (pixel >> self.shift, pixel & ((1 << self.shift) - 1));
        self.first.wrapping_add(panel * self.panel_step + column)
    }
}

impl DepthWise<'_> {
    /// Writes `[channels, rows, columns]` to an array, to the end.
    pub fn onto(&self, x: &[f32], out: &mut [f32]) {
        self.run(x, room(out), None).expect("nobody can stop it");
    }

    /// Writes `[channels, rows, columns]`.
    ///
    /// # Errors
    /// [`Cancelled`] once `cancel` is set.
    pub fn run(&self, x: &[f32], out: &mut [MaybeUninit<f32>], cancel: Option<&AtomicBool>) -> Result<(), Cancelled> {
        let patches = self.patches;
        assert_eq!(
            (x.len(), out.len()),
            (patches.input_len(), patches.channels * patches.pixels()),
            "lengths of planes"
        );
        self.check();
        let stopped = || cancel.is_some_and(|flag| flag.load(Ordering::Relaxed));
        let layout = self.layout();
        let out = SendPtr(out.as_mut_ptr().cast::<f32>());
        team::each_with(patches.channels, Vec::new, |padded, channel| {
            if stopped() {
                return;
            }
            let plane = patches.size[0] * patches.size[1];
            // SAFETY: each channel of the result is written by one task alone.
            let out = unsafe { out.at(channel * patches.pixels()) };
            layout.fill(patches, &x[channel * plane..][..plane], padded);
            self.one(&layout, channel, padded.as_ptr(), Places::plain(out));
        });
        if stopped() { Err(Cancelled) } else { Ok(()) }
    }

    /// Whether there are as many weights as channels and taps.
    pub(super) fn check(&self) {
        let Patches { channels, kernel, .. } = *self.patches;
        let taps = kernel[0] * kernel[1];
        assert_eq!((self.weights.len(), self.bias.len()), (channels * taps, channels), "weights");
    }

    pub(super) fn layout(&self) -> Layout {
        Layout::of(self.patches)
    }

    /// One channel of the result, from its padded copy.
    pub(super) fn one(&self, layout: &Layout, channel: usize, padded: *const f32, out: Places) {
        let Patches { kernel, stride, dilation, output, .. } = *self.patches;
        let taps = layout.taps.len();
        let plane = Plane {
            padded,
            step: stride[0] * layout.row_len,
            taps: &layout.taps,
            weights: &self.weights[channel * taps..][..taps],
            bias: self.bias[channel],
            activation: self.activation,
            out,
            size: output,
            shares: stride[0] == dilation[0] && kernel[0] == kernel[1],
        };
        on_isa!(self.isa, depthwise_plane(&plane));
    }
}

impl Layout {
    fn of(patches: &Patches) -> Self {
        let phases = patches.stride[1];
        Self::with(patches, phases * (patches.reach(1).div_ceil(phases) + SLACK))
    }

    /// The same with rows of so many values.
    pub(super) fn with(patches: &Patches, row_len: usize) -> Self {
        let phases = patches.stride[1];
        let phase_len = row_len / phases;
        let mut taps = Vec::new();
        for row in 0..patches.kernel[0] {
            for column in 0..patches.kernel[1] {
                let column = column * patches.dilation[1];
                taps.push(row * patches.dilation[0] * row_len + column % phases * phase_len + column / phases);
            }
        }
        Self { rows: patches.reach(0), phase_len, row_len, taps }
    }

    /// Takes a padded picture of stride 1 apart into phases. Its rows are `step` values apart, and its first value is
    /// that under the first tap.
    ///
    /// # Safety
    /// All rows of the layout lie there, whole.
    pub(super) unsafe fn split(&self, isa: Isa, from: *const f32, step: usize, padded: &mut Vec<f32>) {
        padded.resize(self.rows * self.row_len + SLACK, 0.0);
        for (row, to) in padded.chunks_exact_mut(self.row_len).enumerate() {
            let phases = self.row_len / self.phase_len;
            // SAFETY: the caller's word.
            let from = unsafe { std::slice::from_raw_parts(from.add(row * step), self.row_len) };
            if phases == 2 {
                on_isa!(isa, split_pairs(from, to));
            } else {
                for (phase, to) in to.chunks_exact_mut(self.phase_len).enumerate() {
                    to.iter_mut().zip(from[phase..].iter().step_by(phases)).for_each(|(to, from)| *to = *from);
                }
            }
        }
    }

    pub(super) fn fill(&self, patches: &Patches, plane: &[f32], padded: &mut Vec<f32>) {
        let [height, width] = patches.size;
        let phases = patches.stride[1];
        // What lies around the picture stays 0 from one channel to the next.
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
    let kernel = if plane.shares { plane.taps.len() } else { 0 };
    let (mut y, rows_in_all) = (0, plane.size[0]);
    let whole = rows_in_all >= ROWS;
    while y < rows_in_all {
        // Rows of the last few once more take no longer than each by itself.
        y = if whole { y.min(rows_in_all - ROWS) } else { y };
        // SAFETY: the caller's word.
        unsafe {
            y += match (whole, kernel) {
                (true, 9) => sharing::<V, 3, 9, ROWS>(plane, y),
                (false, 9) => sharing::<V, 3, 9, 1>(plane, y),
                (true, 25) => sharing::<V, 5, 25, ROWS>(plane, y),
                (true, _) => rows::<V, ROWS>(plane, y),
                (false, _) => rows::<V, 1>(plane, y),
            };
        }
    }
}

/// `N` rows from `y` on; answers `N`.
#[inline(always)]
unsafe fn rows<V: Vector, const N: usize>(plane: &Plane, y: usize) -> usize {
    for x in (0..plane.size[1]).step_by(V::LANES) {
        // SAFETY: the caller's word; the padded rows go on for a vector behind the last pixel.
        unsafe {
            let mut sums = [V::splat(plane.bias); N];
            for (tap, weight) in plane.taps.iter().zip(plane.weights) {
                let (from, weight) = (plane.padded.add(y * plane.step + tap + x), V::splat(*weight));
                for (n, sum) in sums.iter_mut().enumerate() {
                    *sum = V::load(from.add(n * plane.step)).mul_add(weight, *sum);
                }
            }
            write(plane, sums, [y, x]);
        }
    }
    N
}

/// The same for a kernel of `K`² = `TAPS` taps: each row is read once for all rows of the result that it is part of.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "the indices say which tap of which row it is")]
unsafe fn sharing<V: Vector, const K: usize, const TAPS: usize, const N: usize>(plane: &Plane, y: usize) -> usize {
    // SAFETY: the caller's word; the padded rows go on for a vector behind the last pixel.
    unsafe {
        let mut weights = [V::splat(0.0); TAPS];
        for tap in 0..TAPS {
            weights[tap] = V::splat(plane.weights[tap]);
        }
        for x in (0..plane.size[1]).step_by(V::LANES) {
            let mut sums = [V::splat(plane.bias); N];
            for row in 0..K + N - 1 {
                let from = plane.padded.add((y + row) * plane.step + x);
                for column in 0..K {
                    let value = V::load(from.add(plane.taps[column]));
                    for n in 0..N {
                        if row >= n && row - n < K {
                            sums[n] = value.mul_add(weights[(row - n) * K + column], sums[n]);
                        }
                    }
                }
            }
            write(plane, sums, [y, x]);
        }
    }
    N
}

/// Writes pixels of `N` rows.
#[inline(always)]
unsafe fn write<V: Vector, const N: usize>(plane: &Plane, sums: [V; N], [y, x]: [usize; 2]) {
    let width = plane.size[1];
    for (n, sum) in sums.into_iter().enumerate() {
        // SAFETY: the caller's word.
        unsafe {
            let (value, out) = (activate(sum, plane.activation), plane.out.at((y + n) * width + x));
            if width - x >= V::LANES { value.store(out) } else { value.store_first(out, width - x) }
        }
    }
}

/// Even values to the first half of `to`, odd ones to the second.
#[inline(always)]
pub(in crate::kernel) fn split_pairs(from: &[f32], to: &mut [f32]) {
    let (even, odd) = to.split_at_mut(to.len() / 2);
    let pairs = from.as_chunks::<2>().0;
    for (([first, second], even), odd) in pairs.iter().zip(even).zip(odd) {
        (*even, *odd) = (*first, *second);
    }
}
