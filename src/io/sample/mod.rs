//! The built-in sample: a flower bed that the program draws itself, with the disparity of every pixel known.
//!
//! Shapes are painted from far to near with soft edges, in linear light; the softness of a shape's edge is its blur,
//! as if photographed with the focus on the middle flower. The same bytes come out at every run.

mod canvas;
mod plants;
mod shapes;

use std::sync::Arc;

use rayon::prelude::*;

use self::canvas::Band;
use self::shapes::Shape;
use super::DisparityMap;
use crate::field::color::srgb_from_linear;
use crate::field::{FieldError, Photo, sides};

/// Width and height of the sample, in pixels.
pub const SIZE: [u32; 2] = [1200, 800];

/// Disparities of the scene for a width of one pixel: multiplied by a width they are pixels per view step there.
const DISPARITY_PER_WIDTH: f32 = 1.0 / 540.0;

/// The sample photo and the truth about it.
pub struct Sample {
    /// The photo, 8-bit sRGB.
    pub photo: Arc<Photo>,
    /// Disparity of each of its pixels, in pixels per view step at its own width.
    pub disparity: DisparityMap,
}

/// Draws the sample.
///
/// # Errors
/// None in practice: the pictures have the size that is asked for.
pub fn sample() -> Result<Sample, FieldError> {
    let scene = plants::garden(SIZE);
    let (rgba, disparity_px) = draw(&scene, SIZE);
    let photo = Photo::from_srgb8(SIZE, rgba)?;
    Ok(Sample { photo: Arc::new(photo), disparity: DisparityMap::new(SIZE, disparity_px)? })
}

/// Rows that one task draws.
const BAND_ROWS: usize = 16;

/// Paints the shapes, given from far to near: sRGB bytes `[y, x, 4]` and disparity `[y, x]`.
fn draw(scene: &[Box<dyn Shape>], size: [u32; 2]) -> (Vec<u8>, Vec<f32>) {
    let [width, height] = sides(size);
    let mut rgba = vec![255; width * height * 4];
    let mut disparity_px = vec![0.0; width * height];
    let bands = rgba.par_chunks_mut(width * 4 * BAND_ROWS).zip(disparity_px.par_chunks_mut(width * BAND_ROWS));
    bands.enumerate().for_each(|(number, (rgba, disparity))| {
        let first_row = number * BAND_ROWS;
        let mut band = Band::new(width, first_row, disparity.len() / width);
        for shape in scene {
            band.paint(shape.as_ref());
        }
        for (at, pixel) in rgba.chunks_exact_mut(4).enumerate() {
            let (x, y) = (at % width, first_row + at / width);
            let dither = canvas::hash(x as u32, y as u32) - 0.5;
            for (byte, light) in pixel.iter_mut().zip(band.light(at).to_array()) {
                *byte = (srgb_from_linear(light) * 255.0 + 0.5 + dither).clamp(0.0, 255.0) as u8;
            }
        }
        for (pixel, scene_px) in disparity.iter_mut().zip(band.disparity()) {
            *pixel = scene_px * width as f32 * DISPARITY_PER_WIDTH;
        }
    });
    (rgba, disparity_px)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sample_is_the_same_at_every_run() {
        let (first, second) = (sample().unwrap(), sample().unwrap());
        assert_eq!(first.photo.srgb8(), second.photo.srgb8());
        assert_eq!(first.disparity, second.disparity);
    }

    #[test]
    fn it_has_something_near_and_something_far_and_no_hole() {
        let sample = sample().unwrap();
        let values = sample.disparity.disparity_px();
        assert!(values.iter().all(|value| value.is_finite()));
        let per_view = SIZE[0] as f32 * DISPARITY_PER_WIDTH;
        let share = |of: &dyn Fn(f32) -> bool| {
            values.iter().filter(|value| of(**value / per_view)).count() as f32 / values.len() as f32
        };
        assert!(share(&|d| d < -0.8) > 0.15, "far");
        assert!(share(&|d| d > 0.4) > 0.10, "near");
        assert!(share(&|d| d.abs() < 0.3) > 0.05, "in focus");
    }

    #[test]
    fn edges_of_the_disparity_are_edges_of_the_picture() {
        let Sample { photo, disparity } = sample().unwrap();
        let [width, _] = sides(SIZE);
        let mut at_steps = (0.0, 0);
        let mut elsewhere = (0.0, 0);
        for (at, pair) in disparity.disparity_px().windows(2).enumerate() {
            if (at + 1) % width == 0 {
                continue;
            }
            let colour =
                |at: usize| photo.srgb8()[at * 4..at * 4 + 3].iter().map(|c| f32::from(*c)).collect::<Vec<_>>();
            let step: f32 = colour(at).iter().zip(colour(at + 1)).map(|(a, b)| (a - b).abs()).sum();
            let sum = if (pair[0] - pair[1]).abs() > 1.0 { &mut at_steps } else { &mut elsewhere };
            *sum = (sum.0 + step, sum.1 + 1);
        }
        assert!(at_steps.0 / at_steps.1 as f32 > 4.0 * elsewhere.0 / elsewhere.1 as f32);
    }
}
