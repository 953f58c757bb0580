//! Refocus at the photo's own size, as a lens would: see the modules in the order in which light takes them.
//!
//! * `edges`: which side of an edge each place of the map is on, by its colours too.
//! * [`surfaces`](self): where one surface ends before another, at photo size.
//! * `behind`: what goes on behind near edges.
//! * `bounds`: how far light from where can reach.
//! * `pixel`: both together, for each pixel.
//! * [`kernel`]: the shape of a blurred point.
//! * `rays`: light on its way, by pixels, or by blocks where it is spread widely.
//! * `spread`: one slice of it over a tile, put behind what is nearer.
//! * `tile`: from the near side to the far one, a tile at a time, so that memory does not follow the photo's size.
//!
//! The blur that is added is a disc of diameter `√(n² − 1)·|D − D_f|·s` pixels, with `n = 28 / N` views across the
//! aperture and `s` the picture's pixels per pixel of the disparity map.

mod behind;
mod bounds;
mod edges;
#[cfg(feature = "ui")]
mod gpu;
mod grain;
pub mod kernel;
mod layers;
mod light;
mod opening;
mod peaking;
mod pixel;
mod rays;
mod reveal;
mod sample;
mod spread;
mod stack;
mod surfaces;
#[cfg(test)]
mod tests;
mod tile;
mod viewpoint;

use std::sync::Arc;

use rayon::prelude::*;

use crate::field::{DisparityMap, FieldError, Lens, Photo, Pixels, Samples, pixels, sides};
use crate::job::{Cancelled, Job, Stage};
use crate::render::Picture;

use behind::Behind;
use bounds::Bounds;
use kernel::Kernels;
use light::Light;
use rays::BLOCK;
use surfaces::Surfaces;
use tile::{Optics, Pool};

pub use behind::Revealed;
#[cfg(feature = "ui")]
pub use gpu::LensGpu;
pub use layers::{Hidden, Layers};
pub use light::Space;
pub use peaking::peaking;
pub use reveal::revealed;
pub use stack::{Motion, circle, focal_planes, lenses};
pub use tile::Region;

/// Why a picture could not be refocused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LensError {
    /// A photo or a map that is none.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A map of another shape than the photo.
    #[error(
        "the disparity map cannot be used — it is {map:?} pixels where the photo is {photo:?}, which is another shape — give the map of this photo"
    )]
    Shape {
        /// Width and height of the map.
        map: [u32; 2],
        /// Width and height of the photo.
        photo: [u32; 2],
    },
    /// Stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// How far the shape of a map may be from the photo's.
const SHAPE_TOLERANCE: f64 = 0.02;

/// A photo with its disparity map: all that a lens needs to know.
#[derive(Clone)]
pub struct Rgbd {
    photo: Arc<Photo>,
    disparity: DisparityMap,
    behind: Option<Arc<Revealed>>,
    space: Space,
}

impl Rgbd {
    /// A photo and a disparity map of any size but the photo's shape. A map of one value everywhere may have any shape.
    /// The picture will be in the photo's own primaries.
    pub fn new(photo: Arc<Photo>, disparity: DisparityMap) -> Result<Self, LensError> {
        Self::check(photo.size(), &disparity)?;
        Ok(Self { photo, disparity, behind: None, space: Space::Own })
    }

    /// Whether a map can be that of a photo of this size.
    pub fn check(photo: [u32; 2], disparity: &DisparityMap) -> Result<(), LensError> {
        let ratio = |size: [u32; 2]| f64::from(size[0]) / f64::from(size[1]);
        let [low, high] = disparity.range_px();
        // Small maps are rounded to whole pixels, which changes their shape.
        let rounding = 1.0 / f64::from(disparity.size()[0].min(disparity.size()[1]));
        let apart = (ratio(disparity.size()) / ratio(photo)).ln().abs();
        if low < high && apart > SHAPE_TOLERANCE + rounding {
            return Err(LensError::Shape { map: disparity.size(), photo });
        }
        Ok(())
    }

    /// The same scene with what a light field's other views have seen behind the edges.
    #[must_use]
    pub fn with_behind(mut self, behind: Revealed) -> Self {
        self.behind = Some(Arc::new(behind));
        self
    }

    /// The same scene with pictures in other primaries.
    #[must_use]
    pub fn in_space(mut self, space: Space) -> Self {
        self.space = space;
        self
    }

    /// The photo.
    pub fn photo(&self) -> &Arc<Photo> {
        &self.photo
    }

    /// The disparity map.
    pub fn disparity(&self) -> &DisparityMap {
        &self.disparity
    }

    /// Everything that does not depend on the lens, for pictures of a size (at most the photo's; a side is never 0).
    /// Worth keeping while a person turns the lens.
    pub fn prepare(&self, size: [u32; 2]) -> Prepared {
        let full = self.photo.size();
        let size = [0, 1].map(|axis| size[axis].clamp(1, full[axis]));
        let light = Light::of(&self.photo, self.space).reduced(size);
        let surfaces = Surfaces::new(self.disparity.clone(), &light);
        let behind = Behind::new(&surfaces, &light, self.behind.as_deref());
        let bounds = Bounds::new(size, &surfaces, &behind);
        Prepared { size, light, surfaces, behind, bounds }
    }
}

/// A scene made ready for pictures of one size.
pub struct Prepared {
    size: [u32; 2],
    light: Light,
    surfaces: Surfaces,
    behind: Behind,
    bounds: Bounds,
}

/// Renders a whole picture of `size`, at most the photo's.
pub fn render(scene: &Rgbd, lens: &Lens, size: [u32; 2], job: &Job) -> Result<Picture, LensError> {
    let prepared = scene.prepare(size);
    let whole = Region { at: [0; 2], size: prepared.size };
    prepared.render(lens, whole, job)
}

/// Renders a whole picture straight into stored values of 8 or 16 bits, so that light is held for a band only: what
/// large photos are exported with. They are stored with the curve of the scene's [`Space`].
pub fn render_pixels(scene: &Rgbd, lens: &Lens, size: [u32; 2], bits: u8, job: &Job) -> Result<Pixels, LensError> {
    let transfer = scene.space.transfer(&scene.photo);
    let prepared = scene.prepare(size);
    let [width, height] = sides(prepared.size);
    let mut samples = Samples::with_room(bits, width * height * 3);
    let whole = Region { at: [0; 2], size: prepared.size };
    prepared.render_bands(lens, whole, job, |band| samples.push_linear(band, &transfer))?;
    Ok(Pixels { size: prepared.size, samples })
}

impl Prepared {
    /// Width and height of the pictures.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Renders a region. Regions of one picture fit together without a seam.
    pub fn render(&self, lens: &Lens, region: Region, job: &Job) -> Result<Picture, LensError> {
        let mut rgb_linear = Vec::with_capacity(pixels(region.size) * 3);
        self.render_bands(lens, region, job, |band| rgb_linear.extend_from_slice(band))?;
        Ok(Picture { size: region.size, rgb_linear })
    }

    /// Renders a region from top to bottom and hands over band after band, `[y, x, 3]` of the region's width.
    pub fn render_bands(
        &self,
        lens: &Lens,
        region: Region,
        job: &Job,
        mut take: impl FnMut(&[f32]),
    ) -> Result<(), LensError> {
        let optics = self.optics(lens);
        let magenta = lens.magenta();
        let magenta = magenta.as_ref().map(|lens| self.optics(lens));
        let grain = grain::Grain::of(&self.light, lens.grain);
        let side = tile_side(optics.reach);
        let pool = Pool::default();
        let [width, height] = region.size;
        let columns: Vec<u32> = (0..width).step_by(side as usize).collect();
        let tops: Vec<u32> = (0..height).step_by(side as usize).collect();
        for (done, &top) in tops.iter().enumerate() {
            job.advance(Stage::Refocus, done as u32, tops.len() as u32)?;
            let rows = side.min(height - top);
            let tiles: Vec<(u32, Vec<f32>)> = columns
                .par_iter()
                .filter(|_| job.check().is_ok())
                .map(|&left| {
                    let size = [side.min(width - left), rows];
                    let tile = Region { at: [region.at[0] + left, region.at[1] + top], size };
                    (left, self.tile(&optics, magenta.as_ref(), tile, &grain, &pool))
                })
                .collect();
            job.check()?;
            take(&joined(&tiles, width as usize, rows as usize));
        }
        Ok(job.advance(Stage::Refocus, tops.len() as u32, tops.len() as u32)?)
    }

    /// A tile through the lens; red and blue through another, where they are sharp elsewhere.
    fn tile(
        &self,
        optics: &Optics,
        magenta: Option<&Optics>,
        tile: Region,
        grain: &grain::Grain,
        pool: &Pool,
    ) -> Vec<f32> {
        let mut out = vec![0.0; (tile.size[0] * tile.size[1] * 3) as usize];
        if optics.gain == 0.0 {
            let width = tile.size[0] as usize;
            let mut row = vec![[0.0; 3]; width];
            for (y, out) in out.chunks_exact_mut(width * 3).enumerate() {
                self.light.row(tile.at[0] as i32, tile.at[1] as i32 + y as i32, &mut row);
                out.copy_from_slice(row.as_flattened());
            }
            return out;
        }
        let mut bench = pool.take();
        bench.render(self, optics, tile, &mut out);
        if let Some(magenta) = magenta {
            let mut other = vec![0.0; out.len()];
            bench.render(self, magenta, tile, &mut other);
            let pixels = out.chunks_exact_mut(3).zip(other.chunks_exact(3));
            pixels.for_each(|(pixel, other)| (pixel[0], pixel[2]) = (other[0], other[2]));
        }
        pool.give(bench);
        grain.add(self, optics, tile, &mut out);
        out
    }

    fn optics<'a>(&self, lens: &'a Lens) -> Optics<'a> {
        let scale = self.size[0] as f32 / self.surfaces.map_size()[0] as f32;
        let gain = lens.f_number.added_views() * scale;
        // The farthest from what is sharp lies in a corner, or in the middle of a curved surface.
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.5, 0.5]];
        let blurs =
            self.surfaces.range_px().into_iter().flat_map(|d| corners.map(|[x, y]| lens.defocus_px(d, x, y).abs()));
        let widest = gain * blurs.fold(0.0, f32::max);
        let kernels = Kernels::new(lens.shape.clone(), lens.glass, widest, self.size);
        Optics { lens, kernels, gain, reach: (widest / 2.0).ceil() as i32 + 2 * BLOCK as i32, size: self.size }
    }
}

/// Side of a tile: with a wide margin around it, small tiles would be mostly margin.
fn tile_side(reach: i32) -> u32 {
    (6 * reach as u32).next_multiple_of(64).clamp(256, 1024)
}

/// Tiles beside each other as one band.
fn joined(tiles: &[(u32, Vec<f32>)], width: usize, rows: usize) -> Vec<f32> {
    let mut band = vec![0.0; width * rows * 3];
    for (left, tile) in tiles {
        let len = tile.len() / rows;
        for (y, row) in tile.chunks_exact(len).enumerate() {
            let start = (y * width + *left as usize) * 3;
            band[start..start + len].copy_from_slice(row);
        }
    }
    band
}
