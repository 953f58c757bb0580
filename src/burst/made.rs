//! Made bursts for tests: a room with things in it, seen by a hand-held camera whose poses are known.

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::camera::{Focal, Pose, place_of_pixel};
use super::start::turned;
use crate::field::color::srgb8_from_linear;
use crate::field::{Raster, Size, View};

/// How a burst is taken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Taking {
    pub(crate) seed: u32,
    pub(crate) size: Size,
    pub(crate) frames: usize,
    /// How far the hand goes, in metres.
    pub(crate) hand_m: f64,
    /// How far the hand turns, in radians.
    pub(crate) turn: f64,
    /// Standard deviation of the noise, sRGB 0 … 255.
    pub(crate) noise: f32,
    /// Exposure varies by so many stops.
    pub(crate) stops: f32,
    /// Radians that the camera turns while a frame is read.
    pub(crate) rolling: f64,
    /// How far one thing moves between frames, in metres.
    pub(crate) moving_m: f64,
}

impl Default for Taking {
    fn default() -> Self {
        let (noise, stops, rolling) = (5.0, 0.3, 0.002);
        Self { seed: 1, size: [640, 480], frames: 8, hand_m: 0.02, turn: 0.02, noise, stops, rolling, moving_m: 0.05 }
    }
}

/// The lens of made bursts.
pub(crate) const FOCAL: Focal = Focal(28.0 / 36.0);

/// A number from 0 to 1 of a place in a table that never repeats.
pub(crate) fn chance(seed: u32, i: i32, j: i32) -> f64 {
    let mut n =
        seed.wrapping_mul(0x9e37_79b9) ^ (i as u32).wrapping_mul(0x85eb_ca6b) ^ (j as u32).wrapping_mul(0xc2b2_ae35);
    n ^= n >> 15;
    n = n.wrapping_mul(0x2c1b_3c6d);
    n ^= n >> 12;
    n = n.wrapping_mul(0x297a_2d39);
    f64::from(n ^ (n >> 15)) / f64::from(u32::MAX)
}

fn signed(seed: u32, i: i32, j: i32) -> f64 {
    2.0 * chance(seed, i, j) - 1.0
}

/// Smooth noise of a scale.
fn cloud(seed: u32, x: f64, y: f64) -> f64 {
    let (i, j) = (x.floor(), y.floor());
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let (fx, fy) = (ease(x - i), ease(y - j));
    let at = |di: i32, dj: i32| chance(seed, i as i32 + di, j as i32 + dj);
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    mix(mix(at(0, 0), at(1, 0), fx), mix(at(0, 1), at(1, 1), fx), fy)
}

/// A surface's colour at a place of it in metres, linear light.
fn paint(seed: u32, x: f64, y: f64) -> DVec3 {
    let tint = DVec3::new(chance(seed, 1, 7), chance(seed, 2, 7), chance(seed, 3, 7)) * 0.7 + 0.15;
    let other = DVec3::new(chance(seed, 4, 7), chance(seed, 5, 7), chance(seed, 6, 7)) * 0.6 + 0.1;
    let octaves = [(6.0, 0.5), (23.0, 0.3), (90.0, 0.25), (260.0, 0.15)];
    let value: f64 = octaves.iter().enumerate().map(|(n, (f, a))| a * cloud(seed + n as u32, x * f, y * f)).sum();
    let edge = (value - 0.58).clamp(-0.06, 0.06) / 0.12 + 0.5;
    (tint * (1.0 - edge) + other * edge) * (0.5 + value)
}

/// A rectangle in space: its middle, its half sides.
struct Board {
    middle: DVec3,
    across: DVec3,
    down: DVec3,
    seed: u32,
    moves: bool,
}

/// The room: a wall, a floor, and boards at many depths.
fn room(seed: u32) -> Vec<Board> {
    let board =
        |middle: DVec3, across: DVec3, down: DVec3, seed: u32| Board { middle, across, down, seed, moves: false };
    let mut all = vec![
        board(DVec3::new(0.0, 0.0, 3.0), DVec3::new(6.0, 0.0, 0.8), DVec3::new(0.0, 5.0, 0.0), seed * 31 + 1),
        board(DVec3::new(0.0, 0.9, 2.5), DVec3::new(6.0, 0.0, 0.0), DVec3::new(0.0, 0.0, 2.4), seed * 31 + 2),
    ];
    for i in 0..7 {
        let z = 0.6 + 0.28 * f64::from(i) + 0.1 * signed(seed, i, 11);
        let middle = DVec3::new(0.55 * z * signed(seed, i, 12), 0.35 * z * signed(seed, i, 13), z);
        let size = 0.12 * z * (0.6 + chance(seed, i, 14));
        let slant = 0.5 * signed(seed, i, 15);
        let across = DVec3::new(size, 0.0, size * slant);
        all.push(board(middle, across, DVec3::new(0.1 * size, 1.3 * size, 0.0), seed * 31 + 3 + i as u32));
    }
    if let Some(last) = all.get_mut(6) {
        last.moves = true;
    }
    all
}

impl Board {
    /// Distance along a ray, and where on the board it meets it.
    fn met(&self, from: DVec3, along: DVec3, moved: DVec3) -> Option<(f64, f64, f64)> {
        let normal = self.across.cross(self.down);
        let middle = self.middle + moved;
        let way = (middle - from).dot(normal) / along.dot(normal);
        let at = from + along * way - middle;
        let part = |side: DVec3| at.dot(side) / side.length_squared();
        // Sides need not be perpendicular: solve for both.
        let (aa, ab, bb) = (self.across.length_squared(), self.across.dot(self.down), self.down.length_squared());
        let (pa, pb) = (part(self.across) * aa, part(self.down) * bb);
        let det = aa * bb - ab * ab;
        let (u, v) = ((pa * bb - pb * ab) / det, (pb * aa - pa * ab) / det);
        (way > 0.05 && u.abs() <= 1.0 && v.abs() <= 1.0).then_some((way, u * aa.sqrt(), v * bb.sqrt()))
    }
}

/// A burst, the poses, and the true inverse depth of the first photo in inverse metres.
pub(crate) struct Made {
    pub(crate) views: Vec<View>,
    pub(crate) poses: Vec<Pose>,
    pub(crate) inverse_depth: Raster<f32>,
    boards: Vec<Board>,
    taking: Taking,
}

impl Made {
    pub(crate) fn new(taking: Taking) -> Self {
        let boards = room(taking.seed);
        let poses: Vec<Pose> = (0..taking.frames).map(|frame| pose(&taking, frame)).collect();
        let mut made = Self { views: Vec::new(), inverse_depth: Raster::filled([1, 1], 0.0), poses, boards, taking };
        made.views = (0..taking.frames).map(|frame| made.photo(frame)).collect();
        made.inverse_depth = Raster::par_from_fn(taking.size, |x, y| {
            let ray = FOCAL.ray(place_of_pixel(taking.size, x as f64, y as f64));
            made.hit(DVec3::ZERO, ray, DVec3::ZERO).map_or(0.0, |hit| (1.0 / hit.0) as f32)
        });
        made
    }

    /// Depth, and colour.
    fn hit(&self, from: DVec3, along: DVec3, moved: DVec3) -> Option<(f64, DVec3)> {
        let met = self.boards.iter().filter_map(|board| {
            let by = if board.moves { moved } else { DVec3::ZERO };
            board.met(from, along, by).map(|(way, u, v)| (way, board.seed, u, v))
        });
        met.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(way, seed, u, v)| (way, paint(seed, u, v)))
    }

    /// Where the thing that moves is in the first photo.
    pub(crate) fn moving(&self, size: Size) -> Vec<bool> {
        let [w, h] = [size[0] as usize, size[1] as usize];
        let of = |i: usize| {
            let ray = FOCAL.ray(place_of_pixel(size, (i % w) as f64, (i / w) as f64));
            let met = self.boards.iter().filter_map(|b| Some((b.met(DVec3::ZERO, ray, DVec3::ZERO)?.0, b.moves)));
            met.min_by(|a, b| a.0.total_cmp(&b.0)).is_some_and(|met| met.1)
        };
        (0..w * h).map(of).collect()
    }

    fn photo(&self, frame: usize) -> View {
        let t = self.taking;
        let moved = DVec3::new(t.moving_m * frame as f64 / t.frames.max(1) as f64, 0.0, 0.0);
        let gain = if frame == 0 { 1.0 } else { 2f64.powf(f64::from(t.stops) * signed(t.seed, frame as i32, 21)) };
        let noise = |x: usize, y: usize, c: usize| {
            let at = |k: i32| signed(t.seed + 77 * frame as u32, (x * 4 + c) as i32, (y * 8) as i32 + k);
            1.22 * t.noise * (at(0) + at(1)) as f32
        };
        self.render(t.size, &self.poses[frame], moved, |[x, y], light| {
            let coded = (light * gain).to_array().map(|c| f32::from(srgb8_from_linear(c as f32)));
            [0, 1, 2].map(|c| (coded[c] + noise(x, y, c)).round().clamp(0.0, 255.0) as u8)
        })
    }

    fn render(
        &self,
        size: Size,
        pose: &Pose,
        moved: DVec3,
        colour: impl Fn([usize; 2], DVec3) -> [u8; 3] + Sync,
    ) -> View {
        let seen = |x: f64, y: f64| {
            let at = place_of_pixel(size, x, y);
            let ray = FOCAL.ray(at);
            // The row's own rotation, undone.
            let turned_back = ray - (pose.turning * at.y).cross(ray);
            let along = pose.rotation.transpose() * turned_back;
            let from = pose.centre();
            self.hit(from, along, moved).map_or(DVec3::ZERO, |hit| hit.1)
        };
        // Nine rays a pixel over a little more than it: half a pixel of blur.
        let offsets = [-0.45, 0.0, 0.45];
        let pixel = |x: usize, y: usize| {
            let rays = offsets.iter().flat_map(|dy| offsets.iter().map(move |dx| (*dx, *dy)));
            rays.map(|(dx, dy)| seen(x as f64 + dx, y as f64 + dy)).sum::<DVec3>() / 9.0
        };
        let [w, h] = [size[0] as usize, size[1] as usize];
        let of = |i: usize| {
            let [r, g, b] = colour([i % w, i / w], pixel(i % w, i / w));
            [r, g, b, 255]
        };
        View::new(size, (0..w * h).into_par_iter().map(of).collect::<Vec<_>>().into_flattened()).unwrap()
    }
}

/// Where a hand holds the camera: the first frame is the reference.
fn pose(taking: &Taking, frame: usize) -> Pose {
    if frame == 0 {
        return Pose::REFERENCE;
    }
    let of = |k: i32| signed(taking.seed, frame as i32, 30 + k);
    let angle = 2.4 * frame as f64 + taking.seed as f64;
    let out = taking.hand_m * (0.6 + 0.4 * of(0).abs());
    let centre = DVec3::new(out * angle.cos(), out * angle.sin(), 0.3 * taking.hand_m * of(1));
    let rotation = turned(DMat3::IDENTITY, DVec3::new(of(2), of(3), of(4)) * taking.turn);
    let turning = DVec3::new(of(5), of(6), 0.3 * of(7)) * taking.rolling;
    Pose { rotation, translation: -(rotation * centre), turning }
}

/// Gain and shift that bring values nearest to others, by the sum of distances.
pub(crate) fn fit(from: &[f32], to: &[f32]) -> [f32; 2] {
    let (mut gain, mut shift) = (0.0f64, 0.0f64);
    for round in 0..12 {
        let mut sums = [0.0f64; 5];
        for (a, b) in from.iter().zip(to).map(|(a, b)| (f64::from(*a), f64::from(*b))) {
            let weight = if round == 0 { 1.0 } else { 1.0 / (0.01 + (gain * a + shift - b).abs()) };
            [1.0, a, b, a * a, a * b].iter().zip(&mut sums).for_each(|(v, sum)| *sum += weight * v);
        }
        let [n, a, b, aa, ab] = sums;
        gain = (ab - a * b / n) / (aa - a * a / n);
        shift = (b - gain * a) / n;
    }
    [gain as f32, shift as f32]
}

/// Where the true camera sees a point of the reference photo.
pub(crate) fn truly_seen(made: &Made, frame: usize, at: DVec2, inverse_depth: f64) -> DVec2 {
    FOCAL.seen(&made.poses[frame], at, inverse_depth)
}

impl Made {
    /// What a camera at a place of the reference camera's plane sees, shifted so that what has this inverse depth stays.
    pub(crate) fn sheared(&self, size: Size, centre: DVec3, focus: f64) -> View {
        let pixel = |i: usize| {
            let [w, _] = [size[0] as usize, 0];
            let rays = [-0.45, 0.0, 0.45].into_iter().flat_map(|dy| [-0.45, 0.0, 0.45].map(|dx| (dx, dy)));
            let light = rays.map(|(dx, dy)| {
                let at = place_of_pixel(size, (i % w) as f64 + dx, (i / w) as f64 + dy);
                let along = FOCAL.ray(at) - centre * focus;
                self.hit(centre, along, DVec3::ZERO).map_or(DVec3::ZERO, |hit| hit.1)
            });
            let light = light.sum::<DVec3>() / 9.0;
            let [r, g, b] = light.to_array().map(|c| srgb8_from_linear(c as f32));
            [r, g, b, 255]
        };
        let count = size[0] as usize * size[1] as usize;
        View::new(size, (0..count).into_par_iter().map(pixel).collect::<Vec<_>>().into_flattened()).unwrap()
    }
}
