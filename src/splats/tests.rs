//! Scenes whose truth is known, drawn, turned into Gaussians and back.

use glam::{Quat, Vec2, Vec3};

use super::raster::put_together;
use super::shot::Shot;
use super::{Blend, Camera, Cloud, Gaussian, NamedCamera, Processor, Rig, Stage, Tiles, from_field, harmonics};
use crate::field::{
    FNumber, FocalPlane, Lens, LightField, RayDepths, Size, Strength, View, ViewGrid, ViewIndex, ViewOffset, ViewPoint,
};
use crate::job::{Cancel, Job};
use std::sync::Arc;

fn with_job<T, E: std::fmt::Debug>(work: impl FnOnce(&Job) -> Result<T, E>) -> T {
    work(&Job { cancel: &Cancel::default(), sink: &() }).unwrap()
}

/// A colour that changes from pixel to pixel, as grass and leaves do.
fn texture(x: f32, y: f32, hue: f32) -> [f32; 3] {
    let wave = |fx: f32, fy: f32, off: f32| 0.5 + 0.5 * (x * fx + y * fy + off).sin();
    let fine = 0.25 * (wave(1.1, 0.7, 0.0) + wave(-0.6, 1.3, 1.0));
    [0.15 + 0.6 * fine + 0.2 * hue, 0.2 + 0.4 * wave(0.11, 0.05, hue) + fine * 0.3, 0.7 - 0.5 * hue + 0.2 * fine]
}

/// A ground that comes nearer downwards, and a disc before it: the views, exactly, with the disparity of every ray.
pub(super) fn made_scene(size: Size, grid: ViewGrid) -> (LightField, RayDepths) {
    let [w, h] = size.map(|side| side as f32);
    let (mut views, mut disparities) = (Vec::new(), Vec::new());
    for at in grid.views() {
        let ViewOffset { dv, du } = grid.offset(at);
        let mut rgba = Vec::new();
        for i in 0..size[0] * size[1] {
            let (x, y) = ((i % size[0]) as f32, (i / size[0]) as f32);
            let near = 0.9;
            let disc = Vec2::new(x + du * near, y + dv * near);
            let inside = (disc - Vec2::new(0.45 * w, 0.5 * h)).length() < 0.22 * h;
            // On the ground D = −1 + 1.2·y/h at the reference's own y = y' + dv·D.
            let ground_y = (y - dv) / (1.0 - 1.2 * dv / h);
            let ground = -1.0 + 1.2 * ground_y / h;
            let (color, disparity) = match inside {
                true => (texture(disc.x, disc.y, 1.0), near),
                false => (texture(x + du * ground, ground_y, 0.0), ground),
            };
            rgba.extend(color.map(|value| (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8));
            rgba.push(255);
            disparities.push(disparity);
        }
        views.push(Arc::new(View::new(size, rgba).unwrap()));
    }
    (LightField::new(grid, views).unwrap(), RayDepths::new(grid, size, disparities).unwrap())
}

/// Peak signal-to-noise ratio of two views, in dB.
fn psnr(a: &View, b: &View) -> f64 {
    let squares = a.rgba().iter().zip(b.rgba()).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
    let mean = squares.sum::<f64>() / (a.rgba().len() as f64 * 0.75);
    10.0 * (255.0 * 255.0 / mean).log10()
}

#[test]
fn a_light_field_comes_back_from_its_gaussians() {
    let grid = ViewGrid::PAPER;
    let (field, depths) = made_scene([160, 108], grid);
    let stage = with_job(|job| from_field(&field, &depths, None, job));
    for (v, u) in [(0, 0), (0, 7), (2, 5), (4, 4), (7, 0), (7, 7)] {
        let at = ViewIndex { v, u };
        let taken = with_job(|job| stage.taken(&Shot::view(stage.rig, grid.offset(at).to_vec2()), job));
        let close = psnr(field.view(at), &View::new(field.size(), taken.rgba).unwrap());
        let rays = depths.view(at).iter().zip(&taken.disparity_px);
        let mut apart: Vec<f32> = rays.map(|(a, b)| (a - b).abs()).collect();
        apart.sort_by(f32::total_cmp);
        let (median, tail) = (apart[apart.len() / 2], apart[apart.len() * 95 / 100]);
        assert!(close > 30.0, "{at:?}: {close} dB");
        assert!(median < 0.02 && tail < 0.2, "{at:?}: {median} px at the median, {tail} px for 95 %");
    }
}

/// A few Gaussians before a camera at the origin.
fn stage(gaussians: &[(Vec3, f32, [f32; 3])]) -> Stage {
    let mut cloud = Cloud::with_room(0, gaussians.len(), Blend::Encoded);
    for (center, scale, color) in gaussians {
        let (scale, rotation) = (Vec3::splat(*scale), Quat::IDENTITY);
        cloud.push(Gaussian { center: *center, scale, rotation, opacity: 0.8 }, &[harmonics::constant(*color)]);
    }
    let rig = Rig { camera: Camera::at_origin(100.0, [101, 81]), step: 0.02, zero: 0.25, near: 0.1 };
    Stage { cloud, rig, named: NamedCamera::File, ends: [0.1, 1.0], in_metres: false }
}

#[test]
fn one_gaussian_is_where_and_as_wide_as_it_should_be() {
    let stage = stage(&[(Vec3::new(0.4, -0.2, 2.0), 0.06, [0.5, 1.0, 0.25])]);
    let shown = with_job(|job| stage.shown(&Shot::view(stage.rig, Vec2::ZERO), &Processor, job));
    // At 50 + 100·0.4/2 = 70 and 40 − 10 = 30; 100·0.06/2 = 3 px wide, and the low-pass.
    let at = |x: usize, y: usize| y * 101 + x;
    assert!((shown.cover[at(70, 30)] - 0.8).abs() < 1e-4, "{}", shown.cover[at(70, 30)]);
    let variance = 9.0 + 0.3;
    for (dx, dy) in [(3, 0), (0, 4), (2, 2)] {
        let want = 0.8 * (-((dx * dx + dy * dy) as f32) / 2.0 / variance).exp();
        // Seen obliquely it is a little longer, hence 3 %.
        let got = shown.cover[at(70 + dx, 30 + dy)];
        assert!((got / want - 1.0).abs() < 0.03, "{dx} {dy}: {got} for {want}");
    }
    assert!((shown.nearness[at(70, 30)] - 0.5).abs() < 1e-4);
    // A step to the right moves it by −D = −100·0.02·(0.5 − 0.25).
    let moved = with_job(|job| stage.shown(&Shot::view(stage.rig, Vec2::new(8.0, 0.0)), &Processor, job));
    assert!((moved.cover[at(66, 30)] - 0.8).abs() < 1e-3);
}

#[test]
fn what_is_nearer_comes_first_in_any_order() {
    let near = (Vec3::new(0.0, 0.0, 1.0), 0.1, [1.0, 0.0, 0.0]);
    let far = (Vec3::new(0.0, 0.0, 3.0), 0.3, [0.0, 1.0, 0.0]);
    for gaussians in [[near, far], [far, near]] {
        let stage = stage(&gaussians);
        let shown =
            with_job(|job| put_together(&Tiles::seen(&stage.cloud, &Shot::view(stage.rig, Vec2::ZERO), job)?, job));
        let middle = 40 * 101 + 50;
        let [r, g, _] = shown.rgb[middle];
        assert!((r - 0.8).abs() < 1e-3 && (g - 0.16).abs() < 1e-3, "{r} {g}");
        // Expected over what covers: (0.8·1 + 0.16/3) / 0.96.
        assert!((shown.nearness[middle] - (0.8 + 0.16 / 3.0) / 0.96).abs() < 1e-3);
    }
}

#[test]
fn a_lens_gathers_what_many_eyes_on_it_see() {
    let (field, depths) = made_scene([120, 80], ViewGrid::PAPER);
    let stage = with_job(|job| from_field(&field, &depths, None, job));
    let focus = FocalPlane { disparity_px: 0.9, ..FocalPlane::default() };
    let lens = Lens { f_number: FNumber(2.8), focus, ..Lens::default() };
    let from = ViewPoint(ViewOffset { dv: 0.5, du: -1.0 });
    let through =
        |lens: &Lens| with_job(|job| stage.through_lens(lens, from, ([120, 80], Strength::AS_MADE), &Processor, job));
    let picture = through(&lens);
    let (mut sum, mut count) = (vec![0.0f32; 120 * 80 * 3], 0.0);
    let radius = lens.f_number.added_views() / 2.0;
    for i in 0..14 * 14 {
        let place = Vec2::new((i % 14) as f32 + 0.5, (i / 14) as f32 + 0.5) / 7.0 - 1.0;
        if place.length() > 1.0 {
            continue;
        }
        let shot = Shot::through(stage.rig, from.0.to_vec2() + place * radius, from.0.to_vec2(), &lens, 0.0, 0.0);
        let taken = with_job(|job| stage.taken(&shot, job));
        let rgb = taken.rgba.chunks_exact(4).flat_map(|px| [px[0], px[1], px[2]]);
        sum.iter_mut().zip(rgb).for_each(|(sum, byte)| *sum += crate::field::color::linear_from_srgb8(byte));
        count += 1.0;
    }
    let apart = picture.rgb_linear.iter().zip(&sum).map(|(a, b)| (a - b / count).abs()).sum::<f32>() / sum.len() as f32;
    assert!(apart < 0.004, "{apart}");
    // Closed down it is the view itself.
    let closed = through(&Lens { f_number: FNumber::PHOTO, ..lens.clone() });
    let view = with_job(|job| stage.taken(&Shot::view(stage.rig, from.0.to_vec2()), job));
    let same = closed.to_srgb8().iter().zip(&view.rgba).all(|(a, b)| a.abs_diff(*b) <= 1);
    assert!(same, "a lens without an opening is a view");
}

#[test]
fn views_of_a_part_of_the_grid_are_those_of_the_whole() {
    let (field, depths) = made_scene([60, 40], ViewGrid::PAPER);
    let stage = with_job(|job| from_field(&field, &depths, None, job));
    let (grid, how) = (ViewGrid::PAPER, ([60, 40], Strength::AS_MADE));
    let (all, rays) = with_job(|job| stage.views(grid, how.0, how.1, job));
    let block = grid.around(ViewOffset { dv: 1.5, du: -2.0 });
    let (some, some_rays) = with_job(|job| stage.some_views(grid, block, how, job));
    let made: Vec<_> = grid.views().filter(|at| some.view(*at).rgba().iter().any(|byte| *byte != 0)).collect();
    assert_eq!(made, [ViewIndex { v: 5, u: 2 }, ViewIndex { v: 6, u: 2 }]);
    for at in made {
        assert!(some.view(at) == all.view(at) && some_rays.view(at) == rays.view(at), "{at:?}");
    }
}

#[test]
fn fog_of_wide_gaussians_fills_no_tile_without_end() {
    let gaussian = |z: f32| Gaussian {
        center: Vec3::new(0.0, 0.0, z),
        scale: Vec3::splat(100.0),
        rotation: Quat::IDENTITY,
        opacity: 0.005,
    };
    // Farthest first, so that the order of the file is not what keeps the nearest.
    let count = 20_000;
    let mut cloud = Cloud::with_room(0, count, Blend::Encoded);
    (0..count).for_each(|i| cloud.push(gaussian(1.0 + (count - i) as f32 * 1e-3), &[[0.1; 3]]));
    let camera = Camera::at_origin(40.0, [40, 30]);
    let rig = Rig { camera, step: 0.0, zero: 0.0, near: 0.01 };
    let tiles = with_job(|job| Tiles::seen(&cloud, &Shot::view(rig, Vec2::ZERO), job));
    for tile in 0..6 {
        let kept = tiles.of_tile(tile);
        assert_eq!(kept.len(), 8192);
        assert!(kept.iter().all(|number| (*number as usize) >= count - 8192));
    }
    let shown = with_job(|job| put_together(&tiles, job));
    assert!(shown.cover.iter().all(|cover| *cover > 0.999), "so many keep off all light");
}
