//! Blocks of 64 KiB to 2 MiB, side by side on huge pages.
//!
//! Weights and activations of small layers are of that size. On pages of 4 KiB a net that runs for the first time in a
//! while waits for addresses longer than it computes.

use std::alloc::Layout;
use std::ops::Range;
use std::ptr::null_mut;

use super::{PAGE_BYTES, forget, fresh};

/// The smallest block that lies on a shelf.
const LEAST_BYTES: usize = 64 << 10;
/// Blocks take whole multiples of this.
const PLACE_BYTES: usize = 32 << 10;
/// Places of a shelf.
const PLACES: usize = 1024;
const SHELF_BYTES: usize = PLACES * PLACE_BYTES;
/// Places that one number tells of.
const WORD: usize = u64::BITS as usize;
/// Shelves at most: 2 GiB.
const SHELVES: usize = 64;
/// Blocks begin a little behind their first place, each further than one at the place before, up to so many: lest all
/// begin in one set of the cache.
const SHIFTS: usize = 16;
const SHIFT_BYTES: usize = 3 * LINE_BYTES;
const LINE_BYTES: usize = 64;

/// All shelves.
pub(super) struct Shelves {
    shelves: [Shelf; SHELVES],
    count: usize,
}

/// Places one behind the other.
#[derive(Clone, Copy)]
struct Shelf {
    first: *mut u8,
    /// A bit for each place, set where a block has it.
    taken: [u64; PLACES / WORD],
    /// Places that no block has.
    free: usize,
    /// All places before this one are taken.
    from: usize,
    /// So many free places in a row are not here.
    refused: usize,
}

// SAFETY: a shelf's memory belongs to no thread.
unsafe impl Send for Shelf {}

/// How many places such a block takes; none where shelves are not for it.
pub(super) fn places(layout: Layout) -> Option<usize> {
    let is_theirs = (LEAST_BYTES..PAGE_BYTES).contains(&layout.size()) && layout.align() <= LINE_BYTES;
    (cfg!(target_os = "linux") && is_theirs).then(|| (layout.size() + SHIFTS * SHIFT_BYTES).div_ceil(PLACE_BYTES))
}

impl Shelves {
    pub(super) const NONE: Self = Self { shelves: [Shelf::all_free(null_mut()); SHELVES], count: 0 };

    /// Room for a block of so many places; none where all shelves are full.
    pub(super) fn take(&mut self, places: usize) -> Option<*mut u8> {
        let found = self.shelves[..self.count].iter_mut().find_map(|shelf| shelf.take(places));
        found.or_else(|| self.add()?.take(places))
    }

    fn add(&mut self) -> Option<&mut Shelf> {
        let shelf = self.shelves.get_mut(self.count)?;
        *shelf = Shelf::all_free(fresh(SHELF_BYTES));
        if shelf.first.is_null() {
            return None;
        }
        self.count += 1;
        Some(shelf)
    }

    /// Gives back a block of so many places; whether it lay on a shelf. Of empty shelves one keeps its memory.
    pub(super) fn give_back(&mut self, block: *mut u8, places: usize) -> bool {
        let shelves = &mut self.shelves[..self.count];
        let own = shelves.iter_mut().find_map(|shelf| shelf.place(block).map(|first| (shelf, first)));
        let Some((shelf, first)) = own else { return false };
        shelf.mark(first..first + places, false);
        let emptied = (shelf.free == PLACES).then_some(shelf.first);
        if let Some(memory) = emptied.filter(|_| shelves.iter().filter(|shelf| shelf.free == PLACES).count() > 1) {
            // SAFETY: nobody has any of it.
            unsafe { forget(memory, SHELF_BYTES) };
        }
        true
    }
}

impl Shelf {
    const fn all_free(first: *mut u8) -> Self {
        Self { first, taken: [0; PLACES / WORD], free: PLACES, from: 0, refused: PLACES + 1 }
    }

    /// The place where a block begins, if it lies here.
    fn place(&self, block: *mut u8) -> Option<usize> {
        let bytes = block.addr().checked_sub(self.first.addr())?;
        (bytes < SHELF_BYTES).then_some(bytes / PLACE_BYTES)
    }

    fn take(&mut self, places: usize) -> Option<*mut u8> {
        if places >= self.refused {
            return None;
        }
        let Some(first) = self.gap(places) else {
            self.refused = places;
            return None;
        };
        self.mark(first..first + places, true);
        Some(self.first.wrapping_add(first * PLACE_BYTES + first % SHIFTS * SHIFT_BYTES))
    }

    /// The first of so many free places in a row.
    fn gap(&self, places: usize) -> Option<usize> {
        let (mut first, mut at) = (self.from, self.from);
        while at < PLACES {
            // Of the places that this number tells of those from `at` on; behind the last one there are zeros.
            let word = self.taken[at / WORD] >> (at % WORD);
            let free = (word.trailing_zeros() as usize).min(WORD - at % WORD);
            at += free;
            if at - first >= places {
                return Some(first);
            }
            if at % WORD != 0 || free == 0 {
                at += (word >> free).trailing_ones() as usize;
                first = at;
            }
        }
        None
    }

    fn mark(&mut self, places: Range<usize>, taken: bool) {
        if taken {
            self.free -= places.len();
            self.from = if places.start == self.from { places.end } else { self.from };
        } else {
            self.free += places.len();
            self.from = self.from.min(places.start);
            self.refused = PLACES + 1;
        }
        for place in places {
            let (word, bit) = (&mut self.taken[place / WORD], 1 << (place % WORD));
            debug_assert_eq!(*word & bit == 0, taken, "a place that two blocks have, or none");
            *word ^= bit;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::numbers;

    #[test]
    fn blocks_take_the_first_gap_that_is_long_enough() {
        let mut shelf = Shelf::all_free(null_mut());
        let (mut blocks, mut taken) = (Vec::new(), [false; PLACES]);
        let mut chance = numbers(7, 40_000).into_iter();
        let mut below = |most: usize| (0.5 * (chance.next().unwrap() + 1.0) * most as f32) as usize;
        for _ in 0..20_000 {
            if blocks.is_empty() || below(9) < 5 {
                let places = 1 + below(70);
                let first = taken.windows(places).position(|gap| gap.iter().all(|taken| !taken));
                assert_eq!(shelf.take(places).and_then(|block| shelf.place(block)), first, "{places} places");
                if let Some(first) = first {
                    taken[first..first + places].fill(true);
                    blocks.push(first..first + places);
                }
            } else {
                let block: Range<usize> = blocks.swap_remove(below(blocks.len()));
                taken[block.clone()].fill(false);
                shelf.mark(block, false);
            }
            assert_eq!(shelf.free, taken.iter().filter(|taken| !**taken).count());
        }
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn shelves_hold_blocks_apart_and_take_them_back() {
        let mut shelves = Shelves::NONE;
        let layout = Layout::from_size_align(PAGE_BYTES - 1, LINE_BYTES).unwrap();
        let places = places(layout).unwrap();
        let blocks: Vec<*mut u8> = (0..40).map(|_| shelves.take(places).unwrap()).collect();
        assert!(shelves.count > 1, "more than one shelf holds");
        for (i, block) in blocks.iter().enumerate() {
            assert!(block.addr().is_multiple_of(LINE_BYTES));
            // SAFETY: a block of this size, which is nobody else's.
            unsafe { block.write_bytes(i as u8, layout.size()) };
        }
        for (i, block) in blocks.iter().enumerate() {
            // SAFETY: as above.
            let values = unsafe { std::slice::from_raw_parts(*block, layout.size()) };
            assert!(values.iter().all(|value| *value == i as u8), "another block lies on block {i}");
        }
        assert!(blocks.iter().all(|block| shelves.give_back(*block, places)));
        // SAFETY: nobody's, but there.
        let left = [1, 39].map(|i| unsafe { *blocks[i] });
        assert_eq!(left, [1, 0], "of two empty shelves the second gives its memory back");
        assert!(!shelves.give_back([0_u8; 9].as_mut_ptr(), places), "what lies elsewhere is not theirs");
        assert_eq!(shelves.take(places), Some(blocks[0]));
    }

    #[test]
    fn small_and_huge_blocks_are_not_theirs() {
        let taken = |bytes, align| places(Layout::from_size_align(bytes, align).unwrap()).is_some();
        assert!(!taken(LEAST_BYTES - 1, 8) && !taken(PAGE_BYTES, 8) && !taken(PAGE_BYTES / 2, 128));
        assert_eq!(taken(LEAST_BYTES, 64), cfg!(target_os = "linux"));
    }
}
