//! The shapes of the sample: backdrop, ground, light spots, strokes, leaves and petals, flower centres.

use glam::{Vec2, Vec3};

use super::canvas::noise;
use crate::field::ramp;

/// What a shape puts on a pixel.
pub struct Paint {
    /// How much of the pixel it covers, 0 … 1.
    pub cover: f32,
    /// Linear light.
    pub light: Vec3,
    /// Scene disparity: pixels per view step at a width of 540 pixels.
    pub disparity: f32,
}

/// Something that can be painted.
pub trait Shape: Sync {
    /// Left, top, right, bottom of what it may touch, in pixels.
    fn bounds(&self) -> [f32; 4];
    /// What it puts on the pixel with its centre at `(x, y)`.
    fn at(&self, x: f32, y: f32) -> Option<Paint>;
}

/// Where the light comes from: above, a little from the left.
const TO_LIGHT: Vec2 = Vec2::new(-0.666, -0.746);

/// How much of a pixel an edge covers that lies `inside_px` beyond it and is `soft_px` wide.
fn cover(inside_px: f32, soft_px: f32) -> f32 {
    ramp(-0.5, 0.5, inside_px / soft_px.max(1.0))
}

/// Hedge and light far behind, and the lawn that comes from there to our feet.
pub struct Backdrop {
    pub size: Vec2,
    /// Height of the horizon, in pixels from the top.
    pub horizon_y: f32,
    /// Disparity at the horizon and at the lower edge.
    pub disparity: [f32; 2],
}

impl Shape for Backdrop {
    fn bounds(&self) -> [f32; 4] {
        [0.0, 0.0, self.size.x, self.size.y]
    }

    fn at(&self, x: f32, y: f32) -> Option<Paint> {
        let below = ((y - self.horizon_y) / (self.size.y - self.horizon_y)).max(0.0);
        let blotch = noise(x / 190.0, y / 150.0, 1) * 0.6 + noise(x / 80.0, y / 70.0, 2) * 0.3;
        let sky = Vec3::new(0.30, 0.50, 0.30).lerp(Vec3::new(0.035, 0.10, 0.030), (y / self.horizon_y).clamp(0.0, 1.0));
        let glow = (1.0 - Vec2::new(x / self.size.x - 0.78, y / self.size.y - 0.02).length() * 1.4).max(0.0);
        let hedge = sky * (1.0 + 0.55 * blotch) + Vec3::new(0.75, 0.62, 0.26) * glow * glow;
        let fine = noise(x / (4.0 + 5.0 * below), y / (3.0 + 8.0 * below), 3) * below;
        let lawn = Vec3::new(0.10, 0.19, 0.045).lerp(Vec3::new(0.025, 0.06, 0.012), below)
            * (1.0 + 0.3 * blotch + 0.35 * fine);
        let light = hedge.lerp(lawn, cover(y - self.horizon_y - 14.0 * blotch, 70.0));
        let disparity = self.disparity[0] + (self.disparity[1] - self.disparity[0]) * below;
        Some(Paint { cover: 1.0, light, disparity })
    }
}

/// A spot of light out of focus.
pub struct Spot {
    pub center: Vec2,
    pub radius_px: f32,
    pub opacity: f32,
    pub light: Vec3,
    pub disparity: f32,
}

impl Shape for Spot {
    fn bounds(&self) -> [f32; 4] {
        around(self.center, self.radius_px + 4.0)
    }

    fn at(&self, x: f32, y: f32) -> Option<Paint> {
        let from_center = Vec2::new(x, y).distance(self.center);
        let rim = 0.8 + 0.2 * (from_center / self.radius_px).powi(4).min(1.0);
        // Below one half: a spot of the background brings no depth of its own.
        let cover = cover(self.radius_px - from_center, 5.0) * self.opacity * rim;
        (cover > 0.0).then_some(Paint { cover: cover.min(0.49), light: self.light, disparity: self.disparity })
    }
}

/// A stem or a blade of grass: a bent line that gets thinner.
pub struct Stroke {
    /// Its middle line from root to tip, see [`bent`].
    pub line: [Vec2; LINE_POINTS],
    /// Half its width at the root and at the tip.
    pub half_width_px: [f32; 2],
    pub soft_px: f32,
    /// Light at the root and at the tip.
    pub light: [Vec3; 2],
    pub disparity: f32,
}

/// Points of a stroke's middle line.
const LINE_POINTS: usize = 9;

/// The line from a root to a tip that is drawn towards a third point.
pub fn bent(root: Vec2, towards: Vec2, tip: Vec2) -> [Vec2; LINE_POINTS] {
    std::array::from_fn(|number| {
        let t = number as f32 / (LINE_POINTS - 1) as f32;
        root.lerp(towards, t).lerp(towards.lerp(tip, t), t)
    })
}

impl Stroke {
    /// Signed distance to the nearest piece of the middle line (positive to its right) and how far along that is.
    fn nearest(&self, p: Vec2) -> (f32, f32) {
        let mut best = (f32::INFINITY, 0.0, 0.0);
        for (piece, ends) in self.line.windows(2).enumerate() {
            let along = ends[1] - ends[0];
            let t = ((p - ends[0]).dot(along) / along.length_squared().max(1e-6)).clamp(0.0, 1.0);
            let away = p - (ends[0] + along * t);
            if away.length_squared() < best.0 {
                best = (away.length_squared(), along.perp_dot(away), piece as f32 + t);
            }
        }
        (best.0.sqrt().copysign(best.1), best.2 / (LINE_POINTS - 1) as f32)
    }
}

impl Shape for Stroke {
    fn bounds(&self) -> [f32; 4] {
        let (lo, hi) = self.line.iter().fold((Vec2::MAX, Vec2::MIN), |(lo, hi), at| (lo.min(*at), hi.max(*at)));
        let margin = self.half_width_px[0].max(self.half_width_px[1]) + self.soft_px;
        [lo.x - margin, lo.y - margin, hi.x + margin, hi.y + margin]
    }

    fn at(&self, x: f32, y: f32) -> Option<Paint> {
        let (away, t) = self.nearest(Vec2::new(x, y));
        let half_width = self.half_width_px[0] + (self.half_width_px[1] - self.half_width_px[0]) * t;
        let cover = cover(half_width - away.abs(), self.soft_px);
        let round = 1.0 - 0.35 * away / half_width.max(1.0);
        let light = self.light[0].lerp(self.light[1], t) * round.clamp(0.5, 1.4);
        (cover > 0.0).then_some(Paint { cover, light, disparity: self.disparity })
    }
}

/// A petal or a leaf: a blade with a middle rib, on a head that may be tilted away.
pub struct Blade {
    /// Where the head is, in pixels.
    pub head: Vec2,
    /// Height of the head's circle seen from here over its width.
    pub tilt: f32,
    /// Unit vector that it points to on the head.
    pub direction: Vec2,
    /// Distance of its root from the head's middle, its length and half its greatest width.
    pub root_px: f32,
    pub length_px: f32,
    pub half_width_px: f32,
    /// How pointed: 0.3 round … 1 sharp.
    pub point: f32,
    /// Sideways bend of the tip, in half widths.
    pub bend: f32,
    pub soft_px: f32,
    /// Light at the root and at the tip.
    pub light: [Vec3; 2],
    /// Veins: how many and how deep.
    pub veins: [f32; 2],
    /// Disparity at the head, and how much the tip is nearer when it points down.
    pub disparity: [f32; 2],
}

impl Shape for Blade {
    fn bounds(&self) -> [f32; 4] {
        let middle = self.head + self.direction * Vec2::new(1.0, self.tilt) * (self.root_px + self.length_px * 0.5);
        around(middle, self.length_px * 0.5 + self.half_width_px * 1.5 + self.soft_px)
    }

    fn at(&self, x: f32, y: f32) -> Option<Paint> {
        let on_head = (Vec2::new(x, y) - self.head) / Vec2::new(1.0, self.tilt);
        let local = Vec2::new(self.direction.dot(on_head) - self.root_px, self.direction.perp_dot(on_head));
        let along = local.x / self.length_px;
        if !(-0.1..=1.1).contains(&along) || local.y.abs() > 2.0 * self.half_width_px + self.soft_px {
            return None;
        }
        let s = along.clamp(0.0, 1.0);
        let across = local.y - self.bend * self.half_width_px * s * s;
        // 1 at the widest place; round at the root, as pointed as asked for at the tip.
        let width = self.half_width_px * s.powf(0.55) * (1.0 - s).powf(self.point) * (1.55 + 0.9 * (self.point - 0.4));
        let past_end = (-along).max(along - 1.0).max(0.0) * self.length_px;
        let cover = cover(width - across.abs() - past_end, self.soft_px);
        if cover <= 0.0 {
            return None;
        }
        let side = across / width.max(1.0);
        let rib = (1.0 - (across.abs() / (0.05 * self.half_width_px + 0.6)).min(1.0)) * self.veins[1];
        let vein = ((side * self.veins[0]).sin() * 0.5 + 0.5) * self.veins[1];
        let facing = 0.86 + 0.14 * self.direction.dot(TO_LIGHT) - 0.13 * side;
        let root_shadow = 0.62 + 0.38 * (s * 3.2).min(1.0);
        let light =
            self.light[0].lerp(self.light[1], s) * (facing * root_shadow * (1.0 - vein * 0.6 + rib * 0.5)).max(0.0);
        let disparity =
            self.disparity[0] + self.disparity[1] * self.direction.y * (self.root_px + local.x) / self.length_px;
        Some(Paint { cover, light, disparity })
    }
}

/// The middle of a flower: a dome of florets in two families of spirals.
pub struct Dome {
    pub center: Vec2,
    pub tilt: f32,
    pub radius_px: f32,
    pub soft_px: f32,
    /// Light in the middle and at the rim.
    pub light: [Vec3; 2],
    /// Disparity at the rim, and how much nearer the middle is.
    pub disparity: [f32; 2],
}

impl Shape for Dome {
    fn bounds(&self) -> [f32; 4] {
        around(self.center, self.radius_px + self.soft_px)
    }

    fn at(&self, x: f32, y: f32) -> Option<Paint> {
        let on_head = (Vec2::new(x, y) - self.center) / Vec2::new(1.0, self.tilt);
        let r = on_head.length() / self.radius_px;
        let cover = cover((1.0 - r) * self.radius_px * self.tilt, self.soft_px);
        if cover <= 0.0 {
            return None;
        }
        let turn = on_head.to_angle();
        let floret = (turn * 21.0 + r * 26.0).sin() * (turn * 13.0 - r * 26.0).sin();
        let crisp = (1.0 / self.soft_px.max(1.0)).min(1.0);
        let lit = 1.05 - 0.4 * (on_head.dot(Vec2::new(0.6, 0.8)) / self.radius_px) - 0.35 * r.powi(6);
        let light = self.light[0].lerp(self.light[1], r.min(1.0)) * (lit * (1.0 + 0.45 * crisp * floret)).max(0.05);
        let disparity = self.disparity[0] + self.disparity[1] * (1.0 - r * r).max(0.0);
        Some(Paint { cover, light, disparity })
    }
}

fn around(center: Vec2, radius: f32) -> [f32; 4] {
    [center.x - radius, center.y - radius, center.x + radius, center.y + radius]
}
