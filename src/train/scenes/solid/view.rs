//! The camera, and what each of its views sees: depth and face of every sample.
//!
//! All views share one image plane: the camera of a view stands beside the reference camera and its picture is shifted
//! back so that the focal plane stays where it is. A point at reference place X with disparity D is seen at
//! `X − u·D`, with `D = f·b·(1/z − 1/z_f)`: the sign and the units of `plenoscope::field`.

use std::ops::Range;

use glam::{Vec2, Vec3};

use super::mesh::{Corner, Part, World};
use crate::scenes::raster::floor;

/// Samples of a pixel in x and y.
pub const SUB: usize = 2;

/// A camera without distortion.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Where it stands.
    pub eye: Vec3,
    /// Unit vectors to the right of its picture, down, and into it.
    pub axes: [Vec3; 3],
    /// Focal length in pixels.
    pub focal_px: f32,
    /// The principal point: the picture's middle, pixel centres at integers.
    pub middle: Vec2,
    /// Nothing nearer is seen, metres.
    pub near: f32,
}

impl Camera {
    /// A camera that looks along a yaw (0 into −z, positive to the right), a pitch (positive up) and a roll.
    pub fn new(eye: Vec3, [yaw, pitch, roll]: [f32; 3], focal_px: f32, size: [usize; 2]) -> Self {
        let (sy, cy) = yaw.sin_cos();
        let (sp, cp) = pitch.sin_cos();
        let into = Vec3::new(sy * cp, sp, -cy * cp);
        let flat_right = Vec3::new(cy, 0.0, sy);
        let flat_down = into.cross(flat_right);
        let (sr, cr) = roll.sin_cos();
        let right = flat_right * cr + flat_down * sr;
        let axes = [right, into.cross(right), into];
        let middle = Vec2::new(size[0] as f32 - 1.0, size[1] as f32 - 1.0) / 2.0;
        Self { eye, axes, focal_px, middle, near: 0.03 }
    }

    /// Right, down and depth of a place, metres.
    fn local(&self, at: Vec3) -> Vec3 {
        let from = at - self.eye;
        Vec3::new(from.dot(self.axes[0]), from.dot(self.axes[1]), from.dot(self.axes[2]))
    }

    fn project(&self, at: Vec3, curve: Curve) -> Seen {
        let local = self.local(at);
        let inverse = 1.0 / local.z.max(self.near);
        let place = self.middle + Vec2::new(local.x, local.y) * (self.focal_px * inverse);
        Seen { place, inverse, near: curve.of(inverse), depth: local.z }
    }
}

/// What disparity is linear in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Curve {
    /// 1/z: a real camera.
    #[default]
    Camera,
    /// log(1/z + 1/80 m): a relief of the scene, the same photo with its far side as deep as its near one. So are the
    /// nearness maps that photos come with, and one net should learn one curve.
    Relief,
}

impl Curve {
    /// The nearness of an inverse depth.
    pub fn of(self, inverse: f32) -> f32 {
        match self {
            Self::Camera => inverse,
            Self::Relief => (inverse + 1.0 / 80.0).ln(),
        }
    }
}

/// A corner as the reference view sees it.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Place in the reference view.
    pub place: Vec2,
    /// 1/z.
    pub inverse: f32,
    /// What disparity is linear in.
    pub near: f32,
    /// z; not clipped.
    depth: f32,
}

/// The world before one camera, cut at its near plane.
pub struct Frame {
    /// Corners as the reference view sees them; as many as the world has.
    pub seen: Vec<Seen>,
    /// Faces that some view may see.
    pub visible: Vec<u32>,
    /// Width and height in pixels.
    pub size: [usize; 2],
}

/// Scale and zero of the disparity: `D = scale_px · (near − focus)`.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    /// Pixels per view step and nearness.
    pub scale_px: f32,
    /// Nearness of the focal plane.
    pub focus: f32,
}

impl Lens {
    /// Disparity of a nearness.
    #[inline]
    pub fn disparity(&self, near: f32) -> f32 {
        self.scale_px * (near - self.focus)
    }
}

/// Faces further apart in 1/z than this are divided where nearness is no linear function of 1/z.
const STRETCH: f32 = 1.3;

impl Frame {
    /// Projects the world, cuts faces at the near plane and, in a relief, divides those that run far into the depth;
    /// new corners and faces are added to the world.
    pub fn new(world: &mut World, camera: &Camera, size: [usize; 2], curve: Curve) -> Self {
        let seen = world.corners.iter().map(|corner| camera.project(corner.at, curve)).collect();
        let mut frame = Self { seen, visible: Vec::with_capacity(world.parts.len()), size };
        let mut waiting: Vec<u32> = Vec::new();
        for index in 0..world.parts.len() as u32 {
            waiting.push(index);
            while let Some(index) = waiting.pop() {
                let corners = world.parts[index as usize].corners;
                let inside = corners.map(|i| frame.seen[i as usize].depth >= camera.near);
                if !inside.contains(&true) {
                    continue;
                }
                if inside.contains(&false) {
                    frame.cut(world, camera, curve, index, inside, &mut waiting);
                } else if frame.may_be_seen(corners) {
                    match (curve == Curve::Relief).then(|| frame.longest(corners)).flatten() {
                        Some(edge) => frame.divide(world, camera, curve, index, edge, &mut waiting),
                        None => frame.visible.push(index),
                    }
                }
            }
        }
        frame
    }

    fn add_corner(&mut self, world: &mut World, camera: &Camera, curve: Curve, [a, b]: [u32; 2], t: f32) -> u32 {
        let [a, b] = [a, b].map(|i| world.corners[i as usize]);
        let at = a.at.lerp(b.at, t);
        world.corners.push(Corner { at, normal: a.normal.lerp(b.normal, t), uv: a.uv.lerp(b.uv, t) });
        let mut seen = camera.project(at, curve);
        // What is cut at the near plane lies on it, however it is rounded.
        seen.depth = seen.depth.max(camera.near);
        self.seen.push(seen);
        self.seen.len() as u32 - 1
    }

    /// Cuts a face at the near plane; what is left waits to be looked at.
    fn cut(
        &mut self,
        world: &mut World,
        camera: &Camera,
        curve: Curve,
        index: u32,
        inside: [bool; 3],
        waiting: &mut Vec<u32>,
    ) {
        let part = world.parts[index as usize];
        let mut ring = Vec::with_capacity(4);
        for i in 0..3 {
            let (a, b) = (part.corners[i], part.corners[(i + 1) % 3]);
            if inside[i] {
                ring.push(a);
            }
            if inside[i] != inside[(i + 1) % 3] {
                let [za, zb] = [a, b].map(|k| self.seen[k as usize].depth);
                ring.push(self.add_corner(world, camera, curve, [a, b], (camera.near - za) / (zb - za)));
            }
        }
        for i in 2..ring.len() {
            world.parts.push(Part { corners: [ring[0], ring[i - 1], ring[i]], ..part });
            waiting.push(world.parts.len() as u32 - 1);
        }
    }

    /// The edge to divide, if any: from nearer to farther corner.
    fn longest(&self, corners: [u32; 3]) -> Option<usize> {
        let ratio = |i: usize| {
            let [a, b] = [i, (i + 1) % 3].map(|k| self.seen[corners[k] as usize].inverse);
            if a > b { a / b } else { b / a }
        };
        let edge = (0..3).max_by(|&i, &j| ratio(i).total_cmp(&ratio(j)))?;
        (ratio(edge) > STRETCH).then_some(edge)
    }

    /// Divides a face at the point of an edge where 1/z is the geometric mean of its ends'.
    fn divide(
        &mut self,
        world: &mut World,
        camera: &Camera,
        curve: Curve,
        index: u32,
        edge: usize,
        waiting: &mut Vec<u32>,
    ) {
        let part = world.parts[index as usize];
        let [a, b, c] = [0, 1, 2].map(|i| part.corners[(edge + i) % 3]);
        let [za, zb] = [a, b].map(|i| self.seen[i as usize].depth);
        let middle = self.add_corner(world, camera, curve, [a, b], za.sqrt() / (za.sqrt() + zb.sqrt()));
        for corners in [[a, middle, c], [middle, b, c]] {
            world.parts.push(Part { corners, ..part });
            waiting.push(world.parts.len() as u32 - 1);
        }
    }

    /// Whether a face's box meets the picture and what views see beside it.
    fn may_be_seen(&self, corners: [u32; 3]) -> bool {
        let places = corners.map(|i| self.seen[i as usize].place);
        let lo = places[0].min(places[1]).min(places[2]);
        let hi = places[0].max(places[1]).max(places[2]);
        const BESIDE_PX: f32 = 16.0;
        hi.x > -BESIDE_PX
            && hi.y > -BESIDE_PX
            && lo.x < self.size[0] as f32 + BESIDE_PX
            && lo.y < self.size[1] as f32 + BESIDE_PX
    }

    /// Corners of a face in the samples of a view, `[x, y, nearness]`.
    #[inline]
    pub fn corners(&self, corners: [u32; 3], lens: Lens, step: Vec2) -> [[f32; 3]; 3] {
        corners.map(|i| {
            let seen = &self.seen[i as usize];
            let at = (seen.place - step * lens.disparity(seen.near)) * SUB as f32 + (SUB - 1) as f32 / 2.0;
            [at.x, at.y, seen.near]
        })
    }

    /// 1/z of a face's corners.
    #[inline]
    pub fn inverse(&self, corners: [u32; 3]) -> Vec3 {
        Vec3::from(corners.map(|i| self.seen[i as usize].inverse))
    }

    /// Draws one view.
    pub fn draw(&self, world: &World, lens: Lens, step: Vec2, buffer: &mut Buffer) {
        buffer.clear(self.size.map(|side| side * SUB));
        for &index in &self.visible {
            let part = &world.parts[index as usize];
            let corners = self.corners(part.corners, lens, step);
            buffer.part(world, (index, part), corners, |share| straight(share, self.inverse(part.corners)));
        }
    }
}

/// Shares of the corners in space, from those in the picture.
#[inline]
pub fn straight(share: Vec3, inverse: Vec3) -> Vec3 {
    let weighed = share * inverse;
    weighed * (weighed.x + weighed.y + weighed.z).recip()
}

/// Sum of three values by share.
#[inline]
pub fn mixed<T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>>([a, b, c]: [T; 3], share: Vec3) -> T {
    a * share.x + b * share.y + c * share.z
}

/// The face of a sample that meets none.
pub const NOTHING: u32 = u32::MAX;

/// Nearest faces of a view's samples.
#[derive(Default)]
pub struct Buffer {
    /// Width and height in samples.
    pub size: [usize; 2],
    /// Nearness, larger is nearer.
    pub near: Vec<f32>,
    /// Face, or [`NOTHING`].
    pub face: Vec<u32>,
}

impl Buffer {
    /// Empties it, for a view of this many samples.
    pub fn clear(&mut self, size: [usize; 2]) {
        self.size = size;
        self.near.clear();
        self.near.resize(size[0] * size[1], f32::NEG_INFINITY);
        self.face.clear();
        self.face.resize(size[0] * size[1], NOTHING);
    }

    /// Draws a face with its number; of one whose skin is cut out, what is left. `in_space` turns shares of the corners
    /// in the picture into those in space.
    #[inline]
    pub fn part(
        &mut self,
        world: &World,
        (id, part): (u32, &Part),
        corners: [[f32; 3]; 3],
        in_space: impl Fn(Vec3) -> Vec3,
    ) {
        match world.skin_of(part).filter(|skin| skin.cut_out) {
            None => self.triangle(id, corners),
            Some(skin) => {
                let uv = world.corners_of(part).map(|corner| corner.uv);
                self.triangle_where(id, corners, |share| {
                    let at = mixed(uv, in_space(share));
                    skin.covers(at.x, at.y)
                });
            }
        }
    }

    /// Draws a triangle of corners `[x, y, nearness]` where it is nearer than what is there.
    #[inline]
    pub fn triangle(&mut self, id: u32, corners: [[f32; 3]; 3]) {
        let nears = Vec3::from(corners.map(|corner| corner[2]));
        let Self { size, near, face } = self;
        each_row(*size, corners, |plane, y, places| {
            let slope = nears.dot(plane.dx);
            let row = y * size[0];
            let (near, face) = (&mut near[row..][places.clone()], &mut face[row..][places.clone()]);
            let first = nears.dot(plane.at(places.start as f32, y as f32));
            // Written whatever is nearer, that several are done at once.
            for ((near, face), i) in near.iter_mut().zip(face).zip(0i32..) {
                let here = first + i as f32 * slope;
                let is_nearer = here > *near;
                *near = if is_nearer { here } else { *near };
                *face = if is_nearer { id } else { *face };
            }
        });
    }

    /// The same where `keep` agrees too, which is given the shares of the corners.
    #[inline]
    pub fn triangle_where(&mut self, id: u32, corners: [[f32; 3]; 3], keep: impl Fn(Vec3) -> bool) {
        let nears = Vec3::from(corners.map(|corner| corner[2]));
        let Self { size, near, face } = self;
        each_row(*size, corners, |plane, y, places| {
            for x in places {
                let (i, share) = (y * size[0] + x, plane.at(x as f32, y as f32));
                let here = nears.dot(share);
                if here > near[i] && keep(share) {
                    (near[i], face[i]) = (here, id);
                }
            }
        });
    }
}

/// Calls with each row of a picture that a triangle meets, and with the places in it.
#[inline]
fn each_row([w, h]: [usize; 2], corners: [[f32; 3]; 3], mut with: impl FnMut(&Shares, usize, Range<usize>)) {
    let least = |axis: usize| corners[0][axis].min(corners[1][axis]).min(corners[2][axis]);
    let most = |axis: usize| corners[0][axis].max(corners[1][axis]).max(corners[2][axis]);
    let (top, bottom) = (ceil(least(1).max(0.0)), floor(most(1).min((h - 1) as f32)));
    let (left, right) = (ceil(least(0).max(0.0)), floor(most(0).min((w - 1) as f32)));
    // Also false for what is no number.
    if !(top <= bottom && left <= right) {
        return;
    }
    let Some(plane) = Shares::new(corners) else { return };
    let reach = plane.dx.recip();
    for y in top as usize..=bottom as usize {
        if let Some((from, to)) = plane.span(y as f32, left, right, reach) {
            with(&plane, y, from as usize..to as usize + 1);
        }
    }
}

/// Rows of a triangle are a little wider than exact, so that no sample falls between two faces.
const WIDER: f32 = 1e-3;

#[inline]
fn ceil(value: f32) -> f32 {
    -floor(-value)
}

/// Shares of a triangle's corners as functions of the place.
pub struct Shares {
    origin: Vec2,
    dx: Vec3,
    dy: Vec3,
}

impl Shares {
    /// None of a triangle without area.
    #[inline]
    pub fn new([a, b, c]: [[f32; 3]; 3]) -> Option<Self> {
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area.abs() < 1e-6 {
            return None;
        }
        let k = 1.0 / area;
        let dx = [(c[1] - a[1]) * k, (a[1] - b[1]) * k];
        let dy = [(a[0] - c[0]) * k, (b[0] - a[0]) * k];
        let whole = |[second, third]: [f32; 2]| Vec3::new(-second - third, second, third);
        Some(Self { origin: Vec2::new(a[0], a[1]), dx: whole(dx), dy: whole(dy) })
    }

    /// The shares at a place.
    #[inline]
    pub fn at(&self, x: f32, y: f32) -> Vec3 {
        let (x, y) = (x - self.origin.x, y - self.origin.y);
        let second = x * self.dx.y + y * self.dy.y;
        let third = x * self.dx.z + y * self.dy.z;
        Vec3::new(1.0 - second - third, second, third)
    }

    /// First and last place of a row inside. `reach` is how far a whole share is along a row.
    #[inline]
    fn span(&self, y: f32, left: f32, right: f32, reach: Vec3) -> Option<(f32, f32)> {
        let (mut from, mut to) = (left, right);
        let there = self.at(left, y);
        let ends = Vec3::splat(left) - there * reach;
        for (slope, (value, end)) in
            [(self.dx.x, (there.x, ends.x)), (self.dx.y, (there.y, ends.y)), (self.dx.z, (there.z, ends.z))]
        {
            if slope > 0.0 {
                from = from.max(end - WIDER);
            } else if slope < 0.0 {
                to = to.min(end + WIDER);
            } else if value < 0.0 {
                return None;
            }
        }
        let (from, to) = (ceil(from), floor(to));
        (from <= to).then_some((from, to))
    }
}
