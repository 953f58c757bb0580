//! The photo at the size of a view, and as the numbers that nets and warps read.

use std::convert::Infallible;

use glam::Vec4;
use rayon::prelude::*;

use super::SynthError;
use crate::field::color::{linear_from_srgb8, signed_from_u8, srgb_from_linear, srgb8_from_linear};
use crate::field::{Filter, Photo, Raster, Size, View, fit_long_side, resample, resample_rows, sides};
use crate::job::{Cancelled, Job};

/// The reference view: the photo, its longer side at most `long_side`, light averaged as light.
///
/// # Errors
/// Cancelled.
pub fn reference_view(photo: &Photo, long_side: u32, job: &Job) -> Result<View, SynthError> {
    let target = fit_long_side(photo.size(), long_side.max(1));
    if target == photo.size() {
        return Ok(View::new(target, photo.srgb8().to_vec())?);
    }
    let light = shrink(photo, target, job)?;
    let encode =
        |pixel: &[f32]| [srgb8_from_linear(pixel[0]), srgb8_from_linear(pixel[1]), srgb8_from_linear(pixel[2]), 255];
    let rgba: Vec<[u8; 4]> = light.par_chunks_exact(3).map(encode).collect();
    Ok(View::new(target, rgba.into_flattened())?)
}

/// Linear light of the photo at another size. Large photos take a cheap step to twice the size first.
fn shrink(photo: &Photo, target: Size, job: &Job) -> Result<Vec<f32>, Cancelled> {
    let source = photo.size();
    let rows = |y: usize, buffer: &mut [f32]| {
        light_row(&photo.srgb8_row(y), buffer);
        job.cancel.check()
    };
    let half = target.map(|side| side * 2);
    if source[0] < 2 * half[0] || source[1] < 2 * half[1] {
        return resample_rows::<3, _>(source, target, Filter::Lanczos3, rows);
    }
    let between = resample_rows::<3, _>(source, half, Filter::Linear, rows)?;
    Ok(resample::<3>(&between, half, target, Filter::Lanczos3))
}

fn light_row(row: &[u8], buffer: &mut [f32]) {
    for (light, pixel) in buffer.chunks_exact_mut(3).zip(row.chunks_exact(4)) {
        (0..3).for_each(|c| light[c] = linear_from_srgb8(pixel[c]));
    }
}

/// The size nearest to a photo's shape at a long side whose two sides are multiples of `step`. A picture stretched by a
/// few per cent is no other picture to a net; rows that repeat the edge are.
pub(super) fn size_in_steps(photo: Size, long_side: u32, step: u32) -> Size {
    fit_long_side(photo, long_side).map(|side| ((side + step / 2) / step).max(1) * step)
}

/// A view's pixels as the nets see them, sRGB-encoded in −1 … 1: (r, g, b, 0).
pub type Signed = Raster<Vec4>;

impl Signed {
    /// From 8-bit pixels.
    pub fn from_view(view: &View) -> Self {
        view.map(|[r, g, b, _]| Vec4::new(signed_from_u8(r), signed_from_u8(g), signed_from_u8(b), 0.0))
    }

    /// The same picture at another size, light averaged as light.
    pub(crate) fn resized(view: &View, target: Size, filter: Filter) -> Self {
        let source = view.size();
        if source == target {
            return Self::from_view(view);
        }
        let Ok(light) = resample_rows::<3, Infallible>(source, target, filter, |y, buffer| {
            let wide = source[0] as usize * 4;
            light_row(&view.rgba()[y * wide..(y + 1) * wide], buffer);
            Ok(())
        });
        Self::of_light(target, &light)
    }

    /// A photo at a net's own size, light averaged as light.
    pub(crate) fn of_photo(photo: &Photo, target: Size, job: &Job) -> Result<Self, Cancelled> {
        Ok(Self::of_light(target, &shrink(photo, target, job)?))
    }

    /// From linear light, `[y, x, rgb]`.
    fn of_light(size: Size, light: &[f32]) -> Self {
        let signed = |v: f32| srgb_from_linear(v) * 2.0 - 1.0;
        let [w, _] = sides(size);
        Self::from_fn(size, |x, y| {
            let [r, g, b] = [0, 1, 2].map(|c| signed(light[(y * w + x) * 3 + c]));
            Vec4::new(r, g, b, 0.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Cancel;

    fn checkers(size: [u32; 2]) -> Photo {
        let pixel =
            |i: u32| if (i % size[0] + i / size[0]).is_multiple_of(2) { [255, 255, 255, 255] } else { [0, 0, 0, 255] };
        Photo::from_srgb8(size, (0..size[0] * size[1]).flat_map(pixel).collect()).unwrap()
    }

    fn reference(photo: &Photo, long_side: u32) -> View {
        reference_view(photo, long_side, &Job { cancel: &Cancel::default(), sink: &() }).unwrap()
    }

    #[test]
    fn a_stopped_job_shrinks_no_photo() {
        let cancel = Cancel::default();
        cancel.cancel();
        let made = reference_view(&checkers([80, 60]), 20, &Job { cancel: &cancel, sink: &() });
        assert!(matches!(made, Err(SynthError::Cancelled(_))), "{made:?}");
    }

    #[test]
    fn a_small_photo_is_its_own_reference_view() {
        let photo = checkers([30, 20]);
        assert_eq!(reference(&photo, 540).rgba(), &photo.srgb8()[..]);
    }

    #[test]
    fn black_and_white_average_to_half_the_light_not_half_the_code() {
        for side in [80, 400] {
            let view = reference(&checkers([side, side]), 20);
            assert_eq!(view.size(), [20, 20]);
            let middle = view.pixel(10, 10)[0];
            assert!(middle.abs_diff(188) <= 1, "sRGB {middle} where half the light is 188");
        }
    }

    #[test]
    fn taps_are_exact_on_pixels_and_clamp_outside() {
        let view = View::new([2, 1], vec![0, 0, 0, 255, 255, 255, 255, 255]).unwrap();
        let signed = Signed::from_view(&view);
        assert_eq!(signed.tap(0.0, 0.0).x, -1.0);
        assert_eq!(signed.tap(0.5, 7.0).x, 0.0);
        assert_eq!(signed.tap(-9.0, -9.0).x, -1.0);
        assert_eq!(signed.tap(9.0, 0.0).x, 1.0);
    }
}
