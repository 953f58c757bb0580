//! What of a near side must not stay behind in a sharp far plane when the near side is blurred.

use super::*;

const NEAR: [f32; 3] = [0.6, 0.3, 0.02];
const FAR: [f32; 3] = [0.3, 0.4, 0.7];
/// Of the map; the photo has twice as many pixels a side, of which the near one covers those before `BESIDE`.
const SIZE: [u32; 2] = [800, 40];
const BESIDE: f32 = 800.0;
const ROWS: std::ops::Range<usize> = 16..64;

/// A picture focused on the far plane. `light`: what the photo has of the far side.
fn seen(light: impl Fn(f32, f32) -> [f32; 3], disparity_px: impl Fn(f32, f32) -> f32) -> Picture {
    let photo = photo(SIZE.map(|side| 2 * side), |x, y| if x < BESIDE { NEAR } else { light(x, y) });
    take(&photo, map(SIZE, disparity_px), &focused(-1.0))
}

fn step(x: f32) -> f32 {
    if x < BESIDE / 2.0 { 1.0 } else { -1.0 }
}

/// How far two pictures are apart where they are farthest, as sRGB.
fn apart(a: &Picture, b: &Picture) -> f32 {
    let places = ROWS.flat_map(|y| (740..860).map(move |x| (x, y)));
    let of = |(x, y)| {
        let [a, b] = [a, b].map(|picture| at(picture, x, y).map(srgb_from_linear));
        (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max)
    };
    places.map(of).fold(0.0, f32::max)
}

#[test]
fn what_sharpening_left_beside_a_blurred_near_side_is_no_outline() {
    let halo = |x: f32| if x < BESIDE + 2.0 { 0.12 } else { 0.0 };
    let [with, without] = [1.0, 0.0].map(|much| seen(|x, _| FAR.map(|light| light + much * halo(x)), |x, _| step(x)));
    let outline = apart(&with, &without);
    assert!(outline < 0.02, "the outline stays: {outline}");
}

#[test]
fn texture_of_the_far_plane_stays_three_cells_beside_a_blurred_near_side() {
    let far = |x: f32, y: f32| FAR.map(|light| light * (0.7 + 0.6 * hash(x as i32, y as i32, 5)));
    let out = seen(far, |x, _| step(x));
    // Three cells of the map beside the edge a pixel is brighter where the photo is.
    for x in 806..816 {
        let rows = || ROWS.map(|y| (at(&out, x, y)[2], far(x as f32, y as f32)[2]));
        let count = ROWS.len() as f32;
        let [mean, mean_far] = [rows().map(|r| r.0).sum::<f32>() / count, rows().map(|r| r.1).sum::<f32>() / count];
        let along: f32 = rows().map(|(got, far)| (got - mean) * (far - mean_far)).sum();
        let all: f32 = rows().map(|(_, far)| (far - mean_far).powi(2)).sum();
        assert!(along / all > 0.7, "column {x} has {} of the texture", along / all);
    }
}

#[test]
fn a_speck_half_way_to_the_far_plane_is_no_hole_in_it() {
    let is_speck = |x: f32, y: f32| (394.0..398.0).contains(&x) && (18.0..22.0).contains(&y);
    let with = seen(|_, _| FAR, |x, y| if is_speck(x, y) { 0.0 } else { step(x) });
    let hole = apart(&with, &seen(|_, _| FAR, |x, _| step(x)));
    assert!(hole < 0.1, "the speck is seen: {hole}");
}
