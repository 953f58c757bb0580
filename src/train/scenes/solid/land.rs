//! Wide land under skies with clouds: ridge behind ridge to the horizon, water, and what stands before it.

use std::f32::consts::TAU;
use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};

use super::light::Lights;
use super::mesh::Paint;
use super::set::{Set, stand};
use super::shapes::{lathe, sheet};
use super::shot::{Framing, Shot, Sky};
use super::texture::Texture;
use crate::scenes::raster::Raster;
use crate::scenes::walls::noise;

/// The kind of a scene that is mostly far away.
pub const LANDSCAPE: &str = "landscape";

const LAND: [&str; 3] = ["grass", "ground", "stone"];
/// How far the nearest ridge may stand, metres.
const FIRST_RIDGE_M: [f32; 2] = [60.0, 400.0];
/// Where water ends, metres: the horizon of somebody on a beach.
const HORIZON_M: f32 = 4000.0;

impl Set<'_> {
    /// Meadows, beaches and mountains: the land ends far away, and the sky begins there.
    pub fn landscape(&mut self, framing: &Framing) -> Shot {
        let height = self.near_land();
        let shore = if self.chance(0.35) { self.water() } else { 60.0 };
        for k in 0..self.rng.weighted(&[0.15, 0.3, 0.25, 0.2, 0.1]) {
            let away = self.range(FIRST_RIDGE_M[0], FIRST_RIDGE_M[1]) * 2.5f32.powi(k as i32);
            self.ridge(away);
        }
        let up = if self.chance(0.75) { self.range(0.3, 2.2) } else { self.range(2.2, 12.0) };
        let eye = Vec3::Y * (height(0.0, 0.0) + up);
        for _ in 0..self.rng.weighted(&[0.2, 0.2, 0.15, 0.15, 0.1, 0.1, 0.1]) {
            let far = 1.5 + (shore.min(35.0) - 1.5) * self.range(0.0, 1.0).powi(2);
            let x = self.range(-0.7, 0.7) * far;
            self.on_land(Vec3::new(x, height(x, -far), -far), eye);
        }
        let target = eye + Vec3::new(self.range(-0.3, 0.3), self.range(-0.35, 0.4), -1.0);
        let camera = self.look(framing, eye, target);
        let lights = Lights { haze_m: self.rng.log_range(300.0, 12e3), ..self.day() };
        Shot { camera, lights, sky: self.clouds(), kind: LANDSCAPE }
    }

    /// The land about the camera; its height at a place.
    pub(super) fn near_land(&mut self) -> impl Fn(f32, f32) -> f32 + use<> {
        let (bumps, waves) = (self.range(0.02, 0.6), self.waves(3.0, 15.0));
        // Flat far away.
        let height = move |x: f32, z: f32| bumps * waves(x, z) / (1.0 - z.min(0.0) / 60.0);
        let paint = self.cloth(&LAND, 2.0);
        let land = sheet([24, 28], |s, t| {
            // Finer near the camera.
            let (x, z) = ((2.0 * s - 1.0).powi(3) * 900.0, 6.0 - 1000.0 * t.powi(4));
            (Vec3::new(x, height(x, z), z), Vec2::new(x, z))
        });
        self.put(&land, Affine3A::IDENTITY, &paint);
        height
    }

    /// A lake or sea a little above the land, from a shore that is not quite square; how far away it begins.
    fn water(&mut self) -> f32 {
        let (shore, slant, level) = (self.range(2.0, 40.0), self.range(-0.4, 0.4), self.range(0.02, 0.4));
        let blue = [self.range(0.02, 0.3), self.range(0.1, 0.4), self.range(0.15, 0.5)];
        let skin = if self.chance(0.6) { self.cloth(&["stone", "ground", "fabric"], 1.0).skin } else { None };
        let paint = Paint { tint: blue, skin, metres: Vec2::new(self.range(2.0, 12.0), 2.0), gloss: 0.8 };
        let corner = Vec3::new(-HORIZON_M, level, -shore - slant * HORIZON_M);
        let along = Vec3::new(2.0 * HORIZON_M, 0.0, 2.0 * slant * HORIZON_M);
        self.panel(corner, along, Vec3::Z * -2.0 * HORIZON_M, &paint, [false, false]);
        shore
    }

    /// A chain of hills or mountains across the view, this far away.
    fn ridge(&mut self, away: f32) {
        let paint = if self.chance(0.6) { self.cloth(&LAND, 0.02 * away) } else { self.leaf_paint() };
        let paint = Paint { metres: Vec2::splat(self.range(0.01, 0.08) * away), ..paint };
        let (high, rough) = (away * self.range(0.02, 0.3), self.range(0.3, 0.65));
        let waves: Vec<[f32; 3]> = (0..6)
            .map(|k| {
                let often = 2.0f32.powi(k) * self.rng.range(0.7, 1.4);
                [rough.powi(k), often, self.rng.range(0.0, TAU)]
            })
            .collect();
        let crest = |s: f32| waves.iter().map(|[a, often, phase]| a * (often * 3.0 * s + phase).sin()).sum::<f32>();
        let deep = self.range(0.1, 0.5) * away;
        let chain = sheet([72, 4], |s, t| {
            let x = (2.0 * s - 1.0) * 1.6 * away;
            let fold = 1.0 + 0.25 * (crest(2.0 * s + t) * t * (1.0 - t));
            let top = high * (0.55 + 0.35 * crest(s)).max(0.0);
            (Vec3::new(x, top * t - 0.01 * away * (1.0 - t), -away - deep * t * fold), Vec2::new(x, -1.5 * high * t))
        });
        self.put(&chain, Affine3A::IDENTITY, &paint);
    }

    /// A tree, a bush, somebody, a rock, a fence, grass.
    fn on_land(&mut self, at: Vec3, eye: Vec3) {
        match self.rng.weighted(&[0.25, 0.15, 0.2, 0.15, 0.1, 0.15]) {
            0 => {
                let tall = self.range(2.0, 12.0);
                if self.chance(0.5) { self.tree(at, tall) } else { self.thing(&["tree"], at, None).map_or((), |_| ()) }
            }
            1 => self.thing(&["plant", "other", "building", "vehicle"], at, None).map_or((), |_| ()),
            2 => self.someone(at, eye),
            3 => {
                let (paint, wide) = (self.cloth(&["stone", "ground"], 1.0), self.range(0.2, 1.8));
                let flat = self.range(0.4, 0.9);
                let rock = lathe(&[[wide, -0.2], [wide * 0.9, wide * 0.4 * flat], [0.02, wide * flat]], 7);
                self.put(&rock, stand(at, 0.0, 1.0), &paint);
            }
            4 => {
                let (long, tall) = (self.range(4.0, 30.0), self.range(0.6, 1.6));
                self.fence(at - Vec3::X * long / 2.0, Vec3::new(long, 0.0, 0.0), tall);
            }
            _ => {
                let tall = self.range(0.1, 0.7);
                self.grass(at, 1.5, tall, 120);
            }
        }
    }

    /// A sky with clouds, from a few wisps to overcast, smaller towards the horizon.
    pub fn clouds(&mut self) -> Sky {
        let size = [96, 72];
        let seed = self.rng.next_u64();
        let (cover, soft) = (self.range(-0.8, 0.8), self.range(0.15, 1.0));
        let (rough, scale) = (self.range(0.4, 0.75), self.range(1.5, 6.0));
        let high = [self.range(0.15, 0.6), self.range(0.35, 0.75), self.range(0.6, 1.0)];
        let pale = self.range(0.2, 0.9);
        let [lit, dark] = [self.range(0.8, 1.0), self.range(0.35, 0.9)];
        let horizon = self.range(0.9, 1.6);
        let sky = Raster::from_fn(size, |x, y| {
            let [s, t] = [x as f32 / size[0] as f32 - 0.5, y as f32 / size[1] as f32];
            let far = 1.0 / (horizon + 0.15 - t).max(0.12);
            let octave = |k: i32| {
                let often = scale * 2.0f32.powi(k);
                rough.powi(k) * (2.0 * noise(seed ^ k as u64, s * far * often, 1.4 * far * often) - 1.0)
            };
            let thick = (0..5).map(octave).sum::<f32>() + cover;
            let cloud = (thick / soft).clamp(0.0, 1.0);
            let shade = lit + (dark - lit) * (thick * 0.6).clamp(0.0, 1.0) * t;
            std::array::from_fn(|c| {
                let clear = high[c] + (0.92 - high[c]) * pale * t;
                ((clear + (shade - clear) * cloud).clamp(0.0, 1.0) * 255.0) as u8
            })
        });
        Sky::Picture(Arc::new(Texture::opaque(&sky)), Vec2::splat(0.02), Vec2::splat(0.96))
    }
}
