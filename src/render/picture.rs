//! The outcome of every renderer: a picture in linear light.

use crate::field::color::{srgb8_from_linear, srgb16_from_linear};

/// A picture in linear sRGB light.
///
/// # Shapes
/// - `rgb_linear`: `[y, x, 3]`, 0 black … 1 white, in the primaries of what it was made from; highlights may be above 1
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width and height, in pixels.
    pub size: [u32; 2],
    /// Pixels, rows top to bottom.
    pub rgb_linear: Vec<f32>,
}

impl Picture {
    /// A picture whose pixel `(x, y)` is `color(x, y)`, made by all cores.
    pub fn from_fn(size: [u32; 2], color: impl Fn(u32, u32) -> [f32; 3] + Sync) -> Self {
        use rayon::prelude::*;
        let mut rgb_linear = vec![0.0; size[0] as usize * size[1] as usize * 3];
        rgb_linear.par_chunks_mut((size[0] as usize * 3).max(1)).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                pixel.copy_from_slice(&color(x as u32, y as u32));
            }
        });
        Self { size, rgb_linear }
    }

    /// One pixel in linear light.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 3] {
        let at = (y as usize * self.size[0] as usize + x as usize) * 3;
        [self.rgb_linear[at], self.rgb_linear[at + 1], self.rgb_linear[at + 2]]
    }

    /// sRGB bytes, `[y, x, 4]`, alpha 255.
    pub fn to_srgb8(&self) -> Vec<u8> {
        let to_8 = |rgb: &[f32]| [srgb8_from_linear(rgb[0]), srgb8_from_linear(rgb[1]), srgb8_from_linear(rgb[2]), 255];
        self.rgb_linear.chunks_exact(3).flat_map(to_8).collect()
    }

    /// sRGB with 16 bits a channel, `[y, x, 3]`.
    pub fn to_srgb16(&self) -> Vec<u16> {
        self.rgb_linear.iter().map(|&light| srgb16_from_linear(light)).collect()
    }
}
