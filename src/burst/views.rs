//! Rays that the reference photo does not see, from the frames that saw them.
//!
//! Such a ray has a depth and so a place in each frame. A frame saw it where nothing nearer of the scene comes to lie
//! there. Of several, those count that agree, and the one that stands nearest to the view counts most.

use std::sync::Arc;

use glam::{DVec2, Vec3};
use rayon::prelude::*;

use super::BurstError;
use super::camera::{Focal, Pose, pixel_of_place, place_of_pixel};
use super::sweep::Frame;
use crate::field::{
    DisparityMap, LightField, Provenance, RayDepths, Seen, Size, View, ViewGrid, ViewIndex, ViewOffset, bilinear, sides,
};
use crate::job::{Job, Stage};
use crate::synth::FarSide;

/// What is nearer than a ray by so many pixels per view step hides it.
const HIDDEN_PX: f32 = 0.15;
/// Colours that differ by so much (root of the mean square, 0 … 255) are not of the same thing.
const ALIKE: f32 = 30.0;
/// No covering surface.
const NOTHING: f32 = f32::NEG_INFINITY;

/// How disparity and inverse depth hang together: `D = gain·(ρ − focus)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Disparity of one inverse baseline, as a share of the picture's width.
    pub gain: f64,
    /// Inverse depth of disparity 0.
    pub focus: f64,
    /// A step between two views, in baselines.
    pub step: f64,
}

impl Step {
    /// Disparity in pixels of a width.
    pub fn disparity_px(&self, inverse_depth: f64, width: u32) -> f64 {
        self.gain * f64::from(width) * (inverse_depth - self.focus)
    }

    /// Inverse depth of a disparity in pixels of a width.
    pub fn inverse_depth(&self, disparity_px: f64, width: u32) -> f64 {
        disparity_px / (self.gain * f64::from(width)) + self.focus
    }

    /// The same with another distance between the views.
    #[must_use]
    pub fn times(self, strength: f64) -> Self {
        Self { gain: self.gain * strength, step: self.step * strength, ..self }
    }
}

/// A frame with what of the scene covers its pixels.
struct Watcher<'a> {
    view: &'a View,
    pose: Pose,
    /// Where it stands, in view steps.
    at: [f64; 2],
    /// Disparity of the surface that covers a pixel.
    cover: Vec<f32>,
}

/// A light field whose rays come from those that saw them, and where each comes from. `frames` are of the views' size.
///
/// # Errors
/// Stopped.
pub fn seen(
    (field, depths): (&LightField, &RayDepths),
    frames: &[Frame],
    focal: Focal,
    step: Step,
    job: &Job,
) -> Result<(Arc<LightField>, Arc<Provenance>), BurstError> {
    let (grid, map) = (field.grid(), depths.reference_map());
    let watchers: Vec<Watcher> = frames.par_iter().map(|frame| Watcher::new(frame, &map, focal, step)).collect();
    let far = FarSide::of_view(field.reference(), &map)?;
    let scene = Scene { size: field.size(), grid, watchers, far, focal, step };
    let views: Vec<ViewIndex> = grid.views().collect();
    let mut made: Vec<(Arc<View>, Vec<Seen>)> = Vec::with_capacity(views.len());
    for (row, some) in views.chunks(grid.cols()).enumerate() {
        job.advance(Stage::Warp, row as u32, grid.rows() as u32)?;
        let some: Result<Vec<_>, BurstError> =
            some.par_iter().map(|at| scene.view(*at, field.view(*at), depths.view(*at))).collect();
        for (view, seen) in some? {
            job.sink.view(views[made.len()], &view);
            made.push((view, seen));
        }
    }
    job.advance(Stage::Warp, grid.rows() as u32, grid.rows() as u32)?;
    let (views, rays): (Vec<_>, Vec<_>) = made.into_iter().unzip();
    let provenance = Provenance::new(grid, field.size(), rays.concat())?;
    Ok((Arc::new(LightField::new(grid, views)?), Arc::new(provenance)))
}

impl<'a> Watcher<'a> {
    fn new(frame: &'a Frame, map: &DisparityMap, focal: Focal, step: Step) -> Self {
        let (size, [w, h]) = (map.size(), sides(map.size()));
        let mut cover = vec![NOTHING; w * h];
        for (i, d) in map.disparity_px().iter().enumerate() {
            let at = place_of_pixel(size, (i % w) as f64, (i / w) as f64);
            let rho = step.inverse_depth((*d).into(), size[0]);
            let to = pixel_of_place(size, focal.seen(&frame.pose, at, rho)).round();
            if to.x >= 0.0 && to.y >= 0.0 && to.x < w as f64 && to.y < h as f64 {
                let cover = &mut cover[to.y as usize * w + to.x as usize];
                *cover = cover.max(*d);
            }
        }
        let centre = frame.pose.centre();
        Self { view: &frame.view, pose: frame.pose, at: [centre.x / step.step, centre.y / step.step], cover }
    }

    /// The colour of a point, if this frame sees it.
    fn colour(&self, at: DVec2, d: f32, scene: &Scene) -> Option<Vec3> {
        let rho = scene.step.inverse_depth(d.into(), scene.size[0]);
        let to = pixel_of_place(scene.size, scene.focal.seen(&self.pose, at, rho)).as_vec2();
        let [w, h] = sides(scene.size);
        if to.x < 0.0 || to.y < 0.0 || to.x > (w - 1) as f32 || to.y > (h - 1) as f32 {
            return None;
        }
        let (x, y) = (to.x.round() as usize, to.y.round() as usize);
        for y in y.saturating_sub(1)..(y + 2).min(h) {
            for x in x.saturating_sub(1)..(x + 2).min(w) {
                if self.cover[y * w + x] > d + HIDDEN_PX {
                    return None;
                }
            }
        }
        let pixels = self.view.pixels();
        Some(bilinear([w, h], to.x, to.y, |i| Vec3::from([0, 1, 2].map(|c| f32::from(pixels[i][c])))))
    }
}

struct Scene<'a> {
    size: Size,
    grid: ViewGrid,
    watchers: Vec<Watcher<'a>>,
    far: FarSide,
    focal: Focal,
    step: Step,
}

impl Scene<'_> {
    fn view(&self, at: ViewIndex, view: &Arc<View>, depths: &[f32]) -> Result<(Arc<View>, Vec<Seen>), BurstError> {
        if at == self.grid.reference() {
            return Ok((Arc::clone(view), vec![Seen::Reference; depths.len()]));
        }
        let (offset, [w, _]) = (self.grid.offset(at), sides(self.size));
        let mut rgba = view.rgba().to_vec();
        let mut from = Vec::with_capacity(depths.len());
        for (i, (pixel, d)) in rgba.chunks_exact_mut(4).zip(depths).enumerate() {
            let unseen = self.far.unseen([i % w, i / w], offset, *d);
            let colour = (unseen > 0.0).then(|| self.colour([i % w, i / w], offset, *d)).flatten();
            from.push(match (unseen > 0.5, colour.is_some()) {
                (false, _) => Seen::Reference,
                (true, true) => Seen::Frame,
                (true, false) => Seen::Invented,
            });
            if let Some(colour) = colour {
                let own = Vec3::from([0, 1, 2].map(|c| f32::from(pixel[c])));
                let mixed = own + (colour - own) * unseen;
                pixel[..3].copy_from_slice(&mixed.to_array().map(|v| v.round().clamp(0.0, 255.0) as u8));
            }
        }
        Ok((Arc::new(View::new(self.size, rgba)?), from))
    }

    /// What the frames saw of a ray.
    fn colour(&self, [x, y]: [usize; 2], offset: ViewOffset, d: f32) -> Option<Vec3> {
        let end = [x as f32 + offset.du * d, y as f32 + offset.dv * d];
        let at = place_of_pixel(self.size, end[0].into(), end[1].into());
        let saw = self.watchers.iter().filter_map(|watcher| {
            let away = (watcher.at[0] - f64::from(offset.du)).powi(2) + (watcher.at[1] - f64::from(offset.dv)).powi(2);
            Some((watcher.colour(at, d, self)?, 1.0 / (1.0 + away as f32 / 4.0)))
        });
        let saw: Vec<(Vec3, f32)> = saw.collect();
        let like = |a: Vec3, b: Vec3| (-(a - b).length_squared() / (3.0 * ALIKE * ALIKE)).exp();
        let support = |of: &(Vec3, f32)| saw.iter().map(|(colour, weight)| weight * like(*colour, of.0)).sum::<f32>();
        let (best, _) = saw.iter().max_by(|a, b| support(a).total_cmp(&support(b)))?;
        let weighed = |(sum, all): (Vec3, f32), (colour, weight): &(Vec3, f32)| {
            let weight = weight * like(*colour, *best);
            (sum + *colour * weight, all + weight)
        };
        let (sum, all) = saw.iter().fold((Vec3::ZERO, 0.0), weighed);
        Some(sum / all)
    }
}
