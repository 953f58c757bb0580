//! Scenes of Gaussian splats: their views are rendered, and their lens is a true one.

use std::sync::Arc;

use super::picture::{MadeBy, MadeViews, Scene};
use super::{Edit, Making, Need, OutputSize, SceneError, Subject};
use crate::field::{Picture, Size, Strength, ViewGrid};
use crate::job::Job;
use crate::splats::{Painter, Pictured, SplatError, Stage};
use crate::synth::range::{FILM_M, Metric};

/// What people read as the source of depth.
const GAUSSIANS: &str = "Gaussians";

/// What is needed of a scene of splats.
pub(super) fn scene(
    subject: &Arc<Subject>,
    splats: &Pictured,
    how: &Making,
    need: Need,
    job: &Job,
) -> Result<Scene, SceneError> {
    let (map, made_by) = (Arc::clone(&splats.map), MadeBy::named(GAUSSIANS));
    let scene = match need {
        Need::Map => Scene::of_map(subject, map, made_by),
        Need::Views | Need::Some(_) => {
            let views = views(&splats.stage, (how.view_size(subject), need), Strength::AS_MADE, job)?;
            Scene::of_views(subject, Some(map), views, made_by)
        }
    };
    Ok(scene?.in_metres(metric(&splats.stage)))
}

/// The views of a size and a strength, as many as are needed.
pub(super) fn views(
    stage: &Stage,
    (size, need): (Size, Need),
    strength: Strength,
    job: &Job,
) -> Result<MadeViews, SceneError> {
    let grid = ViewGrid::PAPER;
    let (field, depths) = match need.block() {
        Some(block) => stage.some_views(grid, block, (size, strength), job)?,
        None => stage.views(grid, size, strength, job)?,
    };
    Ok(MadeViews { field, depths, provenance: None })
}

/// Metres, where the file's unit is the metre.
fn metric(stage: &Stage) -> Option<Metric> {
    let (rig, [w, h]) = (&stage.rig, stage.size());
    let f35_mm = rig.camera.focal_px.x / w.max(h) as f32 * FILM_M * 1000.0;
    stage.in_metres.then(|| Metric { gain: rig.gain_px() / w as f32, nearness: rig.zero, f35_mm })
}

impl From<SplatError> for SceneError {
    fn from(error: SplatError) -> Self {
        match error {
            SplatError::Cancelled(cancelled) => cancelled.into(),
            SplatError::Field(error) => error.into(),
        }
    }
}

impl Scene {
    /// What a true lens sees: many views over its opening, each of the scene itself. None where the scene is no scene of
    /// splats, or its depth was mended: then the lens renderer has the map.
    ///
    /// # Errors
    /// Stopped.
    pub fn through_true_lens(
        &self,
        edit: &Edit,
        size: OutputSize,
        painter: &dyn Painter,
        job: &Job,
    ) -> Result<Option<Picture>, SceneError> {
        let Some(splats) = self.subject().splats().filter(|_| self.repairs().is_empty()) else { return Ok(None) };
        if size == OutputSize::LightField {
            return Ok(None);
        }
        let size = self.picture_size(size);
        let lens = self.lens_at(edit, size[0]);
        Ok(Some(splats.stage.through_lens(&lens, edit.viewpoint, (size, self.strength()), painter, job)?))
    }
}
