//! True defocus: what a lens gathers is the mean of what many eyes on its opening see, each brought together at the
//! surface that is sharp.
//!
//! Each eye stands for a part of the opening, and its ellipses are blurred as that part would blur them. So few eyes are
//! enough, and no eye's picture is told from its neighbour's.

use glam::Vec2;
use rayon::prelude::*;

use super::raster::Painter;
use super::shot::Shot;
use super::{Blend, Stage};
use crate::field::color::linear_from_srgb;
use crate::field::{Lens, LensShape, Picture, Size, Strength, ViewPoint};
use crate::job::{Cancelled, Job, Stage as At};
use crate::render::aperture;

/// Eyes at least and at most.
const EYES: [usize; 2] = [16, 64];
/// Pixels² of a blurred point that one eye stands for.
const PX2_PER_EYE: f32 = 9.0;
/// Standard deviation of an eye's part of the opening, over the square root of its area.
const PART: f32 = 0.45;
/// The golden angle, by which eyes follow each other round the opening.
const GOLDEN: f32 = 2.399_963_2;
/// Steps of the sequence that fills a square evenly (Roberts's R2).
const EVEN: [f32; 2] = [0.754_877_7, 0.569_840_3];

impl Stage {
    /// The picture of a size through a lens, whose disparities are in pixels of that width and of the strength.
    ///
    /// # Errors
    /// Stopped.
    pub fn through_lens(
        &self,
        lens: &Lens,
        from: ViewPoint,
        (size, strength): (Size, Strength),
        painter: &dyn Painter,
        job: &Job,
    ) -> Result<Picture, Cancelled> {
        let mut picture = self.one_colour_through(lens, from, (size, strength), painter, job)?;
        if let Some(magenta) = lens.magenta() {
            let other = self.one_colour_through(&magenta, from, (size, strength), painter, job)?;
            let pixels = picture.rgb_linear.chunks_exact_mut(3).zip(other.rgb_linear.chunks_exact(3));
            pixels.for_each(|(pixel, other)| (pixel[0], pixel[2]) = (other[0], other[2]));
        }
        Ok(picture)
    }

    fn one_colour_through(
        &self,
        lens: &Lens,
        from: ViewPoint,
        (size, Strength(strength)): (Size, Strength),
        painter: &dyn Painter,
        job: &Job,
    ) -> Result<Picture, Cancelled> {
        let rig = self.rig.resized(size).at_strength(strength);
        let radius = lens.f_number.added_views() / 2.0;
        let ends = self.ends.map(|nearness| rig.disparity_px(nearness));
        let blur_px = ends.iter().map(|d| lens.defocus_px(*d, 0.5, 0.5).abs()).fold(0.0, f32::max) * 2.0 * radius;
        let count = ((blur_px * blur_px / PX2_PER_EYE) as usize).clamp(EYES[0], EYES[1]);
        let eyes = if radius > 0.0 { eyes(&lens.shape, count) } else { vec![Vec2::ZERO] };
        let area = if radius > 0.0 { 4.0 * radius * radius * open_part(&lens.shape) / eyes.len() as f32 } else { 0.0 };
        let narrow = Vec2::new(lens.glass.narrow(), 1.0) * radius;
        let mut sum = vec![[0.0f32; 4]; crate::field::pixels(size)];
        for (done, place) in eyes.iter().enumerate() {
            job.advance(At::Refocus, done as u32, eyes.len() as u32)?;
            let eye = from.0.to_vec2() + *place * narrow;
            let shot = Shot::through(rig, eye, from.0.to_vec2(), lens, PART * area.sqrt(), place.length_squared());
            let shown = self.shown(&shot, painter, job)?;
            let light = Light::of(self.cloud.blend);
            let barrel = Barrel::of(lens, size);
            sum.par_chunks_mut(size[0] as usize).enumerate().for_each(|(y, row)| {
                for (x, sum) in row.iter_mut().enumerate() {
                    let share = barrel.passes(*place, x, y);
                    let rgb = shown.rgb[y * size[0] as usize + x];
                    (0..3).for_each(|c| sum[c] += share * light.linear(rgb[c]));
                    sum[3] += share;
                }
            });
        }
        job.advance(At::Refocus, eyes.len() as u32, eyes.len() as u32)?;
        let rgb_linear = sum.iter().flat_map(|[r, g, b, n]| [r / n.max(1e-6), g / n.max(1e-6), b / n.max(1e-6)]);
        Ok(Picture { size, rgb_linear: rgb_linear.collect() })
    }
}

/// Part of the square around an opening that is open.
fn open_part(shape: &LensShape) -> f32 {
    const SIDE: i32 = 64;
    let places =
        (0..SIDE * SIDE).map(|i| Vec2::new((i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5) * 2.0 / SIDE as f32 - 1.0);
    places.map(|place| aperture::passes(shape, place)).sum::<f32>() / (SIDE * SIDE) as f32
}

/// Places on an opening, −1 … 1 in both axes, evenly over it, about as many as asked for.
fn eyes(shape: &LensShape, count: usize) -> Vec<Vec2> {
    let is_square = *shape == LensShape::Square;
    let of_square = if is_square { 1.0 } else { std::f32::consts::FRAC_PI_4 };
    let tries = (count as f32 * of_square / open_part(shape).max(0.01)).round() as usize;
    let place = |i: usize| {
        if is_square {
            return Vec2::from(EVEN.map(|step| 2.0 * (0.5 + step * i as f32).fract() - 1.0));
        }
        let r = ((i as f32 + 0.5) / tries as f32).sqrt();
        Vec2::from_angle(GOLDEN * i as f32) * r
    };
    // Where half the light passes, every second eye stands.
    let is_open = |i: &usize| aperture::passes(shape, place(*i)) > (EVEN[0] * *i as f32).fract();
    let open: Vec<Vec2> = (0..tries).filter(is_open).map(place).collect();
    // Their middle is the lens's: else the whole picture would stand aside.
    let mean = open.iter().sum::<Vec2>() / open.len().max(1) as f32;
    let is_even = !matches!(shape, LensShape::Blades { .. });
    open.into_iter().map(|place| if is_even { place - mean } else { place }).collect()
}

/// The barrel that cuts the opening towards the corners.
struct Barrel {
    strength: f32,
    middle: Vec2,
    half_diagonal: f32,
}

impl Barrel {
    fn of(lens: &Lens, size: Size) -> Self {
        let own = if let LensShape::CatEye { strength } = lens.shape { strength } else { 0.0 };
        let swirls = matches!(lens.shape, LensShape::Disc | LensShape::CatEye { .. });
        let strength = if swirls { own.max(lens.glass.swirl) } else { 0.0 };
        let middle = Vec2::new(size[0] as f32 - 1.0, size[1] as f32 - 1.0) / 2.0;
        Self { strength: strength.clamp(0.0, 1.0), middle, half_diagonal: middle.length().max(1.0) }
    }

    /// How much of the light of an eye comes through to a pixel.
    #[inline]
    fn passes(&self, eye: Vec2, x: usize, y: usize) -> f32 {
        if self.strength == 0.0 {
            return 1.0;
        }
        let place = (Vec2::new(x as f32, y as f32) - self.middle) / self.half_diagonal;
        let out = (eye - place * self.strength).length();
        1.0 - crate::field::ramp(0.9, 1.1, out)
    }
}

/// Linear light of a cloud's values, above 1 too.
struct Light(Option<Vec<f32>>);

/// Steps of the table between 0 and 1.
const STEPS: usize = 1024;

impl Light {
    fn of(blend: Blend) -> Self {
        let table = || (0..=STEPS + 1).map(|i| linear_from_srgb(i as f32 / STEPS as f32)).collect();
        Self((blend == Blend::Encoded).then(table))
    }

    #[inline]
    fn linear(&self, value: f32) -> f32 {
        match &self.0 {
            None => value,
            Some(_) if value >= 1.0 => linear_from_srgb(value),
            Some(table) => {
                let at = value.max(0.0) * STEPS as f32;
                let (low, part) = (at as usize, at.fract());
                table[low] + (table[low + 1] - table[low]) * part
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eyes_fill_every_opening_evenly() {
        let shapes = [
            LensShape::Disc,
            LensShape::Square,
            LensShape::Ring { inner: 0.5 },
            LensShape::Blades { count: 6, rotation_deg: 0.0, roundness: 0.0 },
        ];
        for shape in shapes {
            let eyes = eyes(&shape, 64);
            assert!((50..80).contains(&eyes.len()), "{shape:?}: {}", eyes.len());
            let mean = eyes.iter().sum::<Vec2>() / eyes.len() as f32;
            assert!(mean.length() < 0.05, "{shape:?}: {mean}");
            // The second moment of the opening itself.
            let square = |v: &Vec2| v.length_squared();
            let want: Vec<Vec2> = (0..10_000)
                .map(|i| Vec2::new((i % 100) as f32 + 0.5, (i / 100) as f32 + 0.5) / 50.0 - 1.0)
                .filter(|place| aperture::passes(&shape, *place) > 0.0)
                .collect();
            let moment = |all: &[Vec2]| all.iter().map(square).sum::<f32>() / all.len() as f32;
            assert!(
                (moment(&eyes) / moment(&want) - 1.0).abs() < 0.06,
                "{shape:?}: {} {}",
                moment(&eyes),
                moment(&want)
            );
        }
    }
}
