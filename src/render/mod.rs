//! Pictures from a light field or a photo: on the CPU for keeping, with wgpu for looking.

pub mod lens;

use crate::field::color::{srgb8_from_linear, srgb16_from_linear};

/// A picture in linear light.
///
/// # Shapes
/// - `rgb_linear`: `[y, x, 3]`, 0 … 1, in the primaries of what it was made from
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width and height.
    pub size: [u32; 2],
    /// Red, green and blue light of every pixel.
    pub rgb_linear: Vec<f32>,
}

impl Picture {
    /// sRGB, `[y, x, 4]`, alpha 255.
    pub fn to_srgb8(&self) -> Vec<u8> {
        let pixel = |p: &[f32]| [srgb8_from_linear(p[0]), srgb8_from_linear(p[1]), srgb8_from_linear(p[2]), 255];
        self.rgb_linear.chunks_exact(3).flat_map(pixel).collect()
    }

    /// sRGB with 16 bits a channel, `[y, x, 3]`.
    pub fn to_srgb16(&self) -> Vec<u16> {
        self.rgb_linear.iter().map(|&light| srgb16_from_linear(light)).collect()
    }
}
