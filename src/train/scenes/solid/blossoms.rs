//! Beds of flowers seen from near: blossoms of curved petals on stems, leaves about and behind them.

use std::f32::consts::TAU;
use std::sync::Arc;

use glam::{Affine3A, Quat, Vec2, Vec3};

use super::mesh::{Mesh, Paint};
use super::set::Set;
use super::shapes::{any_way, lathe, leaves, round_leaves, sheet, stem, together, tube};
use super::shot::{Framing, Shot, Sky, above};
use super::texture::Texture;
use crate::rng::Rng;
use crate::scenes::raster::Raster;

/// One kind of flower; lengths are shares of the blossom's width.
pub(super) struct Kind {
    petals: usize,
    rings: usize,
    /// Width of a petal; the larger the second, the further out it is widest.
    petal: [f32; 2],
    /// How far petals rise at their foot and at their tip, radians.
    rise: [f32; 2],
    /// Radius and height of the middle.
    middle: [f32; 2],
    stamens: usize,
    /// Bells about the end of a stem, and the height that they take; none where petals stand about a middle.
    bells: Option<(usize, f32)>,
    paint: Paint,
    heart: Paint,
    green: Paint,
}

impl Kind {
    /// Petals about the origin, upwards, one wide.
    fn petals(&self, cells: [usize; 2], jitter: &mut impl FnMut() -> f32) -> Mesh {
        let mut pieces = Vec::new();
        for ring in 0..self.rings {
            let (long, lift) = (0.5 * 0.8f32.powi(ring as i32), 0.25 * ring as f32);
            for i in 0..self.petals {
                let turn = TAU * (i as f32 + 0.5 * ring as f32 + 0.2 * jitter()) / self.petals as f32;
                let (long, lift) = (long * (1.0 + 0.12 * jitter()), lift + 0.12 * jitter());
                pieces.push(self.petal(cells, turn, long, lift));
            }
        }
        together(pieces)
    }

    fn petal(&self, cells: [usize; 2], turn: f32, long: f32, lift: f32) -> Mesh {
        let (way, side) = (Quat::from_rotation_y(turn) * Vec3::X, Quat::from_rotation_y(turn) * Vec3::Z);
        let [wide, out] = self.petal;
        // Narrow at the foot, round at the tip.
        let outline = |t: f32| (t.powf(out / (1.0 - out)) * (1.0 - t.powi(4))).sqrt().max(0.06);
        sheet(cells, |s, t| {
            let rise = self.rise[0] + (self.rise[1] - self.rise[0]) * t + lift;
            let across = (s - 0.5) * wide * outline(t);
            let cup = 1.2 * across * across / wide.max(0.05);
            let place = way * (t * long * rise.cos()) + side * across + Vec3::Y * (t * long * rise.sin() + cup);
            (place, Vec2::new(0.05 + 0.9 * s, 0.97 - 0.94 * t))
        })
    }
}

/// Bells about the y axis, smaller and closer to it towards its upper end: hyacinths, lupins, lavender.
fn spike((count, long): (usize, f32), sides: usize, rng: &mut Rng) -> Mesh {
    let taper = rng.range(0.3, 0.8);
    let (out, size, sink) = (rng.range(0.08, 0.2), rng.range(0.12, 0.22), rng.range(-0.8, 0.5));
    together((0..count).map(|i| {
        let share = i as f32 / count as f32;
        // Turned by the golden angle, bells fill the spike evenly.
        let (sin, cos) = (2.4 * i as f32 + rng.range(-0.3, 0.3)).sin_cos();
        let (slim, along) = (1.0 - taper * share, Vec3::new(cos, sink, sin).normalize());
        let foot = Vec3::new(out * slim * cos, long * (share - 0.6), out * slim * sin);
        let (side, up) = along.any_orthonormal_pair();
        sheet([sides.max(4), 3], |s, t| {
            let (sin, cos) = (TAU * s).sin_cos();
            let thick = size * slim * (0.1 + 0.45 * (TAU * 0.45 * t).sin());
            (foot + along * (t * size * slim) + (side * cos + up * sin) * thick, Vec2::new(0.9 * s, 0.9 - 0.8 * t))
        })
    }))
}

impl Set<'_> {
    /// Flowers, one or a few near, from beside to right above, before leaves, earth or the open.
    pub fn bed(&mut self, framing: &Framing) -> Shot {
        let kind = self.flower();
        let big = self.range(0.025, 0.12);
        let ground = self.cloth(&["grass", "ground", "ground", "stone"], 0.6);
        self.panel(Vec3::new(-12.0, 0.0, 4.0), Vec3::X * 24.0, Vec3::Z * -30.0, &ground, [false, true]);
        let tall = big * self.range(1.5, 7.0);
        let pitch = if self.chance(0.35) { self.range(0.7, 1.45) } else { self.range(-0.15, 0.7f32) };
        let yaw = self.rng.normal() * 0.3;
        let back = above(yaw, pitch);
        for i in 0..self.rng.weighted(&[0.0, 0.45, 0.2, 0.15, 0.1, 0.1]) {
            let away = if i == 0 { 0.2 } else { 1.2 } * big;
            let foot = Vec3::new(self.range(-away, away), 0.0, if i == 0 { 0.0 } else { self.range(-2.0, 0.4) * big });
            let towards = if self.chance(0.7) { back } else { Vec3::Y };
            let high = tall * if i == 0 { 1.0 } else { self.range(0.7, 1.1) };
            self.blossom(&kind, foot, high, big, towards, [6, 7]);
        }
        for _ in 0..self.count(0, 22) {
            let z = -big * (1.5 + 14.0 * self.range(0.0, 1.0).powi(2));
            let foot = Vec3::new(self.range(-1.0, 1.0) * (big + z.abs()), 0.0, z);
            let high = tall * self.range(0.5, 1.15);
            self.blossom(&kind, foot, high, big, Vec3::Y, [2, 3]);
        }
        self.foliage(big, tall);
        let target = Vec3::new(0.0, tall * self.range(0.85, 1.05), 0.0);
        let away = framing.distance(big * self.range(1.0, 3.5)).clamp(0.06, 1.2);
        let eye = (target + back * away).max(Vec3::new(f32::MIN, 0.015, f32::MIN));
        let camera = self.look(framing, eye, target);
        let sky = if self.chance(0.5) { self.clouds() } else { Sky::Fade(Vec3::splat(0.4), Vec3::splat(0.15)) };
        Shot { camera, lights: self.day(), sky, kind: "flowers" }
    }

    /// A kind of flower.
    pub(super) fn flower(&mut self) -> Kind {
        let double = self.chance(0.25);
        let petals = if self.chance(0.3) { self.count(9, 20) } else { self.count(4, 8) };
        let rings = if double { self.count(2, 5) } else { 1 };
        let wide = 3.0 / petals as f32 * self.range(0.5, 1.2);
        // Daisies and sunflowers are as good as flat, their middle is a disc.
        let flat = self.chance(0.35);
        let open = if flat { self.range(-0.2, 0.2) } else { self.range(-0.3, 0.9) };
        let bend = if flat { self.range(-0.2, 0.3) } else { self.range(-0.6, 0.5) };
        let skin = Some(self.petal_skin());
        let (middle, high) = if flat {
            (self.range(0.08, 0.3), self.range(0.05, 0.35))
        } else {
            (self.range(0.03, 0.2), self.range(0.3, 1.2))
        };
        let bells = self.chance(0.2).then(|| (self.count(20, 60), self.range(0.8, 2.5)));
        Kind {
            petals,
            rings,
            petal: [wide.min(0.7), self.range(0.35, 0.75)],
            rise: [open + if flat { 0.0 } else { self.range(0.0, 0.5) }, open + bend],
            middle: [middle, middle * high],
            stamens: if !flat && self.chance(0.4) { self.count(3, 14) } else { 0 },
            bells,
            paint: Paint { tint: [1.0; 3], skin, metres: Vec2::ONE, gloss: 0.1 },
            heart: self.heart(),
            green: self.leaf_paint(),
        }
    }

    /// Yellow to brown, mostly of many small dots.
    fn heart(&mut self) -> Paint {
        let tint = [self.range(0.2, 0.9), self.range(0.1, 0.6), self.range(0.0, 0.2)];
        let dots = if self.chance(0.7) { self.speckled(1.0).skin } else { None };
        Paint { tint, skin: dots, metres: Vec2::splat(self.range(0.3, 1.0)), gloss: 0.05 }
    }

    /// A petal's colours from tip to foot, with veins.
    fn petal_skin(&mut self) -> Arc<Texture> {
        let strong = |set: &mut Self| {
            let hue = set.range(0.0, 6.0);
            let grey = if set.chance(0.3) { 0.75 } else { set.range(0.0, 0.4) };
            [0.0, 2.0, 4.0].map(|off: f32| {
                let c = (((hue + off).rem_euclid(6.0) - 3.0).abs() - 1.0).clamp(0.0, 1.0);
                255.0 * (grey + (1.0 - grey) * c)
            })
        };
        let tip = strong(self);
        let foot = if self.chance(0.5) { strong(self) } else { tip.map(|c| c * 0.7) };
        let (veins, often, edge) = (self.range(0.0, 0.25), self.range(2.0, 9.0), self.range(0.4, 3.0));
        let picture = Raster::from_fn([16, 24], |x, y| {
            let (s, t) = (x as f32 / 15.0 - 0.5, 1.0 - y as f32 / 23.0);
            let part = t.powf(edge);
            let light = 1.0 - veins * (0.5 + 0.5 * (s * often * TAU * (1.2 - t)).cos());
            std::array::from_fn(|c| ((foot[c] + (tip[c] - foot[c]) * part) * light) as u8)
        });
        Arc::new(Texture::opaque(&picture))
    }

    /// A blossom of this width on a stem with leaves; it faces about `towards`.
    fn blossom(&mut self, kind: &Kind, foot: Vec3, tall: f32, wide: f32, towards: Vec3, cells: [usize; 2]) {
        let lean = Vec3::Y + 0.25 * any_way(&mut self.rng);
        let points = stem(&mut self.rng, foot, lean, tall, 0.3, 5);
        let thick = wide * self.range(0.015, 0.05);
        self.put(&tube(&points, [thick, thick * 0.8], 5), Affine3A::IDENTITY, &kind.green);
        let (rng, long) = (&mut self.rng, wide * 0.9);
        let leaf = round_leaves(4, |i| {
            let way = (any_way(rng) + 0.4 * Vec3::Y) * long * rng.range(0.5, 1.2);
            (points[1 + i % 4], way, long * rng.range(0.2, 0.5))
        });
        self.put(&leaf, Affine3A::IDENTITY, &kind.green);
        let [before, end] = [points[points.len() - 2], points[points.len() - 1]];
        // Bells stand about their stem, a blossom shows its face.
        let towards =
            if kind.bells.is_some() { end - before } else { towards + 0.35 * any_way(&mut self.rng) + 0.2 * Vec3::Y };
        let wide = wide * self.range(0.8, 1.15);
        self.head(kind, end, wide, towards.normalize_or(Vec3::Y), cells);
    }

    /// Petals, the middle and stamens of a blossom that faces a direction.
    pub(super) fn head(&mut self, kind: &Kind, at: Vec3, wide: f32, facing: Vec3, cells: [usize; 2]) {
        let turned = Quat::from_rotation_arc(Vec3::Y, facing) * Quat::from_rotation_y(self.turn());
        let place = Affine3A::from_scale_rotation_translation(Vec3::splat(wide), turned, at);
        if let Some(bells) = kind.bells {
            let spike = spike(bells, cells[0], &mut self.rng);
            return self.put(&spike, place, &kind.paint);
        }
        let rng = &mut self.rng;
        self.world.add(&kind.petals(cells, &mut || rng.range(-1.0, 1.0)), place, Some(&kind.paint), true);
        let [radius, high] = kind.middle;
        self.put(&lathe(&[[radius, 0.0], [radius * 0.8, high * 0.7], [0.002, high]], 9), place, &kind.heart);
        if kind.stamens > 0 && cells[0] > 2 {
            let rng = &mut self.rng;
            let pin = |_| {
                let tip = Vec3::new(rng.range(-0.15, 0.15), rng.range(0.12, 0.35), rng.range(-0.15, 0.15));
                tube(&[Vec3::ZERO, tip], [0.008, 0.012], 4)
            };
            let pins = together((0..kind.stamens).map(pin).collect::<Vec<_>>());
            self.put(&pins, place, &kind.heart);
        }
    }

    /// Leaves over the ground, and behind the bed leaves, a wall or nothing.
    fn foliage(&mut self, big: f32, tall: f32) {
        let (green, long) = (self.leaf_paint(), big * self.range(0.4, 1.2));
        let [low, deep] = [tall * self.range(0.1, 0.75), big * 14.0];
        let number = self.count(0, 260);
        let rng = &mut self.rng;
        let carpet = round_leaves(number, |_| {
            // Few of them before the blossoms.
            let z = 0.4 * big - deep * rng.range(0.0, 1.0).powi(2);
            let at = Vec3::new(rng.range(-1.0, 1.0) * (2.0 * big - z), rng.range(0.0, low), z);
            (at, (any_way(rng) + 0.5 * Vec3::Y) * long * rng.range(0.4, 1.0), long * 0.5)
        });
        self.put(&carpet, Affine3A::IDENTITY, &green);
        let behind = -big * self.range(2.0, 30.0);
        match self.rng.weighted(&[0.35, 0.25, 0.4]) {
            0 => {
                // A bush.
                let (green, long, high) = (self.leaf_paint(), long.max(0.05 * -behind), tall.max(-behind) * 1.5);
                let rng = &mut self.rng;
                let bush = leaves(400, |_| {
                    let at =
                        Vec3::new(rng.range(-1.2, 1.2) * -behind, rng.range(0.0, high), behind * rng.range(0.8, 1.4));
                    (at, any_way(rng) * 1.5 * long, long)
                });
                self.put(&bush, Affine3A::IDENTITY, &green);
            }
            1 => {
                let (wall, yaw) = (self.any_paint(0.8), self.range(-0.4, 0.4));
                let size = Vec3::new(24.0, self.range(0.5, 3.0), 0.2);
                self.block(Vec3::Z * (behind - 0.1), size, yaw, &wall);
            }
            _ => {}
        }
    }
}
