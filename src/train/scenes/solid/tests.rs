//! Exact ray depths, views that agree, the same bytes, and scenes that the row number does not explain.

use glam::Affine3A;

use super::mesh::Paint;
use super::view::NOTHING;
use super::*;
use crate::scenes::layer::tap_rgb;

const ALL: [usize; 4] = [36, 0, 7, 60];

fn order<'a>(stock: &'a Stock, views: &'a [usize], curve: Curve) -> Order<'a> {
    let (size, focus) = ([96, 72], 0.85);
    Order { stock, photos: &[], masked: &[], size, views, curve, range_px: 0.4, focus, noise: false, pitfalls: 0.0 }
}

#[test]
fn the_disparity_of_a_plane_is_that_of_the_formula_in_every_view() {
    let size = [64, 48];
    let camera = Camera::new(Vec3::new(0.3, 1.0, 0.2), [0.2, -0.3, 0.1], 60.0, size);
    let mut world = World::default();
    let floor = shapes::slab(Vec3::new(-40.0, 0.0, 40.0), Vec3::X * 80.0, Vec3::Z * -80.0, [1, 1]);
    let paint = Paint { tint: [0.5; 3], skin: None, metres: Vec2::ONE, gloss: 0.0 };
    world.add(&floor, Affine3A::IDENTITY, Some(&paint), true);
    let frame = Frame::new(&mut world, &camera, size, Curve::Camera);
    // f·b in px·m, and the focal plane at 2 m.
    let (fb, focus) = (1.3, 0.5);
    let lens = Lens { scale_px: fb, focus };
    let mut buffer = Buffer::default();
    let mut seen = 0;
    for layer in 0..64 {
        let (du, dv) = steps(layer);
        frame.draw(&world, lens, Vec2::new(du, dv), &mut buffer);
        for (i, &near) in buffer.near.iter().enumerate().filter(|(i, _)| buffer.face[*i] != NOTHING) {
            let [x, y] = [i % buffer.size[0], i / buffer.size[0]].map(|j| (j as f32 - 0.5) / SUB as f32);
            // The view's camera stands b·(du, dv) to the side; its picture is shifted back by f·b/z_f.
            let baseline = fb / camera.focal_px;
            let eye = camera.eye + (camera.axes[0] * du + camera.axes[1] * dv) * baseline;
            let off = (Vec2::new(x, y) - Vec2::new(du, dv) * fb * focus - camera.middle) / camera.focal_px;
            let ray = camera.axes[2] + camera.axes[0] * off.x + camera.axes[1] * off.y;
            let z = -eye.y / ray.y;
            let expected = fb * (1.0 / z - focus);
            assert!((lens.disparity(near) - expected).abs() < 2e-4, "{layer} ({x}, {y}): {near} {expected}");
            seen += 1;
        }
    }
    assert!(seen > 64 * 48 * 64, "{seen}");
}

#[test]
fn a_scene_is_told_by_its_seed_and_number() {
    let stock = Stock::default();
    for index in 0..6 {
        let draw = |seed| make(&order(&stock, &ALL, Curve::Camera), seed, index);
        let (a, b) = (draw(3), draw(3));
        assert!(a.pictures == b.pictures && a.disparities == b.disparities);
        assert_ne!(draw(4).pictures[0], a.pictures[0]);
    }
}

#[test]
fn views_agree_along_their_ray_depths() {
    let stock = Stock::default();
    for curve in [Curve::Camera, Curve::Relief] {
        let (mut sum, mut count, mut all) = (0.0, 0.0f32, 0.0f32);
        for index in 0..10 {
            let made = make(&order(&stock, &ALL, curve), 5, index);
            let [w, h] = made.pictures[0].size;
            for (k, &layer) in ALL.iter().enumerate().skip(1) {
                let (du, dv) = steps(layer);
                for i in 0..w * h {
                    let d = made.disparities[k][i];
                    let (x, y) = ((i % w) as f32 + du * d, (i / w) as f32 + dv * d);
                    if x < 2.0 || y < 2.0 || x > (w - 4) as f32 || y > (h - 4) as f32 {
                        continue;
                    }
                    all += 1.0;
                    let (x0, y0) = (x as usize, y as usize);
                    let same = |x: usize, y: usize| (made.disparities[0][y * w + x] - d).abs() < 0.02;
                    if !(y0 - 1..y0 + 3).all(|y| (x0 - 1..x0 + 3).all(|x| same(x, y))) {
                        continue;
                    }
                    let there = tap_rgb(&made.pictures[0].px, [w, h], x, y);
                    sum += (0..3).map(|c| (there[c] - made.pictures[k].px[i][c]).abs()).sum::<f32>() / 3.0;
                    count += 1.0;
                }
            }
        }
        assert!(count > 0.5 * all, "{curve:?}: only {count} of {all} rays were compared");
        assert!(sum / count < 0.02, "{curve:?}: {}", sum / count);
    }
}

#[test]
fn the_row_number_does_not_explain_the_scenes() {
    let stock = Stock::default();
    let order = order(&stock, &ALL[..1], Curve::Camera);
    let rows: Vec<f32> = (0..96 * 72).map(|i| (i / 96) as f32).collect();
    let of = |index| spearman(&make(&order, 9, index).disparities[0], &rows);
    let mean = (0..80).map(of).sum::<f32>() / 80.0;
    assert!((0.0..=0.5).contains(&mean), "{mean}");
}

#[test]
fn ray_depths_span_the_range_that_was_asked_for() {
    let stock = Stock::default();
    for index in 0..20 {
        let made = make(&order(&stock, &ALL, Curve::Relief), 11, index);
        let mut sorted = made.disparities[0].clone();
        sorted.sort_unstable_by(f32::total_cmp);
        let [far, near] = [0.02, 0.98].map(|share| sorted[(share * (sorted.len() - 1) as f32) as usize]);
        assert!(near - far < 0.43 && near - far > 0.05, "{index}: {far} {near}");
        assert!(made.disparities[0].iter().all(|d| d.abs() < 1.2));
        // Other views may see what stands beside the picture, however near.
        assert!(made.disparities.iter().flatten().all(|d| d.is_finite()));
        assert!(made.pictures.iter().flat_map(|p| &p.px).flatten().all(|c| (0.0..=1.0).contains(c)));
    }
}

#[test]
fn pitfalls_are_drawn_where_they_are_asked_for_and_nowhere_else() {
    let stock = Stock::default();
    let all = |pitfalls| Order { pitfalls, ..order(&stock, &ALL[..1], Curve::Relief) };
    let mut kinds: Vec<&str> = (0..60).map(|index| make(&all(1.0), 3, index).kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    assert_eq!(
        kinds,
        [
            "bare top",
            "bright",
            "clouds",
            "dappled",
            "flowers",
            "hanging",
            "landscape",
            "ledge",
            "low sun",
            "pattern",
            "portrait"
        ]
    );
    assert!((0..40).all(|index| !kinds.contains(&make(&all(0.0), 3, index).kind)));
    let [a, b] = [0, 1].map(|_| make(&all(1.0), 3, 7));
    assert!(a.pictures == b.pictures && a.disparities == b.disparities);
}

#[test]
fn a_bare_top_is_lit_unevenly_whichever_way_it_runs() {
    let stock = Stock::default();
    let order = Order { pitfalls: 1.0, ..order(&stock, &ALL[..1], Curve::Relief) };
    let tops = (0..120).map(|index| make(&order, 5, index)).filter(|made| made.kind == pitfalls::BARE_TOP);
    // Brightness beside depth: now it rises with nearness, now it falls.
    let told: Vec<f32> = tops
        .map(|made| spearman(&made.pictures[0].px.iter().map(|c| c[1]).collect::<Vec<_>>(), &made.disparities[0]))
        .collect();
    let (with, against) = (told.iter().filter(|r| **r > 0.2).count(), told.iter().filter(|r| **r < -0.2).count());
    assert!(with > told.len() / 8 && against > told.len() / 8, "{with} and {against} of {}", told.len());
}

#[test]
fn a_wall_that_fills_the_picture_tells_nothing() {
    let size = [64, 48];
    let camera = Camera::new(Vec3::ZERO, [0.0; 3], 60.0, size);
    let paint = Paint { tint: [0.5; 3], skin: None, metres: Vec2::ONE, gloss: 0.0 };
    let told = |corners: &[[f32; 2]], kind| {
        let mut world = World::default();
        for &[x, y] in corners {
            let plate = shapes::slab(Vec3::new(x, y, -2.0), Vec3::X * 2.0, Vec3::Y * 2.0, [1, 1]);
            world.add(&plate, Affine3A::IDENTITY, Some(&paint), true);
        }
        let frame = Frame::new(&mut world, &camera, size, Curve::Camera);
        let mut buffer = Buffer::default();
        frame.draw(&world, Lens { scale_px: 1.0, focus: 0.0 }, Vec2::ZERO, &mut buffer);
        is_told(&world, &buffer, kind)
    };
    assert!(!told(&[[-1.0, -1.0]], "room") && told(&[[-1.0, -1.0]], patterns::PATTERN));
    let quarters = [[-2.0, -2.0], [0.0, -2.0], [-2.0, 0.0], [0.0, 0.0]];
    assert!(told(&quarters, "room") && !told(&quarters[..2], "room"));
}

#[test]
fn a_triangle_covers_the_same_samples_whether_it_is_asked_at_each_or_not() {
    let rng = &mut Rng::new(7, 0);
    let places: Vec<f32> = (0..9 * 400).map(|_| rng.range(-1.0, 1.0)).collect();
    let mut buffers = [Buffer::default(), Buffer::default()];
    buffers.iter_mut().for_each(|buffer| buffer.clear([40, 30]));
    for (id, triangle) in places.as_chunks::<9>().0.iter().enumerate() {
        // Some reach beyond the picture, every third is a sliver.
        let wide = if id % 3 == 0 { 2.0 } else { 40.0 };
        let corner = |i: usize| [20.0 + wide * triangle[3 * i], 15.0 + 25.0 * triangle[3 * i + 1], triangle[3 * i + 2]];
        let corners = [0, 1, 2].map(corner);
        buffers[0].triangle(id as u32, corners);
        buffers[1].triangle_where(id as u32, corners, |_| true);
    }
    let [all, asked] = buffers;
    assert!(all.near.iter().zip(&asked.near).all(|(a, b)| (a - b).abs() < 1e-4 || a == b));
    let differ = all.face.iter().zip(&asked.face).filter(|(a, b)| a != b).count();
    assert!(differ <= 2 && !all.face.contains(&NOTHING), "{differ}");
}
