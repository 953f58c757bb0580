//! Pictures from a light field on the CPU: what is exported, and what the shaders are checked against.

mod colormap;
mod depth;
mod epi;
mod refocus;
mod view;

pub use colormap::Colormap;
pub use depth::{depth, depth_map};
pub use epi::epi;
pub use refocus::{refocus, refocus_with_depths};
#[cfg(feature = "ui")]
pub(crate) use view::{HALF_TRUST_PX, SEARCH_STEPS};
pub use view::{view, view_with_depths};

use crate::field::View;
use crate::field::color::linear_from_srgb8;

/// A colour in linear light between pixel centres (bilinear, the edge pixel goes on). Twin of `tap` in `common.wgsl`.
pub(crate) fn tap(view: &View, x: f32, y: f32) -> [f32; 3] {
    let [w, h] = view.size();
    let (x, y) = (x.clamp(0.0, (w - 1) as f32), y.clamp(0.0, (h - 1) as f32));
    let (x0, y0) = (x.floor(), y.floor());
    let (fx, fy) = (x - x0, y - y0);
    let (x0, y0) = (x0 as u32, y0 as u32);
    let (x1, y1) = ((x0 + 1).min(w - 1), (y0 + 1).min(h - 1));
    let texel = |x, y| view.pixel(x, y).map(linear_from_srgb8);
    let [a, b, c, d] = [texel(x0, y0), texel(x1, y0), texel(x0, y1), texel(x1, y1)];
    std::array::from_fn(|i| mix(mix(a[i], b[i], fx), mix(c[i], d[i], fx), fy))
}

/// The value of a map nearest to a place. Twin of `depth_tap` in `common.wgsl`.
pub(crate) fn nearest(map: &[f32], size: [u32; 2], x: f32, y: f32) -> f32 {
    let at = |p: f32, n: u32| (p + 0.5).floor().clamp(0.0, (n - 1) as f32) as usize;
    map[at(y, size[1]) * size[0] as usize + at(x, size[0])]
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}
