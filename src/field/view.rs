//! One picture of a light field.

use super::{FieldError, check_len};

/// One view: sRGB RGBA8, rows top to bottom, tightly packed. Alpha is 255.
///
/// # Shapes
/// - `rgba`: `[y, x, 4]`
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct View {
    size: [u32; 2],
    rgba: Box<[u8]>,
}

impl View {
    /// A view of `[width, height]` pixels; `rgba` holds width · height · 4 bytes.
    pub fn new(size: [u32; 2], rgba: Vec<u8>) -> Result<Self, FieldError> {
        check_len("the view", size[0] as usize * size[1] as usize * 4, rgba.len())?;
        Ok(Self { size, rgba: rgba.into() })
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// All pixels, `[y, x, 4]`.
    pub fn rgba(&self) -> &[u8] {
        &self.rgba
    }

    /// One pixel, sRGB and alpha.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        let at = (y as usize * self.size[0] as usize + x as usize) * 4;
        [self.rgba[at], self.rgba[at + 1], self.rgba[at + 2], self.rgba[at + 3]]
    }

    /// Gives the pixels away.
    pub fn into_rgba(self) -> Vec<u8> {
        self.rgba.into_vec()
    }
}
