//! What depth does to the picture where it is wrong, and where it lets work be left out.

use super::super::rays::BLOCK;
use super::*;

/// A map as a net makes it: every edge `off` pixels to the right, and 5 % of the map at a wrong depth, in specks.
fn imperfect(size: [u32; 2], off: f32, truth: impl Fn(f32, f32) -> f32) -> DisparityMap {
    map(size, |x, y| {
        let speck = |seed: u32| hash(x as i32 / 2, y as i32 / 2, seed);
        let wrong = if speck(11) < 0.05 { 0.6 * (speck(12) - 0.5) } else { 0.0 };
        truth(x - off, y) + wrong
    })
}

#[test]
fn a_step_of_imperfect_depth_is_hardly_another_picture() {
    let size = [128, 128];
    let mut layers = layers(2);
    layers[0].disparity = 0.6;
    layers[0].covers = |x, y| x + 0.2 * y < 70.0;
    let see = |x, y| nearest(&layers, x, y, [0.0; 2], 0.0);
    let photo = photo(size, |x, y| (see(x, y).light)(x, y));
    for (focus, off) in [0.6, -0.6, 0.0].into_iter().flat_map(|focus| [-2.0, 2.0].map(|off| (focus, off))) {
        let out = take(&photo, imperfect(size, off, |x, y| see(x, y).disparity), &focused(focus));
        let psnr = psnr(&out, &added(&layers, size, focus));
        assert!(psnr >= 42.0, "focus {focus}, edge {off} px off: {psnr} dB");
    }
}

#[test]
fn an_edge_of_the_map_goes_to_where_colours_part() {
    let size = [96, 80];
    let is_near = |x: f32, y: f32| x < 40.0 + 8.0 * (y / 9.0).sin();
    // Off by 3, all 240 were wrong as long as only the map was asked. Two colours behind, and shades of one before them: what parts them is no difference of means.
    let behind = |x: f32, y: f32| if (x * 0.23 + y * 0.17).sin() > 0.0 { [0.02, 0.08, 0.03] } else { [0.2, 0.3, 0.1] };
    let shade = |x: f32, y: f32| 0.8 + 0.4 * hash(x as i32, y as i32, 5);
    let before = |x: f32, y: f32| [0.7 * shade(x, y), 0.4 * shade(x, y), 0.02];
    let photo = photo(size, |x, y| if is_near(x, y) { before(x, y) } else { behind(x, y) });
    let depth = |x: f32, y: f32| if is_near(x, y) { 0.6 } else { -0.3 };
    for off in [-3.0, 0.0, 3.0] {
        let scene = Rgbd::new(Arc::clone(&photo), imperfect(size, off, depth))
            .unwrap()
            .prepare(size, &Cancel::default())
            .unwrap();
        let (reader, mut colors, mut wrong) = (scene.reader(0, 96), vec![[0.0; 3]; 96], 0);
        for y in 0..80 {
            scene.light.row(0, y, &mut colors);
            let row = reader.at_row(y);
            let side = |i: usize| reader.at(&row, i, &colors[i]).0.disparity_px() > 0.15;
            wrong += (0..96).filter(|&i| side(i) != is_near(i as f32, y as f32)).count();
        }
        assert!(wrong <= 140, "off by {off}: {wrong} pixels of an edge of 80 rows are on the wrong side");
    }
}

#[test]
fn no_block_is_blurred_more_than_its_bound() {
    let size = [128, 112];
    let layers = layers(3);
    let see = |x: f32, y: f32| nearest(&layers, x, y, [0.0; 2], 0.0);
    let photo = photo(size, |x, y| (see(x, y).light)(x, y));
    let scene =
        Rgbd::new(photo, map(size, |x, y| see(x, y).disparity)).unwrap().prepare(size, &Cancel::default()).unwrap();
    let focus = FocalPlane { disparity_px: 0.3, tilt_px: [0.5, -0.2] };
    let lens = Lens { focus, curve_px: 0.3, keep_sharp_px: [0.0, 0.1], ..Lens::default() };
    let optics = scene.optics(&lens);
    let reader = scene.reader(-32, 192);
    for y in -32..144 {
        let row = reader.at_row(y);
        let mut colors = vec![[0.0; 3]; 192];
        scene.light.row(-32, y, &mut colors);
        for (i, color) in colors.iter().enumerate() {
            let (seen, hidden) = reader.at(&row, i, color);
            let x = i as i32 - 32;
            let place = [x, y].map(|at| at.div_euclid(BLOCK as i32) * BLOCK as i32);
            let bound = scene.bounds.widest_px(&optics, place) + bounds::SLACK_PX;
            let all = [Some(seen.near_px), Some(seen.far_px), hidden.map(|hidden| hidden.disparity_px)];
            let widest = all.into_iter().flatten().map(|px| optics.blur(px, x, y).abs()).fold(0.0, f32::max);
            assert!(widest <= bound, "{x}, {y}: {widest}, bound to {bound}");
        }
    }
}

#[test]
fn where_a_map_dips_before_an_edge_no_background_shines_through() {
    // The last pixels of a dark leaf in focus lie a little behind it, as maps have them, before a bright wall. Right at the
    // edge a rim of that width is right.
    let size = [128, 48];
    let photo = photo(size, |x, _| [if x < EDGE { 0.05 } else { 0.9 }; 3]);
    for (dip, wide) in [(3.0, 4.0), (2.0, 3.0), (1.0, 6.0)] {
        let depth = |x: f32| {
            if x < EDGE - wide {
                0.0
            } else if x < EDGE {
                -dip / PAPER
            } else {
                -16.0 / PAPER
            }
        };
        let out = take(&photo, map(size, |x, _| depth(x)), &focused(0.0));
        let inside = |x: usize| at(&out, x, 24)[1];
        let most = (30..(EDGE - dip / 2.0 - 1.5) as usize).map(inside).fold(0.0, f32::max);
        assert!(most < 0.12, "the wall shines through, dip {dip}: {most}");
    }
}

#[test]
fn a_bright_wall_does_not_shine_through_where_blur_passes_the_focal_plane() {
    let size = [96, 80];
    let photo = photo(size, |x, _| if x < EDGE { [0.0; 3] } else { [1.0; 3] });
    for slope in [0.15, 0.3, 0.45] {
        // A dark surface that leans through the focal plane, and the wall far behind it.
        let blur = |y: f32| slope * (y - 40.0);
        let out = take(&photo, map(size, |x, y| if x < EDGE { blur(y) / PAPER } else { -3.0 }), &focused(0.0));
        for y in 16..64 {
            let reach = blur(y as f32).abs() / 2.0 + 2.5;
            let inside = (40..60).filter(|&x| (x as f32) < EDGE - reach);
            let brightest = inside.map(|x| at(&out, x, y)[1]).fold(0.0, f32::max);
            assert!(brightest < 0.012, "{slope} px a pixel, row {y}: {brightest}");
        }
    }
}
