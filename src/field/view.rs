//! One picture of a light field.

use super::{FieldError, Raster, Size, check_len, pixels};

/// One view: sRGB RGBA8, rows top to bottom, tightly packed. Alpha is 255.
///
/// # Shapes
/// - `rgba`: `[y, x, 4]`
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct View {
    size: Size,
    rgba: Box<[u8]>,
}

impl View {
    /// A view of `[width, height]` pixels; `rgba` holds width · height · 4 bytes.
    pub fn new(size: Size, rgba: Vec<u8>) -> Result<Self, FieldError> {
        check_len("the view", pixels(size) * 4, rgba.len())?;
        Ok(Self { size, rgba: rgba.into() })
    }

    /// Width and height in pixels.
    pub fn size(&self) -> Size {
        self.size
    }

    /// All bytes, `[y, x, 4]`.
    pub fn rgba(&self) -> &[u8] {
        &self.rgba
    }

    /// All pixels, sRGB and alpha, `[y, x]`.
    #[inline]
    pub fn pixels(&self) -> &[[u8; 4]] {
        self.rgba.as_chunks().0
    }

    /// One pixel, sRGB and alpha.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        self.pixels()[y as usize * self.size[0] as usize + x as usize]
    }

    /// Other values of the same pixels.
    pub fn map<T>(&self, value: impl FnMut([u8; 4]) -> T) -> Raster<T> {
        Raster { size: self.size, pixels: self.pixels().iter().copied().map(value).collect() }
    }

    /// Gives the pixels away.
    pub fn into_rgba(self) -> Vec<u8> {
        self.rgba.into_vec()
    }
}
