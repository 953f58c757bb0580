//! What looks deep and is flat: bold patterns, print, planks and curtains on walls and floors, little before them.

use std::f32::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};

use super::coats::hide;
use super::mesh::Paint;
use super::set::{Set, stand};
use super::shapes::sheet;
use super::shot::{Framing, Shot};
use super::texture::Texture;

/// The kind of such a scene.
pub const PATTERN: &str = "pattern";

impl Set<'_> {
    /// A patterned wall, square or slanting, perhaps a corner, over a patterned ground.
    pub fn patterned(&mut self, framing: &Framing) -> Shot {
        let (wide, high) = (self.range(3.0, 12.0), self.range(1.5, 6.0));
        let ground = self.bold(1.0);
        self.panel(Vec3::new(-30.0, 0.0, 20.0), Vec3::X * 60.0, Vec3::Z * -60.0, &ground, [false, true]);
        let yaw = self.range(-1.0, 1.0);
        let place = stand(Vec3::ZERO, yaw, 1.0);
        let wall = self.bold(1.5);
        self.wall(place, wide, high, &wall);
        if self.chance(0.35) {
            // A second wall, at the end of the first.
            let side = if self.chance(0.5) { -1.0 } else { 1.0 };
            let end = place * stand(Vec3::new(0.5 * side * wide, 0.0, 0.5 * wide), -side * FRAC_PI_2, 1.0);
            let paint = if self.chance(0.5) { wall } else { self.bold(1.5) };
            self.wall(end, wide, high, &paint);
        }
        let target = place.transform_point3(Vec3::new(self.range(-0.3, 0.3) * wide, high * self.range(0.1, 0.9), 0.0));
        let away = framing.distance(self.range(0.5, 4.0)).clamp(0.4, 8.0);
        let eye = Vec3::new(target.x + self.range(-0.5, 0.5) * away, self.range(0.2, 2.2), target.z + away);
        for _ in 0..self.rng.weighted(&[0.3, 0.3, 0.2, 0.2]) {
            let foot = target.lerp(eye, self.range(0.1, 0.75)) + Vec3::X * self.range(-0.4, 0.4) * away;
            self.before_wall(foot.with_y(0.0), eye);
        }
        let camera = self.look(framing, eye, target);
        let lamp_at = eye + Vec3::new(self.range(-1.0, 1.0), self.range(0.2, 1.0), 0.0) * away;
        let lights = if self.chance(0.5) { self.day() } else { self.indoors(lamp_at) };
        Shot { camera, lights, sky: self.sky(), kind: PATTERN }
    }

    /// A pattern of two colours, print, a picture or a texture.
    fn bold(&mut self, metres: f32) -> Paint {
        match self.rng.weighted(&[0.4, 0.15, 0.1, 0.35]) {
            0 => {
                let skin = Some(Arc::new(Texture::opaque(&hide(&mut self.rng))));
                Paint { tint: [1.0; 3], skin, metres: Vec2::splat(metres * self.range(0.3, 2.0)), gloss: 0.0 }
            }
            1 => Paint { metres: Vec2::new(1.0, 1.4) * metres * self.range(0.3, 1.5), ..self.print() },
            2 => self.photo().0,
            _ => self.cloth(&["wall", "floor", "fabric", "wood", "other"], metres),
        }
    }

    /// A flat wall, planks or slats, or a curtain: centimetres deep where they are deep at all.
    fn wall(&mut self, place: Affine3A, wide: f32, high: f32, paint: &Paint) {
        let (often, phase) = (self.range(2.0, 9.0), self.turn());
        let kind = self.rng.weighted(&[0.5, 0.2, 0.3]);
        let deep = [0.0, 0.015, 0.04][kind] * self.range(0.3, 1.5);
        let cells = [1, 240, 240][kind];
        let face = sheet([cells, 1], |s, t| {
            let wave = (TAU * often * s * wide + phase).sin();
            let wave = if kind == 1 { wave.signum() } else { wave + 0.4 * (2.3 * often * s * wide).sin() };
            (Vec3::new((s - 0.5) * wide, t * high, deep * wave), Vec2::new(s * wide, (1.0 - t) * high))
        });
        self.put(&face, place, paint);
    }

    fn before_wall(&mut self, foot: Vec3, eye: Vec3) {
        let tall = self.range(0.15, 1.4);
        match self.rng.weighted(&[0.3, 0.25, 0.25, 0.2]) {
            0 => self.small(foot, tall.min(0.6)),
            1 => self.thing(&["furniture", "plant", "other", "vehicle"], foot, None).map_or((), |_| ()),
            2 => self.someone(foot, eye),
            _ => self.plant(foot, tall),
        }
    }
}
