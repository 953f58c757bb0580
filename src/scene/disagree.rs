//! Edges about which two sources of depth disagree: one of them is wrong there, and nobody knows which.
//!
//! Two sources have two scales, so the other's disparities are brought to those in use by a line that most of both lie on. What
//! they say of wide surfaces may differ still. An edge is agreed on where each map, within the reach of an edge that is a
//! little beside its place, has the disparities that the other one has.

use super::{Content, DepthFrom, Maker, Making, Need, OnePhoto, Scene, SceneError};
use crate::field::{DisparityMap, Filter, Raster, Strength, ramp, resample};
use crate::job::Job;
use crate::repair::Repairs;

/// How far beside its place an edge may lie, as a share of the width: nets see coarsely.
const BESIDE: f32 = 0.012;
/// Round about, by how many times as far, both maps are brought to the same mean.
const ROUND: usize = 3;
/// A step is none, and surely one, when it is this share of the scene's depth.
const STEP: [f32; 2] = [0.1, 0.25];
/// Maps differ not at all and surely by these shares of the scene's depth.
const APART: [f32; 2] = [0.08, 0.2];
/// Rounds in which what lies off the line counts less and less.
const ROUNDS: usize = 4;

impl Maker {
    /// Where the source of a scene's depth and the next best one disagree about an edge, 0 … 1, at the views' size. None
    /// where there is one source alone. The program's own net is run where it is the other source, so this takes a moment.
    ///
    /// # Errors
    /// Stopped, or a scene without views.
    pub fn disagreement(&self, scene: &Scene, how: &Making, job: &Job) -> Result<Option<Raster<f32>>, SceneError> {
        let Content::Photo(one) = &scene.subject().content else { return Ok(None) };
        let Some(source) = self.other_source(one, how, job) else { return Ok(None) };
        // As it came: what was mended is meant to be another than what any source says.
        let making = Making { source, strength: Some(Strength::AS_MADE), repairs: Repairs::default(), ..how.clone() };
        let other = match self.scene(scene.subject(), &making, Need::Map, job) {
            Ok(other) => other,
            Err(stopped @ SceneError::Cancelled(_)) => return Err(stopped),
            Err(error) => {
                log::info!("no second source of depth: {error}");
                return Ok(None);
            }
        };
        let map = |scene: &Scene| Ok::<_, SceneError>(scene.made_views()?.depths.reference_map());
        let (now, as_it_came) = (map(scene)?, map(scene.unmended())?);
        let doubt = disagreement(&as_it_came, other.map());
        let width = now.size()[0] as usize;
        Ok(Some(Raster::par_from_fn(now.size(), |x, y| {
            let i = y * width + x;
            if now.disparity_px()[i] == as_it_came.disparity_px()[i] { doubt.pixels()[i] } else { 0.0 }
        })))
    }

    /// What else a photo's depth could be made from.
    fn other_source(&self, one: &OnePhoto, how: &Making, job: &Job) -> Option<DepthFrom> {
        if one.splats.is_some() || one.several.is_some() {
            return None;
        }
        let quiet = Job { sink: &(), ..*job };
        match self.source_of(one, how, &quiet) {
            DepthFrom::Network => match one.phone {
                Some(_) => Some(DepthFrom::Phone),
                None => how.shelf.as_ref()?.preferred().map(DepthFrom::Model),
            },
            _ => Some(DepthFrom::Network),
        }
    }
}

/// Where two maps disagree about edges, 0 … 1, at the size of the one in use.
pub fn disagreement(used: &DisparityMap, other: &DisparityMap) -> Raster<f32> {
    let size = used.size();
    let other = resample::<1>(other.disparity_px(), other.size(), size, Filter::Linear);
    let [used, other] = [used.disparity_px(), &fitted(used.disparity_px(), &other)].map(|map| {
        let width = size[0] as usize;
        Raster::par_from_fn(size, |x, y| map[y * width + x])
    });
    let depth = depth(used.pixels());
    let reach = ((BESIDE * size[0] as f32).round() as usize).max(1);
    let [used_mean, other_mean] = [&used, &other].map(|map| mean(map, ROUND * reach));
    let other = Raster::par_from_fn(size, |x, y| other.at(x, y) + used_mean.at(x, y) - other_mean.at(x, y));
    let [used_ends, other_ends] = [&used, &other].map(|map| [f32::min, f32::max].map(|of| around(map, reach, of)));
    let beyond = |value: f32, ends: &[Raster<f32>; 2], x, y| {
        (ends[0].at(x, y) - value).max(value - ends[1].at(x, y)).max(0.0) / depth
    };
    let step = |ends: &[Raster<f32>; 2], x, y| (ends[1].at(x, y) - ends[0].at(x, y)) / depth;
    Raster::par_from_fn(size, |x, y| {
        let apart = beyond(used.at(x, y), &other_ends, x, y).max(beyond(other.at(x, y), &used_ends, x, y));
        let step = step(&used_ends, x, y).max(step(&other_ends, x, y));
        ramp(STEP[0], STEP[1], step) * ramp(APART[0], APART[1], apart)
    })
}

/// How deep almost all of a scene is.
fn depth(map: &[f32]) -> f32 {
    let mut all: Vec<f32> = map.iter().step_by((map.len() / 4096).max(1)).copied().collect();
    all.sort_by(f32::total_cmp);
    let at = |share: f32| all[((all.len() - 1) as f32 * share) as usize];
    (at(0.98) - at(0.02)).max(1e-3)
}

/// A map on the scale of another, by the line that most of both lie on.
fn fitted(used: &[f32], other: &[f32]) -> Vec<f32> {
    let step = (used.len() / 8192).max(1);
    let pairs: Vec<[f32; 2]> = used.iter().zip(other).step_by(step).map(|(u, o)| [*o, *u]).collect();
    let tolerance = STEP[0] * depth(used);
    let (mut slope, mut offset) = (0.0, 0.0);
    for round in 0..ROUNDS {
        let weight = |[o, u]: &[f32; 2]| match round {
            0 => 1.0,
            _ => 1.0 / (1.0 + ((u - slope * o - offset) / tolerance).powi(2)),
        };
        let mut sums = [0.0; 5];
        for pair @ [o, u] in &pairs {
            let terms = [1.0, *o, *u, o * o, o * u].map(|term| f64::from(weight(pair) * term));
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        let [n, o, u, oo, ou] = sums;
        // Never the other way round: near stays near.
        let along = ((ou - o * u / n) / (oo - o * o / n).max(1e-12)).max(0.0);
        (slope, offset) = (along as f32, ((u - along * o) / n) as f32);
    }
    other.iter().map(|o| slope * o + offset).collect()
}

/// The least or the greatest value of a square around each place.
fn around(map: &Raster<f32>, reach: usize, of: fn(f32, f32) -> f32) -> Raster<f32> {
    let [width, height] = map.sides();
    let first = map.at(0, 0);
    let fold = |values: &mut dyn Iterator<Item = f32>| values.reduce(of).unwrap_or(first);
    let near = |at: usize, side: usize| at.saturating_sub(reach)..(at + reach + 1).min(side);
    let rows = Raster::par_from_fn(map.size(), |x, y| fold(&mut near(x, width).map(|x| map.at(x, y))));
    Raster::par_from_fn(map.size(), |x, y| fold(&mut near(y, height).map(|y| rows.at(x, y))))
}

/// The mean of a square around each place.
fn mean(map: &Raster<f32>, reach: usize) -> Raster<f32> {
    let [width, height] = map.sides();
    let near = |at: usize, side: usize| at.saturating_sub(reach)..(at + reach + 1).min(side);
    let mean = |values: &mut dyn ExactSizeIterator<Item = f32>| {
        let count = values.len() as f32;
        values.sum::<f32>() / count
    };
    let rows = Raster::par_from_fn(map.size(), |x, y| mean(&mut near(x, width).map(|x| map.at(x, y))));
    Raster::par_from_fn(map.size(), |x, y| mean(&mut near(y, height).map(|y| rows.at(x, y))))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [200, 120];

    fn map(of: impl Fn(f32, f32) -> f32) -> DisparityMap {
        let all = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x as f32, y as f32)));
        DisparityMap::new(SIZE, all.map(|(x, y)| of(x, y)).collect()).unwrap()
    }

    /// A near disc before a wall that leans.
    fn disc(x: f32, y: f32, middle: f32) -> f32 {
        if (x - middle).hypot(y - 60.0) < 30.0 { 1.2 } else { -0.8 + 0.001 * x }
    }

    fn doubtful(used: &DisparityMap, other: &DisparityMap) -> Vec<[usize; 2]> {
        let doubt = disagreement(used, other);
        let width = SIZE[0] as usize;
        let all = doubt.pixels().iter().enumerate().filter(|(_, doubt)| **doubt > 0.5);
        all.map(|(i, _)| [i % width, i / width]).collect()
    }

    #[test]
    fn another_scale_and_an_edge_a_little_beside_are_no_disagreement() {
        let used = map(|x, y| disc(x, y, 100.0));
        let scaled = map(|x, y| 3.0 - 2.0 + 0.4 * disc(x, y, 101.5));
        assert!(doubtful(&used, &scaled).is_empty());
        let bent = map(|x, y| disc(x, y, 100.0) + 0.2 * (x / 60.0).sin());
        assert!(doubtful(&used, &bent).is_empty(), "surfaces may differ gently");
    }

    #[test]
    fn an_edge_elsewhere_is_doubted_along_it_alone() {
        let found = doubtful(&map(|x, y| disc(x, y, 100.0)), &map(|x, y| disc(x, y, 112.0)));
        assert!(found.len() > 200, "{}", found.len());
        assert!(found.iter().all(|[x, y]| {
            let from = |middle: f32| ((*x as f32 - middle).hypot(*y as f32 - 60.0) - 30.0).abs();
            from(100.0).min(from(112.0)) < 14.0
        }));
    }

    #[test]
    fn what_one_of_them_does_not_see_is_doubted_whichever_it_is() {
        let (with, without) = (map(|x, y| disc(x, y, 100.0)), map(|x, _| -0.8 + 0.001 * x + 0.0));
        let post = map(|x, y| if (40.0..46.0).contains(&x) { 1.2 } else { disc(x, y, 130.0) });
        let bare = map(|x, y| disc(x, y, 130.0));
        for (used, other) in [(&post, &bare), (&bare, &post)] {
            let found = doubtful(used, other);
            assert!(found.len() > 300, "{}", found.len());
            assert!(found.iter().all(|[x, _]| (30..60).contains(x)), "{found:?}");
        }
        assert!(!doubtful(&with, &without).is_empty());
    }
}
