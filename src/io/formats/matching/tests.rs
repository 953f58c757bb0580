//! Pairs whose shifts are known.

use super::stereo;
use crate::field::{Raster, RelativeDepth};

/// Blotchy texture at any place: sums of a few waves.
pub(crate) fn texture(x: f32, y: f32) -> f32 {
    let wave = |fx: f32, fy: f32, phase: f32| (x * fx + y * fy + phase).sin();
    0.5 + 0.12 * (wave(0.31, 0.17, 0.3) + wave(-0.23, 0.41, 1.7) + wave(0.53, -0.29, 2.1) + wave(0.11, 0.07, 0.9))
}

const SIZE: [u32; 2] = [160, 120];

fn at(map: &RelativeDepth, x: usize, y: usize) -> f32 {
    map.nearness()[y * SIZE[0] as usize + x]
}

/// The left eye's picture; in the right eye's one the square has moved 6 px to the left, the rest 1 px.
fn square() -> [Raster<f32>; 2] {
    let inside = |x: i32, y: i32| (60..100).contains(&x) && (40..80).contains(&y);
    [[0.0, 0.0], [6.0, 1.0]].map(|shift| {
        Raster::from_fn(SIZE, |x, y| {
            let (x, y) = (x as f32, y as f32);
            let near = inside((x + shift[0]) as i32, y as i32);
            if near { texture(x + shift[0], y + 500.0) } else { texture(x + shift[1], y) }
        })
    })
}

#[test]
fn a_near_square_stands_out_with_the_right_sign() {
    let [left, right] = square();
    let map = stereo(left.clone(), right.clone(), -1.0).unwrap();
    assert!((at(&map, 80, 60) - 6.0).abs() < 0.1 && (at(&map, 30, 100) - 1.0).abs() < 0.1);
    let back = stereo(right, left, 1.0).unwrap();
    assert!((at(&back, 74, 60) - 6.0).abs() < 0.1 && (at(&back, 130, 100) - 1.0).abs() < 0.1);
}

#[test]
fn its_edge_is_where_it_is_and_what_one_eye_sees_alone_is_far() {
    let [left, right] = square();
    let darker = Raster::from_fn(SIZE, |x, y| 0.6 * right.at(x, y) + 0.02);
    let map = stereo(left, darker, -1.0).unwrap();
    let wrong = |x: usize, y: usize| {
        let want = if (60..100).contains(&x) && (40..80).contains(&y) { 6.0 } else { 1.0 };
        (at(&map, x, y) - want).abs() > 0.5
    };
    // The left eye alone sees the five columns left of the square, and what is left of the other eye's picture.
    let off = (0..120).flat_map(|y| (0..160).map(move |x| (x, y))).filter(|(x, y)| wrong(*x, *y)).count();
    assert!(off < 120 * 160 * 3 / 200, "{off} pixels are wrong");
}

#[test]
fn a_slope_is_no_staircase() {
    let shift = |x: f32| 2.0 + x * 0.02;
    // The right eye sees at x − shift(x) what the left one sees at x.
    let right = Raster::from_fn(SIZE, |x, y| texture((x as f32 + 2.0) / 0.98, y as f32));
    let left = Raster::from_fn(SIZE, |x, y| texture(x as f32, y as f32));
    let map = stereo(left, right, -1.0).unwrap();
    let all = (20..100).flat_map(|y| (20..140).map(move |x| (x, y)));
    let apart: f32 = all.map(|(x, y)| (at(&map, x, y) - shift(x as f32)).abs()).sum::<f32>() / (80.0 * 120.0);
    assert!(apart < 0.15, "{apart} px in the mean");
}

#[test]
fn pictures_of_different_things_are_no_pair() {
    let chance =
        |x: usize, y: usize, seed: f32| ((x as f32 * 12.99 + y as f32 * 78.23 + seed).sin() * 43_758.547).fract().abs();
    let noise = |seed: f32| Raster::from_fn(SIZE, |x, y| chance(x, y, seed));
    assert!(stereo(noise(1.0), noise(77.0), -1.0).is_none());
}
