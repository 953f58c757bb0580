//! A memory allocator for binaries: large blocks lie on huge pages and are used again instead of mapped afresh.
//!
//! Each layer of a net writes tens of megabytes into memory it has just got. Mapped afresh, every 4 KiB of it costs a
//! page fault, which took half of the time of the nets. Blocks of less than a huge page share some (`shelves`); small
//! ones go to the system's allocator.
//!
//! Lengths are rounded up to one of eight an octave, so that layers of nearly the same size take each other's blocks.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::{Mutex, MutexGuard, PoisonError};

use shelves::Shelves;

mod shelves;

/// Size of a huge page, and the smallest block that is kept.
const PAGE_BYTES: usize = 2 << 20;
/// Blocks that are kept at most.
const SLOTS: usize = 256;

/// The allocator. Put `#[global_allocator] static BLOCKS: LargeBlocks = LargeBlocks::keeping(384 << 20);` into a binary.
#[derive(Clone, Copy, Debug)]
pub struct LargeBlocks {
    most_bytes: usize,
}

impl LargeBlocks {
    /// Keeps at most so many bytes that nobody uses: what one round of work frees and the next asks for again.
    pub const fn keeping(most_bytes: usize) -> Self {
        Self { most_bytes }
    }
}

/// Blocks that nobody uses: address and length.
struct Kept {
    blocks: [(usize, usize); SLOTS],
    count: usize,
    bytes: usize,
}

static SHELVES: Mutex<Shelves> = Mutex::new(Shelves::NONE);
static KEPT: Mutex<Kept> = Mutex::new(Kept { blocks: [(0, 0); SLOTS], count: 0, bytes: 0 });

impl Kept {
    /// A kept block of exactly this length, the youngest first: its pages are the likeliest in cache.
    fn take(&mut self, len: usize) -> Option<usize> {
        let index = (0..self.count).rev().find(|&i| self.blocks[i].1 == len)?;
        let (address, _) = self.blocks[index];
        self.count -= 1;
        self.blocks.copy_within(index + 1..=self.count, index);
        self.bytes -= len;
        Some(address)
    }

    /// Keeps a block, `most_bytes` in all; the oldest ones that it pushes out are written to `out`, and their number is
    /// answered.
    fn keep(&mut self, block: (usize, usize), most_bytes: usize, out: &mut [(usize, usize); SLOTS]) -> usize {
        let mut pushed = 0;
        while self.count == SLOTS || (self.count > 0 && self.bytes + block.1 > most_bytes) {
            out[pushed] = self.blocks[0];
            pushed += 1;
            self.bytes -= self.blocks[0].1;
            self.blocks.copy_within(1..self.count, 0);
            self.count -= 1;
        }
        self.blocks[self.count] = block;
        self.count += 1;
        self.bytes += block.1;
        pushed
    }
}

fn huge(layout: Layout) -> Option<Layout> {
    let large = cfg!(target_os = "linux") && layout.size() >= PAGE_BYTES && layout.align() <= PAGE_BYTES;
    let step = (1 << layout.size().max(1).ilog2() >> 3).max(PAGE_BYTES);
    let len = layout.size().checked_next_multiple_of(step).filter(|_| large)?;
    Layout::from_size_align(len, PAGE_BYTES).ok()
}

/// Lets the C library keep what is freed of the blocks that no shelf takes: pages that are given back and asked for anew
/// cost page faults.
#[cfg(target_os = "linux")]
fn keep_smaller() {
    #[cfg(target_env = "gnu")]
    {
        use std::sync::Once;
        static ONCE: Once = Once::new();
        // SAFETY: settings of the allocator, which may be changed at any time.
        ONCE.call_once(|| unsafe {
            libc::mallopt(libc::M_MMAP_THRESHOLD, PAGE_BYTES as libc::c_int);
            libc::mallopt(libc::M_TRIM_THRESHOLD, 32 * PAGE_BYTES as libc::c_int);
        });
    }
}

/// A fresh block of zeros on huge pages, which are there once somebody writes to them: by that thread then.
#[cfg(target_os = "linux")]
fn fresh(len: usize) -> *mut u8 {
    use std::ptr::null_mut;
    keep_smaller();
    let Some(all) = len.checked_add(PAGE_BYTES) else { return null_mut() };
    let (rights, kind) = (libc::PROT_READ | libc::PROT_WRITE, libc::MAP_PRIVATE | libc::MAP_ANONYMOUS);
    // SAFETY: a mapping of its own, which touches no other.
    let start = unsafe { libc::mmap(null_mut(), all, rights, kind, -1, 0) };
    if start == libc::MAP_FAILED {
        return null_mut();
    }
    let before = start.addr().next_multiple_of(PAGE_BYTES) - start.addr();
    let block = start.wrapping_byte_add(before);
    // SAFETY: both parts lie within the mapping, beside the block; the advice changes no content, and a refusal does no harm.
    unsafe {
        if before > 0 {
            libc::munmap(start, before);
        }
        libc::munmap(block.wrapping_byte_add(len), PAGE_BYTES - before);
        libc::madvise(block, len, libc::MADV_HUGEPAGE);
    }
    block.cast()
}

/// Gives a block back to the system.
///
/// # Safety
/// It came from [`fresh`], with this length, and nobody uses it.
#[cfg(target_os = "linux")]
unsafe fn free(block: *mut u8, len: usize) {
    // SAFETY: the caller's word.
    unsafe { libc::munmap(block.cast(), len) };
}

/// Lets the system have the pages of a block, which is zeros when it is used again.
///
/// # Safety
/// It lies in what came from [`fresh`], and nobody uses it.
#[cfg(target_os = "linux")]
unsafe fn forget(block: *mut u8, len: usize) {
    // SAFETY: the caller's word; a refusal does no harm.
    unsafe { libc::madvise(block.cast(), len, libc::MADV_DONTNEED) };
}

/// Elsewhere no block is a large one (see [`huge`]), nor on a shelf.
#[cfg(not(target_os = "linux"))]
fn fresh(_len: usize) -> *mut u8 {
    std::ptr::null_mut()
}

#[cfg(not(target_os = "linux"))]
unsafe fn free(_block: *mut u8, _len: usize) {}

#[cfg(not(target_os = "linux"))]
unsafe fn forget(_block: *mut u8, _len: usize) {}

fn kept(len: usize) -> Option<*mut u8> {
    KEPT.lock().unwrap_or_else(PoisonError::into_inner).take(len).map(|address| address as *mut u8)
}

fn shelves() -> MutexGuard<'static, Shelves> {
    SHELVES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A block on a shelf; none where shelves are not for it, or full.
fn shelved(layout: Layout) -> Option<*mut u8> {
    shelves::places(layout).and_then(|places| shelves().take(places))
}

// SAFETY: small blocks are the system allocator's from end to end, or have places of a shelf that no other block has until
// they are given back. A large one is mapped and unmapped with the same rounded length, and between the two it is either in
// use or kept, never both: `take` and `keep` hold the lock.
unsafe impl GlobalAlloc for LargeBlocks {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        match huge(layout) {
            Some(block) => kept(block.size()).unwrap_or_else(|| fresh(block.size())),
            // SAFETY: the caller's word.
            None => shelved(layout).unwrap_or_else(|| unsafe { System.alloc(layout) }),
        }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: nobody else has it, and it is as long.
        let zeroed = |used: *mut u8| unsafe {
            used.write_bytes(0, layout.size());
            used
        };
        match huge(layout) {
            Some(block) => kept(block.size()).map_or_else(|| fresh(block.size()), zeroed),
            // SAFETY: the caller's word.
            None => shelved(layout).map_or_else(|| unsafe { System.alloc_zeroed(layout) }, zeroed),
        }
    }

    unsafe fn dealloc(&self, address: *mut u8, layout: Layout) {
        let Some(block) = huge(layout) else {
            if shelves::places(layout).is_some_and(|places| shelves().give_back(address, places)) {
                return;
            }
            // SAFETY: the caller's word; it came from the system's allocator.
            return unsafe { System.dealloc(address, layout) };
        };
        let mut pushed = [(address as usize, block.size()); SLOTS];
        let count = if block.size() > self.most_bytes {
            1
        } else {
            let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
            kept.keep((address as usize, block.size()), self.most_bytes, &mut pushed)
        };
        for &(address, len) in &pushed[..count] {
            // SAFETY: it was mapped with this length, and is no longer kept.
            unsafe { free(address as *mut u8, len) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_is_used_again_and_never_by_two() {
        let blocks = LargeBlocks::keeping(64 * PAGE_BYTES);
        let layout = Layout::from_size_align(5 * PAGE_BYTES - 100, 64).unwrap();
        // SAFETY: the layout is not empty; each block is freed once, with its layout.
        unsafe {
            let (a, b) = (blocks.alloc(layout), blocks.alloc(layout));
            assert_ne!(a, b);
            assert_eq!(a.addr() % 64, 0);
            a.write_bytes(1, layout.size());
            blocks.dealloc(a, layout);
            assert_eq!(blocks.alloc(layout), a);
            a.write_bytes(1, layout.size());
            blocks.dealloc(a, layout);
            let zeros = blocks.alloc_zeroed(layout);
            assert_eq!(zeros, a, "kept blocks are used for zeros too");
            assert!(std::slice::from_raw_parts(zeros, layout.size()).iter().all(|byte| *byte == 0));
            blocks.dealloc(zeros, layout);
            blocks.dealloc(b, layout);
        }
    }

    #[test]
    fn no_more_is_kept_than_allowed() {
        let mut kept = Kept { blocks: [(0, 0); SLOTS], count: 0, bytes: 0 };
        let mut out = [(0, 0); SLOTS];
        let mut alive = 0;
        for i in 1..200 {
            alive += 1;
            alive -= kept.keep((i, i % 50 * PAGE_BYTES), 200 * PAGE_BYTES, &mut out);
            assert!(kept.count <= SLOTS && kept.bytes <= 200 * PAGE_BYTES);
            assert_eq!(kept.count, alive);
        }
        let (address, len) = kept.blocks[kept.count / 2];
        assert!(kept.take(len).is_some());
        assert!(
            kept.blocks[..kept.count].iter().filter(|block| block.1 == len).all(|block| block.0 != address) || len == 0
        );
    }
}
