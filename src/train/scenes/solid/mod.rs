//! Scenes in three dimensions: light fields with the exact depth of every ray, and what a near thing hides truly hidden.
//!
//! [`make`] draws a scene by chance: a place (`inside`, `outside`) furnished with meshes and textures of a data
//! folder ([`stock`]), photos and shapes made by rule (`set`, `shapes`), a camera before it (`shot`), light
//! ([`light`]). Each view is drawn from its own centre by a small rasteriser ([`view`]); [`picture`] makes a photo of it.
//! It runs on one core without a graphics card, and the same seed gives the same bytes.

mod blossoms;
mod coats;
mod dapple;
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

use self::light::{Shading, Surface};
use self::mesh::World;
use self::picture::Shutter;
use self::set::Set;
use self::shot::{Framing, Shot, Sky};
pub use self::stock::Stock;
pub use self::view::Curve;
use self::view::{Buffer, Camera, Frame, Lens, NOTHING, SUB, Shares, mixed, straight};
use super::raster::{Raster, Rgb};
use super::{Picture, steps};
use crate::eval::metrics::spearman;
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
            || nears.is_worth(&mut rng, order, shot.kind) && (is_told(&world, &buffer, shot.kind) || rng.chance(0.2))
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
    sorted: Vec<f32>,
    /// Least and most of all samples.
    ends: [f32; 2],
    curve: Curve,
}

impl Nears {
    fn of(buffer: &Buffer, curve: Curve) -> Self {
        let size = buffer.size.map(|side| side / SUB);
        let sky = curve.of(0.0);
        let map = Raster::from_fn(size, |x, y| buffer.near[y * SUB * buffer.size[0] + x * SUB].max(sky));
        let mut sorted = map.px.clone();
        sorted.sort_unstable_by(f32::total_cmp);
        let samples = buffer.near.iter().map(|near| near.max(sky));
        let ends = samples.fold([f32::MAX, f32::MIN], |[lo, hi], near| [lo.min(near), hi.max(near)]);
        Self { map, sorted, ends, curve }
    }

    fn percentile(&self, share: f32) -> f32 {
        self.sorted[((self.sorted.len() - 1) as f32 * share) as usize]
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
    fn is_worth(&self, rng: &mut Rng, order: &Order, kind: &str) -> bool {
        let [far, middle, near] = [0.02, 0.5, 0.98].map(|share| self.inverse(self.percentile(share)));
        let sky = self.sorted.partition_point(|&n| n <= order.curve.of(0.0)) as f32 / self.sorted.len() as f32;
        let is_wide = kind == land::LANDSCAPE;
        let may_be_plain = kind == pitfalls::BARE_TOP || kind == shadows::LOW_SUN;
        let has_gap = kind == near::LEDGE || kind == near::HANGING;
        if near < 1.2 * far
            || near < 1e-3
            || sky > if is_wide { 0.75 } else { 0.6 }
            || middle > 9.0
            || (!is_wide && !has_gap && self.inverse(self.percentile(0.65)) > 5.0 * middle.max(1e-3))
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
        let ([far, near], [least, most]) = ([0.02, 0.98].map(|share| self.percentile(share)), self.ends);
        // What stands right before the lens or is seen through a chink must not leave the range that nets can tell.
        let range = (near - far).max((most - far) / MOST_BEYOND).max((near - least) / MOST_BEYOND).max(1e-6);
        Lens { scale_px: order.range_px / range, focus: far + order.focus * (near - far) }
    }

    /// A ball about most of what is seen.
    fn ball(&self, camera: &Camera) -> (Vec3, f32) {
        let [w, h] = self.map.size;
        let deepest = 3.5 / self.inverse(self.percentile(0.5)).max(0.02);
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
    let (centre, radius) = nears.ball(&shot.camera);
    let eye = Eye {
        world,
        shot,
        frame,
        lens,
        shading: Shading::new(world, shot.lights, centre, radius),
        sky_near: order.curve.of(0.0),
        gap: 0.05 * (nears.percentile(0.98) - nears.percentile(0.02)),
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

/// What is needed to tell the light of a view's pixels.
struct Eye<'a> {
    world: &'a World,
    shot: &'a Shot,
    frame: &'a Frame,
    lens: Lens,
    shading: Shading,
    sky_near: f32,
    /// Samples of a pixel that lie further apart in nearness than this belong to two surfaces.
    gap: f32,
}

impl Eye<'_> {
    /// Light and nearness of a view's pixels. A pixel on an edge of depth shows both sides, and has the depth of the one
    /// that covers more of it, of the nearer one where they are equal.
    fn resolve(&self, buffer: &Buffer, step: Vec2) -> (Raster<[f32; 3]>, Vec<f32>) {
        let [w, h] = self.frame.size;
        let wide = buffer.size[0];
        let (mut light, mut nears) = (Vec::with_capacity(w * h), Vec::with_capacity(w * h));
        for y in 0..h {
            for x in 0..w {
                let first = y * SUB * wide + x * SUB;
                let places = [first, first + 1, first + wide, first + wide + 1];
                let faces = places.map(|i| buffer.face[i]);
                let mut near = places.map(|i| buffer.near[i].max(self.sky_near));
                light.push(self.pixel([x, y], faces, near, step).to_array());
                near.sort_unstable_by(f32::total_cmp);
                nears.push(self.depth_of(near));
            }
        }
        (Raster { size: [w, h], px: light }, nears)
    }

    /// Nearness of a pixel, from its samples in order: 1/z is linear in the picture, so the mean of four about the
    /// middle of one surface is exact.
    fn depth_of(&self, near: [f32; 4]) -> f32 {
        let steps = [near[1] - near[0], near[2] - near[1], near[3] - near[2]];
        let widest = if steps[1] >= steps[0] && steps[1] >= steps[2] {
            1
        } else if steps[0] >= steps[2] {
            0
        } else {
            2
        };
        if steps[widest] <= self.gap {
            return (near[0] + near[1] + near[2] + near[3]) / 4.0;
        }
        match widest {
            0 => (near[1] + near[2] + near[3]) / 3.0,
            1 => (near[2] + near[3]) / 2.0,
            _ => (near[0] + near[1] + near[2]) / 3.0,
        }
    }

    fn pixel(&self, [x, y]: [usize; 2], faces: [u32; 4], near: [f32; 4], step: Vec2) -> Vec3 {
        let thing = |face: u32| if face == NOTHING { NOTHING } else { self.world.parts[face as usize].thing };
        let spread = |near: [f32; 4]| {
            near.iter().fold(f32::MIN, |a, &b| a.max(b)) - near.iter().fold(f32::MAX, |a, &b| a.min(b))
        };
        let middle = Vec2::new((x * SUB) as f32 + 0.5, (y * SUB) as f32 + 0.5);
        let one = faces.iter().all(|&face| face == faces[0])
            || (faces.iter().all(|&face| thing(face) == thing(faces[0])) && spread(near) < self.gap);
        if one {
            return self.light(faces[0], middle, step);
        }
        let mut sum = Vec3::ZERO;
        for i in 0..4 {
            // Once for samples of one face.
            if faces[..i].contains(&faces[i]) {
                continue;
            }
            let count = faces.iter().filter(|&&face| face == faces[i]).count();
            let off = Vec2::new((i % 2) as f32, (i / 2) as f32) - 0.5;
            sum += self.light(faces[i], middle + off, step) * count as f32;
        }
        sum / 4.0
    }

    /// Light of a face at a sample's place.
    fn light(&self, face: u32, at: Vec2, step: Vec2) -> Vec3 {
        let pixel = (at - 0.5) / SUB as f32;
        let Some(part) = self.world.parts.get(face as usize) else { return self.sky(pixel, step) };
        let corners = self.frame.corners(part.corners, self.lens, step);
        let Some(shares) = Shares::new(corners) else { return Vec3::ZERO };
        let inverse = part.corners.map(|i| self.frame.seen[i as usize].inverse);
        let there = |x: f32, y: f32| straight(shares.at(x, y).map(|s| s.clamp(-0.5, 1.5)), inverse);
        let share = there(at.x, at.y);
        let [a, b, c] = self.world.corners_of(part);
        let place = mixed([a.at, b.at, c.at], share);
        let mut colour = Vec3::from(part.tint);
        if let Some(skin) = self.world.skin_of(part) {
            let uv = |share| mixed([a.uv, b.uv, c.uv], share);
            let own = uv(share);
            let across = (uv(there(at.x + SUB as f32, at.y)) - own).length();
            let along = (uv(there(at.x, at.y + SUB as f32)) - own).length();
            let [red, green, blue, _] = skin.light(own.x, own.y, 0.5 * (across + along));
            colour *= Vec3::new(red, green, blue);
        }
        let to_eye = self.shot.camera.eye - place;
        let distance = to_eye.length().max(1e-6);
        let to_eye = to_eye / distance;
        let flat = (b.at - a.at).cross(c.at - a.at).normalize_or(Vec3::Y);
        let smooth = mixed([a.normal, b.normal, c.normal], share).normalize_or(flat);
        // Corners whose faces meet at a sharp edge have no normal in common.
        let normal = if smooth.dot(flat).abs() > 0.7 { smooth } else { flat };
        let normal = if flat.dot(to_eye) * flat.dot(normal) < 0.0 { -normal } else { normal };
        self.shading.shade(&Surface { at: place, normal, colour, gloss: part.gloss }, to_eye, distance)
    }

    fn sky(&self, pixel: Vec2, step: Vec2) -> Vec3 {
        let place = pixel + step * self.lens.disparity(self.sky_near);
        let [w, h] = self.frame.size.map(|side| side as f32);
        let [s, t] = [(place.x / w).clamp(0.0, 1.0), (place.y / h).clamp(0.0, 1.0)];
        match &self.shot.sky {
            Sky::Fade(high, low) => high.lerp(*low, t),
            Sky::Picture(texture, corner, size) => {
                let [red, green, blue, _] = texture.light(corner.x + s * size.x, corner.y + t * size.y, size.x / w);
                Vec3::new(red, green, blue) * 1.2
            }
        }
    }
}
