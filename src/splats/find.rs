//! A stage for a cloud: its file's own camera, or a first good view that is found; and how deep the scene is from there.

use glam::{Vec2, Vec3};

use super::raster::put_together;
use super::shot::Shot;
use super::tiles::Tiles;
use super::{Camera, Cloud, NamedCamera, Rig, Stage};
use crate::field::{Size, fit_long_side};
use crate::job::{Cancelled, Job};

/// Long side of the pictures that views are compared by, and Gaussians that they are drawn of.
const LOOK_PX: u32 = 120;
const LOOK_GAUSSIANS: usize = 50_000;
/// Width and height of the picture where the file says none.
const USUAL: Size = [1440, 1080];
/// Focal length over the picture's width where the file says none: a phone's main camera.
const USUAL_FOCAL: f32 = 0.75;
/// Rays that end nearer or farther than all but this part do not count for the scene's depth.
const TAIL: f32 = 0.02;
/// Gaussians that are fainter are not looked at when their middle is looked for.
const FAINT: f32 = 0.1;
/// A cloud lies before the origin when all but this part does, and a view from there must be covered so far.
const BEFORE: f32 = 0.97;
const COVERED: f32 = 0.8;
/// Directions round the middle that are tried, angles above it, and distances in radii.
const ROUND: usize = 12;
const ABOVE: [f32; 2] = [0.15, 0.5];
const DISTANCES: [f32; 2] = [1.6, 3.0];

impl Stage {
    /// A cloud seen by its file's camera, or from where it looks good.
    ///
    /// # Errors
    /// Stopped.
    pub fn new(cloud: Cloud, camera: Option<Camera>, job: &Job) -> Result<Self, Cancelled> {
        let thin = cloud.thinned(LOOK_GAUSSIANS);
        let (camera, named) = match camera {
            Some(camera) => (camera, NamedCamera::File),
            None => (found(&thin, job)?, NamedCamera::Found),
        };
        let ends = Look::of(&thin, &camera, job)?.ends();
        Ok(Self { cloud, rig: Rig::for_range(camera, ends), named, ends, in_metres: false })
    }
}

/// A small picture that a camera is judged by.
struct Look {
    /// Inverse distances of its rays, in order; those without end are left out.
    nearness: Vec<f32>,
    /// Part of the picture that is covered.
    covered: f32,
    /// Mean difference of neighbouring pixels: how much there is to see.
    detail: f32,
    /// Part of the picture that lies much nearer than the rest: fog before the lens.
    fog: f32,
}

impl Look {
    fn of(thin: &Cloud, camera: &Camera, job: &Job) -> Result<Self, Cancelled> {
        let size = fit_long_side(camera.size, LOOK_PX);
        let camera = camera.resized(size);
        let rig = Rig { camera, step: 0.0, zero: 0.0, near: nearest(thin, &camera) };
        let shown = put_together(&Tiles::seen(thin, &Shot::view(rig, Vec2::ZERO), job)?, job)?;
        let solid = |at: &usize| shown.cover[*at] > 0.5;
        let mut nearness: Vec<f32> = (0..shown.cover.len()).filter(solid).map(|at| shown.nearness[at]).collect();
        nearness.sort_by(f32::total_cmp);
        let count = shown.cover.len() as f32;
        let covered = shown.cover.iter().sum::<f32>() / count;
        let width = size[0] as usize;
        let light = |at: usize| shown.rgb[at].iter().sum::<f32>() / 3.0;
        let pairs = (0..shown.rgb.len() - width).map(|at| (light(at) - light(at + width)).abs().min(0.3));
        let detail = pairs.sum::<f32>() / count;
        let middle = nearness.get(nearness.len() / 2).copied().unwrap_or(0.0);
        let fog = nearness.iter().filter(|n| **n > 6.0 * middle).count() as f32 / count;
        Ok(Self { nearness, covered, detail, fog })
    }

    /// Inverse distances of the far and the near end.
    fn ends(&self) -> [f32; 2] {
        let Some(last) = self.nearness.len().checked_sub(1) else { return [0.5, 1.0] };
        let at = |share: f32| self.nearness[(last as f32 * share).round() as usize];
        let [far, near] = [at(TAIL), at(1.0 - TAIL)];
        if near.is_normal() && far >= 0.0 { [far, near.max(far * 1.0001)] } else { [0.5, 1.0] }
    }

    fn score(&self) -> f32 {
        self.covered + 4.0 * self.detail - 2.0 * self.fog
    }
}

/// What is nearer is left out while a camera is judged: a part of the distance that most lies beyond.
fn nearest(cloud: &Cloud, camera: &Camera) -> f32 {
    let distances = cloud.gaussians.iter().map(|gaussian| camera.seen(gaussian.center).z).filter(|z| *z > 0.0);
    let mut distances: Vec<f32> = distances.collect();
    distances.sort_by(f32::total_cmp);
    distances.get(distances.len() / 20).map_or(0.01, |z| 0.2 * z).max(1e-6)
}

/// A view of a cloud whose file names none: from the origin where the cloud lies before it, else the best of those around
/// its middle.
fn found(thin: &Cloud, job: &Job) -> Result<Camera, Cancelled> {
    if let Some(camera) = from_origin(thin)
        && Look::of(thin, &camera, job)?.covered > COVERED
    {
        return Ok(camera);
    }
    let (middle, radius) = middle_of(thin);
    let mut best: Option<(f32, Camera)> = None;
    for distance in DISTANCES {
        for above in ABOVE {
            for turn in 0..ROUND {
                let angle = turn as f32 / ROUND as f32 * std::f32::consts::TAU;
                let away = Vec3::new(angle.sin() * above.cos(), -above.sin(), -angle.cos() * above.cos());
                let from = middle + away * radius * distance;
                let camera = Camera::looking(from, middle, Vec3::Y, USUAL_FOCAL * USUAL[0] as f32, USUAL);
                let score = Look::of(thin, &camera, job)?.score();
                if best.as_ref().is_none_or(|(most, _)| score > *most) {
                    best = Some((score, camera));
                }
            }
        }
    }
    let usual = Camera::at_origin(USUAL_FOCAL * USUAL[0] as f32, USUAL);
    Ok(best.map_or(usual, |(_, camera)| camera))
}

/// The camera that a cloud was made from that lies before the origin, as those made of one picture do.
fn from_origin(thin: &Cloud) -> Option<Camera> {
    let before = thin.gaussians.iter().filter(|gaussian| gaussian.center.z > 0.0);
    let slopes: Vec<Vec2> = before.map(|gaussian| gaussian.center.truncate() / gaussian.center.z).collect();
    if (slopes.len() as f32) < BEFORE * thin.gaussians.len() as f32 || slopes.is_empty() {
        return None;
    }
    let reach = |axis: usize| {
        let mut all: Vec<f32> = slopes.iter().map(|slope| slope[axis].abs()).collect();
        all.sort_by(f32::total_cmp);
        all[(all.len() - 1) * 19 / 20] / 0.95
    };
    let [across, down] = [reach(0), reach(1)];
    let is_picture = (0.1..3.0).contains(&across) && (0.1..3.0).contains(&down);
    let long = USUAL[0] as f32;
    let scale = long / across.max(down);
    let size = [across, down].map(|reach| ((reach * scale) as u32).max(64));
    is_picture.then(|| Camera::at_origin(long / (2.0 * across.max(down)), size))
}

/// Middle of a cloud and the distance within which half of it lies, by medians.
fn middle_of(thin: &Cloud) -> (Vec3, f32) {
    let solid = || thin.gaussians.iter().filter(|gaussian| gaussian.opacity > FAINT).map(|gaussian| gaussian.center);
    let median = |mut values: Vec<f32>| {
        values.sort_by(f32::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    let middle = Vec3::from([0, 1, 2].map(|axis| median(solid().map(|center| center[axis]).collect())));
    let radius = median(solid().map(|center| center.distance(middle)).collect());
    (middle, radius.max(1e-6))
}
