//! Twelve scenes with the edges that a lens of software finds hard.

use super::chance::hash;
use super::sprite::{Sprite, noise};

/// A scene: surfaces from near to far, the last one everywhere, and the disparity that is sharp.
pub struct Scene {
    pub name: &'static str,
    pub layers: Vec<Layer>,
    pub focus_px: f32,
}

/// A surface and its disparity, pixels of the map.
pub struct Layer {
    pub sprite: Sprite,
    pub disparity_px: f32,
}

const NEAR: f32 = 0.5;
const FAR: f32 = -0.3;

/// All of them; each subject once in focus, and some again before what is.
pub fn all() -> Vec<Scene> {
    vec![
        scene("fur", NEAR, fur, meadow),
        scene("fur-blurred", FAR, fur, meadow),
        scene("stems", NEAR, stems, ground),
        scene("stems-blurred", FAR, stems, ground),
        scene("petals", NEAR, petals, ground),
        scene("petals-blurred", FAR, petals, ground),
        scene("branches", NEAR, branches, sky),
        scene("branches-blurred", FAR, branches, sky),
        scene("ear", NEAR, ear, room),
        scene("leaf-on-leaves", NEAR, leaf, ground),
        scene("straight-edge", NEAR, board, room),
        three(),
    ]
}

fn scene(name: &'static str, focus_px: f32, near: fn() -> Sprite, far: fn() -> Sprite) -> Scene {
    let layers = vec![Layer { sprite: near(), disparity_px: NEAR }, Layer { sprite: far(), disparity_px: FAR }];
    Scene { name, layers, focus_px }
}

/// A leaf before petals before the ground, sharp in the middle.
fn three() -> Scene {
    let corner = Sprite::painted(|[x, y]| (x + y > 110.0).then(|| shaded([0.25, 0.42, 0.2], [x, y], 9.0, 0.12, 70)));
    let layers = [(corner, 0.9), (petals(), 0.2), (ground(), -0.5)];
    let layers = layers.map(|(sprite, disparity_px)| Layer { sprite, disparity_px }).into();
    Scene { name: "three-deep", layers, focus_px: 0.2 }
}

/// A colour with even texture in it.
fn shaded(color: [f32; 3], at: [f32; 2], wave: f32, depth: f32, seed: u32) -> [f32; 3] {
    let shade = 1.0 + depth * (noise(at, wave, seed) + 0.6 * noise(at, wave / 3.0, seed + 1));
    color.map(|v| v * shade)
}

/// Dark and lighter leaves, and holes between them.
fn ground() -> Sprite {
    Sprite::painted(|at| {
        let leaf = noise(at, 45.0, 1) + 0.5 * noise(at, 18.0, 2);
        let color = if leaf > 0.25 { [0.35, 0.45, 0.22] } else { [0.16, 0.24, 0.12] };
        Some(shaded(color, at, 7.0, 0.18, 3))
    })
}

/// Grass in the sun.
fn meadow() -> Sprite {
    Sprite::painted(|at| {
        let light = 0.5 + 0.5 * noise(at, 60.0, 11);
        Some(shaded([0.42 + 0.25 * light, 0.55 + 0.2 * light, 0.25], at, 8.0, 0.15, 12))
    })
}

/// Bright sky with a cloud.
fn sky() -> Sprite {
    Sprite::painted(|at| {
        let cloud = (0.5 + 0.5 * noise(at, 150.0, 21)).clamp(0.0, 1.0);
        Some([0.68 + 0.27 * cloud, 0.82 + 0.14 * cloud, 0.96])
    })
}

/// A wall, a shelf, and coloured backs of books.
fn room() -> Sprite {
    Sprite::painted(|at| {
        let book = (at[0] / 46.0).floor() as i32;
        let color = [hash(book, 1, 31), hash(book, 2, 31), hash(book, 3, 31)].map(|v| 0.25 + 0.45 * v);
        Some(shaded(if at[1] > -40.0 { color } else { [0.72, 0.68, 0.6] }, at, 12.0, 0.06, 32))
    })
}

/// An animal's back, with hairs along its outline.
fn fur() -> Sprite {
    let outline = |x: f32| 20.0 * (x / 90.0).sin() - 5.0;
    let color = |x: f32, y: f32, seed| shaded([0.5, 0.34, 0.2], [x * 3.0, y], 14.0, 0.35, seed);
    let mut sprite = Sprite::painted(|[x, y]| (y > outline(x)).then(|| color(x, y, 41)));
    for i in -230..230 {
        let random = |seed: u32| hash(i, 0, seed);
        let x = i as f32 * 1.5;
        let (length, lean) = (14.0 + 26.0 * random(42), 10.0 * (random(43) - 0.3));
        let bend = 10.0 * (random(44) - 0.5);
        let at = |t: f32| [x + lean * t + bend * t * t, outline(x) + 6.0 - length * t];
        let way: Vec<[f32; 2]> = (0..=6).map(|n| at(n as f32 / 6.0)).collect();
        sprite.stroke(&way, [2.4, 0.7], color(x, random(45) * 300.0, 46));
    }
    sprite
}

/// An ear of short soft hair, hardly darker than what is behind it.
fn ear() -> Sprite {
    let inside = |[x, y]: [f32; 2]| ((x + 30.0) / 120.0).powi(2) + ((y - 120.0) / 190.0).powi(2) - 1.0;
    let color = |at: [f32; 2]| shaded([0.36, 0.3, 0.26], at, 10.0, 0.2, 51);
    let mut sprite = Sprite::painted(|at| (inside(at) < 0.0).then(|| color(at)));
    for i in 0..900 {
        let random = |seed: u32| hash(i, 1, seed);
        let angle = i as f32 * std::f32::consts::TAU / 900.0;
        let root = [-30.0 + 119.0 * angle.cos(), 120.0 + 189.0 * angle.sin()];
        let to = angle + 1.2 * (random(52) - 0.3);
        let length = 4.0 + 9.0 * random(53);
        let tip = [root[0] + length * to.cos(), root[1] + length * to.sin()];
        sprite.stroke(&[root, tip], [1.8, 0.6], color([root[0], random(54) * 200.0]));
    }
    sprite
}

/// A flower's head on a stem, and thinner stems beside it, which a coarse map does not know of.
fn stems() -> Sprite {
    let color = |at: [f32; 2]| shaded([0.62, 0.3, 0.6], at, 12.0, 0.25, 61);
    let head = |[x, y]: [f32; 2]| (x + 40.0).hypot(y + 100.0) < 60.0 + 8.0 * ((y + 100.0).atan2(x + 40.0) * 9.0).sin();
    let mut sprite = Sprite::painted(|at| head(at).then(|| color(at)));
    for (x, lean, width) in [(-40.0, 30.0, 13.0), (60.0, -50.0, 7.0), (110.0, 10.0, 4.0), (-120.0, -20.0, 9.0)] {
        let at = |t: f32| [x + lean * t * t, -60.0 + 420.0 * t - if width < 13.0 { 200.0 } else { 0.0 }];
        let way: Vec<[f32; 2]> = (0..=12).map(|n| at(n as f32 / 12.0)).collect();
        sprite.stroke(&way, [width, width * 1.2], [0.55, 0.66, 0.3]);
    }
    sprite
}

/// Pointed petals around a brown middle.
fn petals() -> Sprite {
    Sprite::painted(|[x, y]| {
        let (x, y) = (x + 150.0, y - 150.0);
        let (angle, r) = (y.atan2(x), x.hypot(y));
        let petal = (angle * 22.0 / std::f32::consts::TAU).rem_euclid(1.0) - 0.5;
        let number = (angle * 22.0 / std::f32::consts::TAU).floor() as i32;
        let length = 215.0 + 50.0 * hash(number, 7, 71);
        let width = 0.48 * (1.0 - ((r - 100.0) / (length - 100.0)).clamp(0.0, 1.0).powi(2));
        if r < 90.0 {
            return Some(shaded([0.35, 0.22, 0.12], [x, y], 6.0, 0.4, 72));
        }
        let shade = 0.92 + 0.16 * hash(number, 8, 73) - 0.25 * petal.abs();
        (petal.abs() < width && r < length).then(|| shaded([0.95 * shade, 0.72 * shade, 0.1], [x, y], 10.0, 0.08, 74))
    })
}

/// Dark branches that become twigs.
fn branches() -> Sprite {
    let mut sprite = Sprite::painted(|_| None);
    for (n, (x, y, angle)) in
        [(-350.0, 90.0, -0.25), (-60.0, 350.0, -1.5), (350.0, 160.0, -2.9)].into_iter().enumerate()
    {
        branch(&mut sprite, [x, y], angle, 26.0, n as i32 * 100);
    }
    sprite
}

fn branch(sprite: &mut Sprite, from: [f32; 2], angle: f32, width: f32, seed: i32) {
    if width < 1.6 {
        return;
    }
    let bend = 0.5 * (hash(seed, 1, 81) - 0.5);
    let length = 30.0 + 6.0 * width;
    let mut way = vec![from];
    for n in 1..=6 {
        let to = angle + bend * n as f32 / 6.0;
        let [x, y] = way[n - 1];
        way.push([x + length / 6.0 * to.cos(), y + length / 6.0 * to.sin()]);
    }
    sprite.stroke(&way, [width, 0.8 * width], [0.16, 0.13, 0.11]);
    let end = way[6];
    branch(sprite, end, angle + bend + 0.25, 0.72 * width, seed * 3 + 1);
    branch(sprite, end, angle + bend - 0.5, 0.5 * width, seed * 3 + 2);
    branch(sprite, way[3], angle + 0.8, 0.4 * width, seed * 3 + 3);
}

/// A toothed leaf over leaves of nearly its colour.
fn leaf() -> Sprite {
    Sprite::painted(|[x, y]| {
        let tooth = 10.0 * ((x + 0.3 * y) / 18.0).rem_euclid(1.0);
        (y > 20.0 + 0.3 * x + tooth).then(|| shaded([0.3, 0.4, 0.2], [x, y], 14.0, 0.2, 91))
    })
}

/// A printed board with a straight edge.
fn board() -> Sprite {
    Sprite::painted(|[x, y]| {
        let print = ((x + y) / 22.0).floor() as i32;
        let color = if print.rem_euclid(3) == 0 { [0.75, 0.2, 0.2] } else { [0.85, 0.83, 0.78] };
        (x < 10.0 + 0.2 * y).then(|| shaded(color, [x, y], 5.0, 0.05, 95))
    })
}
