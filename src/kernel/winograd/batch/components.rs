//! Memory for the components of tiles, and of weights.

use super::GROUP;
use crate::kernel::padded::SendPtr;
use crate::kernel::winograd::plane_tile::COMPONENTS;

/// Components of tiles `[component][group][tile][16]`, or of weights, whose "tiles" are rows.
pub(super) struct Components {
    /// Holds the memory; its length stays 0.
    _values: Vec<f32>,
    first: SendPtr,
    pub(super) groups: usize,
    pub(super) tiles: usize,
}

impl Components {
    /// Room for components, nothing set.
    pub(super) fn new(groups: usize, tiles: usize) -> Self {
        let mut values: Vec<f32> = Vec::with_capacity(COMPONENTS * Self::step_of(groups, tiles) + GROUP);
        let aligned = values.as_ptr().align_offset(64).min(GROUP);
        // SAFETY: there is room for a group more.
        let first = SendPtr(unsafe { values.as_mut_ptr().add(aligned) });
        Self { _values: values, first, groups, tiles }
    }

    /// One line more, lest all components of a tile fall into one set of the cache.
    fn step_of(groups: usize, tiles: usize) -> usize {
        groups * tiles * GROUP + GROUP
    }

    /// Values from one component to the next.
    pub(super) fn step(&self) -> usize {
        Self::step_of(self.groups, self.tiles)
    }

    pub(super) fn at(&self, component: usize, group: usize, tile: usize) -> *mut f32 {
        debug_assert!(component < COMPONENTS && group < self.groups && tile < self.tiles);
        // SAFETY: inside, as every caller counts below these sizes.
        unsafe { self.first.at(component * self.step() + (group * self.tiles + tile) * GROUP) }
    }

    /// Sets the tiles of all groups from `tile` on to 0.
    pub(super) fn clear(&self, tile: usize) {
        for (component, group) in (0..COMPONENTS).flat_map(|c| (0..self.groups).map(move |group| (c, group))) {
            if tile < self.tiles {
                // SAFETY: the rest of this group's tiles.
                unsafe { self.at(component, group, tile).write_bytes(0, (self.tiles - tile) * GROUP) };
            }
        }
    }

    /// Adds what `other`, of the same sizes, holds. Both are set.
    pub(super) fn add(&mut self, other: &Self) {
        assert_eq!([self.groups, self.tiles], [other.groups, other.tiles], "sizes of components");
        let len = self.groups * self.tiles * GROUP;
        for component in 0..COMPONENTS {
            // SAFETY: so many values belong to each component, and this one's are borrowed alone.
            let (to, from) = unsafe {
                let to = std::slice::from_raw_parts_mut(self.at(component, 0, 0), len);
                (to, std::slice::from_raw_parts(other.at(component, 0, 0), len))
            };
            to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
        }
    }
}
