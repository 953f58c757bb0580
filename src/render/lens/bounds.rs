//! How much can be blurred where: the disparities that each block of the picture may have, so that a tile looks at no
//! block whose light cannot reach it.

use super::behind::Behind;
use super::rays::{BLOCK, COARSE_PX};
use super::sample::Axis;
use super::surfaces::Surfaces;
use super::tile::{Optics, Region};
use crate::field::{Raster, Size};

/// Least and greatest disparity of anything that is seen in a block, or behind it.
pub(super) struct Bounds {
    blocks: Raster<[f32; 2]>,
    /// Blocks of one surface as the map has it, with nothing behind.
    plain: Raster<bool>,
}

impl Bounds {
    /// Of all blocks of a picture of a size.
    pub(super) fn new(size: Size, surfaces: &Surfaces, behind: &Behind) -> Self {
        let blocks = size.map(|side| side.div_ceil(BLOCK as u32));
        // First and last column, or row, of a grid that the pixels of each block are read from.
        let read = |grid: Size| {
            [0, 1].map(|axis| {
                let count = blocks[axis] as usize * BLOCK;
                let at = Axis::new(0, count, size[axis], grid[axis]);
                let block = |first: usize| [at.get(first).0, at.get(first + BLOCK - 1).1];
                (0..count).step_by(BLOCK).map(block).collect::<Vec<_>>()
            })
        };
        let [of_map, of_cells, of_behind] = [surfaces.map_size(), surfaces.cells_size(), behind.size()].map(read);
        let of = |x: usize, y: usize| {
            let mut bounds = [f32::MAX, f32::MIN];
            let mut hold = |px: f32| bounds = [bounds[0].min(px), bounds[1].max(px)];
            surfaces.each_disparity([&of_map, &of_cells].map(|read| [read[0][x], read[1][y]]), &mut hold);
            behind.each_disparity([of_behind[0][x], of_behind[1][y]], &mut hold);
            bounds
        };
        let is_plain = |x: usize, y: usize| {
            surfaces.are_plain([of_cells[0][x], of_cells[1][y]])
                && behind.is_nothing([of_behind[0][x], of_behind[1][y]])
        };
        Self { blocks: Raster::par_from_fn(blocks, of), plain: Raster::par_from_fn(blocks, is_plain) }
    }

    /// The number of the block whose upper left pixel is at `place`; beyond the picture its edge goes on.
    fn at(&self, place: [i32; 2]) -> [usize; 2] {
        let sides = self.blocks.sides();
        [0, 1].map(|axis| (place[axis].div_euclid(BLOCK as i32).max(0) as usize).min(sides[axis] - 1))
    }

    /// Whether a block is one surface as the map has it, with nothing behind.
    pub(super) fn is_plain(&self, place: [i32; 2]) -> bool {
        let [x, y] = self.at(place);
        self.plain.at(x, y)
    }

    /// The greatest blur diameter of anything in the block whose upper left pixel is at `place`.
    pub(super) fn widest_px(&self, optics: &Optics, place: [i32; 2]) -> f32 {
        let block = self.at(place);
        let last = BLOCK as i32 - 1;
        let corners = [[0, 0], [last, 0], [0, last], [last, last]].map(|by| [0, 1].map(|axis| place[axis] + by[axis]));
        let [low, high] = self.blocks.at(block[0], block[1]);
        let blurs = corners.into_iter().map(|[x, y]| optics.blur(low, x, y).abs().max(optics.blur(high, x, y).abs()));
        blurs.fold(0.0, f32::max)
    }
}

/// Whether light of a block can reach a tile, where nothing in the block is blurred more than `widest_px`.
pub(super) fn reaches(place: [i32; 2], widest_px: f32, tile: Region, finest: f32) -> bool {
    let away = |axis: usize| {
        let [at, size] = [tile.at[axis] as i32, tile.size[axis] as i32];
        (at - place[axis] - BLOCK as i32 + 1).max(place[axis] - at - size + 1)
    };
    let level = COARSE_PX.iter().rposition(|px| px / finest <= widest_px + SLACK_PX).unwrap_or(0);
    away(0).max(away(1)) as f32 <= widest_px / 2.0 + (2 << level) as f32 + SLACK_PX
}

/// Rounding, and the little by which a curved surface may be farther from the focal plane between a block's corners.
pub(super) const SLACK_PX: f32 = 1.0;
