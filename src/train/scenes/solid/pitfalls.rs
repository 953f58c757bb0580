//! Scenes that show what nets read wrongly: a bare top over which the light falls off, a bright wall or window above a
//! darker room, someone near who fills the picture, perhaps in a patterned coat, land and streets under
//! clouds, flowers seen from near, things on a ledge or hanging before the wide world, walls with bold patterns, long
//! shadows, sunlight in patches.

use glam::Vec3;

use super::inside::{FLOOR, Shell, WALL, black};
use super::light::Lights;
use super::mesh::Paint;
use super::set::Set;
use super::shot::{Framing, Shot, above};

/// The kind of a scene whose order the row number may tell.
pub const BARE_TOP: &str = "bare top";

impl Set<'_> {
    /// One of them.
    pub fn pitfall(&mut self, framing: &Framing) -> Shot {
        match self.rng.weighted(&[0.13, 0.1, 0.17, 0.11, 0.07, 0.14, 0.1, 0.07, 0.11, 0.3, 0.2]) {
            0 => self.bare_top(framing),
            1 => self.bright_room(framing),
            2 => self.portrait(framing),
            3 => self.landscape(framing),
            4 => self.under_clouds(framing),
            5 => self.bed(framing),
            6 => self.ledge(framing),
            7 => self.hanging(framing),
            8 => self.patterned(framing),
            9 => self.low_sun(framing),
            _ => self.dappled(framing),
        }
    }

    /// A street, front or garden under a clouded sky.
    fn under_clouds(&mut self, framing: &Framing) -> Shot {
        let shot = match self.rng.below(3) {
            0 => self.street(framing),
            1 => self.facade(framing),
            _ => self.garden(framing),
        };
        Shot { sky: self.clouds(), kind: "clouds", ..shot }
    }

    /// A table, desk or floor that is nearly bare, from 15° to 90° above, lit by a lamp near it.
    fn bare_top(&mut self, framing: &Framing) -> Shot {
        let paint = if self.chance(0.6) { self.plain() } else { self.cloth(&FLOOR, 0.9) };
        let size = Vec3::new(self.range(0.7, 3.0), 0.75, self.range(0.6, 2.0));
        let floor = self.cloth(&FLOOR, 1.2);
        self.panel(Vec3::new(-6.0, 0.0, 6.0), Vec3::X * 12.0, Vec3::Z * -12.0, &floor, [false, true]);
        let wall = if self.chance(0.5) { self.plain() } else { self.cloth(&WALL, 1.5) };
        let behind = -size.z / 2.0 - self.range(0.0, 3.0);
        self.panel(Vec3::new(-6.0, 0.0, behind), Vec3::X * 12.0, Vec3::Y * 4.0, &wall, [false, false]);
        let high = if self.chance(0.75) {
            self.block(Vec3::Y * (size.y - 0.04), Vec3::new(size.x, 0.04, size.z), 0.0, &paint);
            size.y
        } else {
            0.0
        };
        let long = self.range(0.04, 0.16);
        for _ in 0..self.rng.weighted(&[0.25, 0.3, 0.2, 0.15, 0.1]) {
            let at = Vec3::new(self.range(-0.35, 0.35) * size.x, high, self.range(-0.35, 0.35) * size.z);
            let long = long * self.range(0.6, 1.4);
            self.small(at, long);
        }
        let pitch = self.range(0.26, 1.5f32);
        let yaw = if self.chance(0.4) { self.turn() } else { self.rng.normal() * 0.4 };
        let target = Vec3::new(self.range(-0.25, 0.25) * size.x, high, self.range(-0.25, 0.25) * size.z);
        let away = framing.distance(self.range(0.4, 1.1)).clamp(0.25, 1.8);
        let eye = target + above(yaw, pitch) * away;
        let lamp_at = target + Vec3::new(self.range(-1.0, 1.0), self.range(0.2, 1.0), self.range(-1.0, 1.0));
        let camera = self.look(framing, eye, target);
        let lights = self.one_lamp(lamp_at);
        Shot { camera, lights, sky: black(), kind: BARE_TOP }
    }

    /// A lamp that is most of the light there is.
    fn one_lamp(&mut self, lamp_at: Vec3) -> Lights {
        let (lights, rest) = (self.indoors(lamp_at), self.range(0.1, 0.7));
        let lamp = Vec3::splat(self.range(0.5, 2.0)) + lights.lamp;
        Lights { sky: lights.sky * rest, sun: lights.sun * rest, lamp, ..lights }
    }

    /// A room whose upper part is bright: a window, a whiteboard, a wall in the light.
    fn bright_room(&mut self, framing: &Framing) -> Shot {
        let shell = self.shell();
        self.brighten(&shell);
        Shot { kind: "bright", ..self.furnished(framing, &shell) }
    }

    fn brighten(&mut self, shell: &Shell) {
        let Shell { wide, deep, high } = *shell;
        let bright = |set: &mut Self| {
            let light = set.range(1.2, 5.0);
            let skin = if set.chance(0.25) { set.cloth(&["backdrop", "wall"], 2.0).skin } else { None };
            let tint = [set.range(0.85, 1.0), set.range(0.9, 1.0), set.range(0.85, 1.1)].map(|c| c * light);
            Paint { tint, skin, metres: glam::Vec2::splat(2.0), gloss: 0.0 }
        };
        let whole = self.chance(0.35);
        // Along the back wall, then along the side walls.
        for (corner, right, normal, chance) in [
            (Vec3::new(-wide / 2.0, 0.0, -deep), Vec3::X * wide, Vec3::Z, 0.8),
            (Vec3::new(-wide / 2.0, 0.0, 0.0), Vec3::Z * -deep, Vec3::X, 0.4),
            (Vec3::new(wide / 2.0, 0.0, -deep), Vec3::Z * deep, -Vec3::X, 0.4),
        ] {
            if !self.chance(chance) {
                continue;
            }
            let paint = bright(self);
            let [from, part] = if whole { [0.0, 1.0] } else { [self.range(0.0, 0.5), self.range(0.3, 0.8)] };
            let part = part.min(1.0 - from);
            let low = high * self.range(0.25, 0.55);
            let tall = (high - low) * if whole { 1.0 } else { self.range(0.6, 1.0) };
            self.panel(
                corner + right * from + Vec3::Y * low + normal * 0.015,
                right * part,
                Vec3::Y * tall,
                &paint,
                [true, false],
            );
        }
    }

    /// Someone or some animal near, cut by the picture's lower edge, and the rest of the world well behind.
    fn portrait(&mut self, framing: &Framing) -> Shot {
        let outside = self.chance(0.4);
        let ground = if outside { self.cloth(&["grass", "ground", "stone"], 1.0) } else { self.cloth(&FLOOR, 1.0) };
        self.panel(Vec3::new(-15.0, 0.0, 6.0), Vec3::X * 30.0, Vec3::Z * -36.0, &ground, [false, true]);
        let tall = self.range(0.3, 1.7);
        let behind = -tall * self.range(0.6, 4.0) - 0.4;
        if !outside || self.chance(0.4) {
            let wall = if self.chance(0.3) { self.photo().0 } else { self.cloth(&WALL, 1.5) };
            let wall = Paint { metres: glam::Vec2::splat(self.range(1.0, 4.0)), ..wall };
            self.panel(Vec3::new(-15.0, 0.0, behind), Vec3::X * 30.0, Vec3::Y * 6.0, &wall, [false, false]);
        }
        if self.chance(0.4) || self.relief(Vec3::ZERO, tall, 0.0).is_none() {
            let yaw = self.rng.normal() * 0.6;
            if self.chance(0.65) {
                self.coated(Vec3::ZERO, tall, yaw);
            } else {
                self.turned(&["person", "animal"], Vec3::ZERO, Some(tall), yaw);
            }
        }
        for _ in 0..self.count(0, 5) {
            let at = Vec3::new(self.range(-1.6, 1.6) * tall, 0.0, behind * self.range(0.35, 0.95));
            let long = tall * self.range(0.2, 0.9);
            if self.chance(0.5) {
                self.small(at, long);
            } else {
                self.thing(&["furniture", "plant", "other"], at, Some(long));
            }
        }
        let pitch = self.range(-0.1, 0.6f32);
        let target = Vec3::new(self.range(-0.15, 0.15) * tall, tall * self.range(0.45, 0.8), 0.0);
        let shown = tall * self.range(0.3, 1.1) * framing.size[0] as f32 / framing.size[1] as f32;
        let away = framing.distance(shown).clamp(0.3, 6.0);
        let yaw = self.rng.normal() * 0.25;
        let eye = target + above(yaw, pitch) * away;
        let eye = eye.max(Vec3::new(f32::MIN, 0.1, f32::MIN));
        let camera = self.look(framing, eye, target);
        let lamp_at = eye + Vec3::new(self.range(-1.0, 1.0), self.range(0.2, 1.0), 0.0) * tall;
        let lights = if outside { self.day() } else { self.indoors(lamp_at) };
        Shot { camera, lights, sky: self.sky(), kind: "portrait" }
    }
}
