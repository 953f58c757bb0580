//! The order in which poses are found: matches, rotations, a first structure, and all of it adjusted together.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::BurstError;
use super::adjust::{Bundle, Freedom, Tracks};
use super::camera::{Focal, Pose, pixel_of_place, place_of_pixel};
use super::pyramid::{Pyramid, corners};
use super::start::{self, Pair, median};
use super::track::track;
use crate::field::Size;
use crate::job::{Cancel, Cancelled, Job, Stage};

/// Corners that are looked for, and where there are many frames.
const CORNERS: [usize; 2] = [1200, 500];
/// Frames from which on there are many.
const MANY: usize = 12;
/// A frame with fewer matches than these, or than this share of the corners, shows something else.
const FEWEST: usize = 24;
const LEAST_SHARE: f64 = 0.12;
/// A frame of which less than this share of the matches fits its pose is left out.
const FITTING: f64 = 0.4;
/// Usual residuals while the structure becomes known, in pixels of the finest level.
const USUAL_PX: [f64; 3] = [3.0, 1.2, 0.7];
/// Matches that are farther off than so many pixels then are wrong, or move by themselves.
const WRONG_PX: [f64; 2] = [6.0, 2.5];
/// Parallax, in pixels of the finest level, below which nothing can be measured: what a rotation leaves of three quarters
/// of the points.
const STILL_PX: f64 = 0.35;
/// Parallax in residuals below which it may be chance.
const CLEAR: f64 = 6.0;
/// Movement of the whole picture below which the camera stood still, in the same pixels.
const HELD_PX: f64 = 2.0;
/// Share of the cost that is left where a rolling shutter is believed. On made scenes 0.98 and more is left where there is
/// none, 0.8 where one turns by 0.002, and up to there the order of depths is as good without.
const ROLLS: f64 = 0.8;
/// How far off a focal length usually is: from EXIF, and where nothing says it.
const FOCAL_OFF: [f64; 2] = [0.02, 0.15];

/// Frames whose cameras are known.
#[derive(Clone, Debug)]
pub struct Posed {
    /// Of all frames.
    pub focal: Focal,
    /// Of the other frames; none of what was left out.
    pub poses: Vec<Option<Pose>>,
    /// Points that were matched: place in the reference frame, and inverse depth.
    pub points: Vec<(DVec2, f64)>,
    /// Places of the points in the other frames that fit.
    pub seen: Vec<Vec<Option<DVec2>>>,
    /// Median distance of where points are seen from where they should be, in pixels of the finest level.
    pub reprojection_px: f64,
}

/// Finds the poses of frames against the reference frame.
///
/// # Errors
/// [`BurstError`]: nothing fits, the camera stood still or only turned; stopped.
pub fn poses(reference: &Pyramid, others: &[Pyramid], f35_mm: Option<f32>, job: &Job) -> Result<Posed, BurstError> {
    let tracks = tracks(reference, others, job)?;
    let focal = Focal::of_f35(f35_mm.unwrap_or(crate::synth::range::USUAL_F35_MM));
    let is_like = tracks.seen.iter().map(|seen| is_like(seen)).collect::<Vec<_>>();
    if !is_like.contains(&true) {
        return Err(BurstError::Unlike);
    }
    let strongest = strongest(&tracks, &is_like, focal)?;
    job.advance(Stage::Poses, 1, 3)?;
    let bundle = first(&tracks, &is_like, (focal, strongest), job.cancel)?;
    job.advance(Stage::Poses, 2, 3)?;
    let posed = settled(bundle, tracks, (&is_like, f35_mm.is_some()), job.cancel)?;
    job.advance(Stage::Poses, 3, 3)?;
    Ok(posed)
}

fn is_like(seen: &[Option<DVec2>]) -> bool {
    let count = seen.iter().flatten().count();
    count >= FEWEST && count as f64 >= LEAST_SHARE * seen.len() as f64
}

fn tracks(reference: &Pyramid, others: &[Pyramid], job: &Job) -> Result<Tracks, BurstError> {
    let wanted = CORNERS[usize::from(others.len() >= MANY)];
    let size = reference.finest().size();
    let found = corners(reference.finest(), wanted);
    let place = |size: Size, [x, y]: [f32; 2]| place_of_pixel(size, x.into(), y.into());
    let mut seen = Vec::with_capacity(others.len());
    for (i, other) in others.iter().enumerate() {
        job.advance(Stage::Match, i as u32, others.len() as u32)?;
        let there = track(reference, other, &found);
        seen.push(there.into_iter().map(|at| at.map(|at| place(other.finest().size(), at))).collect());
    }
    job.advance(Stage::Match, others.len() as u32, others.len() as u32)?;
    let points = found.into_iter().map(|at| place(size, at)).collect();
    Ok(Tracks { points, seen, px: 1.0 / f64::from(size[0].max(size[1])) })
}

fn pairs(tracks: &Tracks, frame: usize) -> Vec<Pair> {
    tracks.points.iter().zip(&tracks.seen[frame]).filter_map(|(from, to)| Some((*from, (*to)?))).collect()
}

/// The frame that tells most of depth: its rotation leaves most.
fn strongest(tracks: &Tracks, is_like: &[bool], focal: Focal) -> Result<usize, BurstError> {
    let of = |frame: usize| {
        let pairs = pairs(tracks, frame);
        let (rotation, _) = start::rotation(focal, &pairs, tracks.px);
        let mut left: Vec<f64> =
            pairs.iter().map(|(from, to)| (focal.place(rotation * focal.ray(*from)) - *to).length()).collect();
        left.sort_by(f64::total_cmp);
        let mut moved: Vec<f64> = pairs.iter().map(|(from, to)| (*to - *from).length()).collect();
        let three_quarters = left.get(left.len() * 3 / 4).copied().unwrap_or_default() / tracks.px;
        (frame, three_quarters, median(&mut moved) / tracks.px, (pairs.len() as f64).sqrt())
    };
    let all: Vec<_> = (0..is_like.len()).filter(|frame| is_like[*frame]).map(of).collect();
    let most = |part: fn(&(usize, f64, f64, f64)) -> f64| all.iter().map(part).fold(0.0, f64::max);
    if most(|of| of.1) < STILL_PX {
        return Err(if most(|of| of.2) < HELD_PX { BurstError::Still } else { BurstError::OnlyTurned });
    }
    let best = all.iter().max_by(|a, b| (a.1 * a.3).total_cmp(&(b.1 * b.3)));
    Ok(best.map_or(0, |of| of.0))
}

/// The best of several first structures, each of them adjusted a little.
fn first(
    tracks: &Tracks,
    is_like: &[bool],
    (focal, strongest): (Focal, usize),
    cancel: &Cancel,
) -> Result<Bundle, Cancelled> {
    let guesses = start::poses(focal, &pairs(tracks, strongest), tracks.px);
    let depths = |pose: &Pose| -> Vec<f64> {
        let of = |point: usize| {
            let to = tracks.seen[strongest][point]?;
            start::inverse_depth(focal, pose, tracks.points[point], to)
        };
        let all: Vec<Option<f64>> = (0..tracks.points.len()).map(of).collect();
        let middle = median(&mut all.iter().flatten().copied().collect::<Vec<_>>());
        all.into_iter().map(|depth| depth.unwrap_or(middle)).collect()
    };
    let turned_inside_out = |depths: &[f64]| -> Vec<f64> {
        let middle = median(&mut depths.to_vec());
        depths.iter().map(|depth| 2.0 * middle - depth).collect()
    };
    let tried: Vec<Vec<f64>> =
        guesses.iter().map(depths).flat_map(|depths| [turned_inside_out(&depths), depths]).collect();
    let adjusted = |inverse_depths: Vec<f64>| -> Result<(f64, Bundle), Cancelled> {
        cancel.check()?;
        let pose = |frame: usize| match is_like[frame] {
            true => resected(tracks, focal, frame, &inverse_depths),
            false => Pose::REFERENCE,
        };
        let poses = (0..is_like.len()).map(pose).collect();
        let rigid = Freedom { focal: None, rolling: false };
        let bundle = Bundle { focal, poses, inverse_depths }.adjusted(tracks, USUAL_PX[0], rigid, cancel)?;
        let bundle = bundle.adjusted(tracks, USUAL_PX[1], rigid, cancel)?;
        Ok((bundle.cost(tracks, USUAL_PX[1]), bundle))
    };
    let all = tried.into_par_iter().map(adjusted).collect::<Result<Vec<_>, _>>()?;
    let best = all.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let none = || Bundle {
        focal,
        poses: vec![Pose::REFERENCE; is_like.len()],
        inverse_depths: vec![0.0; tracks.points.len()],
    };
    Ok(best.map_or_else(none, |best| best.1))
}

/// The pose of a frame that sees points of known depth.
fn resected(tracks: &Tracks, focal: Focal, frame: usize, inverse_depths: &[f64]) -> Pose {
    let alone = Tracks { points: tracks.points.clone(), seen: vec![tracks.seen[frame].clone()], px: tracks.px };
    let (rotation, _) = start::rotation(focal, &pairs(tracks, frame), tracks.px);
    let pose = Pose { rotation, ..Pose::REFERENCE };
    let bundle = Bundle { focal, poses: vec![pose], inverse_depths: inverse_depths.to_vec() };
    bundle.with_poses_found(&alone, USUAL_PX[0]).poses[0]
}

/// Adjusts everything, leaves out what does not fit, and adjusts again.
fn settled(
    bundle: Bundle,
    mut tracks: Tracks,
    (is_like, knows_focal): (&[bool], bool),
    cancel: &Cancel,
) -> Result<Posed, BurstError> {
    let tracked: Vec<usize> = tracks.seen.iter().map(|seen| seen.iter().flatten().count()).collect();
    for (frame, like) in is_like.iter().enumerate() {
        if !like {
            tracks.seen[frame].fill(None);
        }
    }
    let is_many = is_like.iter().filter(|like| **like).count() >= 3;
    let freedom = Freedom { focal: is_many.then_some(FOCAL_OFF[usize::from(!knows_focal)]), rolling: is_many };
    let mut bundle = bundle;
    for (usual, wrong) in [USUAL_PX[1], USUAL_PX[2]].into_iter().zip(WRONG_PX) {
        bundle = plainest(bundle, &tracks, (usual, freedom), cancel)?;
        for frame in 0..is_like.len() {
            for point in 0..tracks.points.len() {
                let residual = bundle.residual(&tracks, frame, point);
                if residual.is_some_and(|residual| residual.length() > wrong * tracks.px) {
                    tracks.seen[frame][point] = None;
                }
            }
        }
    }
    let bundle = plainest(bundle, &tracks, (USUAL_PX[2], freedom), cancel)?;
    posed(bundle, tracks, &tracked)
}

/// The bundle adjusted without a rolling shutter, and with one only where that explains much more: a floor that comes nearer
/// from row to row looks like one, as far as small motion tells.
fn plainest(
    bundle: Bundle,
    tracks: &Tracks,
    (usual_px, freedom): (f64, Freedom),
    cancel: &Cancel,
) -> Result<Bundle, Cancelled> {
    let still = bundle.poses.iter().map(|pose| Pose { turning: DVec3::ZERO, ..*pose }).collect();
    let rigid = Freedom { rolling: false, ..freedom };
    let whole = Bundle { poses: still, ..bundle }.adjusted(tracks, usual_px, rigid, cancel)?;
    if !freedom.rolling {
        return Ok(whole);
    }
    let rolled = whole.clone().adjusted(tracks, usual_px, freedom, cancel)?;
    Ok(if rolled.cost(tracks, usual_px) < ROLLS * whole.cost(tracks, usual_px) { rolled } else { whole })
}

fn posed(bundle: Bundle, tracks: Tracks, tracked: &[usize]) -> Result<Posed, BurstError> {
    let fits = |frame: usize| {
        let count = tracks.seen[frame].iter().flatten().count();
        count >= FEWEST && count as f64 > FITTING * tracked[frame] as f64
    };
    let poses: Vec<Option<Pose>> = bundle.poses.iter().enumerate().map(|(i, pose)| fits(i).then_some(*pose)).collect();
    if poses.iter().all(Option::is_none) {
        return Err(BurstError::Unlike);
    }
    let count =
        |point: usize| (0..poses.len()).filter(|f| poses[*f].is_some() && tracks.seen[*f][point].is_some()).count();
    let least = if poses.iter().flatten().count() > 3 { 2 } else { 1 };
    let kept: Vec<usize> = (0..tracks.points.len()).filter(|point| count(*point) >= least).collect();
    let of = |frame: usize| kept.iter().map(move |point| (frame, *point));
    let pairs = (0..poses.len()).filter(|frame| poses[*frame].is_some()).flat_map(of);
    let mut residuals: Vec<f64> = pairs
        .filter_map(|(frame, point)| bundle.residual(&tracks, frame, point))
        .map(|r| r.length() / tracks.px)
        .collect();
    let points: Vec<(DVec2, f64)> = kept.iter().map(|i| (tracks.points[*i], bundle.inverse_depths[*i])).collect();
    let seen = tracks.seen.iter().map(|seen| kept.iter().map(|i| seen[*i]).collect()).collect();
    let posed = Posed { focal: bundle.focal, poses, points, seen, reprojection_px: median(&mut residuals) };
    let least = CLEAR * posed.reprojection_px;
    if posed.parallax(1.0 / tracks.px) < least { Err(BurstError::OnlyTurned) } else { Ok(posed) }
}

impl Posed {
    /// Inverse depths of the 3rd and 97th percentile of the points.
    pub fn range(&self) -> [f64; 2] {
        let mut all: Vec<f64> = self.points.iter().map(|point| point.1).collect();
        all.sort_by(f64::total_cmp);
        let at = |share: f64| all.get(((all.len().max(1) - 1) as f64 * share) as usize).copied().unwrap_or(0.0);
        [at(0.03), at(0.97)]
    }

    /// How far far and near points move apart at most, in pixels of a picture of this long side.
    pub fn parallax(&self, long_side: f64) -> f64 {
        let [far, near] = self.range();
        let moved =
            |pose: &Pose| (self.focal.seen(pose, DVec2::ZERO, near) - self.focal.seen(pose, DVec2::ZERO, far)).length();
        self.poses.iter().flatten().map(moved).fold(0.0, f64::max) * long_side
    }

    /// The same with near and far exchanged, which the same places of the points allow.
    pub fn inside_out(&mut self) {
        self.poses.iter_mut().flatten().for_each(|pose| pose.translation = -pose.translation);
        self.points.iter_mut().for_each(|point| point.1 = -point.1);
    }

    /// Pixel of the reference frame of this size that a point is.
    pub fn pixel(&self, size: Size, point: usize) -> DVec2 {
        pixel_of_place(size, self.points[point].0)
    }
}
