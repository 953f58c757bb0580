//! Exposure and white balance of a frame against the reference frame: a factor for each colour, in linear light.

use glam::DVec2;

use super::camera::pixel_of_place;
use super::start::median;
use crate::field::color::{linear_from_srgb8, srgb8_from_linear};
use crate::field::{FieldError, View};

/// Half the side of the patches that are compared.
const HALF: i32 = 2;
/// Light that is too dark or too bright to compare.
const BELIEVED: [f32; 2] = [0.004, 0.9];
/// Fewer patches than these tell nothing.
const FEWEST: usize = 8;

/// What a frame's light is multiplied by to look like the reference frame's. `pairs` are places that see the same.
pub fn gains(reference: &View, frame: &View, pairs: impl Iterator<Item = (DVec2, DVec2)>) -> [f32; 3] {
    let mut ratios: [Vec<f64>; 3] = Default::default();
    for (from, to) in pairs {
        let (a, b) = (mean(reference, from), mean(frame, to));
        for (c, ratios) in ratios.iter_mut().enumerate() {
            let believed = |light: f32| (BELIEVED[0]..BELIEVED[1]).contains(&light);
            if believed(a[c]) && believed(b[c]) {
                ratios.push(f64::from(a[c] / b[c]));
            }
        }
    }
    ratios.map(|mut ratios| if ratios.len() < FEWEST { 1.0 } else { median(&mut ratios) as f32 })
}

fn mean(view: &View, at: DVec2) -> [f32; 3] {
    let at = pixel_of_place(view.size(), at).round();
    let [w, h] = crate::field::sides(view.size()).map(|side| side as i32);
    let mut sum = [0.0; 3];
    for dy in -HALF..=HALF {
        for dx in -HALF..=HALF {
            let (x, y) = ((at.x as i32 + dx).clamp(0, w - 1), (at.y as i32 + dy).clamp(0, h - 1));
            let pixel = view.pixel(x as u32, y as u32);
            (0..3).for_each(|c| sum[c] += linear_from_srgb8(pixel[c]));
        }
    }
    sum.map(|sum| sum / ((2 * HALF + 1) * (2 * HALF + 1)) as f32)
}

/// A frame with its light multiplied.
///
/// # Errors
/// None that the frame did not have.
pub fn matched(frame: &View, gains: [f32; 3]) -> Result<View, FieldError> {
    let tables =
        gains.map(|gain| (0..=255u8).map(|v| srgb8_from_linear(linear_from_srgb8(v) * gain)).collect::<Vec<u8>>());
    let pixel = |p: &[u8]| [tables[0][p[0] as usize], tables[1][p[1] as usize], tables[2][p[2] as usize], p[3]];
    View::new(frame.size(), frame.rgba().chunks_exact(4).flat_map(pixel).collect())
}
