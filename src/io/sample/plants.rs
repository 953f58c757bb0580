//! What stands in the sample's garden, from far to near.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::canvas::hash;
use super::shapes::{Backdrop, Blade, Dome, Shape, Spot, Stroke, bent};

type Scene = Vec<Box<dyn Shape>>;

/// Numbers that look random, in a fixed order.
struct Dice {
    seed: u32,
    count: u32,
}

impl Dice {
    fn new(seed: u32) -> Self {
        Self { seed, count: 0 }
    }

    /// The next number from `lo` to `hi`.
    fn roll(&mut self, lo: f32, hi: f32) -> f32 {
        self.count += 1;
        lo + (hi - lo) * hash(self.seed, self.count)
    }
}

/// A kind of flower.
struct Kind {
    petals: usize,
    /// Length and half width of a petal over the head's radius.
    petal: [f32; 2],
    point: f32,
    /// Light of a petal at its root and tip.
    petal_light: [Vec3; 2],
    dome: f32,
    dome_light: [Vec3; 2],
}

const DAISY: Kind = Kind {
    petals: 21,
    petal: [0.76, 0.088],
    point: 0.32,
    petal_light: [Vec3::new(0.62, 0.60, 0.46), Vec3::new(0.92, 0.91, 0.86)],
    dome: 0.30,
    dome_light: [Vec3::new(0.95, 0.62, 0.05), Vec3::new(0.78, 0.36, 0.015)],
};

const RUDBECKIA: Kind = Kind {
    petals: 15,
    petal: [0.76, 0.125],
    point: 0.45,
    petal_light: [Vec3::new(0.50, 0.075, 0.008), Vec3::new(0.95, 0.52, 0.02)],
    dome: 0.30,
    dome_light: [Vec3::new(0.10, 0.035, 0.015), Vec3::new(0.035, 0.012, 0.008)],
};

const COSMOS: Kind = Kind {
    petals: 8,
    petal: [0.84, 0.27],
    point: 0.26,
    petal_light: [Vec3::new(0.42, 0.03, 0.16), Vec3::new(0.82, 0.22, 0.46)],
    dome: 0.17,
    dome_light: [Vec3::new(0.92, 0.60, 0.06), Vec3::new(0.62, 0.28, 0.02)],
};

/// One flower on its stem; lengths over the picture's width, places over width and height.
struct Flower<'a> {
    kind: &'a Kind,
    at: Vec2,
    radius: f32,
    tilt: f32,
    /// Where the stem meets the lower edge, over the width.
    foot_x: f32,
    disparity: f32,
}

/// The whole garden, far things first.
pub fn garden(size: [u32; 2]) -> Scene {
    let size = Vec2::new(size[0] as f32, size[1] as f32);
    let mut scene: Scene = vec![Box::new(Backdrop { size, horizon_y: size.y * 0.56, disparity: [-1.25, 0.75] })];
    spots(&mut scene, size);
    let v = Vec2::new;
    let flowers = [
        Flower { kind: &RUDBECKIA, at: v(0.885, 0.40), radius: 0.036, tilt: 0.8, foot_x: 0.875, disparity: -0.95 },
        Flower { kind: &DAISY, at: v(0.045, 0.42), radius: 0.040, tilt: 0.7, foot_x: 0.06, disparity: -0.9 },
        Flower { kind: &COSMOS, at: v(0.60, 0.37), radius: 0.048, tilt: 0.75, foot_x: 0.585, disparity: -0.75 },
        Flower { kind: &DAISY, at: v(0.775, 0.50), radius: 0.056, tilt: 0.65, foot_x: 0.76, disparity: -0.5 },
        Flower { kind: &RUDBECKIA, at: v(0.185, 0.34), radius: 0.075, tilt: 0.78, foot_x: 0.215, disparity: -0.3 },
        Flower { kind: &DAISY, at: v(0.43, 0.43), radius: 0.135, tilt: 0.86, foot_x: 0.455, disparity: 0.0 },
        Flower { kind: &COSMOS, at: v(0.705, 0.70), radius: 0.120, tilt: 0.72, foot_x: 0.69, disparity: 0.45 },
        Flower { kind: &RUDBECKIA, at: v(0.115, 0.83), radius: 0.150, tilt: 0.66, foot_x: 0.10, disparity: 0.95 },
    ];
    let mut nearest_so_far = -1.25;
    for (number, flower) in flowers.iter().enumerate() {
        grass(&mut scene, size, [nearest_so_far, flower.disparity], 31 + number as u32);
        plant(&mut scene, size, flower, 7 * number as u32 + 3);
        nearest_so_far = flower.disparity;
    }
    grass(&mut scene, size, [nearest_so_far, 1.25], 77);
    front_leaves(&mut scene, size);
    scene
}

/// Blur of what is off the focal plane, in pixels: the camera that took this was focused on 0.
fn blur_px(size: Vec2, disparity: f32) -> f32 {
    1.2 + (disparity.abs() - 0.12).max(0.0) * size.x * 0.0095
}

fn spots(scene: &mut Scene, size: Vec2) {
    let mut dice = Dice::new(5);
    for _ in 0..150 {
        let center = Vec2::new(dice.roll(0.0, 1.0), dice.roll(0.0, 0.56).powf(1.2)) * size;
        let warm = dice.roll(0.0, 1.0);
        let light = Vec3::new(0.30, 0.52, 0.16).lerp(Vec3::new(1.0, 0.92, 0.55), warm * warm);
        let radius_px = dice.roll(0.012, 0.034) * size.x;
        scene.push(Box::new(Spot { center, radius_px, opacity: dice.roll(0.06, 0.34), light, disparity: -1.25 }));
    }
}

/// Blades of grass that stand on the lawn between two disparities, far ones first.
fn grass(scene: &mut Scene, size: Vec2, disparity: [f32; 2], seed: u32) {
    let mut dice = Dice::new(seed);
    let count = ((disparity[1] - disparity[0]) * 210.0).max(0.0) as usize;
    for number in 0..count {
        let d = disparity[0] + (disparity[1] - disparity[0]) * (number as f32 + 0.5) / count as f32;
        let near = (d + 1.25) / 2.0;
        let root = Vec2::new(dice.roll(-0.03, 1.03), 0.58 + 0.46 * near) * size;
        let height = (0.035 + 0.16 * near) * size.x * dice.roll(0.6, 1.25);
        let lean = dice.roll(-0.45, 0.45) * height;
        let bend = root + Vec2::new(lean * 0.2, -height * 0.6);
        let tip = root + Vec2::new(lean, -height * dice.roll(0.85, 1.0));
        let bright = dice.roll(0.55, 1.25) * (1.05 - 0.25 * near);
        let light = [Vec3::new(0.030, 0.075, 0.014) * bright, Vec3::new(0.21, 0.33, 0.055) * bright];
        let half_width = (0.0008 + 0.0022 * near) * size.x;
        let soft_px = blur_px(size, d);
        let half_width_px = [half_width + 0.3 * soft_px, 0.25 * soft_px];
        scene.push(Box::new(Stroke { line: bent(root, bend, tip), half_width_px, soft_px, light, disparity: d }));
    }
}

fn plant(scene: &mut Scene, size: Vec2, flower: &Flower, seed: u32) {
    let mut dice = Dice::new(seed);
    let head = flower.at * size;
    let radius = flower.radius * size.x;
    let soft_px = blur_px(size, flower.disparity);
    let foot = Vec2::new(flower.foot_x * size.x, size.y + 20.0);
    let bend = Vec2::new((head.x + foot.x) / 2.0 - radius * 0.2, (head.y + foot.y) / 2.0);
    scene.push(Box::new(Stroke {
        line: bent(foot, bend, head),
        half_width_px: [radius * 0.060, radius * 0.042],
        soft_px,
        light: [Vec3::new(0.05, 0.12, 0.02), Vec3::new(0.17, 0.27, 0.05)],
        disparity: flower.disparity - 0.03,
    }));
    for (side, share) in [(1.0, 0.42), (-1.0, 0.62)] {
        let on_stem = foot.lerp(bend, 1.0 - share).lerp(bend.lerp(head, 1.0 - share), 1.0 - share);
        let angle = if side > 0.0 { dice.roll(-0.85, -0.35) } else { std::f32::consts::PI + dice.roll(0.35, 0.85) };
        scene.push(Box::new(leaf(on_stem, angle, radius * dice.roll(0.85, 1.15), soft_px, flower.disparity - 0.02)));
    }
    petals(scene, flower.kind, &mut dice, (head, radius, flower.tilt, soft_px, flower.disparity));
}

fn leaf(root: Vec2, angle: f32, length_px: f32, soft_px: f32, disparity: f32) -> Blade {
    Blade {
        head: root,
        tilt: 1.0,
        direction: Vec2::from_angle(angle),
        root_px: 0.0,
        length_px,
        half_width_px: length_px * 0.17,
        point: 0.9,
        bend: 0.6 * angle.cos().signum(),
        soft_px,
        light: [Vec3::new(0.035, 0.10, 0.018), Vec3::new(0.11, 0.23, 0.035)],
        veins: [9.0, 0.28 / soft_px.max(1.0)],
        disparity: [disparity, 0.05],
    }
}

/// Two rounds of petals and the middle. `on`: head, radius, tilt, blur and disparity of the flower.
fn petals(scene: &mut Scene, kind: &Kind, dice: &mut Dice, on: (Vec2, f32, f32, f32, f32)) {
    let (head, radius, tilt, soft_px, disparity) = on;
    for round in [0.0, 1.0] {
        for number in 0..kind.petals {
            let angle = (number as f32 + 0.5 * round + dice.roll(-0.16, 0.16)) / kind.petals as f32 * TAU;
            let shade = (0.70 + 0.30 * round) * dice.roll(0.9, 1.05);
            let length_px = radius * kind.petal[0] * dice.roll(0.92, 1.04) * (1.0 - 0.05 * round);
            scene.push(Box::new(Blade {
                head,
                tilt,
                direction: Vec2::from_angle(angle),
                root_px: radius * kind.dome * 0.75,
                length_px,
                half_width_px: radius * kind.petal[1] * dice.roll(0.9, 1.1),
                point: kind.point,
                bend: dice.roll(-0.35, 0.35),
                soft_px,
                light: kind.petal_light.map(|light| light * shade),
                veins: [13.0, 0.22 / soft_px.max(1.0)],
                disparity: [disparity + 0.01 * round, 0.05],
            }));
        }
    }
    scene.push(Box::new(Dome {
        center: head,
        tilt,
        radius_px: radius * kind.dome,
        soft_px,
        light: kind.dome_light,
        disparity: [disparity + 0.02, 0.05],
    }));
}

/// Leaves right in front of the camera, in the lower right corner.
fn front_leaves(scene: &mut Scene, size: Vec2) {
    for (number, (x, angle, length)) in
        [(1.06, -2.55, 0.30), (0.99, -1.95, 0.33), (1.03, -2.25, 0.36)].into_iter().enumerate()
    {
        let disparity = 1.25 + 0.12 * number as f32;
        let root = Vec2::new(x, 1.05) * size;
        scene.push(Box::new(leaf(root, angle, length * size.x, blur_px(size, disparity), disparity)));
    }
}
