//! Photos of phones, with the depth that the phone measured, turned to inverse depth: larger is nearer.
//!
//! The depth is extra: whatever is wrong with it becomes a warning, and the photo opens all the same.

pub(crate) mod apple;
pub(crate) mod dynamic;
pub(crate) mod gdepth;
pub(crate) mod heic;
pub(crate) mod jpeg;
pub(crate) mod side_file;
pub(crate) mod spatial;

use crate::field::RelativeDepth;
use crate::io::Problem;
use crate::io::raster;

/// Decodes a grey picture to 0 … 1. It is not turned: that is for the photo's orientation to say.
fn unit_map(bytes: &[u8]) -> Result<RelativeDepth, Problem> {
    let raster = raster::decode(bytes)?;
    let (size, values) = (raster.size, raster.gray());
    Ok(RelativeDepth::new(size, values)?)
}
