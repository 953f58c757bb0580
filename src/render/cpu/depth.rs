//! Ray depths of one view as a picture. Twin of `depth.wgsl`.

use super::Colormap;
use crate::field::color::linear_from_srgb;
use crate::field::{DisparityMap, RayDepths, ViewIndex};
use crate::render::Picture;

/// One view's ray depths in colour: `range` (px per view step, far to near) is spread over the colour map.
pub fn depth(depths: &RayDepths, view: ViewIndex, range: [f32; 2], map: Colormap) -> Picture {
    let width = (range[1] - range[0]).max(1e-6);
    Picture::from_fn(depths.size(), |x, y| {
        let place = (depths.at(view, x, y) - range[0]) / width;
        map.srgb(place).map(linear_from_srgb)
    })
}

/// A map in colour over its own range.
pub fn depth_map(map: &DisparityMap, colors: Colormap) -> Picture {
    let [far, near] = map.range_px();
    let width = (near - far).max(1e-3);
    Picture::from_fn(map.size(), |x, y| colors.srgb((map.at(x, y) - far) / width).map(linear_from_srgb))
}
