//! The proof that this processor multiplies 16-bit numbers in tiles, and the tiles themselves.

use std::fmt;
use std::marker::PhantomData;

/// That 16-bit numbers can be multiplied in tiles: a value of this type is the proof.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Halves(Means);

/// What multiplies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::kernel) enum Means {
    /// Plain Rust: slow, to compare with.
    Portable,
    #[cfg(all(target_arch = "x86_64", target_os = "linux"))]
    Amx,
}

impl Halves {
    /// Tiles of the processor, where it has them and the system lets this process use them (Linux alone asks).
    pub fn best() -> Option<Self> {
        #[cfg(all(target_arch = "x86_64", target_os = "linux"))]
        if amx::is_allowed() {
            return Some(Self(Means::Amx));
        }
        None
    }

    /// The same products one by one, on every processor: for tests.
    pub fn portable() -> Self {
        Self(Means::Portable)
    }

    /// Tiles for products whose rows hold `depth` pairs, at most 16, on this thread until they are dropped.
    pub(in crate::kernel) fn tiles(self, depth: usize) -> Tiles {
        debug_assert!((1..=super::TILE).contains(&depth), "{depth} pairs");
        #[cfg(all(target_arch = "x86_64", target_os = "linux"))]
        if self.0 == Means::Amx {
            amx::configure(depth);
        }
        Tiles { means: self.0, depth, here: PhantomData }
    }
}

impl fmt::Debug for Halves {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.0, f)
    }
}

/// Tiles that this thread may use.
pub(in crate::kernel) struct Tiles {
    pub(in crate::kernel) means: Means,
    pub(in crate::kernel) depth: usize,
    /// They are registers of one thread.
    here: PhantomData<*const ()>,
}

impl Drop for Tiles {
    fn drop(&mut self) {
        #[cfg(all(target_arch = "x86_64", target_os = "linux"))]
        if self.means == Means::Amx {
            amx::release();
        }
    }
}

#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
mod amx {
    use std::arch::asm;
    use std::arch::x86_64::__cpuid_count;
    use std::sync::LazyLock;

    use super::super::TILE;

    /// Bits of leaf 7: bfloat16 in tiles, and tiles.
    const FEATURES: u32 = 1 << 22 | 1 << 24;
    /// "Let this process use a state", and the state of tiles.
    const ARCH_REQ_XCOMP_PERM: libc::c_long = 0x1023;
    const XFEATURE_XTILEDATA: libc::c_long = 18;

    /// Whether the processor has tiles and the system has let us use them; asked once.
    pub(super) fn is_allowed() -> bool {
        static ALLOWED: LazyLock<bool> = LazyLock::new(|| {
            let features = __cpuid_count(7, 0).edx;
            // SAFETY: the call changes nothing but what this process may do.
            let asked = || unsafe { libc::syscall(libc::SYS_arch_prctl, ARCH_REQ_XCOMP_PERM, XFEATURE_XTILEDATA) };
            features & FEATURES == FEATURES && asked() == 0
        });
        *ALLOWED
    }

    /// How the eight tiles are cut: four of sums, two of `[16][depth]` pairs, two of `[depth][16]` pairs.
    #[repr(C, align(64))]
    struct Palette {
        number: u8,
        start_row: u8,
        reserved: [u8; 14],
        row_bytes: [u16; 16],
        rows: [u8; 16],
    }

    pub(super) fn configure(depth: usize) {
        let mut palette = Palette { number: 1, start_row: 0, reserved: [0; 14], row_bytes: [0; 16], rows: [0; 16] };
        let pair = size_of::<[u16; 2]>();
        let shapes = [[TILE; 2]; 4].into_iter().chain([[TILE, depth]; 2]).chain([[depth, TILE]; 2]);
        for (tile, [rows, columns]) in shapes.enumerate() {
            palette.rows[tile] = rows as u8;
            palette.row_bytes[tile] = (columns * pair) as u16;
        }
        // SAFETY: `Means::Amx` exists only where this is allowed; the palette is one that every such processor has.
        unsafe { asm!("ldtilecfg [{}]", in(reg) &raw const palette, options(nostack, readonly)) };
    }

    pub(super) fn release() {
        // SAFETY: as above.
        unsafe { asm!("tilerelease", options(nostack, nomem)) };
    }
}
