//! Refocus at the photo's own size, as a lens would: see the modules in the order in which light takes them.
//!
//! * `edges`: which side of an edge each place of the map is on, by its colours too.
//! * [`surfaces`](self): where one surface ends before another, at photo size.
//! * `behind`: what goes on behind near edges.
//! * `bounds`: how far light from where can reach.
//! * `pixel`: both together, for each pixel.
//! * [`kernel`]: the shape of a blurred point.
//! * `rays`: light on its way, by pixels, or by blocks where it is spread widely.
//! * `rim`: how much of the lens sees a nearly sharp surface beside its edge.
//! * `spread`: one slice of it over a tile, put behind what is nearer.
//! * `tile`: from the near side to the far one, a tile at a time, so that memory does not follow the photo's size.
//! * `tiles`: all tiles of a region, on all cores.
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
mod rim;
mod sample;
mod spread;
mod stack;
mod surfaces;
#[cfg(test)]
mod tests;
mod tile;
mod tiles;
mod viewpoint;

use std::sync::Arc;

use crate::field::{DisparityMap, FieldError, Lens, Photo, Pixels, Samples, fit_long_side};
use crate::job::{Cancel, Cancelled, Job};
use crate::render::Picture;

use behind::Behind;
use bounds::Bounds;
use light::Light;
use surfaces::Surfaces;

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
        let map = disparity.size();
        let apart = (ratio(map) / ratio(photo)).ln().abs();
        // The map of a strip has a side of one pixel, whatever the photo's is.
        let is_shrunk = map == fit_long_side(photo, map[0].max(map[1]));
        if low < high && apart > SHAPE_TOLERANCE + rounding && !is_shrunk {
            return Err(LensError::Shape { map, photo });
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
    pub fn prepare(&self, size: [u32; 2], cancel: &Cancel) -> Result<Prepared, Cancelled> {
        let full = self.photo.size();
        let size = [0, 1].map(|axis| size[axis].clamp(1, full[axis]));
        let light = Light::of(&self.photo, self.space).reduced(size, cancel)?;
        let surfaces = Surfaces::new(self.disparity.clone(), &light, cancel)?;
        let behind = Behind::new(&surfaces, &light, self.behind.as_deref(), cancel)?;
        cancel.check()?;
        let bounds = Bounds::new(size, &surfaces, &behind);
        Ok(Prepared { size, light, surfaces, behind, bounds })
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
    let prepared = scene.prepare(size, job.cancel)?;
    let whole = Region { at: [0; 2], size: prepared.size };
    prepared.render(lens, whole, job)
}

/// Renders a whole picture straight into stored values of 8 or 16 bits, so that light is held for a few tiles only: what
/// large photos are exported with. They are stored with the curve of the scene's [`Space`].
pub fn render_pixels(scene: &Rgbd, lens: &Lens, size: [u32; 2], bits: u8, job: &Job) -> Result<Pixels, LensError> {
    let transfer = scene.space.transfer(&scene.photo);
    let prepared = scene.prepare(size, job.cancel)?;
    let whole = Region { at: [0; 2], size: prepared.size };
    let samples = if bits > 8 {
        Samples::Sixteen(prepared.tiles(lens, whole, job, |light, values| transfer.sixteen_bits(light, values))?)
    } else {
        Samples::Eight(prepared.tiles(lens, whole, job, |light, values| transfer.eight_bits(light, values))?)
    };
    Ok(Pixels { size: prepared.size, samples })
}

impl Prepared {
    /// Width and height of the pictures.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Renders a region. Regions of one picture fit together without a seam.
    pub fn render(&self, lens: &Lens, region: Region, job: &Job) -> Result<Picture, LensError> {
        let rgb_linear = self.tiles(lens, region, job, |light, values: &mut [f32]| values.copy_from_slice(light))?;
        Ok(Picture { size: region.size, rgb_linear })
    }
}
