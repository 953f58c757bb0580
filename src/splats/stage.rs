//! A cloud with the camera that looks at it: pictures, ray depths and the grid of views.

use std::sync::Arc;

use glam::Vec2;

use super::fill::close_gaps;
use super::raster::{Painter, Processor, Shown, put_together};
use super::shot::Shot;
use super::tiles::Tiles;
use super::{Blend, Cloud, Rig, SplatError};
use crate::field::color::srgb8_from_linear;
use crate::field::{
    DisparityMap, LightField, RayDepths, Size, Strength, View, ViewBlock, ViewGrid, ViewIndex, ViewOffset,
};
use crate::job::{Cancelled, Job, Stage as At};

/// Who said where the camera stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NamedCamera {
    /// The file.
    File,
    /// Nobody: it was looked for.
    Found,
}

/// A scene of Gaussians, ready to be looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// The Gaussians.
    pub cloud: Cloud,
    /// The reference camera, for pictures of the scene's own size.
    pub rig: Rig,
    /// Who said where it stands.
    pub named: NamedCamera,
    /// Inverse distances of the far and the near end.
    pub ends: [f32; 2],
    /// Whether the world's unit is the metre.
    pub in_metres: bool,
}

/// A scene with the picture that its own camera sees.
#[derive(Clone, Debug, PartialEq)]
pub struct Pictured {
    /// The scene.
    pub stage: Stage,
    /// Disparities of its own picture.
    pub map: Arc<DisparityMap>,
}

/// Views, and the disparity of every ray.
type Drawn = (Arc<LightField>, Arc<RayDepths>);

/// One picture and its rays.
#[derive(Clone, Debug)]
pub(super) struct Taken {
    pub(super) rgba: Vec<u8>,
    pub(super) disparity_px: Vec<f32>,
}

impl Stage {
    /// Width and height of the scene's own picture.
    pub fn size(&self) -> Size {
        self.rig.camera.size
    }

    /// Its own picture, sRGB `[y, x, 4]`, and the disparity of its rays.
    ///
    /// # Errors
    /// Stopped.
    pub fn photo(&self, job: &Job) -> Result<(Vec<u8>, DisparityMap), Cancelled> {
        let size = self.size();
        let taken = self.taken(&Shot::view(self.rig, Vec2::ZERO), job)?;
        let map = DisparityMap::new(size, taken.disparity_px).unwrap_or_else(|_| DisparityMap::constant(size, 0.0));
        Ok((taken.rgba, map))
    }

    /// The views of a grid with the disparity of every ray, from the reference view outward.
    ///
    /// # Errors
    /// Stopped, or disparities beyond all measure.
    pub fn views(&self, grid: ViewGrid, size: Size, strength: Strength, job: &Job) -> Result<Drawn, SplatError> {
        let (field, depths) = self.drawn(grid, &grid.spiral(), (size, strength), job)?;
        // Listeners learn the grid from the ray depths: those come first.
        job.sink.depths(&depths);
        grid.views().for_each(|at| job.sink.view(at, field.view(at)));
        Ok((field, depths))
    }

    /// Some of these views, blank ones in the place of all others.
    ///
    /// # Errors
    /// As [`Stage::views`].
    pub fn some_views(
        &self,
        grid: ViewGrid,
        block: ViewBlock,
        how: (Size, Strength),
        job: &Job,
    ) -> Result<Drawn, SplatError> {
        let wanted: Vec<ViewIndex> = grid.views().filter(|at| block.contains(*at)).collect();
        self.drawn(grid, &wanted, how, job)
    }

    fn drawn(
        &self,
        grid: ViewGrid,
        wanted: &[ViewIndex],
        (size, Strength(strength)): (Size, Strength),
        job: &Job,
    ) -> Result<Drawn, SplatError> {
        let rig = self.rig.resized(size).at_strength(strength);
        let plane = crate::field::pixels(size);
        let blank = Arc::new(View::new(size, vec![0; 4 * plane])?);
        let mut views = vec![blank; grid.count()];
        let mut disparity_px = vec![0.0; grid.count() * plane];
        for (done, at) in wanted.iter().enumerate() {
            job.advance(At::Warp, done as u32, wanted.len() as u32)?;
            let taken = self.taken(&Shot::view(rig, grid.offset(*at).to_vec2()), job)?;
            let layer = grid.layer_from_view(*at);
            disparity_px[layer * plane..(layer + 1) * plane].copy_from_slice(&taken.disparity_px);
            views[layer] = Arc::new(View::new(size, taken.rgba)?);
        }
        job.advance(At::Warp, wanted.len() as u32, wanted.len() as u32)?;
        let (field, depths) = (LightField::new(grid, views)?, RayDepths::new(grid, size, disparity_px)?);
        Ok((Arc::new(field), Arc::new(depths)))
    }

    /// What an eye sees that stands some view steps beside the reference camera, in the cloud's own values.
    ///
    /// # Errors
    /// Stopped.
    pub fn view(&self, from: ViewOffset, painter: &dyn Painter, job: &Job) -> Result<Shown, Cancelled> {
        self.shown(&Shot::view(self.rig, from.to_vec2()), painter, job)
    }

    /// What one eye sees, stored as a view is.
    pub(super) fn taken(&self, shot: &Shot, job: &Job) -> Result<Taken, Cancelled> {
        let shown = self.shown(shot, &Processor, job)?;
        let disparity_px = shown.nearness.iter().map(|n| shot.rig.disparity_px(*n)).collect();
        let byte = |value: f32| match self.cloud.blend {
            Blend::Encoded => (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8,
            Blend::Linear | Blend::StoredLinear => srgb8_from_linear(value),
        };
        let rgba = shown.rgb.iter().flat_map(|rgb| [byte(rgb[0]), byte(rgb[1]), byte(rgb[2]), 255]).collect();
        Ok(Taken { rgba, disparity_px })
    }

    /// What one eye sees, in the cloud's values, with gaps closed.
    pub(super) fn shown(&self, shot: &Shot, painter: &dyn Painter, job: &Job) -> Result<Shown, Cancelled> {
        let tiles = Tiles::seen(&self.cloud, shot, job)?;
        let mut shown = match painter.paint(&tiles, job)? {
            Some(shown) => shown,
            None => put_together(&tiles, job)?,
        };
        close_gaps(&mut shown, shot.rig.camera.size[0] as usize, self.ends[0]);
        Ok(shown)
    }
}
