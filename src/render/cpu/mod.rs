//! Pictures from a light field on the CPU: what is exported, and what the shaders are checked against.

mod colormap;
mod depth;
mod epi;
mod refocus;
mod view;

pub use colormap::Colormap;
pub use depth::{depth, depth_map};
pub use epi::epi;
#[cfg(feature = "ui")]
pub(crate) use refocus::STREWN_PIECES;
pub use refocus::{refocus, refocus_strewn, refocus_with_depths};
#[cfg(feature = "ui")]
pub(crate) use view::{HALF_TRUST_PX, SEARCH_STEPS};
pub use view::{view, view_with_depths};

use crate::field::color::linear_from_srgb8;
use crate::field::{View, bilinear, sides};

/// A colour in linear light between pixel centres (bilinear, the edge pixel goes on). Twin of `tap` in `common.wgsl`.
pub(crate) fn tap(view: &View, x: f32, y: f32) -> [f32; 3] {
    let light = |i: usize| {
        let [r, g, b, _] = view.pixels()[i].map(linear_from_srgb8);
        [r, g, b]
    };
    bilinear(sides(view.size()), x, y, light)
}

/// The value of a map nearest to a place. Twin of `depth_tap` in `common.wgsl`.
pub(crate) fn nearest(map: &[f32], size: [u32; 2], x: f32, y: f32) -> f32 {
    let at = |p: f32, n: u32| (p + 0.5).floor().clamp(0.0, (n - 1) as f32) as usize;
    map[at(y, size[1]) * size[0] as usize + at(x, size[0])]
}
