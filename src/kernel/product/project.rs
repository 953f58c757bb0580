//! `act(w · x + bias) + summand` for planes of pixels: convolutions that are no 3×3 of stride 1.

use std::mem::MaybeUninit;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use super::patches::Patches;
use super::room;
use super::tile::{Block, Finish, VECTORS, aligned, panel_step};
use crate::job::Cancelled;
use crate::kernel::ending::Limits;
use crate::kernel::isa::{Isa, on_isa};
use crate::kernel::padded::SendPtr;
use crate::kernel::team;
use crate::kernel::tile::Activation;

/// A product of constant weights `[channels, depth]` with pixels.
#[derive(Clone, Copy, Debug)]
pub struct Project<'a> {
    /// Instructions.
    pub isa: Isa,
    /// The weights, row-major.
    pub weights: &'a [f32],
    /// One value a channel.
    pub bias: &'a [f32],
    /// What follows.
    pub activation: Activation,
    /// What the result is kept within, after something was added.
    pub limits: Limits,
}

/// Where the right matrix `[depth, pixels]` comes from.
#[derive(Clone, Copy, Debug)]
pub enum Columns<'a> {
    /// It lies there row-major.
    Planes(&'a [f32]),
    /// It lies there as `[pixels, depth]`.
    PixelsFirst(&'a [f32]),
    /// Each column is the patch of a picture `[channels, rows, columns]` under a kernel.
    Patches(&'a [f32], &'a Patches),
}

/// Values of the right matrix that a task packs at most: they stay in the cache while the weights go by.
const MOST_PACKED: usize = 96 << 10;

impl Project<'_> {
    /// Writes `[channels, pixels]` to an array, to the end.
    pub fn onto(&self, x: Columns, summand: Option<&[f32]>, out: &mut [f32]) {
        self.run(x, summand, room(out), None).expect("nobody can stop it");
    }

    /// Writes `[channels, pixels]`; `summand` of the same shape is added at the end.
    ///
    /// # Errors
    /// [`Cancelled`] once `cancel` is set.
    pub fn run(
        &self,
        x: Columns,
        summand: Option<&[f32]>,
        out: &mut [MaybeUninit<f32>],
        cancel: Option<&AtomicBool>,
    ) -> Result<(), Cancelled> {
        let channels = self.bias.len().max(1);
        let (depth, pixels) = (self.weights.len() / channels, out.len() / channels);
        assert_eq!((self.weights.len(), out.len()), (channels * depth, channels * pixels), "lengths of a product");
        assert!(summand.is_none_or(|summand| summand.len() == out.len()), "length of the summand");
        x.check(depth, pixels);
        let plan = Plan::of(self.isa, [channels, depth, pixels]);
        let stopped = || cancel.is_some_and(|flag| flag.load(Ordering::Relaxed));
        let out = SendPtr(out.as_mut_ptr().cast::<f32>());
        let summand = summand.map(|summand| SendPtr(summand.as_ptr().cast_mut()));
        team::each_with(plan.tasks, Vec::new, |packed, task| {
            if stopped() {
                return;
            }
            let [rows, columns] = plan.task(task);
            let packed = x.pack(depth, pixels, columns.clone(), plan.width, packed);
            let at = rows.start * pixels + columns.start;
            // SAFETY: the lengths were checked above; these rows and columns are written by this task alone.
            let block = unsafe {
                Block {
                    a: self.weights.as_ptr().add(rows.start * depth),
                    a_step: depth,
                    panels: packed.as_ptr(),
                    panel_step: panel_step(depth, plan.width),
                    depth,
                    rows: rows.len(),
                    columns: columns.len(),
                    out: out.at(at),
                    out_step: pixels,
                    finish: Finish {
                        row_bias: self.bias.as_ptr().add(rows.start),
                        activation: self.activation,
                        limits: self.limits,
                        summand: summand.as_ref().map_or(std::ptr::null(), |summand| summand.at(at)),
                        ..Finish::PLAIN
                    },
                }
            };
            on_isa!(self.isa, product(&block));
        });
        if stopped() { Err(Cancelled) } else { Ok(()) }
    }
}

/// How channels and pixels are shared out.
struct Plan {
    channels: usize,
    pixels: usize,
    width: usize,
    task_rows: usize,
    task_columns: usize,
    row_blocks: usize,
    tasks: usize,
}

impl Plan {
    fn of(isa: Isa, [channels, depth, pixels]: [usize; 3]) -> Self {
        let width = VECTORS * isa.lanes();
        let panels = pixels.div_ceil(width);
        let wanted = 3 * rayon::current_num_threads();
        let fitting = (MOST_PACKED / (depth * width).max(1)).max(1);
        // More weights than pixels: each task has its own weights, and all pixels.
        let by_rows = channels >= pixels && panels <= fitting;
        let task_panels = if by_rows { panels } else { panels.div_ceil(wanted).clamp(1, fitting.max(4)) };
        let column_blocks = panels.div_ceil(task_panels);
        // Few pixels: the channels are shared out too, and each task packs for itself.
        let row_blocks = (wanted / column_blocks.max(1)).clamp(1, channels.div_ceil(24));
        let task_rows = channels.div_ceil(row_blocks).next_multiple_of(12);
        let row_blocks = channels.div_ceil(task_rows);
        let tasks = row_blocks * column_blocks;
        Self { channels, pixels, width, task_rows, task_columns: task_panels * width, row_blocks, tasks }
    }

    fn task(&self, task: usize) -> [Range<usize>; 2] {
        let piece = |number: usize, len: usize, all: usize| number * len..((number + 1) * len).min(all);
        let rows = piece(task % self.row_blocks, self.task_rows, self.channels);
        [rows, piece(task / self.row_blocks, self.task_columns, self.pixels)]
    }
}

impl Columns<'_> {
    fn check(&self, depth: usize, pixels: usize) {
        match self {
            Self::Planes(x) | Self::PixelsFirst(x) => assert_eq!(x.len(), depth * pixels, "length of the input"),
            Self::Patches(x, patches) => {
                assert_eq!((depth, pixels), (patches.depth(), patches.pixels()), "size of the patches");
                assert_eq!(x.len(), patches.input_len(), "length of the input");
            }
        }
    }

    /// Packs some pixels as `[panel][depth][pixel of the panel]`, panels being [`panel_step`] apart; what fills no panel
    /// is 0.
    pub(super) fn pack<'p>(
        &self,
        depth: usize,
        pixels: usize,
        columns: Range<usize>,
        width: usize,
        packed: &'p mut Vec<f32>,
    ) -> &'p [f32] {
        let step = panel_step(depth, width);
        let packed = aligned(packed, columns.len().div_ceil(width) * step);
        // What is not written below: the end of the last panel, and what patches have outside of the picture.
        let first_kept = if matches!(self, Self::Patches(..)) { 0 } else { columns.len() / width * step };
        packed[first_kept..].fill(0.0);
        let panels = || columns.clone().step_by(width).map(|first| first..(first + width).min(columns.end)).enumerate();
        match self {
            Self::Planes(x) => {
                // Along the rows of all panels, so that few pages are open at a time.
                for k in 0..depth {
                    let row = &x[k * pixels..][columns.clone()];
                    match width {
                        16 => pack_row::<16>(row, &mut packed[k * width..], step),
                        _ => pack_row::<32>(row, &mut packed[k * width..], step),
                    }
                }
            }
            Self::PixelsFirst(x) => {
                for (panel, pixels_of) in panels() {
                    let target = &mut packed[panel * step..][..depth * width];
                    for (column, pixel) in pixels_of.enumerate() {
                        let values = &x[pixel * depth..][..depth];
                        values.iter().zip(target[column..].iter_mut().step_by(width)).for_each(|(x, t)| *t = *x);
                    }
                }
            }
            Self::Patches(x, patches) => {
                for (panel, pixels_of) in panels() {
                    patches.pack(x, pixels_of, &mut packed[panel * step..][..depth * width], width);
                }
            }
        }
        packed
    }
}

/// Copies a row to every panel of `W` columns; `target` begins with its place in the first.
fn pack_row<const W: usize>(row: &[f32], target: &mut [f32], step: usize) {
    let (whole, rest) = row.as_chunks::<W>();
    let mut at = 0;
    for chunk in whole {
        target[at..at + W].copy_from_slice(chunk);
        at += step;
    }
    if !rest.is_empty() {
        target[at..at + rest.len()].copy_from_slice(rest);
    }
}
