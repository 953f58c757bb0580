//! Scenes in three dimensions: light fields with the exact depth of every ray, and what a near thing hides truly hidden.
//!
//! [`make`] draws a scene by chance: a place (`inside`, `outside`) furnished with meshes and textures of a data
//! folder ([`stock`]), photos and shapes made by rule (`set`, `shapes`), a camera before it (`shot`), light
//! ([`light`]). Each view is drawn from its own centre by a small rasteriser ([`view`]) and lit (`eye`); [`picture`] makes
//! a photo of it.
//! It runs on one core without a graphics card, and the same seed gives the same bytes.

mod blossoms;
mod coats;
mod dapple;
mod eye;
mod glb;
mod inside;
mod land;
pub mod light;
pub mod mesh;
mod near;
mod outside;
mod patterns;
pub mod picture;
mod pitfalls;
mod set;
mod shadows;
mod shapes;
mod shot;
pub mod stock;
pub mod texture;
pub mod view;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use glam::{Vec2, Vec3};

use self::eye::Eye;
use self::light::Shading;
use self::mesh::World;
use self::picture::Shutter;
use self::set::Set;
use self::shot::{Framing, Shot};
pub use self::stock::Stock;
pub use self::view::Curve;
use self::view::{Buffer, Camera, Frame, Lens, SUB};
use super::raster::{Raster, Rgb};
use super::{Picture, steps};
use crate::eval::metrics::{percentiles, spearman};
use crate::rng::Rng;

/// What a scene is made of and how it is seen.
pub struct Order<'a> {
    /// Meshes and textures.
    pub stock: &'a Stock,
    /// Photos for walls and people.
    pub photos: &'a [Picture],
    /// Those of them that have a mask.
    pub masked: &'a [usize],
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Layers of the views, the reference view first.
    pub views: &'a [usize],
    /// What disparity is linear in.
    pub curve: Curve,
    /// Pixels per view step between the 2nd and the 98th percentile of nearness.
    pub range_px: f32,
    /// Where between them the focal plane lies.
    pub focus: f32,
    /// Noise of the camera, and JPEG.
    pub noise: bool,
    /// Share of scenes that show what nets read wrongly.
    pub pitfalls: f32,
}

/// A scene's views.
pub struct Made {
    /// Pictures, sRGB 0 … 1, in the order's order of views.
    pub pictures: Vec<Rgb>,
    /// Ray depths, pixels per view step.
    pub disparities: Vec<Vec<f32>>,
    /// The camera.
    pub camera: Camera,
    /// Scale and zero of the ray depths.
    pub lens: Lens,
    /// Room, street …
    pub kind: &'static str,
}

/// Ray depths beyond the usual range, as a multiple of it.
const MOST_BEYOND: f32 = 2.2;
/// How often a scene that shows nothing is drawn anew.
const TRIES: u64 = 8;
/// So many things, walls and floors too, must be seen of a scene.
const LEAST_SHOWN: usize = 4;
/// Scenes in which the row number tells more than this are mostly drawn anew: photos teach that already.
const TOLD_BY_ROW: f32 = 0.93;

/// Draws scene `index` of a seed.
pub fn make(order: &Order, seed: u64, index: u64) -> Made {
    let mut attempt = 0;
    loop {
        let rng = Rng::new(seed ^ ((0x501d << 8) | attempt), index);
        let (mut world, shot, mut rng) = scene(order, rng);
        let frame = Frame::new(&mut world, &shot.camera, order.size, order.curve);
        let mut buffer = Buffer::default();
        // The reference view is the same whatever the lens.
        frame.draw(&world, Lens { scale_px: 1.0, focus: 0.0 }, Vec2::ZERO, &mut buffer);
        let nears = Nears::of(&buffer, order.curve);
        attempt += 1;
        // The last try is taken as it is.
        if attempt == TRIES
            || nears.is_worth(&mut rng, shot.kind) && (is_told(&world, &buffer, shot.kind) || rng.chance(0.2))
        {
            return draw(order, &world, &shot, &frame, buffer, &nears, rng);
        }
    }
}

/// A place, furnished, and a camera before it.
fn scene<'a>(order: &Order<'a>, rng: Rng) -> (World, Shot, Rng) {
    let Order { stock, photos, masked, size, .. } = *order;
    let mut set = Set { rng, stock, photos, masked, world: World::default() };
    let framing = Framing::random(&mut set, size);
    if order.pitfalls > 0.0 && set.chance(order.pitfalls) {
        let shot = set.pitfall(&framing);
        return (set.world, shot, set.rng);
    }
    let shot = match set.rng.weighted(&[0.24, 0.17, 0.13, 0.1, 0.05, 0.08, 0.09, 0.06, 0.08]) {
        0 => set.room(&framing),
        1 => set.table_top(&framing),
        2 => set.shelves(&framing),
        3 => set.product(&framing),
        4 => set.stairs(&framing),
        5 => set.close_up(&framing),
        6 => set.street(&framing),
        7 => set.facade(&framing),
        _ => set.garden(&framing),
    };
    if set.chance(0.2) {
        let free = nearest(&set.world, &shot.camera, size);
        set.before(&shot.camera, &framing, free);
    }
    (set.world, shot, set.rng)
}

/// About how far the nearest things in the picture are away.
fn nearest(world: &World, camera: &Camera, size: [usize; 2]) -> f32 {
    let inside = |corner: &mesh::Corner| {
        let from = corner.at - camera.eye;
        let z = from.dot(camera.axes[2]);
        let half = [0, 1].map(|i| size[i] as f32 / 2.0 / camera.focal_px * z);
        (z > 0.1 && from.dot(camera.axes[0]).abs() < half[0] && from.dot(camera.axes[1]).abs() < half[1]).then_some(z)
    };
    let mut depths: Vec<f32> = world.corners.iter().filter_map(inside).collect();
    if depths.is_empty() {
        return 2.0;
    }
    let at = depths.len() / 20;
    *depths.select_nth_unstable_by(at, f32::total_cmp).1
}

/// Whether a picture tells its depth: it shows several things, and none of them fills it, as a wall right before the
/// lens does. Bare tops, walls of patterns, wide land and ground with shadows may show less.
fn is_told(world: &World, buffer: &Buffer, kind: &str) -> bool {
    if [pitfalls::BARE_TOP, patterns::PATTERN, land::LANDSCAPE, shadows::LOW_SUN].contains(&kind) {
        return true;
    }
    let [w, h] = buffer.size;
    let mut shown = BTreeMap::new();
    for y in (0..h).step_by(h.div_ceil(24)) {
        for x in (0..w).step_by(w.div_ceil(32)) {
            let thing = world.parts.get(buffer.face[y * w + x] as usize).map(|part| part.thing);
            *shown.entry(thing).or_insert(0) += 1;
        }
    }
    let places: usize = shown.values().sum();
    let most = shown.values().copied().max().unwrap_or(0);
    most * 4 < places * 3 && shown.values().filter(|&&count| count * 150 > places).count() >= LEAST_SHOWN
}

/// Nearness of the reference view's pixels.
struct Nears {
    /// `[y, x]` of every pixel, the upper left sample's.
    map: Raster<f32>,
    /// 2 % of the pixels are farther than the first, half than the second, 65 and 98 % than the others.
    levels: [f32; 4],
    /// Share of the picture that is sky.
    sky: f32,
    /// Least and most of all samples.
    ends: [f32; 2],
    curve: Curve,
}

impl Nears {
    fn of(buffer: &Buffer, curve: Curve) -> Self {
        let size = buffer.size.map(|side| side / SUB);
        let farthest = curve.of(0.0);
        let map = Raster::from_fn(size, |x, y| buffer.near[y * SUB * buffer.size[0] + x * SUB].max(farthest));
        let levels = percentiles(&mut map.px.clone(), [0.02, 0.5, 0.65, 0.98]);
        let sky = map.px.iter().filter(|&&near| near <= farthest).count() as f32 / map.px.len() as f32;
        let samples = buffer.near.iter().map(|near| near.max(farthest));
        let ends = samples.fold([f32::MAX, f32::MIN], |[lo, hi], near| [lo.min(near), hi.max(near)]);
        Self { map, levels, sky, ends, curve }
    }

    /// That of a place about the middle of the picture.
    fn somewhere(&self, rng: &mut Rng) -> f32 {
        let [x, y] = self.map.size.map(|side| (side as f32 * rng.range(0.2, 0.8)) as usize);
        self.map.at(x, y)
    }

    fn inverse(&self, near: f32) -> f32 {
        match self.curve {
            Curve::Camera => near,
            Curve::Relief => near.exp() - 1.0 / 80.0,
        }
    }

    /// Whether there is enough depth in a scene, not all of it sky or right before the lens, and whether it tells more
    /// than that lower is nearer; of a bare top and of ground with shadows there is no more to tell, wide land is mostly
    /// far away, and behind a ledge everything is.
    fn is_worth(&self, rng: &mut Rng, kind: &str) -> bool {
        let [far, middle, upper, near] = self.levels.map(|level| self.inverse(level));
        let is_wide = kind == land::LANDSCAPE;
        let may_be_plain = kind == pitfalls::BARE_TOP || kind == shadows::LOW_SUN;
        let has_gap = kind == near::LEDGE || kind == near::HANGING;
        if near < 1.2 * far
            || near < 1e-3
            || self.sky > if is_wide { 0.75 } else { 0.6 }
            || middle > 9.0
            || (!is_wide && !has_gap && upper > 5.0 * middle.max(1e-3))
        {
            return false;
        }
        let [w, h] = self.map.size;
        let places: Vec<[usize; 2]> =
            (0..h).step_by(h.div_ceil(20)).flat_map(|y| (0..w).step_by(w.div_ceil(24)).map(move |x| [x, y])).collect();
        let values: Vec<f32> = places.iter().map(|&[x, y]| self.map.at(x, y)).collect();
        let rows: Vec<f32> = places.iter().map(|&[_, y]| y as f32).collect();
        is_wide || may_be_plain || spearman(&values, &rows) < TOLD_BY_ROW || rng.chance(0.35)
    }

    fn lens(&self, order: &Order) -> Lens {
        let ([far, .., near], [least, most]) = (self.levels, self.ends);
        // What stands right before the lens or is seen through a chink must not leave the range that nets can tell.
        let range = (near - far).max((most - far) / MOST_BEYOND).max((near - least) / MOST_BEYOND).max(1e-6);
        Lens { scale_px: order.range_px / range, focus: far + order.focus * (near - far) }
    }

    /// A ball about most of what is seen.
    fn ball(&self, camera: &Camera) -> (Vec3, f32) {
        let [w, h] = self.map.size;
        let deepest = 3.5 / self.inverse(self.levels[1]).max(0.02);
        let mut places = Vec::new();
        for y in (0..h).step_by(h.div_ceil(12)) {
            for x in (0..w).step_by(w.div_ceil(16)) {
                let z = (1.0 / self.inverse(self.map.at(x, y)).max(1e-3)).min(deepest);
                let off = (Vec2::new(x as f32, y as f32) - camera.middle) / camera.focal_px;
                places.push(camera.eye + (camera.axes[2] + camera.axes[0] * off.x + camera.axes[1] * off.y) * z);
            }
        }
        let centre = places.iter().copied().sum::<Vec3>() / places.len().max(1) as f32;
        let radius = places.iter().map(|place| place.distance(centre)).fold(0.05, f32::max);
        (centre, radius * 1.1)
    }
}

/// Draws all views of a scene.
fn draw(order: &Order, world: &World, shot: &Shot, frame: &Frame, first: Buffer, nears: &Nears, mut rng: Rng) -> Made {
    let lens = nears.lens(order);
    let [far, .., near] = nears.levels;
    let (centre, radius) = nears.ball(&shot.camera);
    let eye = Eye {
        world,
        shot,
        frame,
        lens,
        shading: Shading::new(world, shot.lights, centre, radius),
        sky_near: order.curve.of(0.0),
        gap: 0.05 * (near - far),
    };
    let mut buffer = first;
    let (mut lights, mut disparities) = (Vec::new(), Vec::new());
    for &layer in order.views {
        let step = Vec2::from(steps(layer));
        if step != Vec2::ZERO {
            frame.draw(world, lens, step, &mut buffer);
        }
        let (light, near) = eye.resolve(&buffer, step);
        lights.push(light);
        disparities.push(near.into_iter().map(|near| lens.disparity(near)).collect::<Vec<f32>>());
    }
    let mean = lights[0].px.iter().map(|t| t[1].min(4.0)).sum::<f32>() / lights[0].px.len() as f32;
    let in_focus = lens.disparity(nears.somewhere(&mut rng));
    let shutter = if order.noise { Shutter::random(&mut rng, mean, in_focus) } else { Shutter::plain(mean) };
    let pictures =
        lights.into_iter().zip(&disparities).map(|(light, map)| shutter.take(&mut rng, light, map)).collect();
    Made { pictures, disparities, camera: shot.camera, lens, kind: shot.kind }
}
