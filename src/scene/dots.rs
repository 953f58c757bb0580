//! A scene as points in space, to be looked at from any side.

use super::{Scene, SceneError};
use crate::job::Job;
pub use crate::splats::{Dots, Gathered, Turn};
use crate::synth::range::FILM_M;

impl Scene {
    /// The points that its rays end at, through the camera's own focal length where the file says it.
    ///
    /// # Errors
    /// Stopped, or the scene has no views.
    pub fn dots(&self, gathered: Gathered, job: &Job) -> Result<Dots, SceneError> {
        let views = self.made_views()?;
        let focal = self.subject().f35_mm().map(|mm| mm / (FILM_M * 1000.0));
        Ok(Dots::of(&views.field, &views.depths, focal, gathered, job)?)
    }
}
