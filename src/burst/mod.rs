//! Several photos of one subject, taken by a hand that moved a little: depth that was measured, and rays that were seen.
//!
//! ```text
//! photos ─pyramid, track─► matches ─start, adjust─► poses ─gain─► frames ─sweep─► inverse depth
//!        ─fill (with the depth net)─► reference map ─synth─► light field ─views─► rays that other photos saw
//! ```
//!
//! Millimetres are enough, as many points are seen many times: Yu and Gallup, "3D reconstruction from accidental motion"
//! (CVPR 2014); Im et al., "High quality structure from small motion for rolling shutter cameras" (ICCV 2015). What the
//! reference photo sees is the reference photo's; the rest comes from the frames that saw it.

mod adjust;
mod camera;
mod denoise;
mod error;
mod fill;
mod gain;
#[cfg(test)]
pub(crate) mod made;
mod pose;
mod pyramid;
mod sides;
mod start;
mod sweep;
#[cfg(test)]
mod tests;
mod track;
mod views;

use std::sync::Arc;

use rayon::prelude::*;

pub use camera::{Focal, Pose};
pub use error::BurstError;
pub use pose::Posed;
pub use sweep::{Frame, Measured};
pub use views::Step;

use crate::field::{
    DisparityMap, Filter, LightField, Provenance, Raster, RayDepths, Size, View, correlation, fit_long_side,
};
use crate::job::Job;
use crate::synth::{Signed, SynthError, upsample};
use pyramid::Pyramid;

/// Most photos of a burst that are looked at.
pub const MOST: usize = 40;
/// Long side to which frames are brought when they are read: more is not needed.
pub const FRAME_LONG_SIDE: u32 = pyramid::FINEST;
/// Long side of the sweep.
const SWEEP_LONG_SIDE: u32 = 540;
/// How far beyond the points that were matched surfaces are looked for, as a part of their range.
const BEYOND: f64 = 0.35;
/// Nothing is farther than far away: that is looked for too where it is this near to the points, as a part of their range.
const TO_INFINITY: f64 = 1.0;
/// Steps between the reference view and the outermost one.
const STEPS: f64 = 4.0;
/// The widest range of disparities that is taken without being asked for, as a share of the width.
const USUAL_RANGE: f64 = 3.2 / 540.0;

/// What several photos tell.
#[derive(Clone, Debug)]
pub struct Solved {
    /// Where they were taken.
    pub posed: Posed,
    /// The frames that fit, with the reference photo's exposure.
    pub frames: Vec<Frame>,
    /// What was measured, at the size of the sweep.
    pub measured: Measured,
    /// What the light of each frame that was given is multiplied by to be the reference photo's.
    gains: Vec<[f32; 3]>,
    /// Whether what hides what has told near from far: without that both fit, and the depth net is asked.
    knows_sides: bool,
}

/// Finds where frames were taken and measures the reference photo. All pictures have one shape.
///
/// # Errors
/// [`BurstError`]: why there is nothing to be measured; stopped.
pub fn solve(reference: &View, frames: &[View], f35_mm: Option<f32>, job: &Job) -> Result<Solved, BurstError> {
    let base = Pyramid::new(reference);
    let pyramids: Vec<Pyramid> = frames.par_iter().map(Pyramid::new).collect();
    job.check()?;
    let posed = pose::poses(&base, &pyramids, f35_mm, job)?;
    drop(pyramids);
    // Of frames that are left out nobody asks.
    let gains = |(i, view): (usize, &View)| {
        if posed.poses[i].is_none() {
            return [1.0; 3];
        }
        let pairs = posed.points.iter().zip(&posed.seen[i]).filter_map(|(point, seen)| Some((point.0, (*seen)?)));
        gain::gains(reference, view, pairs)
    };
    let gains: Vec<[f32; 3]> = frames.iter().enumerate().map(gains).collect();
    let matched = |(i, view): (usize, &View)| -> Option<Result<Frame, SynthError>> {
        let pose = posed.poses[i]?;
        Some(gain::matched(view, gains[i]).map(|view| Frame { view, pose }).map_err(SynthError::from))
    };
    let frames: Vec<Frame> = frames.iter().enumerate().filter_map(matched).collect::<Result<_, _>>()?;
    let size = fit_long_side(reference.size(), SWEEP_LONG_SIDE);
    let small = resized(reference, size)?;
    let swept = frames_at(&frames, size)?;
    let measured = sweep::measure(&small, &swept, posed.focal, wanted_range(&posed), job)?;
    let is_inside_out = sides::is_inside_out(&small, &measured, &swept, posed.focal);
    let solved = Solved { posed, frames, measured, gains, knows_sides: is_inside_out.is_some() };
    Ok(if is_inside_out == Some(true) { solved.inside_out() } else { solved })
}

fn wanted_range(posed: &Posed) -> [f64; 2] {
    let [far, near] = posed.range();
    let span = near - far;
    let low = far - BEYOND * span;
    let low = if low > 0.0 && far < TO_INFINITY * span { 0.0 } else { low };
    [low, near + BEYOND * span]
}

/// A picture at another size.
fn resized(view: &View, size: Size) -> Result<View, SynthError> {
    if view.size() == size {
        return Ok(view.clone());
    }
    let signed = Signed::resized(view, size, Filter::Lanczos3);
    let rgba = signed.pixels().iter().flat_map(|p| {
        let [r, g, b] = [p.x, p.y, p.z].map(crate::field::color::u8_from_signed);
        [r, g, b, 255]
    });
    Ok(View::new(size, rgba.collect())?)
}

fn frames_at(frames: &[Frame], size: Size) -> Result<Vec<Frame>, SynthError> {
    let at = |frame: &Frame| Ok(Frame { view: resized(&frame.view, size)?, pose: frame.pose });
    frames.par_iter().map(at).collect()
}

impl Solved {
    /// The same with near and far exchanged.
    fn inside_out(mut self) -> Self {
        self.posed.inside_out();
        self.frames.iter_mut().for_each(|frame| frame.pose.translation = -frame.pose.translation);
        let Measured { inverse_depth, certain } = self.measured;
        Self { measured: Measured { inverse_depth: inverse_depth.map(|rho| -rho), certain }, ..self }
    }

    /// The same with near and far as a guess has them, where nothing else tells them apart. Larger is nearer.
    ///
    /// # Errors
    /// None for a map.
    pub fn with_sides_of(self: Arc<Self>, guess: &DisparityMap) -> Result<Arc<Self>, BurstError> {
        if self.knows_sides {
            return Ok(self);
        }
        let guess = guess.resized(self.measured.inverse_depth.size())?;
        let measured = self.measured.inverse_depth.pixels().iter().zip(self.measured.certain.pixels());
        let sure = guess.disparity_px().iter().zip(measured).filter(|(_, (_, certain))| **certain > 0.5);
        let contradicts = correlation(sure.map(|(a, (b, _))| (*a, *b))) < 0.0;
        Ok(if contradicts { Arc::new(Self::clone(&self).inside_out()) } else { self })
    }

    /// How the light field's steps follow from the baseline that was there: `share` of it lies between the reference view
    /// and the outermost ones. Where none is asked for, so much that the scene is not deeper than usual, 1 at most.
    pub fn step(&self, share: Option<f64>) -> (Step, f64) {
        let focal = self.posed.focal;
        let reach = self.frames.iter().map(|frame| frame.pose.centre().truncate().length()).fold(0.0, f64::max);
        let [far, near] = self.posed.range();
        let size = self.measured.inverse_depth.size();
        let shape = f64::from(size[0].max(size[1])) / f64::from(size[0]);
        let whole = Step { gain: focal.0 * shape * reach / STEPS, focus: self.focus(), step: reach / STEPS };
        let usual = (USUAL_RANGE / (whole.gain * (near - far)).max(1e-9)).min(1.0);
        let share = share.unwrap_or(usual);
        (whole.times(share), share)
    }

    /// Inverse depth of the middle of what was matched.
    fn focus(&self) -> f64 {
        let mut all: Vec<f64> = self.posed.points.iter().map(|point| point.1).collect();
        start::median(&mut all)
    }

    /// The map of a reference view; `guess` is the depth net's, in any unit.
    ///
    /// # Errors
    /// Stopped.
    pub fn map(
        &self,
        reference: &View,
        guess: Option<&DisparityMap>,
        step: Step,
        job: &Job,
    ) -> Result<DisparityMap, BurstError> {
        let size = self.measured.inverse_depth.size();
        let small = resized(reference, size)?;
        let guess = guess.map(|guess| guess.resized(size)).transpose().map_err(SynthError::from)?;
        let guess =
            guess.map(|guess| Raster::new(size, guess.into_disparity_px())).transpose().map_err(SynthError::from)?;
        let rho = fill::filled(&self.measured, guess.as_ref(), &small, job.cancel)?;
        let px = rho.map(|rho| step.disparity_px(rho.into(), size[0]) as f32);
        let map = DisparityMap::new(size, px.into_pixels()).map_err(SynthError::from)?;
        Ok(upsample::to_guide(&map, reference, job)?)
    }

    /// The reference photo, of any size, with less noise. `frame` gives a frame by its number as it was taken, none where
    /// it cannot be read again.
    ///
    /// # Errors
    /// Stopped, or what `frame` says.
    pub fn denoised<E: From<BurstError>>(
        &self,
        photo: &View,
        frame: impl Fn(usize) -> Result<Option<View>, E>,
        job: &Job,
    ) -> Result<View, E> {
        let own = |error: SynthError| E::from(BurstError::from(error));
        let size = self.measured.inverse_depth.size();
        let small = resized(photo, size).map_err(own)?;
        let rho = fill::filled(&self.measured, None, &small, job.cancel).map_err(BurstError::from)?;
        let mut mean = denoise::Mean::new(photo, &rho, self.posed.focal);
        let posed: Vec<(usize, Pose)> =
            self.posed.poses.iter().enumerate().filter_map(|(i, pose)| Some((i, (*pose)?))).collect();
        for (done, (i, pose)) in posed.iter().enumerate() {
            denoise::advance(job, done, posed.len())?;
            if let Some(view) = frame(*i)? {
                let view = gain::matched(&view, self.gains[*i]).map_err(BurstError::from)?;
                mean.add(&view, pose, job.cancel)?;
            }
        }
        denoise::advance(job, posed.len(), posed.len())?;
        Ok(mean.finish()?)
    }

    /// A light field of the reference view's map whose rays come from those who saw them, and where each comes from.
    ///
    /// # Errors
    /// Stopped.
    pub fn seen(
        &self,
        made: (&LightField, &RayDepths),
        step: Step,
        job: &Job,
    ) -> Result<(Arc<LightField>, Arc<Provenance>), BurstError> {
        let frames = frames_at(&self.frames, made.0.size())?;
        views::seen(made, &frames, self.posed.focal, step, job)
    }
}
