//! A region tile by tile, on all cores, each tile straight into its place.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::grain::Grain;
use super::kernel::Kernels;
use super::rays::BLOCK;
use super::tile::{Bench, Optics, Pool, Region};
use super::{LensError, Prepared};
use crate::field::{Lens, pixels};
use crate::job::{Job, Stage};

/// A tile, and the rows of the picture that it fills.
struct Place<'a, T> {
    tile: Region,
    rows: Vec<&'a mut [T]>,
}

impl Prepared {
    /// Renders a region, `[y, x, 3]`; `store` makes values of a row's linear light.
    pub(super) fn tiles<T: Copy + Default + Send>(
        &self,
        lens: &Lens,
        region: Region,
        job: &Job,
        store: impl Fn(&[f32], &mut [T]) + Sync,
    ) -> Result<Vec<T>, LensError> {
        let optics = self.optics(lens);
        let magenta = lens.magenta();
        let magenta = magenta.as_ref().map(|lens| self.optics(lens));
        let grain = Grain::of(&self.light, lens.grain);
        let pool = Pool::default();
        let mut values = vec![T::default(); pixels(region.size) * 3];
        let places = places(&mut values, region, tile_side(optics.reach));
        let total = places.len() as u32;
        let done = Mutex::new(0);
        job.advance(Stage::Refocus, 0, total)?;
        places.into_par_iter().try_for_each(|Place { tile, rows }| {
            job.check()?;
            let mut bench = pool.take();
            let light = self.tile(&optics, magenta.as_ref(), tile, &grain, &mut bench);
            let wide = tile.size[0] as usize * 3;
            rows.into_iter().zip(light.chunks_exact(wide)).for_each(|(row, light)| store(light, row));
            pool.give(bench);
            let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
            *done += 1;
            job.advance(Stage::Refocus, *done, total)
        })?;
        Ok(values)
    }

    /// A tile through the lens; red and blue through another, where they are sharp elsewhere.
    fn tile<'a>(
        &self,
        optics: &Optics,
        magenta: Option<&Optics>,
        tile: Region,
        grain: &Grain,
        bench: &'a mut Bench,
    ) -> &'a [f32] {
        if optics.gain == 0.0 {
            return bench.sharp(self, tile);
        }
        bench.render(self, optics, tile);
        if let Some(magenta) = magenta {
            let green: Vec<f32> = bench.light().iter().skip(1).step_by(3).copied().collect();
            bench.render(self, magenta, tile);
            bench.light().chunks_exact_mut(3).zip(green).for_each(|(pixel, green)| pixel[1] = green);
        }
        grain.add(self, optics, tile, bench.light());
        bench.light()
    }

    pub(super) fn optics<'a>(&self, lens: &'a Lens) -> Optics<'a> {
        let scale = self.size[0] as f32 / self.surfaces.map_size()[0] as f32;
        let gain = lens.f_number.added_views() * scale;
        let widest = gain * lens.widest_defocus_px(self.surfaces.range_px());
        let kernels = Kernels::new(lens.shape.clone(), lens.glass, widest, self.size);
        let per_px = self.size.map(|side| 1.0 / side as f32);
        Optics { lens, kernels, gain, reach: (widest / 2.0).ceil() as i32 + 2 * BLOCK as i32, per_px }
    }
}

/// Cuts a region into tiles, row by row of them, with the values of each.
fn places<T>(values: &mut [T], region: Region, side: u32) -> Vec<Place<'_, T>> {
    let [width, height] = region.size;
    let band = (side * width * 3) as usize;
    let mut places = Vec::new();
    for (top, values) in (0..height).step_by(side as usize).zip(values.chunks_mut(band)) {
        let first = places.len();
        places.extend((0..width).step_by(side as usize).map(|left| {
            let size = [side.min(width - left), side.min(height - top)];
            Place { tile: Region { at: [region.at[0] + left, region.at[1] + top], size }, rows: Vec::new() }
        }));
        for row in values.chunks_mut(width as usize * 3) {
            let parts = row.chunks_mut(side as usize * 3);
            places[first..].iter_mut().zip(parts).for_each(|(place, part)| place.rows.push(part));
        }
    }
    places
}

/// Side of a tile: with a wide margin around it, small tiles would be mostly margin.
fn tile_side(reach: i32) -> u32 {
    (6 * reach as u32).next_multiple_of(64).clamp(256, 1024)
}
