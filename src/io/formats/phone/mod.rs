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

use crate::io::Problem;
use crate::io::raster;

/// A map whose values are 0 … 1.
struct UnitMap {
    size: [u32; 2],
    values: Vec<f32>,
}

/// Decodes a grey picture to 0 … 1. It is not turned: that is for the photo's orientation to say.
fn unit_map(bytes: &[u8]) -> Result<UnitMap, Problem> {
    let raster = raster::decode(bytes)?;
    Ok(UnitMap { size: raster.size, values: raster.gray() })
}

impl UnitMap {
    fn map(self, inverse_depth: impl Fn(f32) -> f32) -> Self {
        Self { size: self.size, values: self.values.into_iter().map(inverse_depth).collect() }
    }
}
