//! Triangles with places on a texture, and the world that they are put together to.

use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};

use super::texture::Texture;

/// A corner of faces.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    /// Place, metres; y is up.
    pub at: Vec3,
    /// Mean normal of the faces that meet here.
    pub normal: Vec3,
    /// Place on the texture, v downwards; of things to paint, metres.
    pub uv: Vec2,
}

/// The skin of a face that has none.
pub const BARE: u32 = u32::MAX;

/// A triangle.
#[derive(Clone, Copy, Debug)]
pub struct Face {
    /// Its corners.
    pub corners: [u32; 3],
    /// Linear colour, multiplied with the skin's.
    pub tint: [f32; 3],
    /// Which skin, or [`BARE`].
    pub skin: u32,
}

/// A thing, standing on y = 0 about the origin.
#[derive(Default)]
pub struct Mesh {
    /// Corners.
    pub corners: Vec<Corner>,
    /// Faces.
    pub faces: Vec<Face>,
    /// What faces are painted with.
    pub skins: Vec<Arc<Texture>>,
}

/// What a thing is painted with.
#[derive(Clone)]
pub struct Paint {
    /// Linear colour, multiplied with the texture's.
    pub tint: [f32; 3],
    /// A texture.
    pub skin: Option<Arc<Texture>>,
    /// Size of the texture, width and height in metres.
    pub metres: Vec2,
    /// How much of the light's mirror image it shows.
    pub gloss: f32,
}

impl Mesh {
    /// A mesh of corners and faces; normals are made.
    pub fn new(corners: Vec<(Vec3, Vec2)>, faces: Vec<Face>, skins: Vec<Arc<Texture>>) -> Self {
        let corner = |(at, uv)| Corner { at, normal: Vec3::ZERO, uv };
        let mut mesh = Self { corners: corners.into_iter().map(corner).collect(), faces, skins };
        mesh.smooth();
        mesh
    }

    /// A mesh to paint: white faces.
    pub fn plain(corners: Vec<(Vec3, Vec2)>, faces: Vec<[u32; 3]>) -> Self {
        let face = |corners| Face { corners, tint: [1.0; 3], skin: BARE };
        Self::new(corners, faces.into_iter().map(face).collect(), Vec::new())
    }

    /// Gives corners at one place the mean normal of all their faces.
    fn smooth(&mut self) {
        let mut order: Vec<u32> = (0..self.corners.len() as u32).collect();
        let key = |i: u32| self.corners[i as usize].at.to_array().map(f32::to_bits);
        order.sort_unstable_by_key(|&i| key(i));
        let mut place = vec![0u32; self.corners.len()];
        let mut places = 0;
        for (i, &corner) in order.iter().enumerate() {
            places += u32::from(i > 0 && key(corner) != key(order[i - 1]));
            place[corner as usize] = places;
        }
        let mut sums = vec![Vec3::ZERO; places as usize + 1];
        for face in &self.faces {
            let [a, b, c] = face.corners.map(|i| self.corners[i as usize].at);
            let normal = (b - a).cross(c - a);
            face.corners.iter().for_each(|&i| sums[place[i as usize] as usize] += normal);
        }
        for (corner, place) in self.corners.iter_mut().zip(place) {
            corner.normal = sums[place as usize].normalize_or_zero();
        }
    }

    /// Least and greatest place.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let grow = |(lo, hi): (Vec3, Vec3), corner: &Corner| (lo.min(corner.at), hi.max(corner.at));
        self.corners.iter().fold((Vec3::splat(f32::MAX), Vec3::splat(f32::MIN)), grow)
    }
}

/// A face in the world.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Its corners.
    pub corners: [u32; 3],
    /// Linear colour.
    pub tint: [f32; 3],
    /// Which skin of the world, or [`BARE`].
    pub skin: u32,
    /// The thing that it belongs to.
    pub thing: u32,
    /// See [`Paint::gloss`].
    pub gloss: f32,
    /// Whether it throws shadows: walls and ceilings that close a room do not.
    pub casts: bool,
}

/// Everything that stands before the camera.
#[derive(Default)]
pub struct World {
    /// Corners.
    pub corners: Vec<Corner>,
    /// Faces.
    pub parts: Vec<Part>,
    /// Textures.
    pub skins: Vec<Arc<Texture>>,
    things: u32,
    /// Faces that were put here; what comes after them are pieces of them.
    whole: usize,
}

impl World {
    /// Puts a thing into the world. With `paint`, that is its skin; a thing from a file is then wrapped in it.
    pub fn add(&mut self, mesh: &Mesh, place: Affine3A, paint: Option<&Paint>, casts: bool) {
        let first = self.corners.len() as u32;
        let per_metre = paint.map_or(Vec2::ONE, |paint| paint.metres.max(Vec2::splat(1e-3)).recip());
        self.corners.extend(mesh.corners.iter().map(|corner| Corner {
            at: place.transform_point3(corner.at),
            normal: place.transform_vector3(corner.normal).normalize_or_zero(),
            uv: corner.uv * per_metre,
        }));
        let own: Vec<u32> =
            if paint.is_some() { Vec::new() } else { mesh.skins.iter().map(|s| self.skin(s)).collect() };
        let painted = paint.map(|paint| (paint.tint, paint.skin.as_ref().map_or(BARE, |skin| self.skin(skin))));
        let gloss = paint.map_or(0.1, |paint| paint.gloss);
        let thing = self.things;
        self.things += 1;
        self.parts.extend(mesh.faces.iter().map(|face| {
            let skin = own.get(face.skin as usize).copied().unwrap_or(BARE);
            let (tint, skin) = painted.unwrap_or((face.tint, skin));
            Part { corners: face.corners.map(|i| i + first), tint, skin, thing, gloss, casts }
        }));
        self.whole = self.parts.len();
    }

    /// Faces as they were put here, without the pieces that a camera cuts them into.
    pub fn whole(&self) -> &[Part] {
        &self.parts[..self.whole]
    }

    fn skin(&mut self, skin: &Arc<Texture>) -> u32 {
        let known = self.skins.iter().rposition(|own| Arc::ptr_eq(own, skin));
        known.unwrap_or_else(|| {
            self.skins.push(skin.clone());
            self.skins.len() - 1
        }) as u32
    }

    /// The skin of a face.
    #[inline]
    pub fn skin_of(&self, part: &Part) -> Option<&Texture> {
        self.skins.get(part.skin as usize).map(|skin| &**skin)
    }

    /// Corners of a face.
    #[inline]
    pub fn corners_of(&self, part: &Part) -> [&Corner; 3] {
        part.corners.map(|i| &self.corners[i as usize])
    }
}
