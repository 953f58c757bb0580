//! One picture of a light field.

use std::sync::Arc;

use super::{FieldError, Raster, Size, check_len, pixels};

/// One view: sRGB RGBA8, rows top to bottom, tightly packed. Alpha is 255.
///
/// Its bytes are a block of its own, or a part of one that all views of a light field share
/// ([`LightField::in_one_block`](super::LightField::in_one_block)).
///
/// # Shapes
/// - `rgba`: `[y, x, 4]`
#[derive(Clone, Debug)]
pub struct View {
    size: Size,
    block: Arc<Box<[u8]>>,
    start: usize,
}

impl View {
    /// A view of `[width, height]` pixels; `rgba` holds width · height · 4 bytes.
    pub fn new(size: Size, rgba: Vec<u8>) -> Result<Self, FieldError> {
        check_len("the view", pixels(size) * 4, rgba.len())?;
        Ok(Self { size, block: Arc::new(rgba.into()), start: 0 })
    }

    /// The views of one size that lie one after the other in a block.
    pub(super) fn all_of(block: Box<[u8]>, size: Size) -> impl Iterator<Item = Self> {
        let (bytes, block) = (pixels(size) * 4, Arc::new(block));
        (0..block.len() / bytes).map(move |n| Self { size, block: Arc::clone(&block), start: n * bytes })
    }

    /// The block that it lies in, and where it begins there.
    pub(super) fn block(&self) -> (&Arc<Box<[u8]>>, usize) {
        (&self.block, self.start)
    }

    /// Width and height in pixels.
    pub fn size(&self) -> Size {
        self.size
    }

    /// All bytes, `[y, x, 4]`.
    #[inline]
    pub fn rgba(&self) -> &[u8] {
        &self.block[self.start..self.start + pixels(self.size) * 4]
    }

    /// All pixels, sRGB and alpha, `[y, x]`.
    #[inline]
    pub fn pixels(&self) -> &[[u8; 4]] {
        self.rgba().as_chunks().0
    }

    /// One pixel, sRGB and alpha.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        self.pixels()[y as usize * self.size[0] as usize + x as usize]
    }

    /// Other values of the same pixels.
    pub fn map<T>(&self, value: impl FnMut([u8; 4]) -> T) -> Raster<T> {
        Raster { size: self.size, pixels: self.pixels().iter().copied().map(value).collect() }
    }

    /// Gives the pixels away; a copy where others look at them too.
    pub fn into_rgba(self) -> Vec<u8> {
        let part = self.start..self.start + pixels(self.size) * 4;
        match Arc::try_unwrap(self.block) {
            Ok(block) if part.len() == block.len() => block.into_vec(),
            Ok(block) => block[part].to_vec(),
            Err(shared) => shared[part].to_vec(),
        }
    }
}

impl PartialEq for View {
    fn eq(&self, other: &Self) -> bool {
        self.size == other.size && self.rgba() == other.rgba()
    }
}

impl Eq for View {}
