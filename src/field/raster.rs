//! A rectangle of values: photos, maps, views and masks are made of it.

use rayon::prelude::*;

use super::{FieldError, Filter, Mix, Size, bilinear, check_len, pixels, resample, sides};

/// Values of a picture's pixels, rows top to bottom.
///
/// # Shapes
/// - `pixels`: `[y, x]`
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raster<T> {
    pub(super) size: Size,
    pub(super) pixels: Vec<T>,
}

impl<T> Raster<T> {
    /// A picture of `[width, height]`; `pixels` holds width · height values.
    pub fn new(size: Size, pixels: Vec<T>) -> Result<Self, FieldError> {
        Self::named("the picture", size, pixels)
    }

    /// The same, with a name for the error.
    pub(super) fn named(what: &'static str, size: Size, values: Vec<T>) -> Result<Self, FieldError> {
        check_len(what, pixels(size), values.len())?;
        Ok(Self { size, pixels: values })
    }

    /// A picture whose pixel `(x, y)` is `pixel(x, y)`; a side of 0 pixels counts as 1.
    pub fn from_fn(size: Size, mut pixel: impl FnMut(usize, usize) -> T) -> Self {
        let size = size.map(|side| side.max(1));
        let [w, h] = sides(size);
        let mut pixels = Vec::with_capacity(w * h);
        (0..h).for_each(|y| pixels.extend((0..w).map(|x| pixel(x, y))));
        Self { size, pixels }
    }

    /// The same, made by all cores.
    pub fn par_from_fn(size: Size, pixel: impl Fn(usize, usize) -> T + Sync) -> Self
    where
        T: Send,
    {
        let size = size.map(|side| side.max(1));
        let [w, h] = sides(size);
        let made = (0..w * h).into_par_iter().with_min_len(w).map(|i| pixel(i % w, i / w));
        Self { size, pixels: made.collect() }
    }

    /// Width and height in pixels.
    #[inline]
    pub fn size(&self) -> Size {
        self.size
    }

    /// Columns and rows.
    #[inline]
    pub fn sides(&self) -> [usize; 2] {
        sides(self.size)
    }

    /// All pixels, `[y, x]`.
    #[inline]
    pub fn pixels(&self) -> &[T] {
        &self.pixels
    }

    /// All pixels, to be changed.
    pub fn pixels_mut(&mut self) -> &mut [T] {
        &mut self.pixels
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
    pub fn filled(size: Size, value: T) -> Self {
        Self::from_fn(size, |_, _| value)
    }

    /// One pixel.
    #[inline]
    pub fn at(&self, x: usize, y: usize) -> T {
        self.pixels[y * self.size[0] as usize + x]
    }
}

impl<T: Mix> Raster<T> {
    /// The value between pixels, linear; pixel centres at integers, the edge goes on outside.
    #[inline]
    pub fn tap(&self, x: f32, y: f32) -> T {
        bilinear(self.sides(), x, y, |i| self.pixels[i])
    }
}

impl Raster<f32> {
    /// The picture at another size.
    #[must_use]
    pub fn resized(&self, size: Size, filter: Filter) -> Self {
        Self { size, pixels: resample::<1>(&self.pixels, self.size, size, filter) }
    }
}

impl<const N: usize> Raster<[f32; N]> {
    /// The picture at another size.
    #[must_use]
    pub fn resized(&self, size: Size, filter: Filter) -> Self {
        let values = resample::<N>(self.pixels.as_flattened(), self.size, size, filter);
        Self { size, pixels: values.as_chunks().0.to_vec() }
    }
}
