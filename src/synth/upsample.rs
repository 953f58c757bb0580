//! Ray depth at the light field's size, with the photo as guide, so that edges sit on edges.

use super::resample::{Filter, resample};
use crate::field::{DisparityMap, View};

/// Brings a map to the size of its guide; values are multiplied by the ratio of widths.
pub fn to_guide(map: &DisparityMap, guide: &View) -> DisparityMap {
    let (source, target) = (map.size.map(|s| s as usize), guide.size().map(|s| s as usize));
    let ratio = target[0] as f32 / source[0] as f32;
    let disparity_px = resample::<1>(&map.disparity_px, source, target, Filter::Linear);
    DisparityMap { size: guide.size(), disparity_px: disparity_px.iter().map(|d| d * ratio).collect() }
}
