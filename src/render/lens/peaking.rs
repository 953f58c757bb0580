//! Focus peaking: which sharp edges lie in the focal plane.

use crate::field::{DisparityMap, Lens, View};

/// Blur of half a pixel of the view and less is in focus.
const SHARP_PX: f32 = 0.5;

/// How strongly each pixel of a view is to be marked: contrast where the lens is in focus, 0 elsewhere.
/// The map has the view's shape; the lens's disparities are in its pixels.
///
/// # Shapes
/// - returns `[y, x]`, 0 … 255, of the view's size
pub fn peaking(view: &View, disparity: &DisparityMap, lens: &Lens) -> Vec<u8> {
    let [width, height] = view.size();
    let scale = disparity.scale_to(view.size());
    let luma = |x: u32, y: u32| {
        let [r, g, b, _] = view.pixel(x.min(width - 1), y.min(height - 1)).map(i32::from);
        (2 * r + 5 * g + b) / 8
    };
    let mark = |x: u32, y: u32| {
        let at = |i: u32, from: u32, to: u32| (i as f32 + 0.5) / from as f32 * to as f32;
        let map = [at(x, width, disparity.size()[0]) as u32, at(y, height, disparity.size()[1]) as u32];
        let here = disparity.at(map[0].min(disparity.size()[0] - 1), map[1].min(disparity.size()[1] - 1));
        let place = [at(x, width, 1), at(y, height, 1)];
        // As at the paper's widest aperture: a wider one would leave nothing to see, a narrower one everything.
        let blur = 8.0 * scale * lens.defocus_px(here, place[0], place[1]).abs();
        if blur > SHARP_PX {
            return 0;
        }
        let [left, up] = [x.saturating_sub(1), y.saturating_sub(1)];
        let across = luma(x + 1, y) - luma(left, y);
        let down = luma(x, y + 1) - luma(x, up);
        ((across.abs() + down.abs() - 24) * 3).clamp(0, 255) as u8
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| mark(x, y)).collect()
}
