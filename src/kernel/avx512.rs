//! AVX-512: 16 values in a register, masks for the ragged end of a row.

use std::arch::x86_64::*;

use super::vector::{Vector, entry_points};

fn first(n: usize) -> u16 {
    (1u16 << n) - 1
}

// SAFETY of all blocks: the trait's caller has made sure of AVX-512 and of the pointers.
#[allow(clippy::undocumented_unsafe_blocks, reason = "one word for all of them, above")]
impl Vector for __m512 {
    const LANES: usize = 16;
    #[inline(always)]
    unsafe fn splat(value: f32) -> Self {
        unsafe { _mm512_set1_ps(value) }
    }
    #[inline(always)]
    unsafe fn load(from: *const f32) -> Self {
        unsafe { _mm512_loadu_ps(from) }
    }
    #[inline(always)]
    unsafe fn load_first(from: *const f32, n: usize) -> Self {
        unsafe { _mm512_maskz_loadu_ps(first(n), from) }
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut f32) {
        unsafe { _mm512_storeu_ps(to, self) }
    }
    #[inline(always)]
    unsafe fn store_first(self, to: *mut f32, n: usize) {
        unsafe { _mm512_mask_storeu_ps(to, first(n), self) }
    }
    #[inline(always)]
    unsafe fn add(self, other: Self) -> Self {
        unsafe { _mm512_add_ps(self, other) }
    }
    #[inline(always)]
    unsafe fn sub(self, other: Self) -> Self {
        unsafe { _mm512_sub_ps(self, other) }
    }
    #[inline(always)]
    unsafe fn mul(self, other: Self) -> Self {
        unsafe { _mm512_mul_ps(self, other) }
    }
    #[inline(always)]
    unsafe fn div(self, other: Self) -> Self {
        unsafe { _mm512_div_ps(self, other) }
    }
    #[inline(always)]
    unsafe fn min(self, other: Self) -> Self {
        unsafe { _mm512_min_ps(self, other) }
    }
    #[inline(always)]
    unsafe fn max(self, other: Self) -> Self {
        unsafe { _mm512_max_ps(self, other) }
    }
    #[inline(always)]
    unsafe fn mul_add(self, factor: Self, summand: Self) -> Self {
        unsafe { _mm512_fmadd_ps(self, factor, summand) }
    }
    #[inline(always)]
    unsafe fn round(self) -> Self {
        unsafe { _mm512_roundscale_ps::<0>(self) }
    }
    #[inline(always)]
    unsafe fn scale(self, exponent: Self) -> Self {
        unsafe { _mm512_scalef_ps(self, exponent) }
    }
    #[inline(always)]
    unsafe fn if_positive(self, positive: Self, other: Self) -> Self {
        unsafe {
            let mask = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(self, _mm512_setzero_ps());
            _mm512_mask_blend_ps(mask, other, positive)
        }
    }
    #[inline(always)]
    unsafe fn sum(self) -> f32 {
        unsafe { _mm512_reduce_add_ps(self) }
    }
    /// Pairs of rows, pairs of pairs, then quarters of registers change places.
    #[inline(always)]
    unsafe fn transpose_16(from: *const f32, from_step: usize, to: *mut f32, to_step: usize) {
        unsafe {
            let (mut a, mut b) = ([_mm512_setzero_ps(); 16], [_mm512_setzero_ps(); 16]);
            for (i, a) in a.iter_mut().enumerate() {
                *a = _mm512_loadu_ps(from.add(i * from_step));
            }
            for i in (0..16).step_by(2) {
                b[i] = _mm512_unpacklo_ps(a[i], a[i + 1]);
                b[i + 1] = _mm512_unpackhi_ps(a[i], a[i + 1]);
            }
            for i in (0..16).step_by(4) {
                for half in 0..2 {
                    let (near, far) = (_mm512_castps_pd(b[i + half]), _mm512_castps_pd(b[i + half + 2]));
                    a[i + 2 * half] = _mm512_castpd_ps(_mm512_unpacklo_pd(near, far));
                    a[i + 2 * half + 1] = _mm512_castpd_ps(_mm512_unpackhi_pd(near, far));
                }
            }
            for j in 0..4 {
                b[j] = _mm512_shuffle_f32x4::<0x88>(a[j], a[4 + j]);
                b[4 + j] = _mm512_shuffle_f32x4::<0xdd>(a[j], a[4 + j]);
                b[8 + j] = _mm512_shuffle_f32x4::<0x88>(a[8 + j], a[12 + j]);
                b[12 + j] = _mm512_shuffle_f32x4::<0xdd>(a[8 + j], a[12 + j]);
            }
            for j in 0..8 {
                _mm512_storeu_ps(to.add(j * to_step), _mm512_shuffle_f32x4::<0x88>(b[j], b[8 + j]));
                _mm512_storeu_ps(to.add((8 + j) * to_step), _mm512_shuffle_f32x4::<0xdd>(b[j], b[8 + j]));
            }
        }
    }
}

// VL matters: without it the halves of the final sums pin the accumulators to registers 0–15, and they spill.
entry_points!(__m512, "avx512f,avx512vl,avx512dq,avx512bw,fma");
