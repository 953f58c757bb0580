//! Properties of the renderers on scenes with known truth: a wrong sign, a swapped axis, half a pixel or gamma fails here.

mod common;

use common::{Approx, plane, scene, texture, two_planes};
use plenoscope::field::{EpiLine, FNumber, FocalPlane, Lens, LensShape, ViewGrid, ViewIndex, ViewOffset, ViewPoint};
use plenoscope::render::{Picture, cpu};

const SIZE: [u32; 2] = [48, 32];

fn lens(f: f32, disparity_px: f32) -> Lens {
    let focus = FocalPlane { disparity_px, ..FocalPlane::default() };
    Lens { f_number: FNumber(f), focus, ..Lens::default() }
}

fn inner(picture: &Picture, margin: u32) -> Vec<f32> {
    let [w, h] = picture.size;
    let places = (margin..h - margin).flat_map(|y| (margin..w - margin).map(move |x| (x, y)));
    places.flat_map(|(x, y)| picture.pixel(x, y)).collect()
}

fn of_view(view: &plenoscope::field::View) -> Picture {
    Picture::from_fn(view.size(), |x, y| {
        let [r, g, b, _] = view.pixel(x, y).map(plenoscope::field::color::linear_from_srgb8);
        [r, g, b]
    })
}

#[test]
fn a_plane_in_focus_is_the_reference_view() {
    for disparity in [0.0, 1.0, -2.0] {
        let (field, _) = plane(ViewGrid::PAPER, SIZE, disparity);
        let want = of_view(field.reference());
        for shape in [LensShape::Disc, LensShape::Square] {
            let got =
                cpu::refocus(&field, &Lens { shape: shape.clone(), ..lens(3.5, disparity) }, ViewPoint::default());
            Approx::Close.check(&format!("{disparity} {shape:?}"), &inner(&got, 9), &inner(&want, 9));
        }
    }
}

#[test]
fn a_plane_out_of_focus_is_blurred_the_more_the_wider_the_lens() {
    let (field, _) = plane(ViewGrid::PAPER, SIZE, 1.0);
    let contrast = |f: f32| {
        let values = inner(&cpu::refocus(&field, &lens(f, -0.5), ViewPoint::default()), 10);
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        values.iter().map(|v| (v - mean).powi(2)).sum::<f32>()
    };
    let steps = [28.0, 14.0, 7.0, 3.5].map(contrast);
    assert!(steps.windows(2).all(|pair| pair[1] < pair[0] * 0.95), "{steps:?}");
}

#[test]
fn a_closed_lens_is_the_view_itself() {
    let (field, depths) = two_planes(ViewGrid::PAPER, SIZE);
    for (dv, du) in [(0.0, 0.0), (-4.0, 3.0), (2.0, -1.0)] {
        let offset = ViewOffset { dv, du };
        let want = of_view(field.view(field.grid().nearest(offset)));
        assert_eq!(cpu::refocus(&field, &lens(28.0, 0.4), ViewPoint(offset)), want);
        assert_eq!(cpu::view_with_depths(&field, Some(&depths), ViewPoint(offset)), want);
        assert_eq!(cpu::view(&field, ViewPoint(offset)), want);
    }
}

#[test]
fn between_views_a_plane_moves_by_its_disparity() {
    let disparity = 1.0;
    let (field, depths) = plane(ViewGrid::PAPER, SIZE, disparity);
    let (du, dv) = (1.5, -2.25);
    let got = cpu::view_with_depths(&field, Some(&depths), ViewPoint(ViewOffset { dv, du }));
    // A quarter of a pixel is linear interpolation of the texture, so compare against the same taps.
    let want = Picture::from_fn(SIZE, |x, y| {
        let light = |x: f32, y: f32| texture(x, y).map(plenoscope::field::color::linear_from_srgb8);
        let at = |fx: f32, fy: f32| light((x as f32 + du + fx).floor(), (y as f32 + dv + fy).floor());
        let (px, py) = ((x as f32 + du).fract(), (y as f32 + dv).rem_euclid(1.0));
        std::array::from_fn(|i| {
            let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
            mix(mix(at(0.0, 0.0)[i], at(1.0, 0.0)[i], px), mix(at(0.0, 1.0)[i], at(1.0, 1.0)[i], px), py)
        })
    });
    Approx::Close.check("between views", &inner(&got, 8), &inner(&want, 8));
}

#[test]
fn between_views_nothing_doubles() {
    // A white column on black at disparity 2: blended views would show it twice at half its light.
    let (field, depths) = scene(ViewGrid::PAPER, SIZE, |x, _, du, _| {
        let light = if ((x + du * 2.0) - 24.0).abs() < 2.5 { 255 } else { 0 };
        ([light, light, light, 255], 2.0)
    });
    let half = ViewPoint(ViewOffset { dv: 0.0, du: 0.5 });
    let row = |picture: Picture| -> Vec<f32> { (0..SIZE[0]).map(|x| picture.pixel(x, 16)[0]).collect() };
    let sharp = row(cpu::view_with_depths(&field, Some(&depths), half));
    assert_eq!(sharp.iter().filter(|&&light| light > 0.9).count(), 5, "{sharp:?}");
    assert_eq!(sharp.iter().filter(|&&light| light > 0.1).count(), 5, "{sharp:?}");
}

#[test]
fn light_is_summed_linearly() {
    let grid = ViewGrid::new(1, 2).unwrap();
    let (field, _) = scene(grid, [4, 4], |_, _, du, _| if du < 0.0 { ([0; 4], 0.0) } else { ([255; 4], 0.0) });
    let half = cpu::refocus(&field, &Lens { shape: LensShape::Square, ..lens(14.0, 0.0) }, ViewPoint::default());
    assert_eq!(half.to_srgb8()[..4], [188, 188, 188, 255]);
}

#[test]
fn lines_of_an_epi_lean_by_the_disparity() {
    let disparity = 2.0;
    let (field, _) = plane(ViewGrid::PAPER, SIZE, disparity);
    let row = cpu::epi(&field, EpiLine::Row { y: 10, v: 4 }, 1);
    assert_eq!(row.size, [48, 8]);
    let column = cpu::epi(&field, EpiLine::Column { x: 20, u: 4 }, 3);
    assert_eq!(column.size, [24, 32]);
    for step in 0..7 {
        assert_eq!(row.pixel(20, step), row.pixel(20 - disparity as u32, step + 1), "a point moves by −D to the right");
        assert_eq!(column.pixel(step * 3, 20), column.pixel(step * 3 + 3, 20 - disparity as u32));
    }
}

#[test]
fn strewn_views_show_no_copies_where_the_gaps_between_them_are_wide() {
    let stripes = |x: f32, y: f32, du: f32, _dv: f32| {
        let at = x + 4.0 * du + 0.3 * y;
        let value = if at.rem_euclid(60.0) < 30.0 { 255 } else { 0 };
        ([value, value, value, 255], 4.0)
    };
    let (field, depths) = scene(ViewGrid::PAPER, [96, 64], stripes);
    let lens = Lens { shape: LensShape::Square, ..lens(3.5, 0.0) };
    let center = ViewPoint::default();
    // The truth has eyes everywhere in the opening, from 4½ views to the left to 3½ to the right.
    let truth = Picture::from_fn([96, 64], |x, y| {
        let eyes = (0..256).map(|i| stripes(x as f32, y as f32, (i as f32 + 0.5) / 32.0 - 4.5, 0.0).0[0]);
        [eyes.map(|value| f32::from(value) / 255.0).sum::<f32>() / 256.0; 3]
    });
    let error = |picture: &Picture| {
        let pairs = inner(picture, 20).into_iter().zip(inner(&truth, 20));
        pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f32>().sqrt()
    };
    let copies = cpu::refocus_with_depths(&field, Some(&depths), &lens, center);
    let strewn = cpu::refocus_strewn(&field, &depths, &lens, center);
    assert!(error(&strewn) < 0.4 * error(&copies), "{} {}", error(&strewn), error(&copies));

    let sharp = Lens { focus: FocalPlane { disparity_px: 4.0, ..FocalPlane::default() }, ..lens };
    let copies = cpu::refocus_with_depths(&field, Some(&depths), &sharp, center);
    let strewn = cpu::refocus_strewn(&field, &depths, &sharp, center);
    Approx::Close.check("what is in focus", &strewn.rgb_linear, &copies.rgb_linear);
}

#[test]
fn what_is_kept_sharp_is_sharp_beside_the_focal_plane() {
    let (field, depths) = plane(ViewGrid::PAPER, SIZE, 1.0);
    let wide = Lens { keep_sharp_px: [0.0, 1.2], ..lens(3.5, 0.0) };
    let got = cpu::refocus_with_depths(&field, Some(&depths), &wide, ViewPoint::default());
    Approx::Close.check("kept sharp", &inner(&got, 9), &inner(&of_view(field.reference()), 9));
}

#[test]
fn near_is_the_upper_end_of_a_colour_map() {
    let (_, depths) = two_planes(ViewGrid::PAPER, SIZE);
    let picture = cpu::depth(&depths, ViewIndex { v: 4, u: 4 }, [-0.4, 0.9], cpu::Colormap::Gray);
    assert_eq!(picture.pixel(24, 16), [1.0; 3]);
    assert_eq!(picture.pixel(1, 1), [0.0; 3]);
}
