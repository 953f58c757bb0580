//! The same scene deeper or flatter: every disparity times the strength ([`crate::field`]), without running a net again.
//!
//! Of a photo all comes from its map: views are rendered from it anew, and what no view of the photo shows is its far
//! side's ([`synthesize_bared`]). A recorded light field keeps its own rays: its views stand closer together, between
//! those that were recorded, and so its strength ends at 1.

use std::sync::Arc;

use rayon::prelude::*;

use super::picture::{MadeViews, Scene};
use super::{Content, Making, Need, OnePhoto, SceneError, several};
use crate::field::{LightField, RayDepths, Strength, View, ViewGrid, ViewIndex, ViewOffset, ViewPoint, fit_long_side};
use crate::job::{Job, Stage};
use crate::render::cpu;
use crate::synth::{SynthParams, lift, synthesize_bared};

impl Scene {
    /// The scene at a strength, of which as much is made as is needed; itself where it has that strength.
    ///
    /// # Errors
    /// [`SceneError`]: stopped, or too little memory for the views.
    pub fn at_strength(&self, wanted: Strength, how: &Making, need: Need, job: &Job) -> Result<Self, SceneError> {
        let strength = self.subject().strength(wanted);
        if self.strength() == strength && (need == Need::Map || self.views().is_some()) {
            return Ok(self.clone());
        }
        let made = self.as_made();
        if strength == Strength::AS_MADE {
            return Ok(made.clone());
        }
        let scene = made.with_map_at(strength);
        let views = match (&made.subject().content, made.views()) {
            (Content::Views(_), Some(views)) => closer(views, strength, job)?,
            (Content::Photo(one), _) if need != Need::Map => scene.of_photo(one, how, need, job)?,
            _ => return Ok(scene),
        };
        Ok(scene.with_views(views))
    }

    /// The views as they are written: a dark light field is shown brighter than it is stored.
    pub(super) fn stored(&self, job: &Job) -> Result<Arc<LightField>, SceneError> {
        let views = self.made_views()?;
        match self.subject().recorded() {
            Some(recorded) if self.strength() == Strength::AS_MADE => Ok(Arc::clone(recorded.as_stored())),
            Some(recorded) if recorded.stored.is_some() => {
                let depths = &self.as_made().made_views()?.depths;
                between(recorded.as_stored(), depths, self.strength(), job)
            }
            _ => Ok(Arc::clone(&views.field)),
        }
    }

    fn of_photo(&self, one: &OnePhoto, how: &Making, need: Need, job: &Job) -> Result<MadeViews, SceneError> {
        let of_views = |views: &MadeViews| views.field.size().into_iter().max();
        let long_side = self.as_made().views().and_then(of_views).unwrap_or(how.long_side);
        if let Some(splats) = &one.splats {
            let size = fit_long_side(one.photo.size(), long_side.max(1));
            return super::splats::views(&splats.stage, (size, need), self.strength(), job);
        }
        let params = SynthParams { long_side, threads: how.threads, ..SynthParams::default() };
        let made = synthesize_bared(&one.photo, self.map(), &params, job)?;
        several::stronger(one, made, self.strength().0, job)
    }
}

/// A recorded light field whose views stand closer together, with the disparities that they then have.
fn closer(views: &MadeViews, strength: Strength, job: &Job) -> Result<MadeViews, SceneError> {
    let MadeViews { field, depths, .. } = views;
    let map = depths.reference_map().at_strength(strength);
    let field = between(field, depths, strength, job)?;
    let depths = Arc::new(lift::lifted(&map, field.grid(), job)?);
    Ok(MadeViews { field, depths, provenance: None })
}

/// What is seen from `s·u`, for every view `u`.
fn between(
    field: &LightField,
    depths: &RayDepths,
    Strength(strength): Strength,
    job: &Job,
) -> Result<Arc<LightField>, SceneError> {
    let grid = field.grid();
    let seen = |at: ViewIndex| {
        if at == grid.reference() {
            return Ok(Arc::clone(field.view(at)));
        }
        let ViewOffset { dv, du } = grid.offset(at);
        let point = ViewPoint(ViewOffset { dv: dv * strength, du: du * strength });
        let picture = cpu::view_with_depths(field, Some(depths), point);
        View::new(field.size(), picture.to_srgb8()).map(Arc::new)
    };
    let mut views = Vec::with_capacity(grid.count());
    for row in 0..grid.rows() {
        job.advance(Stage::Warp, row as u32, grid.rows() as u32)?;
        let row: Vec<_> = (0..grid.cols()).into_par_iter().map(|u| seen(index(row, u))).collect();
        for view in row {
            views.push(view?);
        }
    }
    job.advance(Stage::Warp, grid.rows() as u32, grid.rows() as u32)?;
    Ok(Arc::new(LightField::new(grid, views)?))
}

fn index(v: usize, u: usize) -> ViewIndex {
    debug_assert!(v.max(u) < ViewGrid::MAX_SIDE);
    ViewIndex { v: v as u8, u: u as u8 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::DisparityMap;
    use crate::job::Cancel;
    use crate::scene::{DepthFrom, Maker, Recorded, Subject};

    fn made(subject: Subject, strength: f32) -> Scene {
        let how = Making {
            long_side: 96,
            occlusion: false,
            source: DepthFrom::Map,
            strength: Some(Strength(strength)),
            ..Making::default()
        };
        let job = Job { cancel: &Cancel::default(), sink: &() };
        Maker::default().scene(&Arc::new(subject), &how, Need::Views, &job).unwrap()
    }

    fn photo(strength: f32) -> Scene {
        let sample = Subject::sample().unwrap();
        let Content::Photo(one) = &sample.content else { panic!("the sample is a photo") };
        let truth = crate::io::formats::depth_map::GivenDepth::Disparity(Arc::clone(one.truth.as_ref().unwrap()));
        made(sample.with_own_map(truth), strength)
    }

    fn recorded(strength: f32) -> Scene {
        let MadeViews { field, depths, .. } = photo(1.0).made_views().unwrap().clone();
        let content = Content::Views(Recorded {
            shown: field,
            stored: None,
            depths: Some(depths),
            reference: None,
            provenance: None,
            layout: Default::default(),
        });
        made(Subject { name: String::new(), path: None, file: None, info: None, content }, strength)
    }

    /// Mean difference of two views, 0 … 255.
    fn apart(a: &View, b: &View) -> f32 {
        let sum: u32 = a.rgba().iter().zip(b.rgba()).map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
        sum as f32 / a.rgba().len() as f32
    }

    #[test]
    fn every_disparity_is_multiplied_and_the_photo_stays() {
        let (plain, deep) = (photo(1.0), photo(2.0));
        let maps = plain.map().disparity_px().iter().zip(deep.map().disparity_px());
        assert!(maps.clone().all(|(plain, deep)| *deep == 2.0 * plain));
        let views = [&plain, &deep].map(|scene| scene.made_views().unwrap());
        assert_eq!(views[0].field.reference(), views[1].field.reference());
        let rays = views[0].depths.reference().iter().zip(views[1].depths.reference());
        assert!(rays.clone().all(|(plain, deep)| (deep - 2.0 * plain).abs() < 1e-5));
        // What two steps show at half the baseline one step shows at the whole one.
        let view = |scene: usize, u| views[scene].field.view(ViewIndex { v: 4, u });
        for (near, far) in [(5, 6), (3, 2)] {
            let (same, other) = (apart(view(1, near), view(0, far)), apart(view(1, near), view(0, near)));
            assert!(same < 0.5 * other, "{near}: {same} of 255, and {other} without strength");
        }
    }

    #[test]
    fn a_scene_comes_back_to_what_was_made() {
        let (plain, how) = (photo(1.0), Making::default());
        let job = Job { cancel: &Cancel::default(), sink: &() };
        let deep = plain.at_strength(Strength(3.0), &how, Need::Views, &job).unwrap();
        assert_eq!((deep.strength(), deep.subject_at()), (Strength(3.0), plain.subject_at()));
        assert_eq!(deep.made_views().unwrap().field.size(), plain.made_views().unwrap().field.size());
        let back = deep.at_strength(Strength::AS_MADE, &how, Need::Views, &job).unwrap();
        assert!(Arc::ptr_eq(back.map(), plain.map()));
        assert!(Arc::ptr_eq(&back.made_views().unwrap().field, &plain.made_views().unwrap().field));
    }

    #[test]
    fn recorded_views_come_closer_and_never_stand_farther_apart() {
        let (whole, half, more) = (recorded(1.0), recorded(0.5), recorded(2.0));
        assert_eq!((half.strength(), more.strength()), (Strength(0.5), Strength::AS_MADE));
        let view = |scene: &Scene, u| Arc::clone(scene.made_views().unwrap().field.view(ViewIndex { v: 4, u }));
        for (out, in_) in [(6, 5), (2, 3), (4, 4)] {
            assert!(apart(&view(&half, out), &view(&whole, in_)) < 1.0, "{out}");
        }
        let px = |scene: &Scene| scene.made_views().unwrap().depths.range_px();
        assert!((px(&half)[1] - 0.5 * px(&whole)[1]).abs() < 1e-5);
    }

    #[test]
    fn a_map_stays_finite() {
        let map = DisparityMap::constant([2, 2], 3e38).at_strength(Strength(4.0));
        assert!(map.range_px()[1].is_finite());
    }
}
