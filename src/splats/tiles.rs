//! Which ellipses lie on which tile of a picture, sorted by distance.

use rayon::prelude::*;

use super::Cloud;
use super::project::{Ellipse, project};
use super::shot::Shot;
use crate::field::{Size, sides};
use crate::job::{Cancelled, Job};

/// Side of a tile, in pixels.
pub(super) const TILE: usize = 16;

/// The most ellipses that a tile keeps, the nearest: hardly any light comes through so many. All tiles together keep
/// fewer where they are many, so that a scene of fog, or a damaged one, takes neither minutes nor gigabytes.
const MOST: usize = 8192;
const LEAST: usize = 1024;
const TOGETHER: usize = 1 << 27;
/// Ellipses between two looks at the cancel flag.
const LOOK_AFTER: usize = 1024;

/// Which ellipses each tile of a picture shows, nearest first.
#[derive(Debug)]
pub struct Tiles {
    /// Width and height of the picture.
    pub(super) size: Size,
    /// Tiles in a row of them.
    pub(super) across: usize,
    /// The ellipses, in the order of the cloud.
    pub(super) ellipses: Vec<Ellipse>,
    /// Where each tile's numbers begin, and the end.
    pub(super) starts: Vec<u32>,
    /// Numbers of ellipses, tile by tile.
    pub(super) numbers: Vec<u32>,
}

impl Tiles {
    /// What an eye sees of a cloud.
    ///
    /// # Errors
    /// Stopped.
    pub(super) fn seen(cloud: &Cloud, shot: &Shot, job: &Job) -> Result<Self, Cancelled> {
        let ellipses = project(cloud, shot);
        job.check()?;
        Self::of(ellipses, shot.rig.camera.size, job)
    }

    fn of(ellipses: Vec<Ellipse>, size: Size, job: &Job) -> Result<Self, Cancelled> {
        let counts = sides(size).map(|side| side.div_ceil(TILE));
        let mut order: Vec<u64> = ellipses
            .par_iter()
            .enumerate()
            .map(|(i, ellipse)| u64::from(!ellipse.nearness.to_bits()) << 32 | i as u64)
            .collect();
        order.par_sort_unstable();
        let touched = |number: u32| {
            let Ellipse { at, reach, .. } = ellipses[number as usize];
            let range = |low: f32, high: f32, count: usize| {
                let tile = |place: f32| (place.max(0.0) / TILE as f32) as usize;
                tile((low + 0.5).floor())..(tile(high + 0.5) + 1).min(count)
            };
            (range(at.x - reach.x, at.x + reach.x, counts[0]), range(at.y - reach.y, at.y + reach.y, counts[1]))
        };
        let tiles = counts[0] * counts[1];
        let most = (TOGETHER / tiles.max(1)).clamp(LEAST, MOST) as u32;
        // How many each tile keeps; once all are full, what lies behind is seen nowhere.
        let (mut starts, mut open) = (vec![0u32; tiles + 1], tiles);
        let mut seen = 0;
        while seen < order.len() && open > 0 {
            if seen.is_multiple_of(LOOK_AFTER) {
                job.check()?;
            }
            let (columns, rows) = touched(order[seen] as u32);
            for tile in rows.flat_map(|row| columns.clone().map(move |column| row * counts[0] + column)) {
                let kept = &mut starts[tile];
                open -= usize::from(*kept + 1 == most);
                *kept = (*kept + 1).min(most);
            }
            seen += 1;
        }
        let mut sum = 0;
        for start in &mut starts {
            (*start, sum) = (sum, sum + *start);
        }
        let mut next = starts.clone();
        let mut numbers = vec![0; sum as usize];
        for (i, key) in order[..seen].iter().enumerate() {
            if i.is_multiple_of(LOOK_AFTER) {
                job.check()?;
            }
            let number = *key as u32;
            let (columns, rows) = touched(number);
            for tile in rows.flat_map(|row| columns.clone().map(move |column| row * counts[0] + column)) {
                if next[tile] < starts[tile + 1] {
                    numbers[next[tile] as usize] = number;
                    next[tile] += 1;
                }
            }
        }
        Ok(Self { size, across: counts[0], ellipses, starts, numbers })
    }

    /// The numbers of one tile's ellipses.
    pub(super) fn of_tile(&self, at: usize) -> &[u32] {
        &self.numbers[self.starts[at] as usize..self.starts[at + 1] as usize]
    }
}
