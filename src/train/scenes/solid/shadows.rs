//! Open ground under a low sun: shadows as long and as clear as what casts them, some of it beside the picture.
//! Nets take such shadows for things.

use glam::Vec3;

use super::light::Lights;
use super::set::Set;
use super::shot::{Framing, Shot};

/// The kind of a scene whose shadows lie on the ground.
pub const LOW_SUN: &str = "low sun";

impl Set<'_> {
    /// People, animals, plants and posts on a lawn, a square or sand, whose shadows lie beside them.
    pub fn low_sun(&mut self, framing: &Framing) -> Shot {
        let height = self.near_land();
        let on = |x: f32, z: f32| Vec3::new(x, height(x, z), z);
        let lights = self.long_shadows();
        let away = framing.distance(self.rng.log_range(0.9, 5.0)).clamp(0.8, 10.0);
        let eye = on(0.0, 0.0) + Vec3::Y * (away * self.range(0.05, 0.8)).clamp(0.2, 3.0);
        let subject = on(self.range(-0.3, 0.3) * away, -away);
        self.casts(subject, eye);
        for _ in 0..self.rng.weighted(&[0.3, 0.25, 0.25, 0.2]) {
            let z = -away * self.range(0.6, 2.5);
            let at = on(self.range(-0.5, 0.5) * z, z);
            self.casts(at, eye);
        }
        // What stands beside or behind the camera, between the sun and what is seen.
        let towards_sun = lights.sun_from.with_y(0.0).normalize_or(Vec3::X);
        for _ in 0..self.rng.weighted(&[0.2, 0.4, 0.25, 0.15]) {
            let dark = on(self.range(-0.4, 0.4) * away, -away * self.range(0.4, 1.3));
            let at = dark + towards_sun * self.range(0.5, 6.0);
            if at.z > 0.3 || at.x.abs() > 0.3 - at.z {
                self.casts(on(at.x, at.z), eye);
            }
        }
        self.far_side(&on, away);
        let target = subject + Vec3::Y * away * self.range(-0.15, 0.2);
        let camera = self.look(framing, eye, target);
        let sky = if self.chance(0.5) { self.clouds() } else { self.sky() };
        Shot { camera, lights, sky, kind: LOW_SUN }
    }

    /// A clear day's light, early or late: most of it is the sun's.
    fn long_shadows(&mut self) -> Lights {
        let (day, turn) = (self.day(), self.turn());
        let height = self.range(0.15, 0.67f32);
        let sun_from = Vec3::new(turn.cos() * height.cos(), height.sin(), turn.sin() * height.cos());
        let sun = self.clear_sun(day.sky, sun_from, 4.0);
        let haze_m = self.range(200.0, 3000.0);
        Lights { sun_from, sun, haze_m, ..day }
    }

    /// What closes the ground, or nothing.
    fn far_side(&mut self, on: &impl Fn(f32, f32) -> Vec3, away: f32) {
        let z = -away * self.range(2.0, 6.0);
        match self.rng.weighted(&[0.35, 0.2, 0.15, 0.3]) {
            0 => {}
            1 => {
                let tall = self.range(0.6, 2.5);
                self.hedge(on(0.0, z), 40.0, tall);
            }
            2 => {
                let (wide, high, yaw) = (self.range(6.0, 20.0), self.range(3.0, 9.0), self.range(-0.5, 0.5));
                let at = on(self.range(-0.4, 0.4) * z, z - 2.0);
                self.front(at, wide, high, yaw);
            }
            _ => {
                for _ in 0..self.count(2, 7) {
                    let (x, tall) = (self.range(-0.8, 0.8) * z, self.range(1.5, 8.0));
                    let at = on(x, z * self.range(0.8, 1.4));
                    self.tree(at, tall);
                }
            }
        }
    }

    /// Something upright.
    fn casts(&mut self, at: Vec3, eye: Vec3) {
        match self.rng.weighted(&[0.55, 0.12, 0.1, 0.08, 0.15]) {
            0 => self.someone(at, eye),
            1 => {
                let tall = self.range(0.3, 1.5);
                self.plant(at, tall);
            }
            2 => {
                let (long, tall) = (self.range(1.0, 6.0), self.range(0.5, 1.8));
                let (sin, cos) = self.turn().sin_cos();
                self.fence(at, Vec3::new(cos, 0.0, sin) * long, tall);
            }
            3 => {
                let tall = self.range(1.5, 6.0);
                self.tree(at, tall);
            }
            _ => self.thing(&["furniture", "vehicle", "other", "toy", "tool"], at, None).map_or((), |_| ()),
        }
    }
}
