//! Shapes made by rule, to be painted: their texture places are metres.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::mesh::Mesh;
use crate::rng::Rng;

/// A parallelogram of `cells` cells each way, from a corner along two edges; u along the first, v against the second.
pub fn slab(corner: Vec3, along: Vec3, up: Vec3, cells: [usize; 2]) -> Mesh {
    let size = Vec2::new(along.length(), up.length());
    sheet(cells, |s, t| (corner + along * s + up * t, Vec2::new(s * size.x, (1.0 - t) * size.y)))
}

/// A sheet of cells from a function of s and t in 0 … 1.
pub fn sheet(cells: [usize; 2], mut at: impl FnMut(f32, f32) -> (Vec3, Vec2)) -> Mesh {
    let [n, m] = cells.map(|c| c.max(1));
    let mut corners = Vec::with_capacity((n + 1) * (m + 1));
    for j in 0..=m {
        corners.extend((0..=n).map(|i| at(i as f32 / n as f32, j as f32 / m as f32)));
    }
    let mut faces = Vec::with_capacity(2 * n * m);
    for j in 0..m {
        for i in 0..n {
            let a = (j * (n + 1) + i) as u32;
            let (b, c, d) = (a + 1, a + n as u32 + 2, a + n as u32 + 1);
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    Mesh::plain(corners, faces)
}

/// A box standing on y = 0 about the origin.
pub fn cuboid(size: Vec3) -> Mesh {
    let (x, y, z) = (size.x / 2.0, size.y, size.z / 2.0);
    let sides: [[Vec3; 3]; 6] = [
        [Vec3::new(-x, 0.0, z), Vec3::X * size.x, Vec3::Y * y],
        [Vec3::new(x, 0.0, -z), -Vec3::X * size.x, Vec3::Y * y],
        [Vec3::new(x, 0.0, z), -Vec3::Z * size.z, Vec3::Y * y],
        [Vec3::new(-x, 0.0, -z), Vec3::Z * size.z, Vec3::Y * y],
        [Vec3::new(-x, y, z), Vec3::X * size.x, -Vec3::Z * size.z],
        [Vec3::new(-x, 0.0, -z), Vec3::X * size.x, Vec3::Z * size.z],
    ];
    let (mut corners, mut faces) = (Vec::new(), Vec::new());
    for [corner, along, up] in sides {
        let first = corners.len() as u32;
        let (w, h) = (along.length(), up.length());
        let four = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        corners.extend(four.map(|(s, t)| (corner + along * s + up * t, Vec2::new(s * w, (1.0 - t) * h))));
        faces.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    Mesh::plain(corners, faces)
}

/// A body of revolution about the y axis; the profile is radius and height from below to above.
pub fn lathe(profile: &[[f32; 2]], sides: usize) -> Mesh {
    let rows = profile.len().max(2) - 1;
    let round = profile.iter().map(|p| p[0]).fold(0.0, f32::max) * TAU;
    sheet([sides, rows], |s, t| {
        let [radius, height] = profile[(t * rows as f32 + 0.5) as usize];
        let (sin, cos) = (s * TAU).sin_cos();
        (Vec3::new(radius * cos, height, radius * sin), Vec2::new(s * round, -height))
    })
}

/// A tube along points, its radius running from the first to the second.
pub fn tube(points: &[Vec3], radius: [f32; 2], sides: usize) -> Mesh {
    let rows = points.len().max(2) - 1;
    let mut length = 0.0;
    let mut rings = Vec::with_capacity(points.len());
    for (i, &point) in points.iter().enumerate() {
        let way = (points[(i + 1).min(rows)] - points[i.saturating_sub(1)]).normalize_or(Vec3::Y);
        let side = way.any_orthonormal_vector();
        length += if i > 0 { point.distance(points[i - 1]) } else { 0.0 };
        rings.push((point, side, way.cross(side), length));
    }
    sheet([sides, rows], |s, t| {
        let (point, a, b, length) = rings[(t * rows as f32 + 0.5) as usize];
        let (sin, cos) = (s * TAU).sin_cos();
        let radius = radius[0] + (radius[1] - radius[0]) * t;
        (point + (a * cos + b * sin) * radius, Vec2::new(s * TAU * radius, -length))
    })
}

/// Points of a cable that hangs through between two places.
pub fn hanging(from: Vec3, to: Vec3, sag: f32, count: usize) -> Vec<Vec3> {
    let at = |i: usize| {
        let t = i as f32 / count as f32;
        from.lerp(to, t) - Vec3::Y * (4.0 * sag * t * (1.0 - t))
    };
    (0..=count).map(at).collect()
}

/// Points of a stem that bends as it rises.
pub fn stem(rng: &mut Rng, from: Vec3, way: Vec3, length: f32, bend: f32, count: usize) -> Vec<Vec3> {
    let (mut at, mut way) = (from, way.normalize_or(Vec3::Y));
    let mut points = vec![at];
    for _ in 0..count {
        at += way * (length / count as f32);
        points.push(at);
        way = (way + bend * any_way(rng) / count as f32).normalize_or(Vec3::Y);
    }
    points
}

/// A random direction, not quite even.
pub fn any_way(rng: &mut Rng) -> Vec3 {
    Vec3::new(rng.normal(), rng.normal(), rng.normal()).normalize_or(Vec3::X)
}

/// Leaves, each a bent kite of four faces, drawn one after the other by `place`: foot, way to the tip, and width.
pub fn leaves(count: usize, place: impl FnMut(usize) -> (Vec3, Vec3, f32)) -> Mesh {
    outlined(&[[0.45, 1.0]], 0.0, count, place)
}

/// The same, round and arched, to be seen from near.
pub fn round_leaves(count: usize, place: impl FnMut(usize) -> (Vec3, Vec3, f32)) -> Mesh {
    outlined(&[[0.2, 0.72], [0.48, 1.0], [0.78, 0.66]], 0.25, count, place)
}

/// Leaves that are as wide as told at shares of their length, and arched by a share of it.
fn outlined(rows: &[[f32; 2]], arch: f32, count: usize, mut place: impl FnMut(usize) -> (Vec3, Vec3, f32)) -> Mesh {
    let (n, mut corners, mut faces) = (rows.len() as u32, Vec::new(), Vec::new());
    for i in 0..count {
        let (foot, way, width) = place(i);
        let side = way.cross(Vec3::Y).normalize_or(Vec3::X) * width / 2.0;
        let fold = way.cross(side).normalize_or(Vec3::Y) * width * 0.15;
        let (first, long) = (corners.len() as u32, way.length());
        corners.push((foot, Vec2::new(0.5 * width, long)));
        for &[t, wide] in rows {
            let middle = foot + way * t + Vec3::Y * (arch * t * (1.0 - t) * long);
            for k in [-1.0, 0.0, 1.0f32] {
                let across = side * k * wide + fold * k.abs() * wide;
                let uv = Vec2::new((0.5 + 0.5 * k * wide) * width, (1.0 - t) * long);
                corners.push((middle + across, uv));
            }
        }
        corners.push((foot + way, Vec2::new(0.5 * width, 0.0)));
        let tip = 3 * n + 1;
        let mut add = |more: &[[u32; 3]]| faces.extend(more.iter().map(|face| face.map(|k| k + first)));
        add(&[[0, 1, 2], [0, 2, 3]]);
        for row in 0..n - 1 {
            let [a, b] = [3 * row + 1, 3 * row + 4];
            add(&[[a, b, b + 1], [a, b + 1, a + 1], [a + 1, b + 1, b + 2], [a + 1, b + 2, a + 2]]);
        }
        add(&[[tip - 3, tip, tip - 2], [tip - 2, tip, tip - 1]]);
    }
    Mesh::plain(corners, faces)
}

/// Several meshes to paint as one.
pub fn together(meshes: impl IntoIterator<Item = Mesh>) -> Mesh {
    let mut all = Mesh::default();
    for mesh in meshes {
        let first = all.corners.len() as u32;
        all.corners.extend(mesh.corners);
        all.faces.extend(mesh.faces.into_iter().map(|mut face| {
            face.corners = face.corners.map(|i| i + first);
            face
        }));
    }
    all
}
