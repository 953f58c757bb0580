//! Plain Rust: arrays of 8 values, which the compiler turns into whatever the target has.

use super::vector::{Vector, entry_points};

/// 8 values.
#[derive(Clone, Copy)]
pub(super) struct Eight([f32; 8]);

impl Eight {
    #[inline(always)]
    fn each(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let mut result = self.0;
        for (a, b) in result.iter_mut().zip(other.0) {
            *a = f(*a, b);
        }
        Self(result)
    }
}

// SAFETY of all blocks: the trait's caller has made sure of the pointers.
#[allow(clippy::undocumented_unsafe_blocks, reason = "one word for all of them, above")]
impl Vector for Eight {
    const LANES: usize = 8;
    #[inline(always)]
    unsafe fn splat(value: f32) -> Self {
        Self([value; 8])
    }
    #[inline(always)]
    unsafe fn load(from: *const f32) -> Self {
        unsafe { Self(from.cast::<[f32; 8]>().read_unaligned()) }
    }
    #[inline(always)]
    unsafe fn load_first(from: *const f32, n: usize) -> Self {
        let mut values = [0.0; 8];
        unsafe { std::ptr::copy_nonoverlapping(from, values.as_mut_ptr(), n) };
        Self(values)
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut f32) {
        unsafe { to.cast::<[f32; 8]>().write_unaligned(self.0) }
    }
    #[inline(always)]
    unsafe fn store_first(self, to: *mut f32, n: usize) {
        unsafe { std::ptr::copy_nonoverlapping(self.0.as_ptr(), to, n) }
    }
    #[inline(always)]
    unsafe fn add(self, other: Self) -> Self {
        self.each(other, |a, b| a + b)
    }
    #[inline(always)]
    unsafe fn sub(self, other: Self) -> Self {
        self.each(other, |a, b| a - b)
    }
    #[inline(always)]
    unsafe fn mul(self, other: Self) -> Self {
        self.each(other, |a, b| a * b)
    }
    #[inline(always)]
    unsafe fn div(self, other: Self) -> Self {
        self.each(other, |a, b| a / b)
    }
    #[inline(always)]
    unsafe fn min(self, other: Self) -> Self {
        // Like the instructions of x86: the other where one of the two is NaN.
        self.each(other, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    unsafe fn max(self, other: Self) -> Self {
        self.each(other, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    unsafe fn mul_add(self, factor: Self, summand: Self) -> Self {
        let mut result = self.0;
        for (a, (b, c)) in result.iter_mut().zip(factor.0.into_iter().zip(summand.0)) {
            // Fused only where there is an instruction: the library call would be a hundred times slower.
            *a = if cfg!(any(target_feature = "fma", target_arch = "aarch64")) {
                (*a).mul_add(b, c)
            } else {
                *a * b + c
            };
        }
        Self(result)
    }
    #[inline(always)]
    unsafe fn round(self) -> Self {
        // Adding 1.5·2²³ leaves no room for a fraction; good for |x| < 2²².
        self.each(self, |a, _| (a + 12_582_912.0) - 12_582_912.0)
    }
    #[inline(always)]
    unsafe fn scale(self, exponent: Self) -> Self {
        self.each(exponent, |a, e| a * f32::from_bits(((e as i32 + 127) as u32) << 23))
    }
    #[inline(always)]
    unsafe fn if_positive(self, positive: Self, other: Self) -> Self {
        let mut result = other.0;
        for (r, (x, p)) in result.iter_mut().zip(self.0.into_iter().zip(positive.0)) {
            *r = if x > 0.0 { p } else { *r };
        }
        Self(result)
    }
    #[inline(always)]
    unsafe fn sum(self) -> f32 {
        self.0.iter().sum()
    }
}

entry_points!(Eight);
