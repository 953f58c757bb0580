//! Light: a sun or a window's light with its shadow, light from above that things take from what is under them, a lamp,
//! and what the ground throws back.

use glam::Vec3;

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
    /// What lies this far away shows as much of the air as of itself, metres.
    pub haze_m: f32,
}

/// Side of a shadow map.
const MAP_PX: usize = 160;

/// Depths of the world as a light far away sees them.
struct ShadowMap {
    axes: [Vec3; 3],
    centre: Vec3,
    per_metre: f32,
    depths: Buffer,
}

impl ShadowMap {
    /// Towards `from`, about a ball.
    fn new(world: &World, from: Vec3, centre: Vec3, radius: f32) -> Self {
        let side = from.any_orthonormal_vector();
        let axes = [side, from.cross(side), from];
        let per_metre = MAP_PX as f32 / (2.0 * radius);
        let mut depths = Buffer::default();
        depths.clear([MAP_PX; 2]);
        let mut map = Self { axes, centre, per_metre, depths };
        let places: Vec<[f32; 3]> = world.corners.iter().map(|corner| map.place(corner.at)).collect();
        for part in world.parts.iter().filter(|part| part.casts) {
            map.depths.triangle(0, part.corners.map(|i| places[i as usize]), &mut |_| true);
        }
        map
    }

    /// Place on the map and height towards the light, metres.
    #[inline]
    fn place(&self, at: Vec3) -> [f32; 3] {
        let from = at - self.centre;
        let half = MAP_PX as f32 / 2.0;
        let along = |axis: usize| from.dot(self.axes[axis]);
        [along(0) * self.per_metre + half, along(1) * self.per_metre + half, along(2)]
    }

    /// The share of four places about this one that the light reaches.
    #[inline]
    fn lit(&self, at: Vec3, reach_m: f32, bias_m: f32) -> f32 {
        let [x, y, height] = self.place(at);
        let reach = (reach_m * self.per_metre).max(0.7);
        // A square, turned so that its corners fall on rows and columns of their own.
        let offsets = [[0.33, 1.0], [1.0, -0.33], [-0.33, -1.0], [-1.0, 0.33]];
        let free = |[dx, dy]: [f32; 2]| {
            let (x, y) = (x + dx * reach, y + dy * reach);
            let inside = x >= 0.0 && y >= 0.0 && x < MAP_PX as f32 && y < MAP_PX as f32;
            !inside || self.depths.near[y as usize * MAP_PX + x as usize] <= height + bias_m
        };
        offsets.into_iter().map(|offset| f32::from(u8::from(free(offset)))).sum::<f32>() / 4.0
    }
}

/// Lights, and what keeps them off.
pub struct Shading {
    lights: Lights,
    sun: ShadowMap,
    above: ShadowMap,
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
        let sun = ShadowMap::new(world, lights.sun_from, centre, radius);
        // Not quite from above, that upright faces do not stand in their own shadow.
        let above = ShadowMap::new(world, Vec3::new(0.11, 1.0, 0.17).normalize(), centre, radius);
        Self { lights, sun, above, radius }
    }

    /// Light that comes from a place towards `to_eye`, which is `distance` long.
    pub fn shade(&self, surface: &Surface, to_eye: Vec3, distance: f32) -> Vec3 {
        let Lights { sun_from, sun, sky, ground, lamp_at, lamp, soft, haze_m } = self.lights;
        let Surface { at, normal, colour, gloss } = *surface;
        let texel = 2.0 * self.radius / MAP_PX as f32;
        // Off the surface by a texel, so that it does not shade itself.
        let off = at + normal * texel;
        let facing = normal.dot(sun_from);
        let direct = if facing > 0.0 { self.sun.lit(off, texel, 0.5 * texel) } else { 0.0 };
        let near = self.above.lit(off, soft * self.radius, texel);
        let wide = self.above.lit(off, 2.7 * soft * self.radius, texel);
        let open = 0.25 + 0.75 * (0.5 * near + 0.5 * wide);
        let up = 0.5 + 0.5 * normal.y;
        let mut light =
            sky * (up * open) + ground * ((1.0 - up) * (0.4 + 0.6 * open)) + sun * (facing.max(0.0) * direct);
        let to_lamp = lamp_at - at;
        let far = to_lamp.length_squared();
        light +=
            lamp * (normal.dot(to_lamp * far.max(1e-6).sqrt().recip()).max(0.0) * (0.35 + 0.65 * open) / (0.3 + far));
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
