//! `softmax(scale · q · kᵀ + biases) · v`, a block of queries at a time: the scores never leave the cache.

use std::mem::MaybeUninit;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use super::tile::{Block, Finish, VECTORS};
use crate::job::Cancelled;
use crate::kernel::isa::{Isa, on_isa};
use crate::kernel::padded::SendPtr;
use crate::kernel::team;

/// Lengths and steps of one head. Steps are values from one row to the next, and from one column to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sides {
    /// Rows of the answer.
    pub queries: usize,
    /// Columns of the scores.
    pub keys: usize,
    /// Columns of queries and keys.
    pub depth: usize,
    /// Columns of the values and the answer.
    pub values: usize,
    /// Of the queries `[queries, depth]`; the second is 1.
    pub query_steps: [usize; 2],
    /// Of the keys `[keys, depth]`.
    pub key_steps: [usize; 2],
    /// Of the values `[keys, values]`.
    pub value_steps: [usize; 2],
    /// Of the answer `[queries, values]`; the second is 1.
    pub out_steps: [usize; 2],
    /// Of each bias `[queries, keys]`; 0 where it is the same all along.
    pub bias_steps: [[usize; 2]; MOST_BIASES],
}

/// Biases that an attention has at most: by place, and twice a mask of windows.
pub const MOST_BIASES: usize = 3;

/// One head.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Head {
    /// Where it begins in queries, keys, values and answer.
    pub starts: [usize; 4],
    /// Where it begins in each bias.
    pub biases: [usize; MOST_BIASES],
    /// The factor of its scores; not 0.
    pub scale: f32,
}

/// Attention of some heads of equal size.
#[derive(Clone, Debug, PartialEq)]
pub struct Attention {
    /// The heads.
    pub heads: Vec<Head>,
    /// The size of one.
    pub sides: Sides,
}

/// Scores of a block at most: they stay in the second cache.
const MOST_SCORES: usize = 64 << 10;
/// Queries of a block are a multiple of this, where there are enough.
const STEP: usize = 12;

/// Rows of scores that become weights: `[rows, len]`, `step` values apart.
#[derive(Clone, Copy, Debug)]
pub(in crate::kernel) struct Scores<'a> {
    pub(in crate::kernel) first: *mut f32,
    pub(in crate::kernel) step: usize,
    pub(in crate::kernel) rows: usize,
    pub(in crate::kernel) len: usize,
    pub(in crate::kernel) scale: f32,
    /// Each from the first row on, with its steps.
    pub(in crate::kernel) biases: &'a [(&'a [f32], [usize; 2])],
    /// Gets 1 over the sum of each row.
    pub(in crate::kernel) over_sums: *mut f32,
}

/// Some queries of one head, and room for their scores.
struct Task<'a> {
    head: &'a Head,
    rows: Range<usize>,
    /// Keys and values as panels.
    packed: &'a [Vec<f32>; 2],
    scores: *mut f32,
    /// Values between rows of scores.
    step: usize,
    over_sums: *mut f32,
}

impl Attention {
    /// Writes the answer of all heads into `out`.
    ///
    /// # Errors
    /// [`Cancelled`] once `cancel` is set.
    ///
    /// # Panics
    /// If a tensor ends before its last head does.
    pub fn run(
        &self,
        isa: Isa,
        [q, k, v]: [&[f32]; 3],
        biases: &[&[f32]],
        out: &mut [MaybeUninit<f32>],
        cancel: Option<&AtomicBool>,
    ) -> Result<(), Cancelled> {
        self.check([q.len(), k.len(), v.len(), out.len()], biases);
        let sides = self.sides;
        let width = VECTORS * isa.lanes();
        let stopped = || cancel.is_some_and(|flag| flag.load(Ordering::Relaxed));
        let mut packed: Vec<[Vec<f32>; 2]> = vec![Default::default(); self.heads.len()];
        team::each_chunk(&mut packed, 1, |head, packed| packed[0] = self.pack(&self.heads[head], k, v, isa));
        let fitting = MOST_SCORES / sides.keys.max(1) / STEP * STEP;
        let block_rows = fitting.clamp(STEP, 8 * STEP);
        let blocks = sides.queries.div_ceil(block_rows);
        let out = SendPtr(out.as_mut_ptr().cast::<f32>());
        let step = sides.keys.next_multiple_of(width) + 16;
        team::each_with(self.heads.len() * blocks, Vec::new, |scratch, task| {
            if stopped() {
                return;
            }
            let (head, first) = (task / blocks, task % blocks * block_rows);
            scratch.resize(block_rows * (step + 1), 0.0);
            let (scores, over_sums) = scratch.split_at_mut(block_rows * step);
            let block = Task {
                head: &self.heads[head],
                rows: first..(first + block_rows).min(sides.queries),
                packed: &packed[head],
                scores: scores.as_mut_ptr(),
                step,
                over_sums: over_sums.as_mut_ptr(),
            };
            self.block(isa, &block, q, biases, &out);
        });
        if stopped() { Err(Cancelled) } else { Ok(()) }
    }

    /// Some queries of one head.
    fn block(&self, isa: Isa, task: &Task, q: &[f32], biases: &[&[f32]], out: &SendPtr) {
        let ([at_query, _, _, at_out], rows, [k, v]) = (task.head.starts, task.rows.clone(), task.packed);
        let s = self.sides;
        let width = VECTORS * isa.lanes();
        let whole = Block {
            a: std::ptr::null(),
            a_step: s.query_steps[0],
            panels: k.as_ptr(),
            panel_step: s.depth * width,
            depth: s.depth,
            rows: rows.len(),
            columns: s.keys,
            out: task.scores,
            out_step: task.step,
            finish: Finish::PLAIN,
        };
        // SAFETY: `check` made sure that these queries lie in the tensor.
        let product = Block { a: unsafe { q.as_ptr().add(at_query + rows.start * s.query_steps[0]) }, ..whole };
        on_isa!(isa, product(&product));
        let mut from_here: [(&[f32], [usize; 2]); MOST_BIASES] = Default::default();
        for (i, bias) in biases.iter().enumerate() {
            let (start, steps) = (task.head.biases[i], s.bias_steps[i]);
            from_here[i] = (&bias[start + rows.start * steps[0]..], steps);
        }
        let soft = Scores {
            first: task.scores,
            step: task.step,
            rows: rows.len(),
            len: s.keys,
            scale: task.head.scale,
            biases: &from_here[..biases.len()],
            over_sums: task.over_sums,
        };
        on_isa!(isa, soft_scores(&soft));
        let answer = Block {
            a: task.scores,
            a_step: task.step,
            panels: v.as_ptr(),
            panel_step: s.keys * width,
            depth: s.keys,
            columns: s.values,
            // SAFETY: as above; these queries are answered by this task alone.
            out: unsafe { out.at(at_out + rows.start * s.out_steps[0]) },
            out_step: s.out_steps[0],
            finish: Finish { row_factor: task.over_sums, ..Finish::PLAIN },
            ..whole
        };
        on_isa!(isa, product(&answer));
    }

    fn check(&self, lens: [usize; 4], biases: &[&[f32]]) {
        let s = &self.sides;
        let last = |[rows, columns]: [usize; 2], steps: [usize; 2]| {
            rows.saturating_sub(1) * steps[0] + columns.saturating_sub(1) * steps[1] + 1
        };
        let extents = [
            last([s.queries, s.depth], s.query_steps),
            last([s.keys, s.depth], s.key_steps),
            last([s.keys, s.values], s.value_steps),
            last([s.queries, s.values], s.out_steps),
        ];
        assert_eq!((s.query_steps[1], s.out_steps[1]), (1, 1), "steps along a row");
        assert!(biases.len() <= MOST_BIASES, "an attention of {} biases", biases.len());
        for head in &self.heads {
            for tensor in 0..4 {
                assert!(
                    head.starts[tensor] + extents[tensor] <= lens[tensor],
                    "length of tensor {tensor} of an attention"
                );
            }
            for (i, bias) in biases.iter().enumerate() {
                let extent = head.biases[i] + last([s.queries, s.keys], s.bias_steps[i]);
                assert!(extent <= bias.len(), "length of a bias of an attention");
            }
        }
    }

    /// Keys and values of one head as panels: `[panel][depth][key]`, `[panel][key][column]`.
    fn pack(&self, head: &Head, k: &[f32], v: &[f32], isa: Isa) -> [Vec<f32>; 2] {
        let s = &self.sides;
        let width = VECTORS * isa.lanes();
        let mut keys = vec![0.0; s.keys.div_ceil(width) * s.depth * width];
        for key in 0..s.keys {
            let target = &mut keys[key / width * s.depth * width + key % width..];
            let source = &k[head.starts[1] + key * s.key_steps[0]..];
            let values = source.iter().step_by(s.key_steps[1].max(1)).take(s.depth);
            values.zip(target.iter_mut().step_by(width)).for_each(|(value, target)| *target = *value);
        }
        let mut values = vec![0.0; s.values.div_ceil(width) * s.keys * width];
        for (panel, target) in values.chunks_exact_mut((s.keys * width).max(1)).enumerate() {
            let first = panel * width;
            let count = width.min(s.values - first);
            for (key, target) in target.chunks_exact_mut(width).enumerate() {
                let source = &v[head.starts[2] + key * s.value_steps[0] + first * s.value_steps[1]..];
                let source = source.iter().step_by(s.value_steps[1].max(1));
                source.zip(&mut target[..count]).for_each(|(value, target)| *target = *value);
            }
        }
        [keys, values]
    }
}
