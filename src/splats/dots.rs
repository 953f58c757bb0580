//! The points that a light field's rays end at, drawn as dots from any side: quick enough to follow the hand.
//!
//! Each dot is as large as its pixel was in the view that found it, and the nearest wins. Turned nowhere, the dots are the
//! reference view.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{Mat3, Vec2, Vec3};
use rayon::prelude::*;

use super::points::{Space, points, seen_by};
use super::{Camera, SplatError};
use crate::field::{LightField, RayDepths, Size};
use crate::job::{Cancelled, Job};

/// From where the scene is looked at: around its middle, and how near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// The scene's turn about the upright axis, in radians: its near side goes right.
    pub yaw: f32,
    /// Its turn about the level axis: its near side goes down.
    pub pitch: f32,
    /// How many times as near as the camera its middle is.
    pub near: f32,
}

impl Default for Turn {
    fn default() -> Self {
        Self { yaw: 0.0, pitch: 0.0, near: 1.0 }
    }
}

impl Turn {
    /// A turn up or down ends before it stands on its head.
    const MOST_PITCH: f32 = 1.4;
    const NEAR: [f32; 2] = [0.2, 16.0];

    /// Turned further, in radians.
    #[must_use]
    pub fn by(self, yaw: f32, pitch: f32) -> Self {
        use std::f32::consts::{PI, TAU};
        let yaw = (self.yaw + yaw + PI).rem_euclid(TAU) - PI;
        Self { yaw, pitch: (self.pitch + pitch).clamp(-Self::MOST_PITCH, Self::MOST_PITCH), ..self }
    }

    /// Brought nearer by a factor.
    #[must_use]
    pub fn nearer(self, factor: f32) -> Self {
        Self { near: (self.near * factor).clamp(Self::NEAR[0], Self::NEAR[1]), ..self }
    }

    fn matrix(self) -> Mat3 {
        Mat3::from_rotation_x(self.pitch) * Mat3::from_rotation_y(-self.yaw)
    }
}

/// Whose rays give the points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gathered {
    /// Those of the reference view.
    Reference,
    /// Those of all views, each point once.
    All,
}

/// Points in space, with their colours.
#[derive(Clone, Debug)]
pub struct Dots {
    camera: Camera,
    /// What the scene turns around.
    middle: Vec3,
    places: Vec<Vec3>,
    /// As the views store them.
    colors: Vec<[u8; 3]>,
}

/// A dot is this much larger than its pixel, so that turned surfaces stay closed.
const ROOM: f32 = 1.2;
/// A dot is no larger than this.
const MOST_PX: f32 = 48.0;
/// What is nearer to the eye than this is not drawn: the nearest point is 1 away from the camera.
const TOO_NEAR: f32 = 0.05;
/// Dots between two looks at the cancel flag.
const CHUNK: usize = 1 << 14;
/// Nothing is seen here.
const NOTHING: u64 = u64::MAX;

impl Dots {
    /// The points of a light field. `focal`: as for [`super::from_field()`].
    ///
    /// # Errors
    /// Stopped, or disparities beyond all measure.
    pub fn of(
        field: &LightField,
        depths: &RayDepths,
        focal: Option<f32>,
        gathered: Gathered,
        job: &Job,
    ) -> Result<Self, SplatError> {
        let points = match gathered {
            Gathered::Reference => seen_by(field, depths, field.grid().reference())?,
            Gathered::All => points(field, depths, job)?,
        };
        let space = Space::of(depths, focal, field.size());
        let places: Vec<Vec3> = points.iter().map(|point| space.place(point)).collect();
        let colors = points.iter().map(|point| point.color(field)).collect();
        // The reference view's points come first: the middle stays when others are added.
        let mut far: Vec<f32> = places.iter().take(crate::field::pixels(field.size())).map(|place| place.z).collect();
        let half = far.len() / 2;
        let middle = Vec3::Z * *far.select_nth_unstable_by(half, f32::total_cmp).1;
        Ok(Self { camera: space.camera, middle, places, colors })
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.places.len()
    }

    /// What is seen, sRGB `[y, x, 4]`, transparent where nothing is. Turned nowhere, the camera's picture just fits.
    ///
    /// # Errors
    /// Stopped.
    pub fn drawn(&self, turn: Turn, size: Size, job: &Job) -> Result<Vec<u8>, Cancelled> {
        let nearest: Vec<AtomicU64> = (0..crate::field::pixels(size)).map(|_| AtomicU64::new(NOTHING)).collect();
        let eye = Eye::new(self, turn, size);
        let dots = self.places.par_chunks(CHUNK).zip(self.colors.par_chunks(CHUNK));
        dots.try_for_each(|(places, colors)| {
            places.iter().zip(colors).for_each(|(place, color)| eye.put(*place, *color, &nearest));
            job.cancel.check()
        })?;
        let rgba = |nearest: &AtomicU64| match nearest.load(Ordering::Relaxed) {
            NOTHING => [0; 4],
            seen => [(seen >> 16) as u8, (seen >> 8) as u8, seen as u8, 255],
        };
        Ok(nearest.iter().flat_map(rgba).collect())
    }
}

/// From a place in space to pixels of the screen.
struct Eye {
    turn: Mat3,
    middle: Vec3,
    /// The middle as the eye sees it.
    ahead: Vec3,
    /// Screen pixels for a pixel of the view.
    scale: f32,
    focal_px: f32,
    center_px: Vec2,
    size: Size,
}

impl Eye {
    fn new(dots: &Dots, turn: Turn, size: Size) -> Self {
        let screen = Vec2::new(size[0] as f32, size[1] as f32);
        let scale = (screen / Vec2::new(dots.camera.size[0] as f32, dots.camera.size[1] as f32)).min_element();
        Self {
            turn: turn.matrix(),
            middle: dots.middle,
            ahead: dots.middle / turn.near,
            scale,
            focal_px: dots.camera.focal_px.x * scale,
            center_px: screen / 2.0 - 0.5,
            size,
        }
    }

    /// Draws a dot where nothing nearer is. The nearest in each pixel does not hang on the order: distance and colour are
    /// one number, of which the least stays.
    fn put(&self, place: Vec3, [r, g, b]: [u8; 3], nearest: &[AtomicU64]) {
        let seen = self.turn * (place - self.middle) + self.ahead;
        if seen.z < TOO_NEAR {
            return;
        }
        let at = seen.truncate() * (self.focal_px / seen.z) + self.center_px;
        let half = (ROOM * self.scale * place.z / seen.z).clamp(1.0, MOST_PX) / 2.0;
        let rows = covered(at.y, half, self.size[1]);
        let columns = covered(at.x, half, self.size[0]);
        let dot = u64::from(seen.z.to_bits()) << 32 | u64::from(u32::from_be_bytes([0, r, g, b]));
        for y in rows {
            for pixel in &nearest[y * self.size[0] as usize..][columns.clone()] {
                if pixel.load(Ordering::Relaxed) > dot {
                    pixel.fetch_min(dot, Ordering::Relaxed);
                }
            }
        }
    }
}

/// The pixels of a row or column whose middle a dot covers.
fn covered(at: f32, half: f32, size: u32) -> std::ops::Range<usize> {
    let first = (at - half).ceil().max(0.0) as usize;
    let end = (at + half).ceil().clamp(0.0, size as f32) as usize;
    first.min(end)..end
}

#[cfg(test)]
mod tests {
    use super::super::tests::made_scene;
    use super::*;
    use crate::field::ViewGrid;
    use crate::job::Cancel;

    const SIZE: Size = [120, 80];

    fn dots(gathered: Gathered) -> (LightField, Dots) {
        let (field, depths) = made_scene(SIZE, ViewGrid::PAPER);
        let dots = Dots::of(&field, &depths, None, gathered, &Job { cancel: &Cancel::default(), sink: &() }).unwrap();
        (field, dots)
    }

    fn drawn(dots: &Dots, turn: Turn) -> Vec<u8> {
        dots.drawn(turn, SIZE, &Job { cancel: &Cancel::default(), sink: &() }).unwrap()
    }

    /// Where the middle of the made scene's disc is seen: it alone is this red.
    fn disc(rgba: &[u8]) -> Vec2 {
        let is_disc = |pixel: &[u8]| pixel[3] > 0 && pixel[0] > pixel[2].saturating_add(25);
        let all = rgba.chunks_exact(4).enumerate().filter(|(_, pixel)| is_disc(pixel));
        let (sum, count) = all.fold((Vec2::ZERO, 0.0), |(sum, count), (i, _)| {
            (sum + Vec2::new((i as u32 % SIZE[0]) as f32, (i as u32 / SIZE[0]) as f32), count + 1.0)
        });
        assert!(count > 200.0, "the disc is seen: {count}");
        sum / count
    }

    #[test]
    fn turned_nowhere_the_dots_are_the_reference_view() {
        for gathered in [Gathered::Reference, Gathered::All] {
            let (field, dots) = dots(gathered);
            let shown = drawn(&dots, Turn::default());
            let view = field.view(field.grid().reference()).rgba();
            let same = shown.chunks_exact(4).zip(view.chunks_exact(4)).filter(|(a, b)| a == b).count();
            assert!(same * 100 >= 99 * 120 * 80, "{gathered:?}: {same}");
        }
    }

    #[test]
    fn near_things_follow_the_turn_and_other_views_fill_what_was_hidden() {
        let (_, all) = dots(Gathered::All);
        let (_, one) = dots(Gathered::Reference);
        assert!(all.count() > one.count());
        let middle = disc(&drawn(&all, Turn::default()));
        let right = disc(&drawn(&all, Turn::default().by(0.3, 0.0)));
        let down = disc(&drawn(&all, Turn::default().by(0.0, 0.3)));
        assert!(right.x > middle.x + 3.0 && (right.y - middle.y).abs() < 3.0, "{middle} {right}");
        assert!(down.y > middle.y + 3.0 && (down.x - middle.x).abs() < 3.0, "{middle} {down}");
        let turned = Turn::default().by(0.12, 0.0);
        let holes = |dots| drawn(dots, turned).chunks_exact(4).filter(|pixel| pixel[3] == 0).count();
        assert!(holes(&all) < holes(&one), "{} of {}", holes(&all), holes(&one));
    }

    #[test]
    fn nearer_is_larger_and_a_whole_turn_leads_back() {
        let (_, dots) = dots(Gathered::Reference);
        let seen = |turn| drawn(&dots, turn).chunks_exact(4).filter(|pixel| pixel[3] > 0).count();
        assert!(seen(Turn::default().nearer(0.5)) < seen(Turn::default()) / 2);
        let around = (0..8).fold(Turn::default(), |turn, _| turn.by(std::f32::consts::FRAC_PI_4, 0.0));
        assert!(around.yaw.abs() < 1e-5 && drawn(&dots, Turn::default().by(9.0, 9.0)).len() == 120 * 80 * 4);
    }

    #[test]
    fn a_stopped_job_draws_nothing() {
        let (_, dots) = dots(Gathered::Reference);
        let cancel = Cancel::default();
        cancel.cancel();
        assert!(dots.drawn(Turn::default(), SIZE, &Job { cancel: &cancel, sink: &() }).is_err());
    }
}
