//! An allocator whose blocks end at a page that may not be touched: whoever reads or writes beyond one, or one that was
//! freed, ends the test with a signal. Blocks hold no zeros at first, but what gives NaN.
#![allow(unsafe_code, reason = "an allocator, and pages of the system")]

use std::alloc::{GlobalAlloc, Layout, System};

/// Put `#[global_allocator] static GUARDED: Guarded = Guarded;` into a test.
pub struct Guarded;

const PAGE: usize = 4096;
/// Smaller blocks are the system's: each guarded one costs two mappings, and a process may have 65530.
const LEAST: usize = 256;

/// Bytes that a block takes without the page behind it; none where it is left to the system.
fn pages(layout: Layout) -> Option<usize> {
    (cfg!(target_os = "linux") && layout.size() >= LEAST && layout.align() <= PAGE)
        .then(|| layout.size().next_multiple_of(PAGE))
}

// SAFETY: a guarded block lies in a mapping of its own, as near to its end as its alignment allows, and the mapping goes
// with it; all others are the system allocator's from end to end.
unsafe impl GlobalAlloc for Guarded {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let Some(len) = pages(layout) else {
            // SAFETY: the caller's word.
            return unsafe { System.alloc(layout) };
        };
        // SAFETY: a fresh mapping of its own; the last page of it is taken away again.
        unsafe {
            let (access, kind) = (libc::PROT_READ | libc::PROT_WRITE, libc::MAP_PRIVATE | libc::MAP_ANONYMOUS);
            let first = libc::mmap(std::ptr::null_mut(), len + PAGE, access, kind, -1, 0);
            if first == libc::MAP_FAILED {
                return std::ptr::null_mut();
            }
            let first = first.cast::<u8>();
            libc::mprotect(first.add(len).cast(), PAGE, libc::PROT_NONE);
            let block = first.add((len - layout.size()) / layout.align() * layout.align());
            block.write_bytes(0xff, layout.size());
            block
        }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        let Some(len) = pages(layout) else {
            // SAFETY: the caller's word; it came from the system's allocator.
            return unsafe { System.dealloc(block, layout) };
        };
        // SAFETY: the block begins in the first page of its mapping.
        unsafe { libc::munmap(block.sub(block.addr() % PAGE).cast(), len + PAGE) };
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's word.
        unsafe {
            let block = self.alloc(layout);
            if !block.is_null() {
                block.write_bytes(0, layout.size());
            }
            block
        }
    }
}
