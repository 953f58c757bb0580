//! Planes of pixels at another size, each axis by its own taps, on all threads.

use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicBool, Ordering};

use super::isa::{Isa, on_isa};
use super::padded::SendPtr;
use super::team;
use super::vector::Vector;
use crate::job::Cancelled;

/// How each place of a longer or shorter axis is made of places of the axis as it was.
#[derive(Clone, Debug, PartialEq)]
pub struct Taps {
    /// Places that a new one is made of.
    pub window: usize,
    /// The old places, `window` for each new one, neighbours in rising order.
    pub places: Vec<usize>,
    /// How much of each.
    pub weights: Vec<f32>,
}

impl Taps {
    /// New places.
    pub fn len(&self) -> usize {
        self.places.len() / self.window.max(1)
    }

    /// Whether nothing comes out.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn check(&self, len: usize) {
        assert_eq!(self.weights.len(), self.places.len(), "one weight a tap");
        assert!(self.places.iter().all(|place| *place < len), "taps beyond the end");
    }

    fn at(&self, place: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
        let taps = place * self.window..(place + 1) * self.window;
        self.places[taps.clone()].iter().copied().zip(self.weights[taps].iter().copied())
    }
}

/// One row across: `out[x] = Σ weight · row[place]`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Across<'a> {
    pub(super) row: &'a [f32],
    pub(super) taps: &'a Taps,
    pub(super) out: *mut f32,
}

/// A weighted sum of rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Down<'a> {
    /// Rows one behind the other.
    pub(super) rows: &'a [f32],
    /// Which row, and how much of it.
    pub(super) parts: &'a [(usize, f32)],
    pub(super) len: usize,
    pub(super) out: *mut f32,
}

/// Rows of a task, where there are fewer planes than tasks are wanted.
const TASK_ROWS: usize = 64;

/// Resizes planes `[planes, rows, columns]` into `out`; `size` is that of a plane before.
///
/// # Errors
/// [`Cancelled`] once `cancel` is set.
pub fn resize(
    isa: Isa,
    x: &[f32],
    [rows, columns]: [usize; 2],
    [down, across]: [&Taps; 2],
    out: &mut [MaybeUninit<f32>],
    cancel: Option<&AtomicBool>,
) -> Result<(), Cancelled> {
    down.check(rows);
    across.check(columns);
    let planes = x.len() / (rows * columns).max(1);
    let [out_rows, out_columns] = [down.len(), across.len()];
    assert_eq!((x.len(), out.len()), (planes * rows * columns, planes * out_rows * out_columns), "lengths of planes");
    let stopped = || cancel.is_some_and(|flag| flag.load(Ordering::Relaxed));
    let pieces = out_rows.div_ceil(TASK_ROWS);
    let out = SendPtr(out.as_mut_ptr().cast::<f32>());
    team::each_with(planes * pieces, Kept::default, |kept, task| {
        if stopped() {
            return;
        }
        let (plane, first) = (task / pieces, task % pieces * TASK_ROWS);
        kept.start(down.window, out_columns);
        let source = &x[plane * rows * columns..][..rows * columns];
        for y in first..(first + TASK_ROWS).min(out_rows) {
            // SAFETY: each row of the result is written by one task alone.
            let target = unsafe { out.at((plane * out_rows + y) * out_columns) };
            kept.row(isa, (source, columns), [down, across], y, target);
        }
    });
    if stopped() { Err(Cancelled) } else { Ok(()) }
}

/// Rows that were resized across already.
#[derive(Default)]
struct Kept {
    values: Vec<f32>,
    /// Which row lies in each place.
    held: Vec<usize>,
    parts: Vec<(usize, f32)>,
}

impl Kept {
    fn start(&mut self, window: usize, columns: usize) {
        self.values.resize(window * columns, 0.0);
        self.held.clear();
        self.held.resize(window, usize::MAX);
    }

    fn row(&mut self, isa: Isa, (x, len): (&[f32], usize), [down, across]: [&Taps; 2], y: usize, out: *mut f32) {
        let columns = across.len();
        self.parts.clear();
        for (row, weight) in down.at(y) {
            // The rows of a window are neighbours, so none of them pushes out another.
            let place = row % self.held.len();
            if self.held[place] != row {
                let target = self.values[place * columns..][..columns].as_mut_ptr();
                on_isa!(isa, resize_across(&Across { row: &x[row * len..][..len], taps: across, out: target }));
                self.held[place] = row;
            }
            self.parts.push((place, weight));
        }
        on_isa!(isa, resize_down(&Down { rows: &self.values, parts: &self.parts, len: columns, out }));
    }
}

/// # Safety
/// `out` has room for a value for each place of the taps, which were checked.
#[inline(always)]
pub(super) unsafe fn across(across: &Across) {
    let Across { row, taps, out } = *across;
    if taps.window == 2 {
        let pairs = taps.places.as_chunks::<2>().0.iter().zip(taps.weights.as_chunks::<2>().0);
        for (x, (places, weights)) in pairs.enumerate() {
            // SAFETY: the caller's word.
            unsafe {
                *out.add(x) = *row.get_unchecked(places[0]) * weights[0] + *row.get_unchecked(places[1]) * weights[1];
            }
        }
        return;
    }
    for x in 0..taps.len() {
        // SAFETY: the caller's word.
        unsafe { *out.add(x) = taps.at(x).map(|(place, weight)| *row.get_unchecked(place) * weight).sum() };
    }
}

/// # Safety
/// All rows have `len` values and `out` has room for as many; the processor has the instructions of `V`.
#[inline(always)]
pub(super) unsafe fn down<V: Vector>(down: &Down) {
    for at in (0..down.len).step_by(V::LANES) {
        let n = (down.len - at).min(V::LANES);
        // SAFETY: the caller's word.
        unsafe {
            let mut sum = V::splat(0.0);
            for (row, weight) in down.parts {
                let from = down.rows.as_ptr().add(row * down.len + at);
                let value = if n == V::LANES { V::load(from) } else { V::load_first(from, n) };
                sum = value.mul_add(V::splat(*weight), sum);
            }
            if n == V::LANES { sum.store(down.out.add(at)) } else { sum.store_first(down.out.add(at), n) }
        }
    }
}
