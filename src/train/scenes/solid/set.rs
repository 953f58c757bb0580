//! The hands that furnish a scene: paints, things, and what is made by rule.

use std::f32::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

use glam::{Affine3A, Quat, Vec2, Vec3};

use super::mesh::{Mesh, Paint, World};
use super::shapes::{any_way, cuboid, hanging, lathe, leaves, round_leaves, sheet, slab, stem, together, tube};
use super::stock::{Prop, Stock};
use super::texture::{Texture, to_linear};
use crate::rng::Rng;
use crate::scenes::Picture;
use crate::scenes::raster::Raster;

/// Small things that stand about.
pub const CLUTTER: [&str; 6] = ["tableware", "food", "tool", "toy", "plant", "other"];

/// Textures that a plain colour may be taken from.
const COLOURED: [&str; 8] = ["backdrop", "fabric", "floor", "grass", "other", "stone", "wall", "wood"];

/// A scene in the making.
pub struct Set<'a> {
    /// Chance.
    pub rng: Rng,
    /// Meshes and textures.
    pub stock: &'a Stock,
    /// Photos, to hang on walls and to cut people out of.
    pub photos: &'a [Picture],
    /// Those of them that have a mask.
    pub masked: &'a [usize],
    /// What has been put up.
    pub world: World,
}

/// Where a thing stands: its foot, turned about the upright, then leant.
pub fn stand(at: Vec3, yaw: f32, scale: f32) -> Affine3A {
    Affine3A::from_scale_rotation_translation(Vec3::splat(scale), Quat::from_rotation_y(yaw), at)
}

impl<'a> Set<'a> {
    /// A number between two.
    pub fn range(&mut self, lo: f32, hi: f32) -> f32 {
        self.rng.range(lo, hi)
    }

    /// A whole number between two, both included.
    pub fn count(&mut self, lo: usize, hi: usize) -> usize {
        lo + self.rng.below(hi - lo + 1)
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f32) -> bool {
        self.rng.chance(probability)
    }

    /// Any direction about the upright.
    pub fn turn(&mut self) -> f32 {
        self.rng.range(0.0, TAU)
    }

    /// A quarter turn, not quite.
    pub fn quarter(&mut self) -> f32 {
        self.rng.below(4) as f32 * FRAC_PI_2 + self.rng.range(-0.08, 0.08)
    }

    /// A colour: mostly a pixel of a photo or else of a texture, so that colours are those of the world; else anything.
    pub fn colour(&mut self) -> [f32; 3] {
        let (stock, photos) = (self.stock, self.photos);
        if !self.rng.chance(0.2) {
            if !photos.is_empty() {
                let photo = &photos[self.rng.below(photos.len())].rgb;
                return photo.px[self.rng.below(photo.px.len())].map(|c| to_linear(f32::from(c) / 255.0));
            }
            if let Some(cloth) = stock.cloth(&mut self.rng, &COLOURED) {
                let [red, green, blue, _] = cloth.texture.light(self.rng.unit(), self.rng.unit(), 0.1);
                return [red, green, blue];
            }
        }
        [0; 3].map(|_: i32| to_linear(self.rng.range(0.05, 0.95)))
    }

    /// One colour.
    pub fn plain(&mut self) -> Paint {
        let gloss = if self.chance(0.3) { self.range(0.1, 0.8) } else { 0.0 };
        Paint { tint: self.colour(), skin: None, metres: Vec2::ONE, gloss }
    }

    /// A texture of one of these kinds, its picture about this large; sometimes of another hue.
    pub fn cloth(&mut self, kinds: &[&str], metres: f32) -> Paint {
        let stock = self.stock;
        let Some(cloth) = stock.cloth(&mut self.rng, kinds) else { return self.speckled(metres) };
        let metres = metres * self.range(0.6, 1.7);
        let hue = if self.chance(0.3) { self.colour() } else { [0.8; 3] };
        let light = self.range(0.6, 1.2) / hue.iter().copied().fold(0.05, f32::max);
        let gloss = if self.chance(0.25) { self.range(0.05, 0.6) } else { 0.0 };
        let tint = hue.map(|c| (0.35 + 0.65 * c * light).min(1.3));
        Paint {
            tint,
            skin: Some(cloth.texture.clone()),
            metres: Vec2::new(metres, metres / cloth.texture.aspect()),
            gloss,
        }
    }

    /// Two colours in spots: for folders without textures, and hearts of flowers.
    pub(super) fn speckled(&mut self, metres: f32) -> Paint {
        let [a, b] = [self.rng.range(60.0, 250.0), self.rng.range(60.0, 250.0)];
        let rng = &mut self.rng;
        let mut spots = Raster::from_fn([32, 32], |_, _| [rng.unit()]);
        spots.blur(1.2);
        let picture = spots.map(|s| [(a + (b - a) * ((s[0] - 0.5) * 4.0 + 0.5).clamp(0.0, 1.0)) as u8; 3]);
        let skin = Some(Arc::new(Texture::opaque(&picture)));
        Paint { tint: self.colour().map(|c| 0.3 + 0.7 * c), skin, metres: Vec2::splat(metres), gloss: 0.0 }
    }

    /// Whatever walls, floors and boxes may be painted with.
    pub fn any_paint(&mut self, metres: f32) -> Paint {
        match self.rng.weighted(&[0.45, 0.25, 0.15, 0.15]) {
            0 => self.cloth(&["wood", "fabric", "metal", "stone", "other", "wall", "floor"], metres),
            1 => self.plain(),
            2 => self.photo().0,
            _ => self.print(),
        }
    }

    /// A photo of one metre's width; and its width over its height.
    pub fn photo(&mut self) -> (Paint, f32) {
        if self.photos.is_empty() {
            return (self.speckled(1.0), 1.0);
        }
        let picture = &self.photos[self.rng.below(self.photos.len())].rgb;
        let texture = Texture::opaque(picture);
        let aspect = texture.aspect();
        let metres = Vec2::new(1.0, 1.0 / aspect);
        (Paint { tint: [0.9; 3], skin: Some(Arc::new(texture)), metres, gloss: 0.0 }, aspect)
    }

    /// A page of print: lines of strokes, some larger, sometimes a picture; 1 m wide, 1.4 m high.
    pub fn print(&mut self) -> Paint {
        let size = [60, 84];
        let ink = self.rng.range(0.0, 110.0);
        let paper = self.rng.range(170.0, 255.0);
        let mut page = Raster { size, px: vec![[paper as u8; 3]; size[0] * size[1]] };
        let mut y = 4 + self.rng.below(4);
        while y + 4 < size[1] {
            let tall = if self.rng.chance(0.15) { 4 } else { 1 + self.rng.below(2) };
            let end = if self.rng.chance(0.2) { 6 + self.rng.below(48) } else { 56 };
            let mut x = 4;
            while x < end {
                let letter = 1 + self.rng.below(tall + 1);
                if !self.rng.chance(0.22) {
                    for j in y..(y + tall + 1).min(size[1]) {
                        let dark = ink + self.rng.range(0.0, 50.0);
                        (x..(x + letter).min(56)).for_each(|i| page.px[j * size[0] + i] = [dark as u8; 3]);
                    }
                }
                x += letter + 1;
            }
            y += tall + 2 + self.rng.below(2);
        }
        let tint = if self.chance(0.7) { [0.9; 3] } else { self.colour().map(|c| 0.2 + 0.8 * c) };
        Paint { tint, skin: Some(Arc::new(Texture::opaque(&page))), metres: Vec2::new(1.0, 1.4), gloss: 0.0 }
    }

    /// Puts a painted mesh up.
    pub fn put(&mut self, mesh: &Mesh, place: Affine3A, paint: &Paint) {
        self.world.add(mesh, place, Some(paint), true);
    }

    /// A flat piece from a corner along two edges. With `fitted`, the paint's picture covers it once.
    pub fn panel(&mut self, corner: Vec3, along: Vec3, up: Vec3, paint: &Paint, [fitted, casts]: [bool; 2]) {
        let metres = if fitted { Vec2::new(along.length(), up.length()) } else { paint.metres };
        let paint = Paint { metres, ..paint.clone() };
        self.world.add(&slab(corner, along, up, [1, 1]), Affine3A::IDENTITY, Some(&paint), casts);
    }

    /// A box that stands on a place.
    pub fn block(&mut self, at: Vec3, size: Vec3, yaw: f32, paint: &Paint) {
        self.put(&cuboid(size), stand(at, yaw, 1.0), paint);
    }

    /// A thing of one of these kinds on a place, its longest side as given or its own; tells its size.
    pub fn thing(&mut self, kinds: &[&str], at: Vec3, longest: Option<f32>) -> Option<Vec3> {
        let yaw = self.turn();
        self.turned(kinds, at, longest, yaw)
    }

    /// The same, turned as told.
    pub fn turned(&mut self, kinds: &[&str], at: Vec3, longest: Option<f32>, yaw: f32) -> Option<Vec3> {
        let stock = self.stock;
        let prop = stock.prop(&mut self.rng, kinds)?;
        let scale = longest.map_or(1.0, |longest| longest / prop.size.max_element());
        Some(self.set_up(prop, stand(at, yaw, scale)) * scale)
    }

    /// A thing that lies on its side.
    pub fn lying(&mut self, kinds: &[&str], at: Vec3, longest: f32) {
        let stock = self.stock;
        let Some(prop) = stock.prop(&mut self.rng, kinds) else { return };
        let scale = longest / prop.size.max_element();
        let turned = Quat::from_rotation_y(self.turn()) * Quat::from_rotation_x(FRAC_PI_2);
        let middle = Vec3::Y * (prop.size.z * scale / 2.0);
        let centred = Affine3A::from_translation(-Vec3::Y * prop.size.y / 2.0);
        let place = Affine3A::from_scale_rotation_translation(Vec3::splat(scale), turned, at + middle);
        self.set_up(prop, place * centred);
    }

    fn set_up(&mut self, prop: &Prop, place: Affine3A) -> Vec3 {
        let metres = prop.size.max_element();
        let paint = if prop.blank || self.chance(0.12) { Some(self.any_paint(metres)) } else { None };
        self.world.add(&prop.mesh, place, paint.as_ref(), true);
        prop.size
    }

    /// A small thing: mostly from a file, else a bowl, bottle, box, ball or pile of books.
    pub fn small(&mut self, at: Vec3, longest: f32) {
        match self.rng.weighted(&[0.6, 0.2, 0.08, 0.07, 0.05]) {
            0 => {
                if self.thing(&CLUTTER, at, Some(longest)).is_none() {
                    self.vessel(at, longest);
                }
            }
            1 => self.vessel(at, longest),
            2 => {
                let size = Vec3::new(self.range(0.3, 1.0), self.range(0.2, 1.0), self.range(0.3, 1.0)) * longest;
                let (paint, yaw) = (self.any_paint(longest), self.turn());
                self.block(at, size, yaw, &paint);
            }
            3 => self.books(at, longest),
            _ => self.lying(&CLUTTER, at, longest),
        }
    }

    /// A bowl, cup, bottle, vase or ball of revolution.
    pub fn vessel(&mut self, at: Vec3, tall: f32) {
        let mut radius = self.range(0.15, 0.6);
        let rows = 9;
        let swing = self.range(0.0, 0.5);
        let phase = self.turn();
        let ball = self.chance(0.2);
        let profile: Vec<[f32; 2]> = (0..=rows)
            .map(|i| {
                let t = i as f32 / rows as f32;
                radius += self.rng.range(-0.02, 0.02);
                let r = if ball { (t * (1.0 - t)).sqrt() } else { radius * (1.0 + swing * (phase + 5.0 * t).sin()) };
                [r.max(0.005) * tall, t * tall]
            })
            .collect();
        let paint = if self.chance(0.5) { self.plain() } else { self.any_paint(tall) };
        self.put(&lathe(&profile, 14), stand(at, 0.0, 1.0), &paint);
    }

    /// Books in a pile.
    pub fn books(&mut self, at: Vec3, long: f32) {
        let mut height = 0.0;
        for _ in 0..self.count(1, 6) {
            let thick = self.range(0.05, 0.2) * long;
            let size = Vec3::new(self.range(0.55, 0.8) * long, thick, self.range(0.8, 1.0) * long);
            let (paint, yaw) =
                (if self.chance(0.4) { self.print() } else { self.any_paint(long) }, self.range(-0.4, 0.4));
            self.block(at + Vec3::Y * height, size, yaw, &paint);
            height += thick;
        }
    }

    /// Books in a row from a place along x.
    pub fn row_of_books(&mut self, at: Vec3, wide: f32, tall: f32, deep: f32) {
        let mut x = 0.0;
        while x < wide {
            let thick = self.range(0.015, 0.06);
            let size = Vec3::new(thick * 0.96, self.range(0.65, 1.0) * tall, self.range(0.7, 1.0) * deep);
            let paint = if self.chance(0.6) { self.plain() } else { self.any_paint(0.2) };
            self.block(at + Vec3::new(x + thick / 2.0, 0.0, 0.0), size, 0.0, &paint);
            x += thick;
            if self.chance(0.05) {
                x += self.range(0.05, 0.3);
            }
        }
    }

    /// A picture, page or mirror-like plate on an upright face: its middle, the face's right and its normal.
    pub fn on_wall(&mut self, middle: Vec3, right: Vec3, normal: Vec3, wide: f32) {
        let (paint, aspect) = match self.rng.weighted(&[0.6, 0.25, 0.15]) {
            0 => self.photo(),
            1 => (self.print(), 1.0 / 1.4),
            _ => (self.any_paint(0.5), 0.8),
        };
        let tall = wide / aspect;
        let off = normal * 0.02;
        let corner = middle - right * (wide / 2.0) - Vec3::Y * (tall / 2.0) + off;
        self.panel(corner, right * wide, Vec3::Y * tall, &paint, [true, false]);
        if self.chance(0.5) {
            let (frame, thick) = (self.plain(), wide * self.range(0.02, 0.08));
            for (from, along, up) in [
                (corner - Vec3::Y * thick, right * wide, Vec3::Y * thick),
                (corner + Vec3::Y * tall, right * wide, Vec3::Y * thick),
                (corner - right * thick, right * thick, Vec3::Y * tall),
                (corner + right * wide, right * thick, Vec3::Y * tall),
            ] {
                self.panel(from + off, along, up, &frame, [false, false]);
            }
        }
    }

    /// A person, animal or thing cut out of a photo as an upright relief of this height; its width.
    pub fn relief(&mut self, at: Vec3, tall: f32, yaw: f32) -> Option<f32> {
        let photos = self.photos;
        if self.masked.is_empty() {
            return None;
        }
        let picture = &photos[self.masked[self.rng.below(self.masked.len())]];
        let cutout = picture.cutout()?;
        let look = cutout.subject();
        let [l, t, r, b] = cutout.bounds;
        let (w, h) = (r.saturating_sub(l), b.saturating_sub(t));
        if w < 12 || h < 12 {
            return None;
        }
        let texel = |x: usize, y: usize| {
            let [r, g, b] = look.front.at(l + x, t + y);
            [r, g, b, look.alpha.at(l + x, t + y)]
        };
        let skin = Some(Arc::new(Texture::new(Raster::from_fn([w, h], texel))));
        let wide = tall * w as f32 / h as f32;
        let deep = wide.min(tall) * self.range(0.1, 0.45);
        let mirrored = self.chance(0.5);
        let mesh = sheet([10, 12], |s, up| {
            let u = if mirrored { 1.0 - s } else { s };
            let dome = look.dome.tap(l as f32 + u * (w - 1) as f32, t as f32 + (1.0 - up) * (h - 1) as f32) / 255.0;
            (
                Vec3::new((s - 0.5) * wide, up * tall, deep * dome),
                Vec2::new(u * 0.998 + 0.001, (1.0 - up) * 0.998 + 0.001),
            )
        });
        let paint = Paint { tint: [1.0; 3], skin, metres: Vec2::ONE, gloss: 0.0 };
        self.put(&mesh, stand(at, yaw, 1.0), &paint);
        Some(wide)
    }

    /// Someone: a figure, or a cut-out that faces `eye`.
    pub fn someone(&mut self, at: Vec3, eye: Vec3) {
        let from = eye - at;
        let yaw = from.x.atan2(from.z) + self.range(-0.5, 0.5);
        if self.chance(0.5) {
            let tall = self.range(0.4, 1.9);
            if self.relief(at, tall, yaw).is_some() {
                return;
            }
        }
        self.turned(&["person", "person", "animal"], at, None, yaw);
    }

    /// A table: its top's height, width and depth.
    pub fn table(&mut self, at: Vec3, size: Vec3) {
        let top =
            if self.chance(0.7) { self.cloth(&["wood", "stone", "fabric", "metal"], 0.8) } else { self.any_paint(0.7) };
        let legs = self.plain();
        let thick = self.range(0.02, 0.06);
        self.block(at + Vec3::Y * (size.y - thick), Vec3::new(size.x, thick, size.z), 0.0, &top);
        let wide = self.range(0.03, 0.08);
        for (i, j) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            let foot = at + Vec3::new(i * (size.x / 2.0 - wide), 0.0, j * (size.z / 2.0 - wide));
            self.block(foot, Vec3::new(wide, size.y - thick, wide), 0.0, &legs);
        }
    }

    /// A chair made by rule: thin legs, seat and back.
    pub fn chair(&mut self, at: Vec3, yaw: f32) {
        let (wide, seat, back) = (self.range(0.38, 0.5), self.range(0.4, 0.5), self.range(0.35, 0.6));
        let leg = self.range(0.015, 0.045);
        let post = |x: f32, z: f32, from: f32, to: f32| {
            let foot = Vec3::new(x * (wide / 2.0 - leg), from, z * (wide / 2.0 - leg));
            tube(&[foot, foot + Vec3::Y * (to - from)], [leg / 2.0; 2], 5)
        };
        let mut pieces = vec![post(-1.0, 1.0, 0.0, seat), post(1.0, 1.0, 0.0, seat)];
        pieces.extend([post(-1.0, -1.0, 0.0, seat + back), post(1.0, -1.0, 0.0, seat + back)]);
        let bars = self.count(1, 4);
        for i in 0..bars {
            let y = seat + back * (0.3 + 0.65 * i as f32 / bars as f32);
            let end = Vec3::new(wide / 2.0 - leg, y, -(wide / 2.0 - leg));
            pieces.push(tube(&[Vec3::new(-end.x, y, end.z), end], [leg * 0.6; 2], 4));
        }
        let frame = self.any_paint(0.4);
        self.put(&together(pieces), stand(at, yaw, 1.0), &frame);
        let cushion = self.any_paint(0.5);
        self.put(&cuboid(Vec3::new(wide, 0.03, wide)), stand(at + Vec3::Y * seat, yaw, 1.0), &cushion);
    }

    /// A cable between two places.
    pub fn cable(&mut self, from: Vec3, to: Vec3, radius: f32) {
        let (sag, paint) = (from.distance(to) * self.range(0.02, 0.25), self.plain());
        self.put(&tube(&hanging(from, to, sag, 10), [radius; 2], 4), Affine3A::IDENTITY, &paint);
    }

    /// A lamp that hangs from a ceiling.
    pub fn hanging_lamp(&mut self, from: Vec3, down: f32) {
        self.cable(from, from - Vec3::Y * down, 0.006);
        let wide = self.range(0.1, 0.3);
        let shade = lathe(&[[wide, 0.0], [wide * self.range(0.4, 1.0), wide * 0.5], [wide * 0.15, wide * 0.8]], 12);
        let paint = self.any_paint(0.3);
        self.put(&shade, stand(from - Vec3::Y * down, 0.0, 1.0), &paint);
    }

    /// A green that is not always green.
    pub fn leaf_paint(&mut self) -> Paint {
        let green = [self.range(0.05, 0.25), self.range(0.12, 0.4), self.range(0.02, 0.12)];
        let tint = if self.chance(0.2) { self.colour() } else { green };
        let skin = if self.chance(0.4) { self.cloth(&["grass", "ground", "fabric"], 0.4).skin } else { None };
        let tint = if skin.is_some() { tint.map(|c| (2.0 * c).min(1.0)) } else { tint };
        Paint { tint, skin, metres: Vec2::splat(0.3), gloss: 0.15 }
    }

    /// A plant by rule: bending stems with leaves, sometimes blossoms.
    pub fn plant(&mut self, at: Vec3, tall: f32) {
        let (green, wood) = (self.leaf_paint(), self.leaf_paint());
        let (mut stems, mut feet) = (Vec::new(), Vec::new());
        let spread = self.range(0.2, 1.0);
        for _ in 0..self.count(1, 6) {
            let way = Vec3::Y + any_way(&mut self.rng) * spread * 0.6;
            let long = tall * self.range(0.6, 1.0);
            let points = stem(&mut self.rng, at, way, long, 0.7, 5);
            let thick = tall * self.range(0.004, 0.015);
            stems.push(tube(&points, [thick, thick * 0.4], 4));
            feet.extend(points.into_iter().skip(1));
        }
        self.put(&together(stems), Affine3A::IDENTITY, &wood);
        let (long, slim) = (tall * self.range(0.1, 0.4), self.range(0.15, 0.7));
        let number = feet.len() * self.count(1, 4);
        let rng = &mut self.rng;
        let leaf = round_leaves(number, |i| {
            let way = (any_way(rng) + Vec3::Y * 0.4) * long * rng.range(0.6, 1.2);
            (feet[i % feet.len()], way, long * slim)
        });
        self.put(&leaf, Affine3A::IDENTITY, &green);
        if self.chance(0.5) {
            let petal = self.plain();
            let (size, count) = (tall * self.range(0.05, 0.15), self.count(5, 9));
            let tips: Vec<Vec3> = feet.iter().skip(4).step_by(5).copied().collect();
            let ring = leaves(tips.len() * count, |i| {
                let (sin, cos) = (TAU * (i % count) as f32 / count as f32).sin_cos();
                (tips[i / count], Vec3::new(cos, 0.35, sin) * size, size * 0.7)
            });
            self.put(&ring, Affine3A::IDENTITY, &petal);
        }
    }

    /// Blades of grass about a place.
    pub fn grass(&mut self, at: Vec3, wide: f32, tall: f32, count: usize) {
        let paint = self.leaf_paint();
        let rng = &mut self.rng;
        let blades = leaves(count, |_| {
            let foot = at + Vec3::new(rng.range(-wide, wide), 0.0, rng.range(-wide, wide));
            let way = Vec3::new(rng.range(-0.5, 0.5), 1.0, rng.range(-0.5, 0.5)) * tall * rng.range(0.5, 1.2);
            (foot, way, tall * rng.range(0.03, 0.12))
        });
        self.put(&blades, Affine3A::IDENTITY, &paint);
    }

    /// A tree by rule: trunk, boughs and leaves; with few leaves its twigs are thin parts.
    pub fn tree(&mut self, at: Vec3, tall: f32) {
        let bark = self.cloth(&["wood", "ground", "stone"], 0.8);
        let thick = tall * self.range(0.015, 0.05);
        let trunk = stem(&mut self.rng, at, Vec3::Y, tall * 0.75, 0.25, 6);
        let mut pieces = vec![tube(&trunk, [thick, thick * 0.5], 7)];
        let (mut ends, low) = (Vec::new(), self.range(0.2, 0.6));
        for _ in 0..self.count(5, 14) {
            let from = trunk[(trunk.len() as f32 * self.range(low, 1.0)) as usize % trunk.len()];
            let way = any_way(&mut self.rng) + Vec3::Y * 0.5;
            let long = tall * self.range(0.15, 0.4);
            let bough = stem(&mut self.rng, from, way, long, 0.5, 4);
            pieces.push(tube(&bough, [thick * 0.35, thick * 0.08], 4));
            ends.extend(bough.into_iter().skip(2));
        }
        self.put(&together(pieces), Affine3A::IDENTITY, &bark);
        if self.chance(0.25) {
            return;
        }
        let (green, long) = (self.leaf_paint(), tall * self.range(0.03, 0.1));
        let rng = &mut self.rng;
        let crown = leaves(ends.len() * 8, |i| {
            let foot = ends[i % ends.len()] + any_way(rng) * long * 1.5;
            (foot, any_way(rng) * long, long * 0.6)
        });
        self.put(&crown, Affine3A::IDENTITY, &green);
    }

    /// A fence from a place along a way: posts and rails, boards, or wires.
    pub fn fence(&mut self, from: Vec3, along: Vec3, tall: f32) {
        let paint = if self.chance(0.6) { self.cloth(&["wood", "metal"], 0.5) } else { self.plain() };
        let (long, way) = (along.length(), along.normalize_or(Vec3::X));
        let mut pieces = Vec::new();
        let thin = self.range(0.004, 0.03);
        let gap = self.range(0.06, 0.4).max(4.0 * thin);
        for i in 0..((long / gap) as usize).min(160) {
            let foot = from + way * (i as f32 * gap);
            pieces.push(tube(&[foot, foot + Vec3::Y * tall], [thin; 2], 4));
        }
        for i in 0..self.count(1, 4) {
            let y = Vec3::Y * tall * (0.1 + 0.28 * i as f32);
            pieces.push(tube(&[from + y, from + along + y], [thin * 1.2; 2], 4));
        }
        self.put(&together(pieces), Affine3A::IDENTITY, &paint);
    }
}
