//! Mirrors of the shaders' uniforms. Keep in sync with the structs of the same names in `shaders/*.wgsl`; the tests
//! check sizes and offsets.

use bytemuck::{Pod, Zeroable};

use crate::field::ViewGrid;
use crate::render::aperture;
use crate::render::cpu::{Colormap, HALF_TRUST_PX, SEARCH_STEPS};

/// Views of the largest grid (17×17).
pub const MAX_TAPS: usize = ViewGrid::MAX_SIDE * ViewGrid::MAX_SIDE;

/// One view's part in a picture (`common.wgsl`).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Tap {
    /// Steps from the viewpoint, x = du, y = dv.
    pub offset: [f32; 2],
    /// Share of the light.
    pub weight: f32,
    /// Layer of the view.
    pub layer: u32,
}

impl Tap {
    /// The shader's form of a tap.
    pub fn new(tap: &aperture::Tap, grid: ViewGrid) -> Self {
        Self { offset: tap.offset.to_array(), weight: tap.weight, layer: grid.layer_from_view(tap.view) as u32 }
    }
}

/// `refocus.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Refocus {
    /// Disparity in the picture's middle, and its growth from left to right and from top to bottom.
    pub focus: [f32; 3],
    /// Taps in use.
    pub count: u32,
    /// Disparities around the focal plane that stay sharp too.
    pub keep_sharp: [f32; 2],
    /// Layer whose ray depths say what stays sharp.
    pub depth_layer: u32,
    /// 1 where there are ray depths.
    pub has_depths: u32,
    /// Steps between the views that each tap is strewn over, 0: none.
    pub strewn: f32,
    /// Pieces of a tap that is strewn, along each axis.
    pub pieces: u32,
    /// Padding to 16 bytes.
    pub pad: [u32; 2],
    /// Views and their shares.
    pub taps: [Tap; MAX_TAPS],
}

/// `view.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Viewpoint {
    /// Taps in use, 1 … 4.
    pub count: u32,
    /// 1 where there are ray depths.
    pub has_depths: u32,
    /// Steps of the search for a ray.
    pub search_steps: u32,
    /// Disparity by which a search may end beside its ray and still count half.
    pub half_trust: f32,
    /// The nearest views.
    pub taps: [Tap; 4],
}

impl Default for Viewpoint {
    fn default() -> Self {
        let taps = [Tap::default(); 4];
        Self { count: 0, has_depths: 0, search_steps: SEARCH_STEPS, half_trust: HALF_TRUST_PX, taps }
    }
}

/// `epi.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Epi {
    /// 0 a picture row, 1 a picture column.
    pub column: u32,
    /// The row's y or the column's x.
    pub line: f32,
    /// Layer of the first view of the cut.
    pub first_layer: u32,
    /// Layers from one view of the cut to the next.
    pub layer_step: u32,
    /// Pixels that a view is thick.
    pub scale: u32,
    /// Padding to 16 bytes.
    pub pad: [u32; 3],
}

/// `depth.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Depth {
    /// Disparities at the two ends of the colour map, far and near.
    pub range: [f32; 2],
    /// Layer of the map.
    pub layer: u32,
    /// 1: near is white, without a polynomial.
    pub gray: u32,
    /// The colour map's polynomial.
    pub powers: [[f32; 4]; 7],
}

impl Depth {
    /// A map's uniform.
    pub fn new(range: [f32; 2], layer: u32, map: Colormap) -> Self {
        let powers = map.powers().map(|[r, g, b]| [r, g, b, 0.0]);
        Self { range, layer, gray: u32::from(map == Colormap::Gray), powers }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::{offset_of, size_of};

    #[test]
    fn sizes_and_offsets_are_those_of_wgsl() {
        assert_eq!(size_of::<Tap>(), 16);
        assert_eq!((size_of::<Refocus>(), offset_of!(Refocus, keep_sharp)), (48 + 289 * 16, 16));
        assert_eq!((offset_of!(Refocus, has_depths), offset_of!(Refocus, strewn)), (28, 32));
        assert_eq!(offset_of!(Refocus, taps), 48);
        assert_eq!((size_of::<Viewpoint>(), offset_of!(Viewpoint, taps)), (80, 16));
        assert_eq!(size_of::<Epi>(), 32);
        assert_eq!((size_of::<Depth>(), offset_of!(Depth, powers)), (128, 16));
    }
}
