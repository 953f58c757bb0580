//! The innermost piece of a matrix product: a few rows by two vectors of columns, held in registers.
//!
//! With 32 registers of 16 values a tile is 12 rows × 32 columns: 24 sums, two vectors of the right matrix, and the value
//! of the left one comes from memory as an operand. With 16 registers of 8 values it is 6 rows × 16 columns.

use crate::kernel::ending::Limits;
use crate::kernel::tile::{Activation, activate};
use crate::kernel::vector::Vector;

/// Vectors in a panel.
pub(in crate::kernel) const VECTORS: usize = 2;

/// Values in a line of the cache.
pub(super) const LINE: usize = 16;

/// Values between the panels of a right matrix that is packed for one product: an odd number of lines, lest the panels
/// fall into one set of the cache.
pub(super) fn panel_step(depth: usize, width: usize) -> usize {
    ((depth * width).div_ceil(LINE) | 1) * LINE
}

/// Room for `len` values from the beginning of a line on; what was never written is 0.
pub(super) fn aligned(values: &mut Vec<f32>, len: usize) -> &mut [f32] {
    values.resize(values.len().max(len + LINE), 0.0);
    let skipped = values.as_ptr().align_offset(LINE * size_of::<f32>()).min(LINE);
    &mut values[skipped..][..len]
}

/// What is done with the sums of a tile before they are written.
#[derive(Clone, Copy, Debug)]
pub(in crate::kernel) struct Finish {
    /// Added to each column; good for whole panels. Null adds nothing.
    pub(in crate::kernel) column_bias: *const f32,
    /// Added to each row. Null adds nothing.
    pub(in crate::kernel) row_bias: *const f32,
    /// Each row is multiplied by this. Null multiplies by nothing.
    pub(in crate::kernel) row_factor: *const f32,
    /// Then this.
    pub(in crate::kernel) activation: Activation,
    /// Then this is added, laid out as the result. Null adds nothing.
    pub(in crate::kernel) summand: *const f32,
    /// And the sum is kept within these.
    pub(in crate::kernel) limits: Limits,
}

impl Finish {
    /// The sums as they are.
    pub(in crate::kernel) const PLAIN: Self = Self {
        column_bias: std::ptr::null(),
        row_bias: std::ptr::null(),
        row_factor: std::ptr::null(),
        activation: Activation::None,
        summand: std::ptr::null(),
        limits: Limits::NONE,
    };

    /// Whether it is a bias a row, limits, perhaps a summand, and limits again: what follows most convolutions.
    fn is_usual(&self) -> bool {
        let clamps = matches!(self.activation, Activation::None | Activation::Clamp { .. });
        clamps && !self.row_bias.is_null() && self.column_bias.is_null() && self.row_factor.is_null()
    }

    /// The same, from another row and column on.
    fn at(self, row: usize, column: usize, step: usize) -> Self {
        let moved = |from: *const f32, by: usize| if from.is_null() { from } else { from.wrapping_add(by) };
        Self {
            column_bias: moved(self.column_bias, column),
            row_bias: moved(self.row_bias, row),
            row_factor: moved(self.row_factor, row),
            summand: moved(self.summand, row * step + column),
            ..self
        }
    }
}

/// A block of a product: rows of the left matrix, panels of the right one.
#[derive(Clone, Copy, Debug)]
pub(in crate::kernel) struct Block {
    /// The first row of the left matrix; the values of a row lie one behind the other.
    pub(in crate::kernel) a: *const f32,
    /// Values between rows of the left matrix.
    pub(in crate::kernel) a_step: usize,
    /// The right matrix, `[panel][depth][column of the panel]`.
    pub(in crate::kernel) panels: *const f32,
    /// Values between panels.
    pub(in crate::kernel) panel_step: usize,
    /// Products in a sum.
    pub(in crate::kernel) depth: usize,
    pub(in crate::kernel) rows: usize,
    pub(in crate::kernel) columns: usize,
    /// The first row of the result.
    pub(in crate::kernel) out: *mut f32,
    /// Values between rows of the result, and of the summand.
    pub(in crate::kernel) out_step: usize,
    pub(in crate::kernel) finish: Finish,
}

/// The most products that are summed up before the next piece of the panel: it stays in the fastest cache.
const DEPTH: usize = 320;

/// Computes a block.
///
/// # Safety
/// All pointers are good for what the sizes say; the processor has the instructions of `V`.
#[inline(always)]
pub(in crate::kernel) unsafe fn run<V: Vector>(block: &Block) {
    let width = VECTORS * V::LANES;
    let pieces = block.depth.div_ceil(DEPTH).max(1);
    let piece = block.depth.div_ceil(pieces);
    for number in 0..pieces {
        let first = number * piece;
        let depth = piece.min(block.depth - first);
        for column in (0..block.columns).step_by(width) {
            // SAFETY: the caller's word; the piece lies in each row and each panel, the column in the result.
            unsafe {
                let tile = Tile {
                    a: block.a.add(first),
                    a_step: block.a_step,
                    b: block.panels.add(column / width * block.panel_step + first * width),
                    depth,
                    out: block.out.add(column),
                    out_step: block.out_step,
                    columns: width.min(block.columns - column),
                    goes_on: number > 0,
                    finish: (number + 1 == pieces).then(|| block.finish.at(0, column, block.out_step)),
                };
                rows::<V>(&tile, block.rows);
            }
        }
    }
}

/// Rows of the left matrix by one panel.
struct Tile {
    a: *const f32,
    a_step: usize,
    b: *const f32,
    depth: usize,
    out: *mut f32,
    out_step: usize,
    columns: usize,
    /// Whether the result holds the sum so far.
    goes_on: bool,
    /// What is done at the last.
    finish: Option<Finish>,
}

/// All rows, as many at a time as registers hold.
#[inline(always)]
unsafe fn rows<V: Vector>(tile: &Tile, rows: usize) {
    let mut row = 0;
    while row < rows {
        let left = rows - row;
        // SAFETY: the caller's word.
        unsafe {
            row += match (V::LANES >= 16, tile.columns <= V::LANES) {
                (true, false) if left >= 12 => compute::<V, 12, 2>(tile, row),
                (true, false) if left >= 8 => compute::<V, 8, 2>(tile, row),
                (true, false) if left >= 4 => compute::<V, 4, 2>(tile, row),
                (false, false) if left >= 6 => compute::<V, 6, 2>(tile, row),
                (false, false) if left >= 3 => compute::<V, 3, 2>(tile, row),
                (_, false) => compute::<V, 1, 2>(tile, row),
                (_, true) if left >= 8 => compute::<V, 8, 1>(tile, row),
                (_, true) if left >= 4 => compute::<V, 4, 1>(tile, row),
                (_, true) => compute::<V, 1, 1>(tile, row),
            };
        }
    }
}

/// `M` rows from `row` on by `N` vectors; answers `M`.
#[inline(always)]
#[allow(clippy::manual_memcpy, reason = "a memcpy would take the address of the sums and push them out of registers")]
unsafe fn compute<V: Vector, const M: usize, const N: usize>(tile: &Tile, row: usize) -> usize {
    // SAFETY: the caller's word.
    unsafe {
        let sums = accumulate::<V, M, N>(tile, row);
        let out = tile.out.add(row * tile.out_step);
        let finish = tile.finish.map(|finish| finish.at(row, 0, tile.out_step));
        if let Some(finish) = finish.filter(|finish| finish.is_usual() && !tile.goes_on && tile.columns == N * V::LANES)
        {
            usual::<V, M, N>(&sums, &finish, out, tile.out_step);
            return M;
        }
        // The rows are not unrolled here, so what they index lives in memory. The sums themselves must not.
        let mut results = [[V::splat(0.0); N]; M];
        for (results, sums) in results.iter_mut().zip(&sums) {
            #[allow(clippy::manual_memcpy, reason = "a copy by memory would take the sums out of their registers")]
            for n in 0..N {
                results[n] = sums[n];
            }
        }
        for (m, results) in results.iter().enumerate() {
            for (n, &sum) in results.iter().enumerate() {
                let at = m * tile.out_step + n * V::LANES;
                let left = tile.columns - n * V::LANES;
                let mut value = sum;
                if tile.goes_on {
                    value = value.add(load::<V>(out.add(at), left));
                }
                if let Some(finish) = &finish {
                    value = finished(value, finish, m, n * V::LANES, at, left);
                }
                if left >= V::LANES { value.store(out.add(at)) } else { value.store_first(out.add(at), left) }
            }
        }
        M
    }
}

/// Ends sums as [`Finish::is_usual`] says, and writes them, without leaving their registers.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "with counts that are constants all of it is unrolled")]
unsafe fn usual<V: Vector, const M: usize, const N: usize>(
    sums: &[[V; N]; M],
    finish: &Finish,
    out: *mut f32,
    step: usize,
) {
    let first = match finish.activation {
        Activation::Clamp { low, high } => Limits { low, high },
        _ => Limits::NONE,
    };
    // SAFETY: the caller's word.
    unsafe {
        let [first, last] = [first, finish.limits].map(|limits| [V::splat(limits.low), V::splat(limits.high)]);
        for m in 0..M {
            let bias = V::splat(*finish.row_bias.add(m));
            for n in 0..N {
                let at = m * step + n * V::LANES;
                let mut value = first[1].min(first[0].max(sums[m][n].add(bias)));
                if !finish.summand.is_null() {
                    value = value.add(V::load(finish.summand.add(at)));
                }
                last[1].min(last[0].max(value)).store(out.add(at));
            }
        }
    }
}

#[inline(always)]
unsafe fn load<V: Vector>(from: *const f32, left: usize) -> V {
    // SAFETY: the caller's word.
    unsafe { if left >= V::LANES { V::load(from) } else { V::load_first(from, left) } }
}

#[inline(always)]
unsafe fn finished<V: Vector>(sum: V, finish: &Finish, row: usize, column: usize, at: usize, left: usize) -> V {
    // SAFETY: the caller's word.
    unsafe {
        let mut value = sum;
        if !finish.column_bias.is_null() {
            value = value.add(V::load(finish.column_bias.add(column)));
        }
        if !finish.row_bias.is_null() {
            value = value.add(V::splat(*finish.row_bias.add(row)));
        }
        if !finish.row_factor.is_null() {
            value = value.mul(V::splat(*finish.row_factor.add(row)));
        }
        value = activate(value, finish.activation);
        if !finish.summand.is_null() {
            value = value.add(load::<V>(finish.summand.add(at), left));
        }
        if finish.limits.are_some() {
            value = V::splat(finish.limits.high).min(V::splat(finish.limits.low).max(value));
        }
        value
    }
}

/// Σ over the depth.
#[inline(always)]
unsafe fn accumulate<V: Vector, const M: usize, const N: usize>(tile: &Tile, row: usize) -> [[V; N]; M] {
    // SAFETY: the caller's word.
    unsafe {
        let mut sums = [[V::splat(0.0); N]; M];
        let (mut a, mut b) = (tile.a.add(row * tile.a_step), tile.b);
        for _ in 0..tile.depth {
            let mut columns = [V::splat(0.0); N];
            for (n, columns) in columns.iter_mut().enumerate() {
                *columns = V::load(b.add(n * V::LANES));
            }
            for (m, sums) in sums.iter_mut().enumerate() {
                let factor = V::splat(*a.add(m * tile.a_step));
                for n in 0..N {
                    sums[n] = columns[n].mul_add(factor, sums[n]);
                }
            }
            a = a.add(1);
            b = b.add(VECTORS * V::LANES);
        }
        sums
    }
}
