//! The layers of a scene as the bytes of a living picture.

use crate::field::color::srgb8_from_linear;
use crate::io::formats::living::Rgb;
use crate::render::lens::Layers;

/// The layers as pictures, and the disparities of byte 0 and 255.
pub(super) struct Bytes {
    pub(super) photo: Rgb,
    pub(super) depths: Rgb,
    pub(super) behind: Rgb,
    pub(super) behind_depths: Rgb,
    pub(super) range: [f32; 2],
}

impl Bytes {
    pub(super) fn of(layers: &Layers) -> Self {
        let range = range(layers);
        let byte = |d: f32| ((d - range[0]) / (range[1] - range[0]).max(1e-9) * 255.0).round().clamp(0.0, 255.0) as u8;
        let part = |share: f32| (share.clamp(0.0, 1.0) * 255.0).round() as u8;
        // Finer steps would take a twentieth of the page, and the photo would be the coarser.
        let coarse = |share: f32| 17 * (share.clamp(0.0, 1.0) * 15.0).round() as u8;
        let depth = |i: usize| {
            let [near, far] = [layers.near_px[i], layers.far_px[i]].map(byte);
            // A farther near side is none.
            [near, near.saturating_sub(far), marked(part(1.0 - layers.cover[i]), layers.stained[i])]
        };
        let depths = (0..layers.near_px.len()).map(depth).collect();
        let behind = layers
            .behind
            .iter()
            .map(|cell| [byte(cell.disparity_px), coarse(cell.share), cell.distance.min(255.0) as u8]);
        Self {
            photo: Rgb {
                size: layers.size,
                pixels: layers.rgb_linear.iter().map(|rgb| rgb.map(srgb8_from_linear)).collect(),
            },
            depths: Rgb { size: layers.size, pixels: depths },
            behind: Rgb { size: layers.behind_size, pixels: colors_behind(layers) },
            behind_depths: Rgb { size: layers.behind_size, pixels: behind.collect() },
            range,
        }
    }
}

/// What the near side leaves free. Where that is all, the last two steps say how far the pixel is stained: 255 not at all,
/// 253 wholly. They are no part that is drawn, and the PNG stays as small as it is.
fn marked(free: u8, stained: f32) -> u8 {
    const ALL: u8 = 253;
    if free < ALL { free } else { u8::MAX - (2.0 * stained.clamp(0.0, 1.0)).round() as u8 }
}

/// Least and greatest of all disparities.
fn range(layers: &Layers) -> [f32; 2] {
    let behind = layers.behind.iter().filter(|cell| cell.share > 0.0).map(|cell| &cell.disparity_px);
    let all = layers.near_px.iter().chain(&layers.far_px).chain(behind);
    all.fold([f32::INFINITY, f32::NEG_INFINITY], |[lo, hi], &d| [lo.min(d), hi.max(d)])
}

/// Colours behind the edges; where nothing is known, the last one of the row goes on, so that they compress well.
fn colors_behind(layers: &Layers) -> Vec<[u8; 3]> {
    let width = layers.behind_size[0] as usize;
    let mut pixels = Vec::with_capacity(layers.behind.len());
    for row in layers.behind.chunks_exact(width) {
        let mut last =
            row.iter().find(|cell| cell.share > 0.0).map_or([128; 3], |cell| cell.rgb.map(srgb8_from_linear));
        for cell in row {
            if cell.share > 0.0 {
                last = cell.rgb.map(srgb8_from_linear);
            }
            pixels.push(last);
        }
    }
    pixels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_pixel_that_the_near_side_leaves_free_is_marked_as_stained() {
        assert_eq!([0.0, 0.5, 1.0].map(|stained| marked(255, stained)), [255, 254, 253]);
        assert_eq!(marked(253, 0.0), 255, "a last hundredth is no part that is drawn");
        assert_eq!([0, 100, 252].map(|free| marked(free, 1.0)), [0, 100, 252]);
    }
}
