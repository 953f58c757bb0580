//! What a view shows: light and nearness of its pixels, out of the faces of their samples.

use glam::{Vec2, Vec3};

use super::light::{Shading, Surface};
use super::mesh::{Corner, Part, World};
use super::shot::{Shot, Sky};
use super::texture::Texture;
use super::view::{Buffer, Frame, Lens, NOTHING, SUB, Shares, mixed, straight};
use crate::scenes::raster::Raster;

/// What is needed to tell the light of a view's pixels.
pub struct Eye<'a> {
    pub world: &'a World,
    pub shot: &'a Shot,
    pub frame: &'a Frame,
    pub lens: Lens,
    pub shading: Shading,
    pub sky_near: f32,
    /// Samples of a pixel that lie further apart in nearness than this belong to two surfaces.
    pub gap: f32,
}

impl Eye<'_> {
    /// Light and nearness of a view's pixels. A pixel on an edge of depth shows both sides, and has the depth of the one
    /// that covers more of it, of the nearer one where they are equal.
    pub fn resolve(&self, buffer: &Buffer, step: Vec2) -> (Raster<[f32; 3]>, Vec<f32>) {
        let [w, h] = self.frame.size;
        let wide = buffer.size[0];
        let mut facets = Facets { eye: self, step, kept: std::array::from_fn(|_| (NOTHING, None)) };
        let (mut light, mut nears) = (Vec::with_capacity(w * h), Vec::with_capacity(w * h));
        for y in 0..h {
            for x in 0..w {
                let first = y * SUB * wide + x * SUB;
                let places = [first, first + 1, first + wide, first + wide + 1];
                let faces = places.map(|i| buffer.face[i]);
                let mut near = places.map(|i| buffer.near[i].max(self.sky_near));
                light.push(self.pixel(&mut facets, [x, y], faces, near).to_array());
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

    fn pixel(&self, facets: &mut Facets, [x, y]: [usize; 2], faces: [u32; 4], near: [f32; 4]) -> Vec3 {
        let thing = |face: u32| if face == NOTHING { NOTHING } else { self.world.parts[face as usize].thing };
        let spread = |near: [f32; 4]| {
            near.iter().fold(f32::MIN, |a, &b| a.max(b)) - near.iter().fold(f32::MAX, |a, &b| a.min(b))
        };
        let middle = Vec2::new((x * SUB) as f32 + 0.5, (y * SUB) as f32 + 0.5);
        let one = faces.iter().all(|&face| face == faces[0])
            || (faces.iter().all(|&face| thing(face) == thing(faces[0])) && spread(near) < self.gap);
        if one {
            return facets.light(faces[0], middle);
        }
        let mut sum = Vec3::ZERO;
        for i in 0..4 {
            // Once for samples of one face.
            if faces[..i].contains(&faces[i]) {
                continue;
            }
            let count = faces.iter().filter(|&&face| face == faces[i]).count();
            let off = Vec2::new((i % 2) as f32, (i / 2) as f32) - 0.5;
            sum += facets.light(faces[i], middle + off) * count as f32;
        }
        sum / 4.0
    }

    fn sky(&self, at: Vec2, step: Vec2) -> Vec3 {
        let pixel = (at - 0.5) / SUB as f32;
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

    /// A face as a view shows it; none of one that is seen from its edge.
    fn facet(&self, face: u32, step: Vec2) -> Option<Facet<'_>> {
        let part = &self.world.parts[face as usize];
        let shares = Shares::new(self.frame.corners(part.corners, self.lens, step))?;
        let corners = self.world.corners_of(part);
        let [a, b, c] = corners.map(|corner| corner.at);
        Some(Facet {
            part,
            corners,
            skin: self.world.skin_of(part),
            shares,
            inverse: self.frame.inverse(part.corners),
            flat: (b - a).cross(c - a).normalize_or(Vec3::Y),
        })
    }
}

/// A face as a view shows it.
struct Facet<'a> {
    part: &'a Part,
    corners: [&'a Corner; 3],
    skin: Option<&'a Texture>,
    shares: Shares,
    /// 1/z of the corners.
    inverse: Vec3,
    /// Unit normal to its plane.
    flat: Vec3,
}

impl Facet<'_> {
    /// Shares of its corners in space at a sample's place.
    #[inline]
    fn share(&self, x: f32, y: f32) -> Vec3 {
        straight(self.shares.at(x, y).clamp(Vec3::splat(-0.5), Vec3::splat(1.5)), self.inverse)
    }

    /// Its colour where these are the shares, at a sample's place.
    #[inline]
    fn colour(&self, share: Vec3, at: Vec2) -> Vec3 {
        let tint = Vec3::from(self.part.tint);
        let Some(skin) = self.skin else { return tint };
        let corners = self.corners.map(|corner| corner.uv);
        let own = mixed(corners, share);
        let across = (mixed(corners, self.share(at.x + SUB as f32, at.y)) - own).length();
        let along = (mixed(corners, self.share(at.x, at.y + SUB as f32)) - own).length();
        let [red, green, blue, _] = skin.light(own.x, own.y, 0.5 * (across + along));
        tint * Vec3::new(red, green, blue)
    }

    /// The unit normal towards the camera.
    #[inline]
    fn normal(&self, share: Vec3, to_eye: Vec3) -> Vec3 {
        let flat = self.flat;
        let smooth = mixed(self.corners.map(|corner| corner.normal), share).normalize_or(flat);
        // Corners whose faces meet at a sharp edge have no normal in common.
        let normal = if smooth.dot(flat).abs() > 0.7 { smooth } else { flat };
        if flat.dot(to_eye) * flat.dot(normal) < 0.0 { -normal } else { normal }
    }
}

/// How many faces are kept.
const KEPT: usize = 8;

/// A view's faces, the last ones kept: pixels side by side mostly show the same.
struct Facets<'a> {
    eye: &'a Eye<'a>,
    step: Vec2,
    kept: [(u32, Option<Facet<'a>>); KEPT],
}

impl Facets<'_> {
    /// Light of a face at a sample's place.
    fn light(&mut self, face: u32, at: Vec2) -> Vec3 {
        let Self { eye, step, kept } = self;
        if face == NOTHING {
            return eye.sky(at, *step);
        }
        let kept = &mut kept[face as usize % KEPT];
        if kept.0 != face {
            *kept = (face, eye.facet(face, *step));
        }
        let Some(facet) = &kept.1 else { return Vec3::ZERO };
        let share = facet.share(at.x, at.y);
        let place = mixed(facet.corners.map(|corner| corner.at), share);
        let to_eye = eye.shot.camera.eye - place;
        let distance = to_eye.length().max(1e-6);
        let to_eye = to_eye * distance.recip();
        let (normal, colour) = (facet.normal(share, to_eye), facet.colour(share, at));
        eye.shading.shade(&Surface { at: place, normal, colour, gloss: facet.part.gloss }, to_eye, distance)
    }
}
