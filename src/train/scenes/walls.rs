//! Procedural backdrops that stand upright: fences of boards, brick walls, hedges. The background of a photo may be a
//! ground or a wall; of these it is known that their lower part is no nearer than their upper one.

use plenoscope::field::ramp;

use super::raster::{Raster, floor};
use crate::rng::Rng;

/// An upright backdrop over a canvas in colours of the photo, 0 … 255.
pub fn wall(rng: &mut Rng, size: [usize; 2], photo: &Raster<[u8; 3]>) -> Raster<[f32; 3]> {
    let mut rgb = match rng.weighted(&[0.4, 0.2, 0.4]) {
        0 => boards(rng, size, photo),
        1 => bricks(rng, size, photo),
        _ => hedge(rng, size, photo),
    };
    shine(rng, &mut rgb);
    rgb
}

/// How an upright backdrop lies in depth: nearness of each pixel, at most a little turned.
pub fn upright(rng: &mut Rng, size: [usize; 2]) -> Raster<f32> {
    let near = rng.range(0.05, 0.5);
    let [across, down] = [rng.range(-0.08, 0.08), rng.range(-0.04, 0.04)];
    let [w, h] = size.map(|side| side as f32);
    Raster::from_fn(size, |x, y| near + across * (2.0 * x as f32 / w - 1.0) + down * (2.0 * y as f32 / h - 1.0))
}

/// A colour of the photo, not too dark.
fn colour(rng: &mut Rng, photo: &Raster<[u8; 3]>) -> [f32; 3] {
    let drawn = photo.px[rng.below(photo.px.len())].map(f32::from);
    drawn.map(|c| 0.85 * c + 25.0)
}

/// A number from 0 to 1 that belongs to a cell.
fn hash(seed: u64, cell: [i32; 2]) -> f32 {
    Rng::new(seed, (cell[0] as u32 as u64) << 32 | u64::from(cell[1] as u32)).unit()
}

/// Smooth noise 0 … 1, one value a unit.
pub(super) fn noise(seed: u64, x: f32, y: f32) -> f32 {
    let (x0, y0) = (floor(x), floor(y));
    let (fx, fy) = (ramp(0.0, 1.0, x - x0), ramp(0.0, 1.0, y - y0));
    let at = |dx: i32, dy: i32| hash(seed, [x0 as i32 + dx, y0 as i32 + dy]);
    let row = |dy: i32| at(0, dy) * (1.0 - fx) + at(1, dy) * fx;
    row(0) * (1.0 - fy) + row(1) * fy
}

/// Boards side by side with dark gaps, each of its own shade and grain; upright or lying.
fn boards(rng: &mut Rng, size: [usize; 2], photo: &Raster<[u8; 3]>) -> Raster<[f32; 3]> {
    let long = size[0].max(size[1]) as f32;
    let (wide, gap) = (rng.range(0.03, 0.14) * long, rng.range(0.02, 0.15));
    let (base, spread, grain, seed) = (colour(rng, photo), rng.range(0.1, 0.6), rng.range(0.0, 0.6), rng.next_u64());
    let turn = rng.range(-0.08, 0.08) + if rng.chance(0.3) { std::f32::consts::FRAC_PI_2 } else { 0.0 };
    let (sin, cos) = f32::sin_cos(turn);
    let depth_of_gap = rng.range(0.2, 0.8);
    Raster::from_fn(size, |x, y| {
        let (x, y) = (x as f32, y as f32);
        let [across, along] = [cos * x + sin * y + 4.0 * long, cos * y - sin * x];
        let board = (across / wide).floor();
        let inside = across / wide - board;
        let shade = 1.0 + spread * (hash(seed, [board as i32, 0]) - 0.5);
        let streak = 1.0 + grain * (noise(seed ^ board as u64, across / 1.5, along / 12.0) - 0.5);
        // Over a pixel and a half from light to dark.
        let edge = ((inside.min(1.0 - inside) - 0.5 * gap) * wide / 1.5).clamp(0.0, 1.0);
        let light = shade * streak * (depth_of_gap + (1.0 - depth_of_gap) * edge);
        base.map(|c| c * light)
    })
}

/// Courses of bricks or tiles with joints of another brightness.
fn bricks(rng: &mut Rng, size: [usize; 2], photo: &Raster<[u8; 3]>) -> Raster<[f32; 3]> {
    let tall = rng.range(0.03, 0.12) * size[1] as f32;
    let (wide, shift) = (tall * rng.range(1.0, 3.0), if rng.chance(0.8) { 0.5 } else { 0.0 });
    let (base, joint, spread) = (colour(rng, photo), rng.range(0.5, 1.6), rng.range(0.05, 0.6));
    let (seed, rough) = (rng.next_u64(), rng.range(0.0, 0.5));
    Raster::from_fn(size, |x, y| {
        let course = (y as f32 / tall).floor();
        let along = x as f32 / wide + shift * course;
        let brick = [along.floor() as i32, course as i32];
        let [inside_x, inside_y] = [along - along.floor(), y as f32 / tall - course];
        let to_joint = (inside_x.min(1.0 - inside_x) * wide).min(inside_y.min(1.0 - inside_y) * tall);
        let solid = (to_joint - 0.3).clamp(0.0, 1.0);
        let grain = 1.0 + rough * (noise(seed, x as f32 / 2.0, y as f32 / 2.0) - 0.5);
        let shade = 1.0 + spread * (hash(seed, brick) - 0.5);
        base.map(|c| c * grain * (joint + (shade - joint) * solid))
    })
}

/// Leaf upon leaf, a few colours of the photo in many shades.
fn hedge(rng: &mut Rng, size: [usize; 2], photo: &Raster<[u8; 3]>) -> Raster<[f32; 3]> {
    let base = [0; 3].map(|_: i32| colour(rng, photo));
    let dark = rng.range(0.2, 0.7);
    let mut rgb = Raster::from_fn(size, |_, _| base[0].map(|c| c * dark));
    let [w, h] = size.map(|side| side as f32);
    let half = rng.range(0.012, 0.06) * w.max(h);
    // Enough to cover the canvas twice.
    let count = (2.0 * w * h / (half * half)).min(900.0) as usize;
    for _ in 0..count {
        let middle = [rng.range(0.0, w), rng.range(0.0, h)];
        let (long, slim) = (half * rng.range(0.6, 1.4), rng.range(0.25, 0.8));
        let (sin, cos) = f32::sin_cos(rng.range(0.0, std::f32::consts::TAU));
        let (leaf, shade) = (base[rng.below(3)], rng.range(dark, 1.4));
        let span = |at: f32, all: usize| (at - long).max(0.0) as usize..((at + long + 1.0).max(0.0) as usize).min(all);
        for y in span(middle[1], size[1]) {
            for x in span(middle[0], size[0]) {
                let (dx, dy) = (x as f32 - middle[0], y as f32 - middle[1]);
                let (along, across) = ((cos * dx + sin * dy) / long, (cos * dy - sin * dx) / (long * slim));
                if along * along + across * across < 1.0 {
                    rgb.px[y * size[0] + x] = leaf.map(|c| c * shade * (1.0 + 0.2 * across));
                }
            }
        }
    }
    rgb
}

/// Uneven light over the whole.
fn shine(rng: &mut Rng, rgb: &mut Raster<[f32; 3]>) {
    let (seed, strength) = (rng.next_u64(), rng.range(0.0, 0.5));
    let unit = rng.range(0.2, 0.8) * rgb.size[0].max(rgb.size[1]) as f32;
    let wide = rgb.size[0];
    for (i, texel) in rgb.px.iter_mut().enumerate() {
        let light = 1.0 + strength * (noise(seed, (i % wide) as f32 / unit, (i / wide) as f32 / unit) - 0.5);
        *texel = texel.map(|c| (c * light).clamp(0.0, 255.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [60, 44];

    #[test]
    fn a_walls_foot_is_hardly_nearer_than_its_top() {
        for seed in 0..20 {
            let depth = upright(&mut Rng::new(seed, 0), SIZE);
            let row = |y: usize| depth.px[y * SIZE[0]..][..SIZE[0]].iter().sum::<f32>() / SIZE[0] as f32;
            assert!((row(SIZE[1] - 1) - row(0)).abs() < 0.1);
            assert!(depth.px.iter().all(|z| (-0.1..0.7).contains(z)));
        }
    }

    #[test]
    fn a_wall_has_the_photos_hue_and_structure() {
        // A photo of pure reds: walls made of it have no blue but what brightens all colours alike.
        let photo = Raster::from_fn(SIZE, |x, _| [(120 + x) as u8, 0, 0]);
        for seed in 0..20 {
            let rgb = wall(&mut Rng::new(seed, 0), SIZE, &photo);
            assert!(rgb.px.iter().flatten().all(|c| (0.0..=255.0).contains(c)));
            assert!(rgb.px.iter().all(|c| c[0] >= c[1] && c[1] == c[2]));
            let mean = rgb.px.iter().map(|c| c[0]).sum::<f32>() / rgb.px.len() as f32;
            let spread = rgb.px.iter().map(|c| (c[0] - mean).abs()).sum::<f32>() / rgb.px.len() as f32;
            assert!(spread > 1.0, "seed {seed}: flat, {spread}");
        }
    }
}
