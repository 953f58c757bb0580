//! Photos of phones, with the depth that the phone measured, turned to inverse depth: larger is nearer.
//!
//! The depth is extra: whatever is wrong with it becomes a warning, and the photo opens all the same.

mod apple;
mod dynamic;
mod gdepth;
pub(crate) mod heic;
pub(crate) mod jpeg;
pub(crate) mod side_file;
mod spatial;

use crate::io::Problem;
use crate::io::raster::{self, Samples};
use crate::io::sniff::sniff;

/// A map whose values are 0 … 1.
struct UnitMap {
    size: [u32; 2],
    values: Vec<f32>,
}

/// Decodes a grey picture to 0 … 1. It is not turned: that is for the photo's orientation to say.
fn unit_map(bytes: &[u8]) -> Result<UnitMap, Problem> {
    let raster = raster::decode(bytes, sniff(bytes).ok_or(Problem::Unknown)?)?;
    let values = match raster.samples {
        Samples::Eight(px) => px.iter().map(|px| f32::from(px[0]) / 255.0).collect(),
        Samples::Sixteen(px) => px.iter().map(|px| f32::from(px[0]) / 65_535.0).collect(),
    };
    Ok(UnitMap { size: raster.size, values })
}

impl UnitMap {
    fn map(self, inverse_depth: impl Fn(f32) -> f32) -> Self {
        Self { size: self.size, values: self.values.into_iter().map(inverse_depth).collect() }
    }
}
