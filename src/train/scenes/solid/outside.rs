//! Scenes without a ceiling: streets, facades, gardens and woods; and what stands before any scene.

use std::f32::consts::FRAC_PI_2;

use glam::{Affine3A, Vec2, Vec3};

use super::mesh::Paint;
use super::set::{Set, stand};
use super::shapes::{cuboid, round_leaves, sheet, stem, together, tube};
use super::shot::{Framing, Shot};
use super::view::Camera;

const GROUND: [&str; 4] = ["ground", "grass", "stone", "floor"];

impl Set<'_> {
    fn plain_ground(&mut self, kinds: &[&str]) {
        let paint = self.cloth(kinds, 2.0);
        self.panel(Vec3::new(-60.0, 0.0, 40.0), Vec3::X * 120.0, Vec3::Z * -140.0, &paint, [false, true]);
    }

    /// A house front along x at z = 0 with windows and doors set into it or standing out.
    pub(super) fn front(&mut self, at: Vec3, wide: f32, high: f32, yaw: f32) {
        let place = stand(at, yaw, 1.0);
        let wall = self.cloth(&["wall", "stone", "wall", "wood"], 2.5);
        let deep = self.range(3.0, 9.0);
        self.put(
            &cuboid(Vec3::new(wide, high, deep)),
            place * Affine3A::from_translation(Vec3::Z * -deep / 2.0),
            &wall,
        );
        let (floors, across) = ((high / self.range(2.6, 3.6)).max(1.0), (wide / self.range(1.4, 3.2)).max(1.0));
        let (glass, frame) = (self.any_paint(1.0), self.plain());
        let (w, h) = (self.range(0.35, 0.75), self.range(0.4, 0.75));
        let out = self.range(0.02, 0.2);
        let balcony = self.chance(0.25);
        let cell = Vec3::new(wide / across.floor(), high / floors.floor(), 0.0);
        for floor in 0..floors as usize {
            for column in 0..across as usize {
                let x = -wide / 2.0 + cell.x * (column as f32 + 0.5);
                let y = cell.y * (floor as f32 + 0.5 - h / 2.0);
                let (ww, hh) = (cell.x * w, cell.y * h);
                let corner = place * Affine3A::from_translation(Vec3::new(x - ww / 2.0, y, 0.02));
                let pane = Paint { metres: Vec2::new(ww, hh), gloss: 0.6, ..glass.clone() };
                let (origin, along, up) =
                    (corner.transform_point3(Vec3::ZERO), place.transform_vector3(Vec3::X * ww), Vec3::Y * hh);
                self.panel(origin, along, up, &pane, [true, false]);
                let sill = place * Affine3A::from_translation(Vec3::new(x, y - 0.1, out / 2.0));
                self.put(&cuboid(Vec3::new(ww * 1.15, 0.1, out)), sill, &frame);
                if balcony && floor > 0 {
                    let plate = place * Affine3A::from_translation(Vec3::new(x, y - 0.25, 0.5));
                    self.put(&cuboid(Vec3::new(cell.x * 0.9, 0.12, 1.0)), plate, &frame);
                    let rail = place.transform_point3(Vec3::new(x - cell.x * 0.45, y - 0.13, 1.0));
                    self.fence(rail, place.transform_vector3(Vec3::X * cell.x * 0.9), 0.9);
                }
            }
        }
        if self.chance(0.5) {
            let roof = self.cloth(&["roof", "stone"], 2.0);
            let rise = self.range(0.5, 3.0);
            let slope = sheet([1, 2], |s, t| {
                let at = Vec3::new(
                    (s - 0.5) * (wide + 0.6),
                    high + rise * (1.0 - (2.0 * t - 1.0).abs()),
                    0.3 - t * (deep + 0.6),
                );
                (at, Vec2::new(s * wide, t * deep))
            });
            self.put(&slope, place, &roof);
        }
    }

    /// A street: fronts on both sides or one, poles with wires, cars, people, trees.
    pub fn street(&mut self, framing: &Framing) -> Shot {
        self.plain_ground(&["floor", "ground", "stone"]);
        let half = self.range(2.5, 9.0);
        let kerb = self.cloth(&["stone", "floor"], 1.0);
        for side in [-1.0, 1.0] {
            let (walk, height) = (self.range(1.0, 3.0), self.range(0.05, 0.2));
            self.block(Vec3::new(side * (half - walk / 2.0), 0.0, -25.0), Vec3::new(walk, height, 80.0), 0.0, &kerb);
            let mut z = 6.0;
            while z > -50.0 && self.chance(0.95) {
                let (wide, high, gap) = (self.range(4.0, 14.0), self.range(3.0, 16.0), self.range(0.0, 2.0));
                let at = Vec3::new(side * half, 0.0, z - wide / 2.0);
                if self.chance(0.25) {
                    self.turned(&["building"], at + Vec3::X * side * 3.0, None, -side * FRAC_PI_2);
                } else if self.chance(0.9) {
                    self.front(at, wide, high, -side * FRAC_PI_2);
                }
                z -= wide + gap;
            }
            let (every, tall) = (self.range(5.0, 14.0), self.range(3.5, 8.0));
            let (pole, x) = (self.plain(), side * (half - 0.5));
            let wires = self.chance(0.5);
            for i in 0..self.count(0, 5) {
                let foot = Vec3::new(x, 0.0, 2.0 - i as f32 * every);
                self.put(&tube(&[foot, foot + Vec3::Y * tall], [0.07, 0.05], 6), Affine3A::IDENTITY, &pole);
                if wires {
                    self.cable(foot + Vec3::Y * tall, foot + Vec3::new(0.0, tall, -every), 0.015);
                }
            }
        }
        if self.chance(0.45) {
            // The street ends at a front.
            let (z, wide, high) = (-self.range(8.0, 45.0), 2.0 * half + 8.0, self.range(4.0, 18.0));
            self.front(Vec3::new(0.0, 0.0, z), wide, high, 0.0);
        }
        let eye_y = if self.chance(0.8) { self.range(0.3, 2.2) } else { self.range(2.5, 12.0) };
        let eye = Vec3::new(self.range(-0.8, 0.8) * half, eye_y, self.range(0.0, 3.0));
        self.passers_by(half, eye);
        let target = Vec3::new(self.range(-1.4, 1.4) * half, self.range(-1.0, 6.5), -self.range(4.0, 20.0));
        let camera = self.look(framing, eye, target);
        Shot { camera, lights: self.day(), sky: self.sky(), kind: "street" }
    }

    fn passers_by(&mut self, half: f32, eye: Vec3) {
        for _ in 0..self.count(0, 5) {
            let at = Vec3::new(self.range(-0.8, 0.8) * half, 0.0, -self.range(2.0, 28.0));
            self.turned(&["vehicle"], at, None, 0.0);
        }
        for _ in 0..self.count(0, 6) {
            let at = Vec3::new(self.range(-0.9, 0.9) * half, 0.0, -self.range(0.5, 16.0));
            self.someone(at, eye);
        }
        for _ in 0..self.count(0, 4) {
            let (at, tall) =
                (Vec3::new(self.range(-1.0, 1.0) * half, 0.0, -self.range(1.5, 25.0)), self.range(2.5, 8.0));
            if self.chance(0.5) {
                self.tree(at, tall)
            } else {
                self.thing(&["tree", "other", "plant"], at, None).map_or((), |_| ())
            }
        }
    }

    /// A house front before the camera, square or slanting, and what stands before it.
    pub fn facade(&mut self, framing: &Framing) -> Shot {
        self.plain_ground(&GROUND);
        let (wide, high) = (self.range(7.0, 26.0), self.range(4.0, 24.0));
        let yaw = self.range(-0.6, 0.6);
        self.front(Vec3::ZERO, wide, high, yaw);
        if self.chance(0.5) {
            let (next, tall, way) =
                (self.range(5.0, 12.0), self.range(4.0, 18.0), if self.chance(0.5) { 1.0 } else { -1.0 });
            let beside = Vec3::new(way * yaw.cos(), 0.0, -way * yaw.sin()) * (wide + next) / 2.0;
            let at = beside + Vec3::Z * self.range(-3.0, 1.0);
            self.front(at, next, tall, yaw);
        }
        let target = Vec3::new(self.range(-0.3, 0.3) * wide, high * self.range(0.1, 0.8), 0.0);
        let away = framing.distance(wide * self.range(0.3, 1.0)).clamp(2.5, 30.0);
        let eye = Vec3::new(self.range(-0.4, 0.4) * wide, self.range(0.4, 2.2), away);
        for _ in 0..self.count(0, 7) {
            let z = self.range(0.1, 0.9) * away;
            let at = Vec3::new(self.range(-0.4, 0.4) * wide, 0.0, z);
            match self.rng.weighted(&[0.35, 0.25, 0.15, 0.15, 0.1]) {
                0 => self.someone(at, eye),
                1 => self.thing(&["plant", "other", "furniture", "vehicle"], at, None).map_or((), |_| ()),
                2 => {
                    let tall = self.range(1.5, 7.0);
                    self.tree(at, tall);
                }
                3 => {
                    let (long, tall) = (self.range(2.0, 10.0), self.range(0.6, 1.8));
                    self.fence(at, Vec3::X * long, tall);
                }
                _ => {
                    let tall = self.range(0.4, 1.5);
                    self.plant(at, tall);
                }
            }
        }
        if self.chance(0.3) {
            let y = self.range(2.5, 6.0);
            self.cable(Vec3::new(-wide, y, away * 0.5), Vec3::new(wide, y + 1.0, away * 0.3), 0.012);
        }
        let camera = self.look(framing, eye, target);
        Shot { camera, lights: self.day(), sky: self.sky(), kind: "facade" }
    }

    /// Hilly ground: its height at a place.
    fn hills(&mut self) -> impl Fn(f32, f32) -> f32 + use<> {
        let height = if self.chance(0.5) { self.range(0.1, 2.5) } else { 0.05 };
        let waves = self.waves(4.0, 20.0);
        let rise = if self.chance(0.4) { self.range(-0.15, 0.4) } else { 0.0 };
        move |x, z| height * waves(x, z) - rise * z.min(0.0)
    }

    /// A wave along x and one along z, −2 … 2 in all, whose lengths over 2π lie between two.
    pub(super) fn waves(&mut self, shortest: f32, longest: f32) -> impl Fn(f32, f32) -> f32 + use<> {
        let phase = [self.turn(), self.turn()];
        let long = [self.range(shortest, longest), self.range(shortest, longest)];
        move |x, z| (x / long[0] + phase[0]).sin() + (z / long[1] + phase[1]).sin()
    }

    /// A hedge or wall across the view.
    pub(super) fn hedge(&mut self, at: Vec3, wide: f32, tall: f32) {
        let paint = self.cloth(&["grass", "stone", "wall", "wood"], 0.8);
        self.block(at, Vec3::new(wide, tall, 0.5), 0.0, &paint);
    }

    /// A garden or a wood: plants near and far, boughs overhead, benches, fences, people and animals.
    pub fn garden(&mut self, framing: &Framing) -> Shot {
        let wood = self.chance(0.45);
        let height = self.hills();
        let paint = self.cloth(&["grass", "ground", "ground", "stone"], 1.5);
        let land = sheet([24, 24], |s, t| {
            // Finer near the camera.
            let (x, z) = ((2.0 * s - 1.0).powi(3) * 50.0, 6.0 - 76.0 * t * t);
            (Vec3::new(x, height(x, z), z), Vec2::new(x, z))
        });
        self.put(&land, Affine3A::IDENTITY, &paint);
        let on = |x: f32, z: f32| Vec3::new(x, height(x, z), z);
        let eye = on(0.0, 0.0) + Vec3::Y * if self.chance(0.8) { self.range(0.15, 2.0) } else { self.range(2.0, 7.0) };
        for _ in 0..self.count(3, if wood { 16 } else { 8 }) {
            let far = 1.5 + 28.0 * self.range(0.0, 1.0).powi(2);
            let at = on(self.range(-0.8, 0.8) * far, -far);
            let tall = self.range(2.0, 9.0);
            match self.rng.weighted(if wood { &[0.6, 0.35, 0.05] } else { &[0.2, 0.4, 0.4] }) {
                0 => self.tree(at, tall),
                1 => self.thing(&["tree"], at, None).map_or((), |_| ()),
                _ => self.thing(&["plant"], at, None).map_or((), |_| ()),
            }
        }
        for _ in 0..self.count(2, 9) {
            let far = 0.4 + 7.0 * self.range(0.0, 1.0).powi(2);
            let at = on(self.range(-0.7, 0.7) * far, -far);
            let tall = self.range(0.2, 1.4);
            match self.rng.weighted(&[0.4, 0.3, 0.3]) {
                0 => self.plant(at, tall),
                1 => self.grass(at, 0.8, 0.4 * tall, 70),
                _ => self.thing(&["other", "plant", "furniture", "animal"], at, None).map_or((), |_| ()),
            }
        }
        for _ in 0..self.rng.weighted(&[0.4, 0.4, 0.2]) {
            let far = self.range(1.2, 9.0);
            let at = on(self.range(-0.5, 0.5) * far, -far);
            self.someone(at, eye);
        }
        if self.chance(0.35) {
            let z = -self.range(1.5, 14.0);
            let (from, tall) = (on(-9.0, z), self.range(0.5, 2.2));
            if self.chance(0.5) {
                self.fence(from, Vec3::X * 18.0, tall);
            } else {
                self.hedge(on(0.0, z), 24.0, tall);
            }
        }
        if self.chance(0.3) {
            let (z, wide, high) = (-self.range(8.0, 30.0), self.range(6.0, 15.0), self.range(3.0, 9.0));
            let (at, yaw) = (on(self.range(-8.0, 8.0), z), self.range(-0.7, 0.7));
            self.front(at, wide, high, yaw);
        }
        let up = if wood { self.range(-0.5, 0.8) } else { self.range(-0.6, 0.4) };
        let far = self.range(3.0, 10.0);
        let target = eye + Vec3::new(self.range(-0.4, 0.4) * far, up * far, -far);
        let camera = self.look(framing, eye, target);
        Shot { camera, lights: self.day(), sky: self.sky(), kind: if wood { "wood" } else { "garden" } }
    }

    /// Something before the whole scene: a window's frame, bars, a fence, boughs, a wire, someone's shoulder. `free` is
    /// how far away the nearest things of the scene are.
    pub fn before(&mut self, camera: &Camera, framing: &Framing, free: f32) {
        let away = (free * self.range(0.25, 0.7)).max(0.08);
        let [right, down, into] = camera.axes;
        let half = framing.half(away);
        let at = |x: f32, y: f32| camera.eye + into * away + right * (x * half[0]) + down * (y * half[1]);
        let thin = away * self.range(0.004, 0.05);
        let paint = if self.chance(0.5) { self.plain() } else { self.any_paint(0.4) };
        let mut pieces = Vec::new();
        match self.rng.weighted(&[0.3, 0.2, 0.3, 0.2]) {
            0 => {
                // A window: a frame, perhaps a cross.
                let (edge, bar) = (self.range(0.75, 0.98), thin * 3.0);
                for (a, b) in [
                    ((-edge, -1.2), (-edge, 1.2)),
                    ((edge, -1.2), (edge, 1.2)),
                    ((-1.2, -edge), (1.2, -edge)),
                    ((-1.2, edge), (1.2, edge)),
                ] {
                    if self.chance(0.75) {
                        pieces.push(tube(&[at(a.0, a.1), at(b.0, b.1)], [bar; 2], 4));
                    }
                }
                for _ in 0..self.count(0, 2) {
                    let x = self.range(-0.5, 0.5);
                    pieces.push(tube(&[at(x, -1.2), at(x, 1.2)], [thin; 2], 4));
                }
            }
            1 => {
                // Bars or wires across the view.
                let (step, lean) = (self.range(0.12, 0.6), self.range(-0.2, 0.2));
                let upright = self.chance(0.6);
                let first = self.range(-1.3, -0.8);
                for i in 0..(2.5 / step) as usize {
                    let s = first + step * i as f32;
                    let ends =
                        if upright { [at(s, -1.3), at(s + lean, 1.3)] } else { [at(-1.3, s), at(1.3, s + lean)] };
                    pieces.push(tube(&ends, [thin * 0.5; 2], 4));
                }
            }
            2 => {
                // A bough that hangs or stands into the picture.
                let side = if self.chance(0.5) { -1.2 } else { 1.2 };
                let from =
                    if self.chance(0.6) { at(side, self.range(-1.2, 0.5)) } else { at(self.range(-1.0, 1.0), -1.2) };
                let way = at(self.range(-0.3, 0.3), self.range(-0.6, 0.3)) - from;
                let points = stem(&mut self.rng, from, way, way.length(), 0.6, 6);
                pieces.push(tube(&points, [thin, thin * 0.4], 5));
                let (long, green) = (away * self.range(0.06, 0.2), self.leaf_paint());
                let rng = &mut self.rng;
                let leaf = round_leaves(points.len() * 6, |i| {
                    let way = super::shapes::any_way(rng) * long;
                    (points[i % points.len()], way, long * 0.45)
                });
                self.put(&leaf, Affine3A::IDENTITY, &green);
            }
            _ => {
                // Somebody or something large at the picture's edge.
                let x = if self.chance(0.5) { -0.85 } else { 0.85 };
                let foot = at(x, 1.4);
                let yaw = (-into.x).atan2(-into.z);
                let tall = half[1] * self.range(1.2, 2.2);
                self.relief(foot, tall, yaw);
                return;
            }
        }
        self.put(&together(pieces), Affine3A::IDENTITY, &paint);
    }
}
