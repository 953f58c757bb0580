//! Products of four tiles of pixels with one tile of results.

use super::TILE;
use crate::kernel::halves::{Means, Tiles};

/// Pixels that are multiplied at a time: four tiles.
pub(super) const PIXELS: usize = 4 * TILE;

/// Sums `[pixel][16 results]`, whole lines.
#[repr(align(64))]
pub(in crate::kernel) struct Sums(pub(super) [f32; PIXELS * TILE]);

/// Σ over taps of `pixels · weights`, high and low halves: `[64, pairs] · [pairs, 16]`. Distances are in bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Product<'a> {
    /// High halves of the first pixel at the first tap.
    pub(super) pixels: *const u8,
    /// From one pixel to the next.
    pub(super) pixel_step: usize,
    /// From high halves to low ones.
    pub(super) low: usize,
    /// A tile of high halves for each tap, and one of low ones where there are two parts.
    pub(super) weights: *const u8,
    pub(super) parts: usize,
    /// From the first pixel to what each tap, of each block of channels, reads.
    pub(super) taps: &'a [usize],
}

impl Product<'_> {
    /// Writes `[pixel][16 results]`.
    ///
    /// # Safety
    /// All tiles of all taps can be read.
    pub(super) unsafe fn onto(&self, tiles: &Tiles, sums: &mut Sums) {
        // SAFETY: the caller's word.
        unsafe {
            match tiles.means {
                Means::Portable => self.one_by_one(tiles.depth, sums),
                #[cfg(all(target_arch = "x86_64", target_os = "linux"))]
                Means::Amx => self.by_tiles(tiles.depth, sums),
            }
        }
    }

    /// What tiles do, written out plainly.
    unsafe fn one_by_one(&self, depth: usize, sums: &mut Sums) {
        let pair = |at: *const u8, number: usize| {
            // SAFETY: the caller's word.
            let word = unsafe { at.cast::<u32>().add(number).read_unaligned() };
            [f32::from_bits(word << 16), f32::from_bits(word & 0xffff_0000)]
        };
        let tile = depth * TILE * size_of::<u32>();
        for (pixel, sums) in sums.0.as_chunks_mut::<TILE>().0.iter_mut().enumerate() {
            *sums = [0.0; TILE];
            for (number, tap) in self.taps.iter().enumerate() {
                let pixel = self.pixels.wrapping_add(tap + pixel * self.pixel_step);
                let weights = self.weights.wrapping_add(self.parts * number * tile);
                for k in 0..depth {
                    let ([a, b], [c, d]) = (pair(pixel, k), pair(pixel.wrapping_add(self.low), k));
                    for (result, sum) in sums.iter_mut().enumerate() {
                        let at = k * TILE + result;
                        let [g, h] = pair(weights, at);
                        *sum += a * g + b * h + c * g + d * h;
                        if self.parts == 2 {
                            let [g, h] = pair(weights.wrapping_add(tile), at);
                            *sum += a * g + b * h;
                        }
                    }
                }
            }
        }
    }
}

#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
mod amx {
    use std::arch::asm;

    use super::{Product, Sums, TILE};

    /// The loop over taps: tiles 0 … 3 are sums, 4 and 5 pixels, 6 and 7 high and low weights. Lines in brackets are of
    /// the low ones. Two products onto the same sums stand apart, as one takes as long as three others.
    macro_rules! tiles {
        ($product:expr, $depth:expr, $sums:expr, [$($load:literal)*], [$($first:literal)*], [$($last:literal)*]) => {
            asm!(
                "tilezero tmm0",
                "tilezero tmm1",
                "tilezero tmm2",
                "tilezero tmm3",
                "2:",
                "tileloadd tmm6, [{weights} + {line}*1]",
                "add {weights}, {tile}",
                "mov {at}, [{taps}]",
                "add {at}, {pixels}",
                "tileloadd tmm4, [{at} + {pixel_step}*1]",
                "add {at}, {next}",
                "tdpbf16ps tmm0, tmm4, tmm6",
                "tileloadd tmm5, [{at} + {pixel_step}*1]",
                "add {at}, {next}",
                "tdpbf16ps tmm1, tmm5, tmm6",
                $($load,)*
                $($first,)*
                "tileloadd tmm4, [{at} + {pixel_step}*1]",
                "add {at}, {next}",
                "tileloadd tmm5, [{at} + {pixel_step}*1]",
                "add {at}, {to_low}",
                "tdpbf16ps tmm2, tmm4, tmm6",
                "tdpbf16ps tmm3, tmm5, tmm6",
                $($last,)*
                "tileloadd tmm4, [{at} + {pixel_step}*1]",
                "add {at}, {next}",
                "tileloadd tmm5, [{at} + {pixel_step}*1]",
                "add {at}, {next}",
                "tdpbf16ps tmm0, tmm4, tmm6",
                "tdpbf16ps tmm1, tmm5, tmm6",
                ".irp line, 0,64,128,192,256,320,384,448,512,576,640,704,768,832,896,960",
                r"prefetcht1 [{weights} + {ahead} + \line]",
                ".endr",
                "tileloadd tmm4, [{at} + {pixel_step}*1]",
                "add {at}, {next}",
                "tileloadd tmm5, [{at} + {pixel_step}*1]",
                "tdpbf16ps tmm2, tmm4, tmm6",
                "tdpbf16ps tmm3, tmm5, tmm6",
                "add {taps}, 8",
                "dec {count}",
                "jnz 2b",
                "tilestored [{sums} + {line}*1], tmm0",
                "tilestored [{sums} + {line}*1 + 1024], tmm1",
                "tilestored [{sums} + {line}*1 + 2048], tmm2",
                "tilestored [{sums} + {line}*1 + 3072], tmm3",
                at = out(reg) _,
                taps = inout(reg) $product.taps.as_ptr() => _,
                count = inout(reg) $product.taps.len() => _,
                pixels = in(reg) $product.pixels,
                pixel_step = in(reg) $product.pixel_step,
                next = in(reg) TILE * $product.pixel_step,
                to_low = in(reg) $product.low.wrapping_sub(3 * TILE * $product.pixel_step),
                weights = inout(reg) $product.weights => _,
                tile = in(reg) $depth * LINE,
                line = in(reg) LINE,
                ahead = const AHEAD,
                sums = in(reg) $sums.0.as_mut_ptr(),
                out("tmm0") _, out("tmm1") _, out("tmm2") _, out("tmm3") _,
                out("tmm4") _, out("tmm5") _, out("tmm6") _, out("tmm7") _,
                options(nostack),
            )
        };
    }

    /// Bytes that weights are asked for ahead, into the second cache: read for the first time they come from afar.
    const AHEAD: usize = 8 << 10;
    /// Bytes of a row of weights, and of sums.
    const LINE: usize = 64;

    impl Product<'_> {
        /// The same by the processor's tiles.
        ///
        /// # Safety
        /// As of [`onto`](Self::onto), with tiles that are cut.
        pub(super) unsafe fn by_tiles(&self, depth: usize, sums: &mut Sums) {
            // SAFETY: the caller's word; the tiles are said to be overwritten.
            unsafe {
                match self.parts {
                    1 => tiles!(self, depth, sums, [], [], []),
                    _ => tiles!(
                        self,
                        depth,
                        sums,
                        ["tileloadd tmm7, [{weights} + {line}*1]" "add {weights}, {tile}"],
                        ["tdpbf16ps tmm0, tmm4, tmm7" "tdpbf16ps tmm1, tmm5, tmm7"],
                        ["tdpbf16ps tmm2, tmm4, tmm7" "tdpbf16ps tmm3, tmm5, tmm7"]
                    ),
                }
            }
        }
    }
}
