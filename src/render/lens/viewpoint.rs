//! The scene from beside the reference view: a photo and a disparity map as they would be there.
//!
//! Along the line on which the points of a pixel's ray lie in the reference view, the first surface from the near side
//! is what the eye sees: `L(x, u) = L(x + u·D, 0)` (paper, §3). A ray that goes past a near edge meets what is behind.

use std::sync::Arc;

use rayon::prelude::*;

use super::behind::Behind;
use super::light::{Light, Space};
use super::surfaces::Surfaces;
use super::{LensError, Rgbd};
use crate::background::Beside;
use crate::field::color::srgb8_from_linear;
use crate::field::{
    DisparityMap, Mix, Photo, PhotoPixels, PixelsPart, Raster, Size, ToSrgb8, Transfer, ViewPoint, bilinear,
    nearest_index, sides,
};
use crate::job::{Cancel, Cancelled, Job, Stage};

/// A ray that is behind a surface by more than this, in pixels per view step of the map, has gone past its edge.
const PAST_PX: f32 = 0.06;
/// Steps of the search are at most so many pixels apart, before the last one is halved.
const STEP_PX: f32 = 0.7;
/// Rows that are looked at together, between two looks at the flag.
const ROWS: usize = 64;

impl Rgbd {
    /// The scene as it is seen from a viewpoint, in `size` pixels (at most the photo's). From the reference view it is
    /// the scene itself. What lies at the disparity `pivot_px` stays where it is.
    pub fn seen_from(&self, eye: ViewPoint, pivot_px: f32, size: Size, job: &Job) -> Result<Self, LensError> {
        if eye == ViewPoint::default() {
            return Ok(self.clone());
        }
        let full = self.photo.size();
        let size = [0, 1].map(|axis| size[axis].clamp(1, full[axis]));
        let front = Front::new(self, size, job.cancel)?;
        let scale = self.disparity.scale_to(size);
        let shift = [eye.0.du * scale, eye.0.dv * scale];
        let aside = shift.map(|shift| shift * pivot_px);
        let [width, height] = sides(size);
        let mut wide = vec![u16::MAX; width * height * 4];
        let bands = height.div_ceil(ROWS);
        let at = |x: usize, y: usize| [x as f32 - aside[0], y as f32 - aside[1]];
        for (done, wide) in wide.chunks_mut(width * 4 * ROWS).enumerate() {
            job.advance(Stage::Refocus, done as u32, bands as u32)?;
            wide.par_chunks_mut(width * 4).enumerate().for_each(|(row, wide)| {
                for (x, pixel) in wide.chunks_exact_mut(4).enumerate() {
                    let (rgb, _) = front.look(at(x, done * ROWS + row), shift);
                    (0..3).for_each(|c| pixel[c] = front.transfer.sixteen_from_linear(c, rgb[c]));
                }
            });
        }
        // The map keeps its size, as a lens's disparities belong to that; single values, as means would invent depths.
        let map = self.disparity.size();
        let [columns, rows] = sides(map);
        let place = |x: usize, y: usize| at(nearest_index(x, width, columns), nearest_index(y, height, rows));
        let depth = Raster::par_from_fn(map, |x, y| front.look(place(x, y), shift).1);
        front.scene(self, wide, DisparityMap::new(map, depth.into_pixels())?)
    }
}

/// The visible surfaces of the reference view, pixel by pixel, and what is behind them.
struct Front {
    size: Size,
    light: Light,
    depth: Vec<f32>,
    range: [f32; 2],
    behind: Behind,
    transfer: Transfer,
}

impl Front {
    fn new(scene: &Rgbd, size: Size, cancel: &Cancel) -> Result<Self, Cancelled> {
        let light = Light::of(&scene.photo, scene.space).reduced(size, cancel)?;
        let surfaces = Surfaces::new(scene.disparity.clone(), &light, cancel)?;
        let behind = Behind::new(&surfaces, &light, scene.behind.as_deref(), cancel)?;
        let transfer = scene.space.transfer(&scene.photo);
        let width = size[0] as usize;
        let reader = surfaces.reader(0, width, size);
        let mut depth = vec![0.0; width * size[1] as usize];
        depth.par_chunks_mut(width).enumerate().try_for_each(|(y, row)| {
            cancel.check()?;
            let mut colors = vec![[0.0; 3]; width];
            light.row(0, y as i32, &mut colors);
            let at = reader.at_row(y as i32);
            for (i, (depth, color)) in row.iter_mut().zip(&colors).enumerate() {
                *depth = reader.seen(&at, i, color).disparity_px();
            }
            Ok(())
        })?;
        let range = depth.iter().fold([f32::MAX, f32::MIN], |[lo, hi], &d| [lo.min(d), hi.max(d)]);
        Ok(Self { size, light, depth, range, behind, transfer })
    }

    /// Colour and disparity of what is seen at a pixel; `shift`: pixels by which a disparity of 1 is displaced.
    fn look(&self, at: [f32; 2], shift: [f32; 2]) -> ([f32; 3], f32) {
        let [far, near] = self.range;
        let place = |d: f32| [at[0] + shift[0] * d, at[1] + shift[1] * d];
        let steps = ((near - far) * shift[0].hypot(shift[1]) / STEP_PX).ceil().max(1.0);
        let step = (near - far) / steps;
        let mut before = near;
        for i in 0..=steps as u32 {
            let ray = near - step * i as f32;
            let surface = self.depth_at(place(ray));
            if surface < ray {
                before = ray;
                continue;
            }
            if surface - ray > PAST_PX + step {
                // Behind an edge: what is there may be known.
                if let Some(hidden) = self.hidden(place(ray), ray, step) {
                    return hidden;
                }
                continue;
            }
            let ray = self.halved([before, ray], place);
            return (self.bared(self.color_at(place(ray)), place(ray), ray, shift), ray);
        }
        let last = place(far);
        (self.color_at(last), far)
    }

    /// Where the ray meets the surface between two disparities.
    fn halved(&self, [mut before, mut inside]: [f32; 2], place: impl Fn(f32) -> [f32; 2]) -> f32 {
        for _ in 0..4 {
            let middle = (before + inside) / 2.0;
            if self.depth_at(place(middle)) < middle {
                before = middle;
            } else {
                inside = middle;
            }
        }
        (before + inside) / 2.0
    }

    /// What is behind a place, if a ray at that disparity meets it there.
    fn hidden(&self, at: [f32; 2], ray: f32, step: f32) -> Option<([f32; 3], f32)> {
        let [x, y] = self.nearest(at);
        let reader = self.behind.reader(x as i32, 1, self.size);
        let hidden = reader.hidden(reader.at_row(y as i32), 0)?;
        (hidden.share > 0.5 && hidden.disparity_px + step >= ray).then_some((hidden.rgb, hidden.disparity_px))
    }

    /// The colour of a place that has some of a nearer one's beside it, as the far side's where it is seen apart from it.
    fn bared(&self, own: [f32; 3], at: [f32; 2], ray: f32, shift: [f32; 2]) -> [f32; 3] {
        let [x, y] = self.nearest(at);
        let reader = self.behind.reader(x as i32, 1, self.size);
        let Some(hidden) = reader.hidden(reader.at_row(y as i32), 0).filter(|hidden| hidden.share > 0.5) else {
            return own;
        };
        let sides = sides(self.size);
        let beside = Beside::of(&self.depth, sides, y * sides[0] + x, PAST_PX);
        let bare = beside.map_or(0.0, |beside| beside.bare(ray, shift));
        own.mix(hidden.rgb, bare)
    }

    fn nearest(&self, at: [f32; 2]) -> [usize; 2] {
        [0, 1].map(|axis| at[axis].round().clamp(0.0, self.size[axis] as f32 - 1.0) as usize)
    }

    fn depth_at(&self, at: [f32; 2]) -> f32 {
        let [x, y] = self.nearest(at);
        self.depth[y * self.size[0] as usize + x]
    }

    fn color_at(&self, [x, y]: [f32; 2]) -> [f32; 3] {
        bilinear(sides(self.size), x, y, |i| self.light.pixel(i))
    }

    /// The scene of what was seen.
    fn scene(&self, from: &Rgbd, wide: Vec<u16>, map: DisparityMap) -> Result<Rgbd, LensError> {
        let transfer = self.transfer.clone();
        let by: ToSrgb8 = Arc::new(move |part, out| {
            let PixelsPart::Sixteen(px) = part else { return };
            for (i, (to, from)) in out.iter_mut().zip(px).enumerate() {
                *to = if i % 4 < 3 { srgb8_from_linear(transfer.linear_from_16(i % 4, *from)) } else { u8::MAX };
            }
        });
        let mut metadata = from.photo.metadata().clone();
        if from.space == Space::Srgb {
            metadata.icc = None;
        }
        let photo = Photo::converted(self.size, PhotoPixels::Sixteen(Arc::new(wide)), by, metadata)?;
        let photo = match from.photo.source() {
            Some(path) => photo.with_source(path),
            None => photo,
        };
        Ok(Rgbd { photo: Arc::new(photo), disparity: map, behind: None, space: from.space })
    }
}
