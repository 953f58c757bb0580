//! A rectangle of values: photos, maps, views and masks are made of it.

use super::{FieldError, check_len};

/// Values of a picture's pixels, rows top to bottom.
///
/// # Shapes
/// - `pixels`: `[y, x]`
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raster<T> {
    pub(super) size: [u32; 2],
    pub(super) pixels: Vec<T>,
}

impl<T> Raster<T> {
    /// A picture of `[width, height]`; `pixels` holds width · height values.
    pub fn new(size: [u32; 2], pixels: Vec<T>) -> Result<Self, FieldError> {
        Self::named("the picture", size, pixels)
    }

    /// The same, with a name for the error.
    pub(super) fn named(what: &'static str, size: [u32; 2], pixels: Vec<T>) -> Result<Self, FieldError> {
        check_len(what, size[0] as usize * size[1] as usize, pixels.len())?;
        Ok(Self { size, pixels })
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// All pixels, `[y, x]`.
    pub fn pixels(&self) -> &[T] {
        &self.pixels
    }

    /// Gives the pixels away.
    pub fn into_pixels(self) -> Vec<T> {
        self.pixels
    }

    /// The same picture of other values.
    pub fn map<U>(self, value: impl FnMut(T) -> U) -> Raster<U> {
        Raster { size: self.size, pixels: self.pixels.into_iter().map(value).collect() }
    }
}

impl<T: Copy> Raster<T> {
    /// The same value everywhere; a side of 0 pixels counts as 1.
    pub fn filled(size: [u32; 2], value: T) -> Self {
        let size = size.map(|side| side.max(1));
        Self { size, pixels: vec![value; size[0] as usize * size[1] as usize] }
    }

    /// One pixel.
    pub fn at(&self, x: u32, y: u32) -> T {
        self.pixels[y as usize * self.size[0] as usize + x as usize]
    }
}
