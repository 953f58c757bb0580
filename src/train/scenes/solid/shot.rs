//! Where the camera stands and what lights the scene.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::dapple::Through;
use super::light::Lights;
use super::set::Set;
use super::texture::Texture;
use super::view::Camera;

/// What is seen where nothing stands.
pub enum Sky {
    /// From the top of the picture to its bottom, linear.
    Fade(Vec3, Vec3),
    /// A picture, and the part of it that is seen: its corner and size.
    Picture(Arc<Texture>, Vec2, Vec2),
}

/// Height of the lowest sun that lights level ground, of 1.
const LOWEST_SUN: f32 = 0.15;

/// A camera before a scene.
pub struct Shot {
    /// The camera of the reference view.
    pub camera: Camera,
    /// Lights.
    pub lights: Lights,
    /// Background.
    pub sky: Sky,
    /// What kind of scene it is.
    pub kind: &'static str,
}

/// How a photo is framed, drawn before the scene is known.
#[derive(Clone, Copy, Debug)]
pub struct Framing {
    /// Width and height of the picture in pixels.
    pub size: [usize; 2],
    /// Focal length, 35-mm equivalent.
    pub mm: f32,
}

impl Framing {
    /// A focal length between 20 and 100 mm, mostly wide.
    pub fn random(set: &mut Set, size: [usize; 2]) -> Self {
        Self { size, mm: (20.0f32.ln() + set.range(0.0, 1.0).powf(1.4) * 5.0f32.ln()).exp() }
    }

    /// Focal length in pixels: a 35-mm film is 36 mm wide.
    pub fn focal_px(&self) -> f32 {
        self.mm / 36.0 * self.size[0].max(self.size[1]) as f32
    }

    /// From how far away something this wide fills the picture's width.
    pub fn distance(&self, wide: f32) -> f32 {
        wide * self.focal_px() / self.size[0] as f32
    }

    /// Metres from the picture's middle to its right and lower edges, this far away.
    pub fn half(&self, away: f32) -> [f32; 2] {
        self.size.map(|side| side as f32 / 2.0 / self.focal_px() * away)
    }
}

/// The direction to a camera that stands `pitch` above what it looks at, turned by `yaw` from its front, radians.
pub fn above(yaw: f32, pitch: f32) -> Vec3 {
    Vec3::new(yaw.sin() * pitch.cos(), pitch.sin(), yaw.cos() * pitch.cos())
}

impl Set<'_> {
    /// A camera that looks at a place from another, not quite level.
    pub fn look(&mut self, framing: &Framing, eye: Vec3, target: Vec3) -> Camera {
        let way = (target - eye).normalize_or(-Vec3::Z);
        let roll = if self.chance(0.3) { self.range(-0.35, 0.35) } else { self.rng.normal() * 0.035 };
        let angles = [way.x.atan2(-way.z), way.y.clamp(-1.0, 1.0).asin(), roll];
        Camera::new(eye, angles, framing.focal_px(), framing.size)
    }

    fn warmth(&mut self, reach: f32) -> Vec3 {
        let warm = self.range(-reach, reach).exp();
        Vec3::new(warm, self.range(0.96, 1.04), 1.0 / warm)
    }

    /// Light of a day outside: sun by height, sky, and what the ground throws back.
    pub fn day(&mut self) -> Lights {
        let height = self.range(0.15, 1.4f32);
        let turn = self.turn();
        let sun_from = Vec3::new(turn.cos() * height.cos(), height.sin(), turn.sin() * height.cos()).normalize();
        let clouded = self.chance(0.35);
        let sun = if clouded { self.range(0.0, 0.3) } else { self.range(0.8, 3.0) };
        // Low suns are red.
        let red = Vec3::new(1.0, 0.75 + 0.2 * height.sin(), 0.5 + 0.45 * height.sin());
        let sky = self.warmth(0.15) * Vec3::new(0.9, 1.0, 1.15) * self.range(0.5, 1.0);
        let haze_m = if self.chance(0.3) { self.range(25.0, 150.0) } else { self.range(200.0, 2000.0) };
        Lights {
            sun_from,
            sun: red * sun,
            sky,
            ground: self.warmth(0.1) * self.range(0.15, 0.4),
            lamp_at: Vec3::ZERO,
            lamp: Vec3::ZERO,
            soft: self.range(0.01, 0.05),
            through: Through::Air,
            haze_m,
        }
    }

    /// Light of a sun that on level ground gives 0.8 to `most` times as much as the sky.
    pub fn clear_sun(&mut self, sky: Vec3, sun_from: Vec3, most: f32) -> Vec3 {
        let warm = Vec3::new(1.0, self.range(0.8, 1.0), self.range(0.6, 1.0));
        // What lies lower gives no more.
        warm * (sky.y * self.range(0.8, most) / sun_from.y.max(LOWEST_SUN))
    }

    /// Light of a room: a window or a large lamp that throws shadows, a small lamp, and what walls throw back.
    pub fn indoors(&mut self, lamp_at: Vec3) -> Lights {
        let turn = self.turn();
        let height = self.range(0.35, 1.2f32);
        let sun_from = Vec3::new(turn.cos() * height.cos(), height.sin(), turn.sin() * height.cos()).normalize();
        let (key, lamp) = (self.range(0.0, 1.4), if self.chance(0.7) { self.range(0.2, 2.2) } else { 0.0 });
        Lights {
            sun_from,
            sun: self.warmth(0.2) * key,
            sky: self.warmth(0.15) * self.range(0.25, 0.8),
            ground: self.warmth(0.15) * self.range(0.12, 0.4),
            lamp_at,
            lamp: self.warmth(0.3) * lamp,
            soft: self.range(0.01, 0.06),
            through: Through::Air,
            haze_m: 1e4,
        }
    }

    /// A sky: plain, or a photo's upper part, or a picture of somewhere.
    pub fn sky(&mut self) -> Sky {
        if self.chance(0.35) {
            let stock = self.stock;
            if let Some(cloth) = stock.cloth(&mut self.rng, &["backdrop"]) {
                let wide = self.range(0.4, 0.9);
                let corner = Vec2::new(self.range(0.0, 1.0 - wide), self.range(0.0, 1.0 - wide));
                return Sky::Picture(cloth.texture.clone(), corner, Vec2::splat(wide));
            }
        }
        let low = self.warmth(0.15) * self.range(0.8, 1.6);
        let high = Vec3::new(self.range(0.25, 0.9), self.range(0.45, 0.95), 1.0) * self.range(0.5, 1.3);
        Sky::Fade(high, low)
    }
}
