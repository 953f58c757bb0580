//! Products of two tiles of rows with two tiles of columns.

use super::TILE;
use super::tiles::{Means, Tiles};

/// Where the tiles of a step lie: bytes on from the first ones.
pub(super) type Step = [usize; 2];

/// Σ over steps of `rows · columns`: `[16 or 32, pairs] · [pairs, 32]`. Steps and distances are in bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Product {
    /// 16 rows of pairs.
    pub(super) rows: *const u8,
    /// From one row to the next.
    pub(super) row_step: usize,
    /// From these 16 rows to the other 16, if there are some.
    pub(super) more_rows: Option<usize>,
    /// A row of 16 pairs for each pair of a row.
    pub(super) columns: *const u8,
    /// From one to the next.
    pub(super) column_step: usize,
    /// From these 16 columns to the other 16.
    pub(super) more_columns: usize,
    /// Whether it is added to what there is.
    pub(super) adds: bool,
}

impl Product {
    /// Writes `[16 or 32][32]` sums, rows of which are `step` values apart.
    ///
    /// # Safety
    /// All tiles of all steps can be read, and the sums can be read and written.
    pub(super) unsafe fn onto(&self, tiles: &Tiles, steps: &[Step], sums: *mut f32, step: usize) {
        if steps.is_empty() {
            return;
        }
        // SAFETY: the caller's word.
        unsafe {
            match tiles.means {
                Means::Portable => self.one_by_one(tiles.depth, steps, sums, step),
                #[cfg(all(target_arch = "x86_64", target_os = "linux"))]
                Means::Amx => self.by_tiles(steps, sums, step),
            }
        }
    }

    /// What tiles do, written out plainly.
    unsafe fn one_by_one(&self, depth: usize, steps: &[Step], sums: *mut f32, step: usize) {
        let pair = |at: *const u8| {
            // SAFETY: the caller's word.
            let word = unsafe { at.cast::<u32>().read_unaligned() };
            [f32::from_bits(word << 16), f32::from_bits(word & 0xffff_0000)]
        };
        let row_starts = [Some(0), self.more_rows];
        for (group, start) in row_starts.into_iter().enumerate().filter_map(|(i, start)| Some((i, start?))) {
            for (row, column) in (0..TILE).flat_map(|row| (0..2 * TILE).map(move |column| (row, column))) {
                // SAFETY: the caller's word.
                unsafe {
                    let to = sums.add((group * TILE + row) * step + column);
                    let mut sum = if self.adds { *to } else { 0.0 };
                    for [to_rows, to_columns] in steps {
                        let rows = self.rows.add(to_rows + start + row * self.row_step);
                        let across = column / TILE * self.more_columns + column % TILE * 4;
                        let columns = self.columns.add(to_columns + across);
                        for k in 0..depth {
                            let ([a, b], [c, d]) = (pair(rows.add(4 * k)), pair(columns.add(k * self.column_step)));
                            sum += a * c + b * d;
                        }
                    }
                    *to = sum;
                }
            }
        }
    }
}

#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
mod amx {
    use std::arch::asm;

    use super::{Product, Step};

    /// The loop over steps: tiles 0 … 3 are sums, 4 and 5 rows, 6 and 7 columns. Lines in brackets are of the other rows.
    macro_rules! tiles {
        ($product:expr, $steps:expr, $sums:expr, $step:expr, $more:expr,
         [$($load:literal)*], [$($zero:literal)*], [$($rows:literal)*], [$($multiply:literal)*], [$($store:literal)*]) => {
            asm!(
                "test {adds:e}, {adds:e}",
                "jz 2f",
                "tileloadd tmm0, [{sums} + {step}*1]",
                "tileloadd tmm1, [{sums} + {step}*1 + 64]",
                $($load,)*
                "jmp 3f",
                "2:",
                "tilezero tmm0",
                "tilezero tmm1",
                $($zero,)*
                "3:",
                "mov {at}, [{steps} + 8]",
                "add {at}, {columns}",
                "tileloadd tmm6, [{at} + {column_step}*1]",
                "add {at}, {more_columns}",
                "tileloadd tmm7, [{at} + {column_step}*1]",
                "mov {at}, [{steps}]",
                "add {at}, {rows}",
                "tileloadd tmm4, [{at} + {row_step}*1]",
                $($rows,)*
                "tdpbf16ps tmm0, tmm4, tmm6",
                "tdpbf16ps tmm1, tmm4, tmm7",
                $($multiply,)*
                "add {steps}, 16",
                "dec {count}",
                "jnz 3b",
                "tilestored [{sums} + {step}*1], tmm0",
                "tilestored [{sums} + {step}*1 + 64], tmm1",
                $($store,)*
                adds = in(reg) u32::from($product.adds),
                sums = in(reg) $sums,
                step = in(reg) $step * 4,
                steps = inout(reg) $steps.as_ptr() => _,
                count = inout(reg) $steps.len() => _,
                at = out(reg) _,
                rows = in(reg) $product.rows,
                row_step = in(reg) $product.row_step,
                more_rows = in(reg) $more,
                columns = in(reg) $product.columns,
                column_step = in(reg) $product.column_step,
                more_columns = in(reg) $product.more_columns,
                out("tmm0") _, out("tmm1") _, out("tmm2") _, out("tmm3") _,
                out("tmm4") _, out("tmm5") _, out("tmm6") _, out("tmm7") _,
                options(nostack),
            )
        };
    }

    impl Product {
        /// The same by the processor's tiles.
        ///
        /// # Safety
        /// As of [`onto`](Self::onto), with tiles that are cut.
        pub(super) unsafe fn by_tiles(&self, steps: &[Step], sums: *mut f32, step: usize) {
            // SAFETY: the caller's word; the tiles are said to be overwritten.
            unsafe {
                match self.more_rows {
                    None => tiles!(self, steps, sums, step, 0_usize, [], [], ["/* {more_rows} */"], [], []),
                    Some(more) => tiles!(
                        self,
                        steps,
                        sums,
                        step,
                        more,
                        [
                            "mov {at}, {step}" "shl {at}, 4" "add {at}, {sums}"
                            "tileloadd tmm2, [{at} + {step}*1]" "tileloadd tmm3, [{at} + {step}*1 + 64]"
                        ],
                        ["tilezero tmm2" "tilezero tmm3"],
                        ["add {at}, {more_rows}" "tileloadd tmm5, [{at} + {row_step}*1]"],
                        ["tdpbf16ps tmm2, tmm5, tmm6" "tdpbf16ps tmm3, tmm5, tmm7"],
                        [
                            "mov {at}, {step}" "shl {at}, 4" "add {at}, {sums}"
                            "tilestored [{at} + {step}*1], tmm2" "tilestored [{at} + {step}*1 + 64], tmm3"
                        ]
                    ),
                }
            }
        }
    }
}
