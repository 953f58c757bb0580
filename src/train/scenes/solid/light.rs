//! Light: a sun or a window's light with its shadow, light from above that things take from what is under them, a lamp,
//! and what the ground throws back.

use glam::{Vec2, Vec3, Vec4};

use super::dapple::Through;
use super::mesh::World;
use super::view::Buffer;

/// What lights a scene, linear.
#[derive(Clone, Copy, Debug)]
pub struct Lights {
    /// Unit vector towards the sun or the window.
    pub sun_from: Vec3,
    /// Its light.
    pub sun: Vec3,
    /// Light from above.
    pub sky: Vec3,
    /// Light from below.
    pub ground: Vec3,
    /// A lamp's place.
    pub lamp_at: Vec3,
    /// Its light at a metre.
    pub lamp: Vec3,
    /// How far light from above finds its way under things, as a share of the scene's size.
    pub soft: f32,
    /// What the sun shines through.
    pub through: Through,
    /// What lies this far away shows as much of the air as of itself, metres.
    pub haze_m: f32,
}

/// Side of the sun's shadow map, whose shadows have clear edges, and of the sky's.
const SUN_PX: usize = 384;
const SKY_PX: usize = 160;

/// Depths of the world as a light far away sees them.
struct ShadowMap {
    axes: [Vec3; 3],
    centre: Vec3,
    per_metre: f32,
    depths: Buffer,
}

impl ShadowMap {
    /// Towards `from`, about a ball, of this many pixels a side.
    fn new(world: &World, from: Vec3, centre: Vec3, radius: f32, side: usize) -> Self {
        let across = from.any_orthonormal_vector();
        let axes = [across, from.cross(across), from];
        let per_metre = side as f32 / (2.0 * radius);
        let mut depths = Buffer::default();
        depths.clear([side; 2]);
        let mut map = Self { axes, centre, per_metre, depths };
        let places: Vec<[f32; 3]> = world.corners.iter().map(|corner| map.place(corner.at)).collect();
        for part in world.whole().iter().filter(|part| part.casts) {
            let corners = part.corners.map(|i| places[i as usize]);
            map.depths.part(world, (0, part), corners, |share| share);
        }
        map.open_border();
        map
    }

    /// Nothing shades the border, where `lit` looks for all that lies beyond the map.
    fn open_border(&mut self) {
        let side = self.depths.size[0];
        for i in 0..side {
            for place in [i, (side - 1) * side + i, i * side, i * side + side - 1] {
                self.depths.near[place] = f32::NEG_INFINITY;
            }
        }
    }

    /// Place on the map and height towards the light, metres.
    #[inline]
    fn place(&self, at: Vec3) -> [f32; 3] {
        let from = at - self.centre;
        let half = self.depths.size[0] as f32 / 2.0;
        let along = |axis: usize| from.dot(self.axes[axis]);
        [along(0) * self.per_metre + half, along(1) * self.per_metre + half, along(2)]
    }

    fn texel_m(&self) -> f32 {
        self.per_metre.recip()
    }

    /// The share of four points about a place on the map that the light reaches.
    #[inline]
    fn lit(&self, [x, y, height]: [f32; 3], reach_m: f32, bias_m: f32) -> f32 {
        let side = self.depths.size[0];
        let (reach, last) = ((reach_m * self.per_metre).max(0.7), (side - 1) as f32);
        // A square, turned so that its corners fall on rows and columns of their own; all four at once.
        let texels = |at: f32, offsets: Vec4| {
            let places = (offsets * reach + (at - 0.5)).clamp(Vec4::ZERO, Vec4::splat(last));
            // Beside a number this large a number's last bits are whole ones: much the fastest way to them.
            (places + (1u32 << 23) as f32).to_array().map(|place| (place.to_bits() & 0x7f_ffff) as usize)
        };
        let columns = texels(x, Vec4::new(0.33, 1.0, -0.33, -1.0));
        let rows = texels(y, Vec4::new(1.0, -0.33, -1.0, 0.33));
        let heights = Vec4::from(std::array::from_fn(|i| self.depths.near[rows[i] * side + columns[i]]));
        heights.cmple(Vec4::splat(height + bias_m)).bitmask().count_ones() as f32 / 4.0
    }
}

/// Lights, and what keeps them off.
pub struct Shading {
    lights: Lights,
    sun: ShadowMap,
    above: ShadowMap,
    /// Across the sun's light: level, and up.
    across: [Vec3; 2],
    radius: f32,
}

/// A place on a surface.
pub struct Surface {
    /// Where.
    pub at: Vec3,
    /// Unit normal towards the camera.
    pub normal: Vec3,
    /// Linear colour.
    pub colour: Vec3,
    /// See [`super::mesh::Paint::gloss`].
    pub gloss: f32,
}

impl Shading {
    /// Draws the shadow maps of what lies in a ball.
    pub fn new(world: &World, lights: Lights, centre: Vec3, radius: f32) -> Self {
        let sun = ShadowMap::new(world, lights.sun_from, centre, radius, SUN_PX);
        // Not quite from above, that upright faces do not stand in their own shadow.
        let above = ShadowMap::new(world, Vec3::new(0.11, 1.0, 0.17).normalize(), centre, radius, SKY_PX);
        let level = Vec3::Y.cross(lights.sun_from).normalize_or(Vec3::X);
        Self { lights, sun, above, across: [level, lights.sun_from.cross(level)], radius }
    }

    /// Light that comes from a place towards `to_eye`, which is `distance` long.
    pub fn shade(&self, surface: &Surface, to_eye: Vec3, distance: f32) -> Vec3 {
        let Lights { sun_from, sun, sky, ground, lamp_at, lamp, soft, through, haze_m } = self.lights;
        let Surface { at, normal, colour, gloss } = *surface;
        // Off the surface by a texel, so that it does not shade itself.
        let (sharp, texel) = (self.sun.texel_m(), self.above.texel_m());
        let facing = normal.dot(sun_from);
        let direct = if facing > 0.0 {
            self.sun.lit(self.sun.place(at + normal * sharp), sharp, 0.5 * sharp)
                * through.passes(Vec2::from(self.across.map(|axis| at.dot(axis))))
        } else {
            0.0
        };
        let off = self.above.place(at + normal * texel);
        let near = self.above.lit(off, soft * self.radius, texel);
        let wide = self.above.lit(off, 2.7 * soft * self.radius, texel);
        let open = 0.25 + 0.75 * (0.5 * near + 0.5 * wide);
        let up = 0.5 + 0.5 * normal.y;
        let mut light =
            sky * (up * open) + ground * ((1.0 - up) * (0.4 + 0.6 * open)) + sun * (facing.max(0.0) * direct);
        let to_lamp = lamp_at - at;
        let far = to_lamp.length_squared();
        let on_lamp = normal.dot(to_lamp) * far.max(1e-6).sqrt().recip();
        light += lamp * (on_lamp.max(0.0) * (0.35 + 0.65 * open) / (0.3 + far));
        let mut out = colour * light;
        if gloss > 0.0 {
            let half = (sun_from + to_eye).normalize_or_zero();
            let shine = normal.dot(half).max(0.0).powi(24) * direct;
            out += (sun * shine + sky * (0.04 * open)) * gloss;
        }
        let clear = (-distance / haze_m).exp();
        out * clear + sky * (1.0 - clear)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Affine3A;

    use super::super::mesh::Paint;
    use super::super::shapes::slab;
    use super::super::texture::Texture;
    use super::*;
    use crate::scenes::raster::Raster;

    #[test]
    fn a_cut_out_throws_the_shadow_of_what_is_left_of_it() {
        // A card of two metres on the ground whose right half is cut away.
        let picture = Raster::from_fn([16, 16], |x, _| [200, 90, 40, if x < 8 { 255 } else { 0 }]);
        let skin = Some(Arc::new(Texture::new(picture)));
        let paint = Paint { tint: [1.0; 3], skin, metres: Vec2::splat(2.0), gloss: 0.0 };
        let mut world = World::default();
        let card = slab(Vec3::new(-1.0, 0.0, 0.0), Vec3::X * 2.0, Vec3::Y * 2.0, [1, 1]);
        world.add(&card, Affine3A::IDENTITY, Some(&paint), true);
        let map = ShadowMap::new(&world, Vec3::new(0.0, 1.0, 1.0).normalize(), Vec3::ZERO, 3.0, SUN_PX);
        let lit = |x: f32, z: f32| map.lit(map.place(Vec3::new(x, 0.0, z)), map.texel_m(), 0.5 * map.texel_m());
        assert_eq!([lit(-0.5, -1.0), lit(0.5, -1.0)], [0.0, 1.0], "behind either half");
        assert_eq!([lit(-0.5, 1.0), lit(-0.5, -2.2)], [1.0, 1.0], "before it, and beyond its shadow");
    }
}
