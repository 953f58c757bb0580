//! Something small and near, and the wide world far behind it: on a ledge, or hanging from a bough.

use glam::{Affine3A, Vec3};

use super::set::Set;
use super::shapes::{any_way, round_leaves, stem, tube};
use super::shot::{Framing, Shot};

/// The kinds of scenes that have nothing between near and far.
pub const LEDGE: &str = "ledge";
pub const HANGING: &str = "hanging";

impl Set<'_> {
    /// Wide land, a street, a front or a garden, to stand behind something.
    fn far_world(&mut self, framing: &Framing) -> Shot {
        let shot = match self.rng.weighted(&[0.3, 0.2, 0.15, 0.35]) {
            0 => self.landscape(framing),
            1 => self.street(framing),
            2 => self.facade(framing),
            _ => self.garden(framing),
        };
        let sky = if self.chance(0.5) { self.clouds() } else { shot.sky };
        Shot { sky, ..shot }
    }

    /// Things on a wall, a rail or a table's edge: it ends behind them, and what follows is far away.
    pub fn ledge(&mut self, framing: &Framing) -> Shot {
        let world = self.far_world(framing);
        let eye = world.camera.eye;
        let into = world.camera.axes[2].with_y(0.0).normalize_or(-Vec3::Z);
        let yaw = (-into.x).atan2(-into.z);
        let away = self.rng.log_range(0.25, 1.5);
        let pitch = self.range(-0.05, 0.5f32);
        let target = eye + away * (into * pitch.cos() - Vec3::Y * pitch.sin());
        let tall = away * self.range(0.15, 0.6);
        let foot = target - Vec3::Y * tall * self.range(0.2, 1.1);
        let (behind, before) = (away * self.range(0.04, 0.5), away * self.range(0.05, 0.7));
        let thick = if self.chance(0.6) { 3.0 } else { self.range(0.03, 0.15) } * away;
        let paint = if self.chance(0.7) {
            self.cloth(&["stone", "wall", "wood", "ground"], 0.6 * away)
        } else {
            self.any_paint(away)
        };
        let middle = foot + into * (behind - before) / 2.0 - Vec3::Y * thick;
        let slant = yaw + self.rng.normal() * 0.15;
        self.block(middle, Vec3::new(16.0 * away, thick, behind + before), slant, &paint);
        let right = world.camera.axes[0].with_y(0.0).normalize_or(Vec3::X);
        for i in 0..self.rng.weighted(&[0.1, 0.5, 0.25, 0.15]) {
            let aside = if i == 0 { 0.12 } else { 0.7 } * away;
            let at = foot + right * self.range(-aside, aside);
            let long = tall * if i == 0 { 1.0 } else { self.range(0.3, 1.0) };
            self.on_ledge(at, long, yaw);
        }
        let camera = self.look(framing, eye, target);
        Shot { camera, kind: LEDGE, ..world }
    }

    fn on_ledge(&mut self, at: Vec3, tall: f32, yaw: f32) {
        let turned = yaw + self.rng.normal() * 0.5;
        match self.rng.weighted(&[0.3, 0.25, 0.2, 0.1, 0.15]) {
            0 => self.small(at, tall),
            1 => self.turned(&["toy", "animal", "other", "vehicle"], at, Some(tall), turned).map_or((), |_| ()),
            2 => self.relief(at, tall, turned).map_or((), |_| ()),
            3 => self.coated(at, tall, turned),
            _ => self.plant(at, tall),
        }
    }

    /// A bough with leaves, and mostly blossoms, that comes into the picture from above or from a side.
    pub fn hanging(&mut self, framing: &Framing) -> Shot {
        let world = self.far_world(framing);
        let camera = &world.camera;
        let away = self.rng.log_range(0.15, 1.0);
        let half = framing.half(away);
        let [right, down, into] = camera.axes;
        let at = |x: f32, y: f32, z: f32| camera.eye + into * (away * z) + right * (x * half[0]) + down * (y * half[1]);
        let (kind, wood, green) = (self.flower(), self.leaf_paint(), self.leaf_paint());
        for _ in 0..self.count(1, 3) {
            let side = if self.chance(0.5) { -1.25 } else { 1.25 };
            let [x, y] = if self.chance(0.5) { [side, self.range(-1.2, 0.4)] } else { [self.range(-1.0, 1.0), -1.25] };
            let from = at(x, y, self.range(0.8, 1.4));
            let way = at(self.range(-0.5, 0.5), self.range(-0.6, 0.6), self.range(0.8, 1.2)) - from;
            let points = stem(&mut self.rng, from, way, way.length(), 0.5, 6);
            let thick = away * self.range(0.004, 0.03);
            self.put(&tube(&points, [thick, thick * 0.4], 5), Affine3A::IDENTITY, &wood);
            let (long, slim) = (half[0] * self.range(0.15, 0.7), self.range(0.2, 0.6));
            let rng = &mut self.rng;
            let leaf = round_leaves(rng.below(14), |i| {
                let way = (any_way(rng) + 0.4 * down) * long * rng.range(0.5, 1.2);
                (points[i % points.len()], way, long * slim)
            });
            self.put(&leaf, Affine3A::IDENTITY, &green);
            for _ in 0..self.rng.weighted(&[0.3, 0.35, 0.2, 0.15]) {
                let wide = half[0] * self.range(0.2, 0.8);
                let head = points[1 + self.rng.below(points.len() - 1)] + down * wide * self.range(0.0, 0.4);
                let facing = down * self.range(-0.3, 1.0) - into * self.range(0.0, 1.0) + 0.4 * any_way(&mut self.rng);
                self.head(&kind, head, wide, facing.normalize_or(down), [6, 7]);
            }
        }
        Shot { kind: HANGING, ..world }
    }
}
