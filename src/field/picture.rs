//! The outcome of every renderer: a picture in linear light, and the same as the values that stand in a file.

use std::borrow::Cow;

use rayon::prelude::*;

use super::color::srgb8_from_linear;
use super::{Size, Transfer, pixels};

/// A picture in linear sRGB light.
///
/// # Shapes
/// - `rgb_linear`: `[y, x, 3]`, 0 black … 1 white, in the primaries of what it was made from; highlights may be above 1
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width and height, in pixels.
    pub size: Size,
    /// Pixels, rows top to bottom.
    pub rgb_linear: Vec<f32>,
}

impl Picture {
    /// A picture whose pixel `(x, y)` is `color(x, y)`, made by all cores.
    pub fn from_fn(size: Size, color: impl Fn(u32, u32) -> [f32; 3] + Sync) -> Self {
        use rayon::prelude::*;
        let mut rgb_linear = vec![0.0; pixels(size) * 3];
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
}

/// Stored values of a picture, `[y, x, 3]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Samples {
    /// 8 bits a channel.
    Eight(Vec<u8>),
    /// 16 bits a channel.
    Sixteen(Vec<u16>),
}

/// A picture as it will stand in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pixels {
    /// Width and height.
    pub size: Size,
    /// Red, green and blue of every pixel.
    pub samples: Samples,
}

impl Pixels {
    /// Stored values of linear light, `[y, x, 3]`.
    pub fn from_linear(size: Size, rgb_linear: &[f32], bits: u8, transfer: &Transfer) -> Self {
        let samples = if bits > 8 {
            Samples::Sixteen(stored(rgb_linear, |light, values| transfer.sixteen_bits(light, values)))
        } else {
            Samples::Eight(stored(rgb_linear, |light, values| transfer.eight_bits(light, values)))
        };
        Self { size, samples }
    }

    /// The same picture with 8 bits a channel.
    pub fn to_eight(&self) -> Cow<'_, [u8]> {
        match &self.samples {
            Samples::Eight(px) => px.into(),
            Samples::Sixteen(px) => px.iter().map(|&v| ((u32::from(v) * 255 + 32767) / 65535) as u8).collect(),
        }
    }
}

/// The values of light, `[.., 3]`; on all cores.
fn stored<T: Copy + Default + Send>(rgb_linear: &[f32], store: impl Fn(&[f32], &mut [T]) + Sync) -> Vec<T> {
    const PIXELS: usize = 1 << 14;
    let mut values = vec![T::default(); rgb_linear.len()];
    let parts = values.par_chunks_mut(3 * PIXELS).zip(rgb_linear.par_chunks(3 * PIXELS));
    parts.for_each(|(values, light)| store(light, values));
    values
}
