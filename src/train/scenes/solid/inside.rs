//! Scenes with walls: rooms, tables, shelves and counters, things before a wall, stairs.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;

use super::set::{Set, stand};
use super::shapes::{cuboid, sheet};
use super::shot::{Framing, Shot, Sky, above};

/// Things that stand on floors.
const STANDING: [&str; 4] = ["furniture", "furniture", "plant", "other"];

pub(super) const FLOOR: [&str; 4] = ["floor", "wood", "fabric", "stone"];
pub(super) const WALL: [&str; 4] = ["wall", "stone", "wood", "backdrop"];

pub(super) fn black() -> Sky {
    Sky::Fade(Vec3::splat(0.3), Vec3::splat(0.2))
}

/// A room from z = 0 back to −deep, about x = 0.
pub(super) struct Shell {
    pub wide: f32,
    pub deep: f32,
    pub high: f32,
}

impl Set<'_> {
    /// Floor, ceiling and walls with what hangs on them. They throw no shadow, or it would be night.
    pub(super) fn shell(&mut self) -> Shell {
        let (wide, deep, high) = (self.range(2.2, 7.0), self.range(2.5, 9.0), self.range(2.1, 3.6));
        let [x, z] = [wide / 2.0, deep];
        let floor = self.cloth(&FLOOR, 1.2);
        let wall = if self.chance(0.6) { self.plain() } else { self.cloth(&WALL[..2], 1.5) };
        let ceiling = if self.chance(0.7) { self.plain() } else { self.cloth(&WALL, 1.5) };
        let (right, up, back) = (Vec3::X * wide, Vec3::Y * high, Vec3::Z * -deep);
        let plain = [false, false];
        self.panel(Vec3::new(-x, 0.0, 0.0), right, back, &floor, plain);
        self.panel(Vec3::new(-x, high, 0.0), right, back, &ceiling, plain);
        self.panel(Vec3::new(-x, 0.0, -z), right, up, &wall, plain);
        self.panel(Vec3::new(-x, 0.0, 0.5), right, up, &wall, plain);
        let side = if self.chance(0.3) { self.any_paint(1.5) } else { wall };
        self.panel(Vec3::new(-x, 0.0, 0.0), back, up, &side, plain);
        self.panel(Vec3::new(x, 0.0, -z), -back, up, &side, plain);
        for _ in 0..self.count(0, 5) {
            let (face, long) = (self.count(0, 2), self.range(0.25, 1.4));
            let y = self.range(0.8, high - 0.5);
            match face {
                0 => {
                    let at = Vec3::new(self.range(-x + 0.4, x - 0.4), y, -z);
                    self.on_wall(at, Vec3::X, Vec3::Z, long);
                }
                1 => {
                    let at = Vec3::new(-x, y, -self.range(0.5, z - 0.3));
                    self.on_wall(at, -Vec3::Z, Vec3::X, long);
                }
                _ => {
                    let at = Vec3::new(x, y, -self.range(0.5, z - 0.3));
                    self.on_wall(at, Vec3::Z, -Vec3::X, long);
                }
            }
        }
        if self.chance(0.25) {
            // Beams or pipes under the ceiling.
            let (paint, thick) = (self.any_paint(0.5), self.range(0.05, 0.25));
            for i in 0..self.count(1, 5) {
                let at = Vec3::new(0.0, high - thick, -0.6 - deep * i as f32 / 5.0);
                self.world.add(&cuboid(Vec3::new(wide, thick, thick)), stand(at, 0.0, 1.0), Some(&paint), false);
            }
        }
        Shell { wide, deep, high }
    }

    /// A room with furniture along its walls and in its middle, and what lies on it and hangs over it.
    pub fn room(&mut self, framing: &Framing) -> Shot {
        let shell = self.shell();
        self.furnished(framing, &shell)
    }

    /// A shell, furnished.
    pub(super) fn furnished(&mut self, framing: &Framing, shell: &Shell) -> Shot {
        let Shell { wide, deep, high } = *shell;
        let (x, z) = (wide / 2.0, deep);
        for _ in 0..self.count(3, 9) {
            let (px, pz) = match self.rng.weighted(&[0.35, 0.25, 0.25, 0.15]) {
                0 => (self.range(-x + 0.5, x - 0.5), -z + 0.45),
                1 => (-x + 0.45, -self.range(0.8, z - 0.5)),
                2 => (x - 0.45, -self.range(0.8, z - 0.5)),
                _ => (self.range(-x, x) * 0.6, -self.range(0.35, 0.8) * z),
            };
            let (at, yaw) = (Vec3::new(px, 0.0, pz), self.quarter());
            if self.chance(0.12) {
                self.chair(at, yaw);
                continue;
            }
            let Some(size) = self.turned(&STANDING, at, None, yaw) else {
                let size = Vec3::new(self.range(0.4, 1.5), self.range(0.4, 1.9), self.range(0.3, 0.7));
                let paint = self.any_paint(0.8);
                self.block(at, size, yaw, &paint);
                continue;
            };
            if size.y < 1.2 && self.chance(0.75) {
                for _ in 0..self.count(1, 4) {
                    let on = Vec3::new(self.range(-0.3, 0.3) * size.x, size.y, self.range(-0.3, 0.3) * size.z);
                    let long = self.range(0.08, 0.4);
                    self.small(at + on, long);
                }
            }
        }
        for _ in 0..self.count(0, 5) {
            let (at, long) =
                (Vec3::new(self.range(-x, x) * 0.85, 0.0, -self.range(0.5, z - 0.3)), self.range(0.1, 0.5));
            self.small(at, long);
        }
        if self.chance(0.3) {
            let rug = self.any_paint(1.5);
            let corner = Vec3::new(-self.range(0.3, 0.9) * x, 0.012, -self.range(0.2, 0.6) * z);
            let (along, up) = (Vec3::X * self.range(1.0, 2.4), Vec3::Z * -self.range(0.8, 2.0));
            self.panel(corner, along, up, &rug, [true, false]);
        }
        for _ in 0..self.rng.weighted(&[0.5, 0.3, 0.2]) {
            let from = Vec3::new(self.range(-x, x) * 0.7, high, -self.range(0.25, 0.9) * z);
            let down = self.range(0.2, 1.1);
            self.hanging_lamp(from, down);
        }
        let eye =
            Vec3::new(self.range(-0.8, 0.8) * x, self.range(0.2, (high - 0.15).min(2.2)), -self.range(0.02, 0.3) * z);
        for _ in 0..self.rng.weighted(&[0.5, 0.35, 0.15]) {
            let at = Vec3::new(self.range(-0.7, 0.7) * x, 0.0, -self.range(0.4, 0.9) * z);
            self.someone(at, eye);
        }
        // Somewhere in the back half, from the floor to the ceiling.
        let target = Vec3::new(self.range(-0.9, 0.9) * x, high * self.range(0.1, 0.9), -self.range(0.6, 1.0) * z);
        let camera = self.look(framing, eye, target);
        let lamp_at = Vec3::new(self.range(-0.6, 0.6) * x, high - 0.3, -self.range(0.2, 0.8) * z);
        Shot { camera, lights: self.indoors(lamp_at), sky: black(), kind: "room" }
    }

    /// A table top, seen from 15° to 90° above, with what lies, stands and leans on it.
    pub fn table_top(&mut self, framing: &Framing) -> Shot {
        let food = self.chance(0.45);
        let high = self.range(0.4, 1.1);
        let size = Vec3::new(self.range(0.6, 2.4), high, self.range(0.5, 1.4));
        let floor = self.cloth(&FLOOR, 1.2);
        self.panel(Vec3::new(-6.0, 0.0, 5.0), Vec3::X * 12.0, Vec3::Z * -11.0, &floor, [false, true]);
        let behind = -size.z / 2.0 - self.range(0.0, 3.5);
        let wall = self.cloth(&WALL, 1.5);
        self.panel(Vec3::new(-6.0, 0.0, behind), Vec3::X * 12.0, Vec3::Y * 4.0, &wall, [false, false]);
        for _ in 0..self.count(0, 3) {
            let at = Vec3::new(self.range(-1.5, 1.5), high + self.range(0.2, 1.0), behind);
            let wide = self.range(0.3, 1.2);
            self.on_wall(at, Vec3::X, Vec3::Z, wide);
        }
        self.table(Vec3::ZERO, size);
        for _ in 0..self.count(0, 3) {
            let (at, yaw) = (Vec3::new(self.range(-1.6, 1.6), 0.0, -size.z / 2.0 - self.range(0.1, 1.0)), self.turn());
            if self.chance(0.5) { self.chair(at, yaw) } else { self.thing(&STANDING, at, None).map_or((), |_| ()) }
        }
        let reach = self.range(0.3, 1.0);
        let on_top = |set: &mut Self| {
            Vec3::new(set.range(-0.45, 0.45) * size.x * reach, high, set.range(-0.42, 0.42) * size.z * reach)
        };
        for _ in 0..self.count(2, 5) {
            // Flat things first: pages, photos, cloths, boards.
            let (at, w, h) = (on_top(self), self.range(0.1, 0.4), self.range(0.1, 0.3));
            let paint = if self.chance(0.4) { self.print() } else { self.any_paint(0.3) };
            let thick = if self.chance(0.7) { 0.003 } else { self.range(0.005, 0.04) };
            let yaw = self.turn();
            self.block(at, Vec3::new(w, thick, h), yaw, &paint);
        }
        for _ in 0..self.count(2, 12) {
            let (at, long) = (on_top(self), self.range(0.06, 0.32));
            if food && self.chance(0.7) {
                self.thing(&["food", "food", "tableware"], at, Some(long));
            } else {
                self.small(at, long);
            }
        }
        if self.chance(0.3) {
            let (from, to) = (on_top(self), on_top(self));
            self.cable(from + Vec3::Y * 0.01, to + Vec3::Y * 0.01, 0.004);
        }
        let pitch = if self.chance(0.35) { self.range(0.9, 1.5) } else { self.range(0.15, 1.0f32) };
        let target =
            Vec3::new(self.range(-0.2, 0.2) * size.x, high + self.range(0.0, 0.15), self.range(-0.2, 0.2) * size.z);
        let yaw = if self.chance(0.3) { self.turn() } else { self.rng.normal() * 0.5 };
        let wide = self.range(0.35, 1.3);
        let away = framing.distance(wide).clamp(0.25, 2.2);
        let eye = target + above(yaw, pitch) * away;
        let lamp_at = target + Vec3::new(self.range(-1.0, 1.0), self.range(0.6, 1.6), self.range(-1.0, 1.0));
        let camera = self.look(framing, eye, target);
        Shot { camera, lights: self.indoors(lamp_at), sky: black(), kind: "table" }
    }

    /// Shelves, cupboards or counters along a wall, seen from in front or along it.
    pub fn shelves(&mut self, framing: &Framing) -> Shot {
        let high = self.range(2.2, 3.2);
        let floor = self.cloth(&FLOOR, 1.0);
        self.panel(Vec3::new(-7.0, 0.0, 4.0), Vec3::X * 14.0, Vec3::Z * -4.0, &floor, [false, true]);
        let wall = self.cloth(&WALL, 1.2);
        self.panel(Vec3::new(-7.0, 0.0, 0.0), Vec3::X * 14.0, Vec3::Y * high, &wall, [false, false]);
        let ceiling = self.plain();
        self.panel(Vec3::new(-7.0, high, 4.0), Vec3::X * 14.0, Vec3::Z * -4.0, &ceiling, [false, false]);
        let wood = self.cloth(&["wood", "metal", "stone", "fabric"], 0.8);
        let (deep, wide) = (self.range(0.22, 0.6), self.range(1.2, 4.5));
        let boards = self.count(2, 6);
        let (low, thick) = (self.range(0.05, 0.9), self.range(0.012, 0.05));
        let books = if self.chance(0.25) { 0.9 } else { 0.3 };
        let step = ((high - 0.4 - low) / boards as f32).clamp(0.2, 0.6);
        for i in 0..=boards {
            let y = low + step * i as f32;
            self.block(Vec3::new(0.0, y, deep / 2.0), Vec3::new(wide, thick, deep), 0.0, &wood);
            let mut x = -wide / 2.0 + 0.02;
            while x < wide / 2.0 - 0.1 && i < boards {
                let room = self.range(0.1, 0.6).min(wide / 2.0 - x);
                let at = Vec3::new(x, y + thick, deep * self.range(0.4, 0.6));
                if self.chance(books) {
                    self.row_of_books(at, room, step * 0.85, deep * 0.7);
                } else if self.chance(0.8) {
                    let long = self.range(0.5, 0.9) * (step - thick).min(room).min(deep * 1.3);
                    self.small(at + Vec3::X * long / 2.0, long);
                }
                x += room;
            }
        }
        for side in [-1.0, 1.0] {
            let at = Vec3::new(side * wide / 2.0, low, deep / 2.0);
            self.block(at, Vec3::new(thick, step * boards as f32, deep), 0.0, &wood);
        }
        if self.chance(0.5) {
            // A counter before the wall, and what stands on it.
            let (top, body) = (self.cloth(&["stone", "wood", "metal"], 0.8), self.any_paint(0.6));
            let (h, d) = (self.range(0.7, 1.0), deep + self.range(0.1, 0.35));
            self.block(Vec3::new(0.0, 0.0, d / 2.0), Vec3::new(wide, h, d), 0.0, &body);
            self.block(Vec3::new(0.0, h, d / 2.0), Vec3::new(wide, 0.04, d + 0.05), 0.0, &top);
            for _ in 0..self.count(1, 6) {
                let at = Vec3::new(self.range(-0.45, 0.45) * wide, h + 0.04, d * self.range(0.6, 0.95));
                let long = self.range(0.08, 0.4);
                self.small(at, long);
            }
        }
        for _ in 0..self.count(0, 3) {
            let at = Vec3::new(self.range(-0.6, 0.6) * wide, 0.0, self.range(0.6, 1.6));
            self.thing(&STANDING, at, None);
        }
        let target = Vec3::new(self.range(-0.35, 0.35) * wide, self.range(low, low + step * boards as f32), deep / 2.0);
        let away = framing.distance(self.range(0.5, 1.1) * wide).clamp(0.5, 3.7);
        let yaw = self.range(-1.0, 1.0);
        let eye = Vec3::new(target.x + away * yaw.sin(), self.range(0.3, high - 0.2), 0.3 + deep + away * yaw.cos());
        let lamp_at = Vec3::new(self.range(-1.0, 1.0), high - 0.3, self.range(0.8, 2.0));
        let camera = self.look(framing, eye, target);
        Shot { camera, lights: self.indoors(lamp_at), sky: black(), kind: "shelves" }
    }

    /// Things before a plain wall or on a sweep of paper.
    pub fn product(&mut self, framing: &Framing) -> Shot {
        let paint = if self.chance(0.55) { self.plain() } else { self.any_paint(1.0) };
        let (back, bend) = (self.range(0.15, 1.6), self.range(0.02, 0.4));
        // Flat in front, then a bend, then upright.
        let sweep = sheet([1, 14], |s, t| {
            let along = t * 14.0 - 4.0;
            let angle = along.clamp(0.0, 8.0) / 8.0 * FRAC_PI_2;
            let flat = (-along).max(0.0) * 0.7;
            let upright = (along - 8.0).max(0.0) * 1.2;
            let z = flat - back + bend * (1.0 - angle.sin());
            let at = Vec3::new((s - 0.5) * 9.0, bend * (1.0 - angle.cos()) + upright, z);
            (at, glam::Vec2::new(s * 9.0, -t * 6.0))
        });
        self.put(&sweep, glam::Affine3A::IDENTITY, &paint);
        let big = self.range(0.12, 1.5);
        for i in 0..self.count(1, 5) {
            let at = if i == 0 {
                Vec3::new(self.range(-0.2, 0.2) * big, 0.0, 0.0)
            } else {
                Vec3::new(self.range(-1.2, 1.2) * big, 0.0, self.range(-0.5, 1.0) * big.min(back))
            };
            let long = big * self.range(0.4, 1.0);
            match self.rng.weighted(&[0.5, 0.25, 0.15, 0.1]) {
                0 => self.small(at, long),
                1 => self
                    .thing(&["toy", "animal", "tool", "tableware", "vehicle", "furniture"], at, Some(long))
                    .map_or((), |_| ()),
                2 => self.relief(at, long, 0.0).map_or((), |_| ()),
                _ => self.plant(at, long),
            }
        }
        let pitch = self.range(-0.05, 0.7f32);
        let yaw = self.rng.normal() * 0.4;
        let away = framing.distance(big * self.range(1.0, 2.0)).clamp(0.3, 6.0);
        let target = Vec3::new(0.0, big * self.range(0.2, 0.5), 0.0);
        let eye = target + above(yaw, pitch) * away;
        let lamp_at = eye + Vec3::new(self.range(-1.0, 1.0), self.range(0.2, 1.0), 0.0) * big;
        let camera = self.look(framing, eye.max(Vec3::new(f32::MIN, 0.05, f32::MIN)), target);
        Shot { camera, lights: self.indoors(lamp_at), sky: black(), kind: "product" }
    }

    /// Stairs between walls, seen from below or from above.
    pub fn stairs(&mut self, framing: &Framing) -> Shot {
        let (wide, rise, run) = (self.range(0.9, 3.0), self.range(0.14, 0.2), self.range(0.24, 0.34));
        let steps = self.count(5, 16);
        let (tread, wall) = (self.any_paint(0.8), self.cloth(&WALL, 1.2));
        let open = self.chance(0.4);
        let top = rise * steps as f32;
        for i in 0..steps {
            let (h, from) = (rise * (i + 1) as f32, if open { rise * i as f32 + 0.1 } else { 0.0 });
            let at = Vec3::new(0.0, from, -1.5 - run * (i as f32 + 0.5));
            self.block(at, Vec3::new(wide, h - from, run), 0.0, &tread);
        }
        let end = -1.5 - run * steps as f32;
        let floor = self.cloth(&FLOOR, 1.0);
        let (room, high) = (wide / 2.0 + self.range(0.0, 1.5), top + self.range(2.2, 3.2));
        let plain = [false, false];
        self.panel(Vec3::new(-room, 0.0, 3.5), Vec3::X * 2.0 * room, Vec3::Z * (end - 3.5 - 3.0), &floor, plain);
        self.panel(Vec3::new(-room, top, end), Vec3::X * 2.0 * room, Vec3::Z * -3.0, &floor, plain);
        self.panel(Vec3::new(-room, 0.0, 3.5), Vec3::Z * (end - 6.5), Vec3::Y * high, &wall, plain);
        self.panel(Vec3::new(room, 0.0, end - 3.0), Vec3::Z * (6.5 - end), Vec3::Y * high, &wall, plain);
        self.panel(Vec3::new(-room, 0.0, end - 3.0), Vec3::X * 2.0 * room, Vec3::Y * high, &wall, plain);
        self.panel(Vec3::new(-room, 0.0, 3.5), Vec3::X * 2.0 * room, Vec3::Y * high, &wall, plain);
        let ceiling = self.plain();
        self.panel(Vec3::new(-room, high, 3.5), Vec3::X * 2.0 * room, Vec3::Z * (end - 6.5), &ceiling, plain);
        for side in [-1.0, 1.0] {
            if self.chance(0.6) {
                let foot = Vec3::new(side * (wide / 2.0 - 0.03), 0.0, -1.5);
                self.railing(foot, Vec3::new(0.0, top, end + 1.5), 0.9);
            }
        }
        for _ in 0..self.count(0, 4) {
            let i = self.rng.below(steps) as f32;
            let at = Vec3::new(self.range(-0.4, 0.4) * wide, rise * (i + 1.0), -1.5 - run * (i + 0.5));
            if self.chance(0.5) { self.small(at, 0.3) } else { self.someone(at, Vec3::new(0.0, 1.5, 2.0)) }
        }
        let down = self.chance(0.45);
        let (eye, target) = if down {
            (
                Vec3::new(self.range(-0.3, 0.3) * wide, top + self.range(0.8, 1.8), end - self.range(0.0, 1.0)),
                Vec3::new(0.0, 0.0, -0.5),
            )
        } else {
            let target = Vec3::new(0.0, top * self.range(0.3, 1.2), end);
            (Vec3::new(self.range(-0.4, 0.4) * wide, self.range(0.3, 1.8), self.range(-1.0, 2.5)), target)
        };
        let lamp_at = Vec3::new(0.0, high - 0.4, end / 2.0);
        let camera = self.look(framing, eye, target);
        Shot { camera, lights: self.indoors(lamp_at), sky: black(), kind: "stairs" }
    }

    /// Posts with a rail along a way that may rise.
    fn railing(&mut self, foot: Vec3, along: Vec3, tall: f32) {
        let (paint, thin, gap) = (self.plain(), self.range(0.008, 0.02), self.range(0.1, 0.6));
        let count = (along.length() / gap) as usize;
        let posts = (0..=count).map(|i| {
            let at = foot + along * (i as f32 / count.max(1) as f32);
            super::shapes::tube(&[at, at + Vec3::Y * tall], [thin; 2], 4)
        });
        let rail = super::shapes::tube(&[foot + Vec3::Y * tall, foot + along + Vec3::Y * tall], [thin * 2.0; 2], 5);
        let all = super::shapes::together(posts.chain([rail]).collect::<Vec<_>>());
        self.put(&all, glam::Affine3A::IDENTITY, &paint);
    }

    /// A close-up: a plant or thing that fills the picture, and the rest of the world behind it.
    pub fn close_up(&mut self, framing: &Framing) -> Shot {
        let big = self.range(0.06, 0.35);
        let outside = self.chance(0.5);
        let ground =
            self.cloth(if outside { &["grass", "ground", "stone"] } else { &["wood", "fabric", "stone"] }, 0.5);
        self.panel(Vec3::new(-8.0, 0.0, 4.0), Vec3::X * 16.0, Vec3::Z * -20.0, &ground, [false, true]);
        let behind = -self.range(0.2, 6.0);
        if self.chance(0.7) {
            let wall = if self.chance(0.4) { self.photo().0 } else { self.cloth(&WALL, 1.0) };
            let wall = super::mesh::Paint { metres: glam::Vec2::splat(self.range(1.0, 6.0)), ..wall };
            self.panel(Vec3::new(-8.0, 0.0, behind), Vec3::X * 16.0, Vec3::Y * 6.0, &wall, [false, false]);
        }
        for i in 0..self.count(2, 9) {
            let z = if i == 0 { 0.0 } else { self.range(behind.max(-2.0), 0.3 * big) };
            let at = Vec3::new(self.range(-1.0, 1.0) * (big + z.abs()) * if i == 0 { 0.2 } else { 1.0 }, 0.0, z);
            let long = (big + 0.3 * z.abs()) * self.range(0.6, 1.4);
            match self.rng.weighted(if outside { &[0.5, 0.2, 0.3] } else { &[0.2, 0.7, 0.1] }) {
                0 => self.plant(at, long),
                1 => self.small(at, long),
                _ => self.grass(at, long, long, 40),
            }
        }
        let pitch = self.range(-0.3, 0.8f32);
        let yaw = self.range(-PI, PI) * 0.15;
        let away = framing.distance(big * self.range(0.8, 1.6)).clamp(0.1, 1.2);
        let target = Vec3::new(0.0, big * self.range(0.4, 0.9), 0.0);
        let eye = target + above(yaw, pitch) * away;
        let camera = self.look(framing, eye.max(Vec3::new(f32::MIN, 0.02, f32::MIN)), target);
        let lights = if outside { self.day() } else { self.indoors(target + Vec3::new(0.3, 0.8, 0.4)) };
        Shot { camera, lights, sky: self.sky(), kind: "close-up" }
    }
}
