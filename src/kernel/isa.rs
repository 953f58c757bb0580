//! Which instructions the convolution is done with.

use std::fmt;

/// A set of instructions that this processor has: a value of this type is the proof.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Isa(pub(super) Set);

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Set {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Isa {
    /// Plain Rust, on every processor.
    pub fn portable() -> Self {
        Self(Set::Portable)
    }

    /// AVX2 and FMA, where the processor has them.
    pub fn avx2() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            return Some(Self(Set::Avx2));
        }
        None
    }

    /// AVX-512 (F, VL, DQ, BW), where the processor has it.
    pub fn avx512() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512bw")
        {
            return Some(Self(Set::Avx512));
        }
        None
    }

    /// The fastest that this processor has.
    pub fn best() -> Self {
        Self::avx512().or_else(Self::avx2).unwrap_or_else(Self::portable)
    }

    /// All that this processor has, the fastest first.
    pub fn all() -> impl Iterator<Item = Self> {
        [Self::avx512(), Self::avx2(), Some(Self::portable())].into_iter().flatten()
    }

    /// Values in one vector register.
    pub(super) fn lanes(self) -> usize {
        match self.0 {
            Set::Portable => 8,
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => 8,
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => 16,
        }
    }
}

impl Default for Isa {
    fn default() -> Self {
        Self::best()
    }
}

impl fmt::Display for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.0 {
            Set::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => "AVX2",
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => "AVX-512",
        })
    }
}

impl fmt::Debug for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Calls `$function` of the module that belongs to `$isa`.
macro_rules! on_isa {
    ($isa:expr, $function:ident($($argument:expr),* $(,)?)) => {
        match $isa.0 {
            // SAFETY: an `Isa` exists only where the processor has its instructions; the rest is the caller's word.
            $crate::kernel::isa::Set::Portable => unsafe { $crate::kernel::portable::$function($($argument),*) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: an `Isa` exists only where the processor has its instructions; the rest is the caller's word.
            $crate::kernel::isa::Set::Avx2 => unsafe { $crate::kernel::avx2::$function($($argument),*) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: an `Isa` exists only where the processor has its instructions; the rest is the caller's word.
            $crate::kernel::isa::Set::Avx512 => unsafe { $crate::kernel::avx512::$function($($argument),*) },
        }
    };
}
pub(super) use on_isa;

/// Asks for some lines of the second cache from `at` on.
#[inline(always)]
pub(super) fn prefetch(at: *const f32, lines: usize) {
    #[cfg(target_arch = "x86_64")]
    for line in 0..lines {
        use std::arch::x86_64::{_MM_HINT_T1, _mm_prefetch};
        // SAFETY: a prefetch of any address is harmless, and every x86-64 has it.
        unsafe { _mm_prefetch::<_MM_HINT_T1>(at.wrapping_add(16 * line).cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (at, lines);
}
