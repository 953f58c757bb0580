//! Ray depths of one view as a picture. Twin of `depth.wgsl`.

use super::Colormap;
use crate::field::color::linear_from_srgb;
use crate::field::{RayDepths, ViewIndex};
use crate::render::Picture;

/// One view's ray depths in colour: `range` (px per view step, far to near) is spread over the colour map.
pub fn depth(depths: &RayDepths, view: ViewIndex, range: [f32; 2], map: Colormap) -> Picture {
    let width = (range[1] - range[0]).max(1e-6);
    Picture::from_fn(depths.size(), |x, y| {
        let place = (depths.at(view, x, y) - range[0]) / width;
        map.srgb(place).map(linear_from_srgb)
    })
}
