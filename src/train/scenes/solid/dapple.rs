//! Sunlight in patches: through a window's panes on floors, walls and tables, through leaves on the ground. Nets take
//! such patches for things.

use glam::Vec2;

use super::light::Lights;
use super::set::Set;
use super::shot::{Framing, Shot};
use crate::scenes::walls::noise;

/// What the sun's light comes through on its way to a scene.
#[derive(Clone, Copy, Debug)]
pub enum Through {
    /// Nothing.
    Air,
    /// Windows side by side.
    Panes {
        /// From one window to the next, across the light, metres.
        every: Vec2,
        /// How much of it is glass.
        glass: Vec2,
        /// Panes of a window along each side.
        panes: Vec2,
        /// Width of the bars between panes, and of the patches' edges, metres.
        bar: f32,
        soft: f32,
        /// Where the first stands.
        at: Vec2,
    },
    /// A roof of leaves with gaps.
    Leaves {
        /// Which.
        seed: u64,
        /// Size of its gaps, metres.
        gap: f32,
        /// How much of it is leaves, and the width of the gaps' edges, both of 1.
        cover: f32,
        soft: f32,
    },
}

impl Through {
    /// How much of the light passes at a place across it, metres.
    #[inline]
    pub fn passes(&self, at: Vec2) -> f32 {
        match *self {
            Self::Air => 1.0,
            Self::Panes { every, glass, panes, bar, soft, at: first } => {
                let place = (at - first).rem_euclid(every);
                let side = glass * every;
                let pane = side / panes;
                let within = |i: usize| {
                    let inside = place[i].min(side[i] - place[i]);
                    let middle = (place[i] / pane[i]).round() * pane[i];
                    let off_bar = if middle > 0.0 && middle < side[i] - 1e-4 {
                        (place[i] - middle).abs() - bar / 2.0
                    } else {
                        inside
                    };
                    (inside.min(off_bar) / soft + 0.5).clamp(0.0, 1.0)
                };
                within(0) * within(1)
            }
            Self::Leaves { seed, gap, cover, soft } => {
                let place = at / gap;
                let thick = 0.65 * noise(seed, place.x, place.y) + 0.35 * noise(seed ^ 1, 2.7 * place.x, 2.7 * place.y);
                ((thick - cover) / soft + 0.5).clamp(0.0, 1.0)
            }
        }
    }
}

/// The kind of a scene with sunlight in patches.
pub const DAPPLED: &str = "dappled";

impl Set<'_> {
    /// A room, a table or stairs with the sun through a window, a garden, front or lawn with the sun through leaves.
    pub fn dappled(&mut self, framing: &Framing) -> Shot {
        let inside = self.chance(0.55);
        let shot = match (inside, self.rng.below(3)) {
            (true, 0) => self.room(framing),
            (true, 1) => self.table_top(framing),
            (true, _) => self.stairs(framing),
            (false, 0) => self.garden(framing),
            (false, 1) => self.facade(framing),
            (false, _) => self.low_sun(framing),
        };
        let through = if inside && self.chance(0.8) { self.panes() } else { self.leaves() };
        let sky = shot.lights.sky * self.range(0.4, 1.0);
        let sun = self.clear_sun(sky, shot.lights.sun_from, 5.0);
        Shot { lights: Lights { sun, sky, through, ..shot.lights }, kind: DAPPLED, ..shot }
    }

    fn panes(&mut self) -> Through {
        let wide = self.rng.log_range(0.25, 2.0);
        let every = Vec2::new(wide, wide * self.range(0.7, 2.0));
        let glass = Vec2::new(self.range(0.35, 0.9), self.range(0.4, 0.9));
        let panes = Vec2::new(self.count(1, 3) as f32, self.count(1, 4) as f32);
        let at = Vec2::new(self.range(0.0, 1.0), self.range(0.0, 1.0)) * every;
        Through::Panes {
            every,
            glass,
            panes,
            bar: wide * self.range(0.02, 0.09),
            soft: wide * self.range(0.01, 0.1),
            at,
        }
    }

    fn leaves(&mut self) -> Through {
        let gap = self.rng.log_range(0.12, 1.2);
        Through::Leaves { seed: self.rng.next_u64(), gap, cover: self.range(0.35, 0.65), soft: self.range(0.05, 0.4) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_lets_light_through_its_panes_alone() {
        let (every, glass, panes) = (Vec2::splat(2.0), Vec2::splat(0.5), Vec2::new(2.0, 1.0));
        let window = Through::Panes { every, glass, panes, bar: 0.1, soft: 0.01, at: Vec2::new(-4.0, 0.0) };
        let passes = [0.25, 0.5, 0.75, 1.5, 2.25].map(|x| window.passes(Vec2::new(x, 0.5)));
        assert_eq!(passes, [1.0, 0.0, 1.0, 0.0, 1.0], "pane, bar, pane, wall, the next window's pane");
        assert_eq!(window.passes(Vec2::new(0.25, 1.5)), 0.0, "above it is wall");
    }

    #[test]
    fn thin_leaves_let_more_light_through_and_some_everywhere() {
        let mean = |cover: f32| {
            let leaves = Through::Leaves { seed: 3, gap: 0.3, cover, soft: 0.1 };
            let places = (0..900).map(|i| Vec2::new((i % 30) as f32, (i / 30) as f32) * 0.17);
            places.map(|at| leaves.passes(at)).sum::<f32>() / 900.0
        };
        let [thin, thick] = [0.35, 0.65].map(mean);
        assert!(thin > thick + 0.3 && thick > 0.02 && thin < 0.98, "{thin} {thick}");
    }
}
