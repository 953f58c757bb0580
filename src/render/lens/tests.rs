//! What the picture must be, on scenes whose truth is known.

#[path = "../../../tests/common/chance.rs"]
mod chance;
mod depth;
mod outlines;

use chance::hash;

use super::*;
use crate::field::color::{linear_from_srgb, srgb_from_linear, srgb8_from_linear, srgb16_from_linear};
use crate::field::{FNumber, FocalPlane, LensShape, Metadata, PhotoPixels, ViewOffset, ViewPoint};

/// One step of 8 bits.
const STEP: f32 = 1.0 / 255.0;
/// Blur diameter for a disparity of 1 at f/3.5.
const PAPER: f32 = 7.937_254;

fn photo(size: [u32; 2], light: impl Fn(f32, f32) -> [f32; 3]) -> Arc<Photo> {
    let all: Vec<[f32; 3]> =
        (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| light(x as f32, y as f32)).collect();
    let wide: Vec<u16> = all.iter().flat_map(|p| [p[0], p[1], p[2], 1.0].map(srgb16_from_linear)).collect();
    let narrow: Vec<u8> = all.iter().flat_map(|p| [p[0], p[1], p[2], 1.0].map(srgb8_from_linear)).collect();
    let metadata = Metadata { orientation: 1, ..Metadata::default() };
    Arc::new(Photo::new(size, PhotoPixels::Sixteen(wide.into()), narrow.into(), metadata).unwrap())
}

fn map(size: [u32; 2], disparity: impl Fn(f32, f32) -> f32) -> DisparityMap {
    let all = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    DisparityMap::new(size, all.map(|(x, y)| disparity(x as f32, y as f32)).collect()).unwrap()
}

fn focused(disparity_px: f32) -> Lens {
    Lens { focus: FocalPlane { disparity_px, ..FocalPlane::default() }, ..Lens::default() }
}

fn take(photo: &Arc<Photo>, map: DisparityMap, lens: &Lens) -> Picture {
    let scene = Rgbd::new(Arc::clone(photo), map).unwrap();
    render(&scene, lens, photo.size(), &Job { cancel: &Default::default(), sink: &() }).unwrap()
}

fn at(picture: &Picture, x: usize, y: usize) -> [f32; 3] {
    let i = (y * picture.size[0] as usize + x) * 3;
    [picture.rgb_linear[i], picture.rgb_linear[i + 1], picture.rgb_linear[i + 2]]
}

fn noise_photo(size: [u32; 2]) -> Arc<Photo> {
    photo(size, |x, y| std::array::from_fn(|c| hash(x as i32, y as i32, c as u32)))
}

fn stored(scene: &Rgbd, lens: &Lens, bits: u8) -> Pixels {
    render_pixels(scene, lens, scene.photo().size(), bits, &Job { cancel: &Default::default(), sink: &() }).unwrap()
}

#[test]
fn r1_the_photo_itself_at_f28_and_where_all_is_in_focus() {
    let size = [70, 50];
    let photo = noise_photo(size);
    let PhotoPixels::Sixteen(px) = photo.pixels() else { unreachable!() };
    let sixteen = Samples::Sixteen(px.chunks(4).flat_map(|p| p[..3].to_vec()).collect());
    let eight = Samples::Eight(photo.srgb8().chunks(4).flat_map(|p| p[..3].to_vec()).collect());
    let closed = Lens { f_number: FNumber::PHOTO, ..focused(0.3) };
    let steps = map(size, |x, y| if x + y > 60.0 { 1.5 } else { -0.5 });
    for (disparity, lens) in [(steps, closed), (DisparityMap::constant(size, 0.7), focused(0.7))] {
        let scene = Rgbd::new(Arc::clone(&photo), disparity).unwrap();
        assert_eq!(stored(&scene, &lens, 16).samples, sixteen);
        assert_eq!(stored(&scene.in_space(Space::Srgb), &lens, 8).samples, eight);
    }
}

#[test]
fn r2_a_dot_becomes_one_even_disc_of_the_right_width_and_light() {
    for c in [3.0f32, 4.5, 8.0, 17.3, 40.0, 101.0, 200.0] {
        let side = (c as u32 + 24) | 1;
        let half = side as usize / 2;
        let dot = photo([side; 2], |x, y| [f32::from(x as usize == half && y as usize == half); 3]);
        let out = take(&dot, DisparityMap::constant([side; 2], -c / PAPER), &focused(0.0));
        let green = |x: usize, y: usize| at(&out, x, y)[1];
        let energy: f32 = out.rgb_linear.iter().skip(1).step_by(3).sum();
        assert!((energy - 1.0).abs() < 0.01, "c = {c}: energy {energy}");
        let inside = green(half, half);
        for vertical in [false, true] {
            let line = |i: usize| if vertical { green(half, i) } else { green(i, half) };
            let width: f32 = (0..side as usize).map(|i| (line(i) / inside).min(1.0)).sum();
            assert!((width - c).abs() < 1.0, "c = {c}: width {width}");
        }
        let (mut low, mut high) = (f32::MAX, 0.0f32);
        for y in 0..side as usize {
            for x in 0..side as usize {
                let r = (x as f32 - half as f32).hypot(y as f32 - half as f32);
                if r < c / 2.0 - 1.0 {
                    low = low.min(green(x, y));
                    high = high.max(green(x, y));
                }
                assert!(r < c / 2.0 + 1.5 || green(x, y) < 1e-6, "c = {c}: a second copy at {x}, {y}");
            }
        }
        assert!(high - low <= 0.03 * inside, "c = {c}: ripple {}", (high - low) / inside);
    }
}

/// Left half near, right half far; the edge lies before column 60.
const EDGE: f32 = 60.0;

fn halves(size: [u32; 2], near: f32, far: f32) -> DisparityMap {
    map(size, |x, _| if x < EDGE { near } else { far })
}

#[test]
fn r3_a_sharp_near_object_sheds_no_colour_and_no_shade_on_the_far_plane() {
    let size = [128, 64];
    let far =
        |x: f32, y: f32| [0.0, 0.3 + 0.25 * (x * 0.7).sin() * (y * 0.5).cos(), 0.4 + 0.2 * (x * 0.3 + y * 0.9).sin()];
    let near = |x: f32, y: f32| [0.5 + 0.4 * hash(x as i32, y as i32, 1), 0.0, 0.0];
    let both = photo(size, |x, y| if x < EDGE { near(x, y) } else { far(x, y) });
    let alone = photo(size, far);
    let c = 16.0;
    let out = take(&both, halves(size, 0.0, -c / PAPER), &focused(0.0));
    let truth = take(&alone, DisparityMap::constant(size, -c / PAPER), &focused(0.0));
    let [mut beyond, mut red, mut least] = [0.0f32, 0.0f32, 1.0f32];
    for y in 0..64 {
        for x in 0..128 {
            let (got, want) = (at(&out, x, y).map(srgb_from_linear), at(&truth, x, y).map(srgb_from_linear));
            let apart = (0..3).map(|c| (got[c] - want[c]).abs()).fold(0.0, f32::max);
            if x as f32 > EDGE + c / 2.0 {
                beyond = beyond.max(apart);
            } else if x as f32 >= EDGE {
                red = red.max(got[0]);
                least = least.min(got[1] / want[1]);
            } else {
                let own = near(x as f32, y as f32).map(srgb_from_linear);
                assert!(
                    (got[0] - own[0]).abs() < STEP && got[1] < STEP,
                    "the near object changed at {x}, {y}: {got:?}"
                );
            }
        }
    }
    assert!(beyond <= 2.0 * STEP, "beyond the edge: {}", beyond / STEP);
    assert!(red <= 2.0 * STEP, "near colour leaks: {}", red / STEP);
    assert!(least > 0.85, "a dark rim: {least}");
}

#[test]
fn a_soft_near_edge_leaves_no_outline_on_a_sharp_far_plane() {
    // The near side covers less and less of the pixels up to 2.5 beyond the map's edge, as hair and out-of-focus edges do.
    let size = [160, 48];
    let cover = |x: f32| ((EDGE + 2.5 - x) / 5.0).clamp(0.0, 1.0);
    let far = |x: f32, y: f32| 0.5 + 0.02 * (hash(x as i32, y as i32, 3) - 0.5);
    let photo = photo(size, |x, y| [cover(x) * 0.03 + (1.0 - cover(x)) * far(x, y); 3]);
    let c = 16.0;
    let out = take(&photo, halves(size, c / PAPER, 0.0), &focused(0.0));
    // A disc's chord at each distance from its middle.
    let chord = |d: f32| (c * c / 4.0 - d * d).max(0.0).sqrt();
    let whole: f32 = (-8..=8).map(|d| chord(d as f32)).sum();
    for x in 40..110 {
        let blurred: f32 = (-8..=8).map(|d| chord(d as f32) * cover((x + d) as f32)).sum::<f32>() / whole;
        let want = srgb_from_linear(blurred * 0.03 + (1.0 - blurred) * 0.5);
        let got = srgb_from_linear(at(&out, x as usize, 24)[1]);
        assert!((got - want).abs() < 0.06, "at {x}: {got}, not {want}");
    }
}

#[test]
fn behind_an_uneven_near_side_is_the_far_side() {
    // A red rim before red that is deeper by more than what counts as behind, then green.
    let size = [160, 60];
    let near = |x: f32| if x < EDGE - 6.0 { 0.8 } else { 1.0 };
    let uneven = map(size, |x, _| if x < EDGE { near(x) } else { -1.0 });
    let photo = photo(size, |x, _| if x < EDGE { [0.8, 0.0, 0.0] } else { [0.0, 0.5, 0.0] });
    let out = take(&photo, uneven, &focused(1.0));
    for x in EDGE as usize + 2..100 {
        assert!(at(&out, x, 30)[0] < 0.02, "red at {x}: {:?}", at(&out, x, 30));
    }
}

#[test]
fn where_blur_has_ridges_no_background_shines_through() {
    // A dark stripe with ridges as straight pieces between a map's cells make them, before a bright wall.
    let size = [200, 80];
    let ridges = |x: f32, y: f32| {
        let wave = |t: f32| ((t / 14.0).fract() * 2.0 - 1.0).abs() * 7.0;
        0.4 + 0.008 * (wave(x) + wave(y))
    };
    let is_dark = |x: f32| (60.0..140.0).contains(&x);
    let photo = photo(size, |x, _| [if is_dark(x) { 0.01 } else { 0.9 }; 3]);
    let wide = Lens { f_number: FNumber(1.0), ..focused(0.05) };
    let out = take(&photo, map(size, |x, y| if is_dark(x) { ridges(x, y) } else { -0.1 }), &wide);
    let dark = (20..60).flat_map(|y| (69..131).map(move |x| (x, y)));
    let most = dark.map(|(x, y)| at(&out, x, y)[1]).fold(0.0, f32::max);
    assert!(most < 0.02, "the wall shines through: {most}");
}

#[test]
fn r4_a_blurred_near_object_has_the_rim_of_a_disc_and_the_far_plane_shows_through() {
    let size = [128, 48];
    let c = 24.0f32;
    let integral = |t: f32| {
        let t = t.clamp(-1.0, 1.0);
        0.5 + (t * (1.0 - t * t).sqrt() + t.asin()) / std::f32::consts::PI
    };
    let stripes = |x: f32| if (x as i32) % 4 < 2 { 0.6 } else { 0.2 };
    let scene = photo(size, |x, _| if x < EDGE { [1.0, 0.0, 0.0] } else { [0.0, stripes(x), 0.0] });
    let out = take(&scene, halves(size, c / PAPER, 0.0), &focused(0.0));
    for x in 40..80usize {
        let [red, green, _] = at(&out, x, 24);
        let cover = integral((EDGE - 0.5 - x as f32) / (c / 2.0));
        assert!((red - cover).abs() < 0.02, "rim at {x}: {red} for {cover}");
        if x as f32 >= EDGE {
            let want = (1.0 - cover) * stripes(x as f32);
            assert!((green - want).abs() < 0.02, "far plane at {x}: {green} for {want}");
        } else {
            assert!(
                green <= (1.0 - cover) * 0.6 + 0.02 && green >= (1.0 - cover) * 0.2 - 0.02,
                "behind at {x}: {green}"
            );
        }
    }
}

/// What a disc leaves of a wave's contrast: `2·J₁(z)/z` with `z = π · diameter · frequency`.
fn disc_contrast(z: f32) -> f32 {
    let steps = 400;
    let chord = |i: i32| {
        let t = (i as f32 + 0.5) / steps as f32 * 2.0 - 1.0;
        (1.0 - t * t).sqrt() * (z * t).cos()
    };
    (0..steps).map(chord).sum::<f32>() * 4.0 / std::f32::consts::PI / steps as f32
}

#[test]
fn r5_a_slanted_plane_has_no_bands() {
    // Rows of waves 16 px long on a plane whose blur grows from 0 to 30 px to the right and 8 px to the left.
    let size = [384, 96];
    let wave = |y: f32| (y * std::f32::consts::TAU / 16.0).cos();
    let waves = photo(size, |_, y| [0.5 + 0.4 * wave(y); 3]);
    let disparity = |x: f32| (x - 80.0) * 0.0125;
    let out = take(&waves, map(size, |x, _| disparity(x)), &focused(0.0));
    let contrast = |x: usize| (24..72).map(|y| at(&out, x, y)[1] * wave(y as f32)).sum::<f32>() / 24.0 / 0.4;
    let all: Vec<f32> = (0..384).map(contrast).collect();
    for (x, &got) in all.iter().enumerate().take(370).skip(20) {
        let z = std::f32::consts::PI * (disparity(x as f32) * PAPER).abs() / 16.0;
        let want = disc_contrast(z);
        assert!((got - want).abs() < 0.03, "contrast at {x}: {got} for {want}");
        assert!((all[x + 1] - got).abs() < 0.03, "a band at {x}: {got}, then {}", all[x + 1]);
    }
}

/// A layer: colours, disparity, and where it is.
struct Layer {
    disparity: f32,
    light: fn(f32, f32) -> [f32; 3],
    covers: fn(f32, f32) -> bool,
}

/// Layers from near to far; the last one is everywhere.
fn layers(count: usize) -> Vec<Layer> {
    let back = Layer {
        disparity: -0.6,
        light: |x, y| {
            [0.25 + 0.1 * (x * 0.11).sin(), 0.35 + 0.1 * (y * 0.13).cos(), 0.5 + 0.1 * ((x + y) * 0.07).sin()]
        },
        covers: |_, _| true,
    };
    let middle = Layer {
        disparity: 0.1,
        light: |x, y| [0.6 + 0.2 * (x * 0.4).sin(), 0.45 + 0.2 * (y * 0.3).sin(), 0.2],
        covers: |x, y| (x - 88.0).hypot(y - 60.0) < 24.0,
    };
    let front = Layer {
        disparity: 0.9,
        light: |x, y| [0.3, 0.5 + 0.2 * ((x - y) * 0.15).sin(), 0.25],
        covers: |x, y| (x - 40.0).abs() < 16.0 && (y - 70.0).abs() < 30.0,
    };
    if count == 2 { vec![middle, back] } else { vec![front, middle, back] }
}

fn nearest(layers: &[Layer], x: f32, y: f32, step: [f32; 2], focus: f32) -> &Layer {
    let sees = |l: &&Layer| (l.covers)(x + step[0] * (l.disparity - focus), y + step[1] * (l.disparity - focus));
    layers.iter().find(sees).unwrap()
}

/// Shift-and-add of 33×33 exactly rendered views over a disc.
fn added(layers: &[Layer], size: [u32; 2], focus: f32) -> Picture {
    added_from(layers, size, focus, [0.0; 2])
}

/// The same around a viewpoint `[u, v]`, whose own view stays where it is.
fn added_from(layers: &[Layer], size: [u32; 2], focus: f32, eye: [f32; 2]) -> Picture {
    added_through(layers, size, focus, eye, |[u, v]| u.hypot(v) <= 1.0)
}

/// The same over any opening, `[u, v]` from −1 to 1.
fn added_through(
    layers: &[Layer],
    size: [u32; 2],
    focus: f32,
    eye: [f32; 2],
    is_open: impl Fn([f32; 2]) -> bool,
) -> Picture {
    let steps: Vec<[f32; 2]> = (-16..=16)
        .flat_map(|v| (-16..=16).map(move |u| [u as f32 / 16.5, v as f32 / 16.5]))
        .filter(|place| is_open(*place))
        .map(|place| place.map(|p| p * PAPER / 2.0))
        .collect();
    let color = |x: f32, y: f32| {
        let mut sum = [0.0; 3];
        for &step in &steps {
            // L(x − s·D_f, e + s) is on the surface at x − s·D_f + (e + s)·D.
            let on = |l: &Layer| [0, 1].map(|a| step[a] * (l.disparity - focus) + eye[a] * l.disparity);
            let sees = |l: &&Layer| (l.covers)(x + on(l)[0], y + on(l)[1]);
            let layer = layers.iter().find(sees).unwrap();
            let light = (layer.light)(x + on(layer)[0], y + on(layer)[1]);
            (0..3).for_each(|c| sum[c] += light[c] / steps.len() as f32);
        }
        sum
    };
    let all = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    Picture { size, rgb_linear: all.flat_map(|(x, y)| color(x as f32, y as f32)).collect() }
}

/// Peak signal over the error, in stored values.
fn psnr(a: &Picture, b: &Picture) -> f32 {
    let pairs = a.rgb_linear.iter().zip(&b.rgb_linear);
    let error: f32 = pairs.map(|(a, b)| (srgb_from_linear(*a) - srgb_from_linear(*b)).powi(2)).sum();
    -10.0 * (error / a.rgb_linear.len() as f32).log10()
}

#[test]
fn r6_agrees_with_shift_and_add_of_the_light_field() {
    let size = [128, 128];
    for count in [2, 3] {
        let layers = layers(count);
        let see = |x, y| nearest(&layers, x, y, [0.0; 2], 0.0);
        let photo = photo(size, |x, y| (see(x, y).light)(x, y));
        for focus in [-0.6, 0.1, 0.9, 0.4] {
            let out = take(&photo, map(size, |x, y| see(x, y).disparity), &focused(focus));
            let psnr = psnr(&out, &added(&layers, size, focus));
            assert!(psnr >= 44.0, "{count} layers, focus {focus}: {psnr} dB");
        }
    }
}

#[test]
fn a_picture_as_opening_agrees_with_shift_and_add_through_it() {
    let size = [128, 128];
    let layers = layers(3);
    let see = |x, y| nearest(&layers, x, y, [0.0; 2], 0.0);
    let photo = photo(size, |x, y| (see(x, y).light)(x, y));
    let shape = opening::tests::letter();
    let LensShape::Picture(letter) = &shape else { unreachable!() };
    for focus in [-0.6, 0.1, 0.9] {
        let lens = Lens { shape: shape.clone(), ..focused(focus) };
        let out = take(&photo, map(size, |x, y| see(x, y).disparity), &lens);
        let truth = added_through(&layers, size, focus, [0.0; 2], |place| letter.at(place) > 0.5);
        let psnr = psnr(&out, &truth);
        assert!(psnr >= 36.0, "focus {focus}: {psnr} dB");
    }
}

#[test]
fn from_beside_the_scene_is_as_it_would_be_there() {
    let size = [128, 128];
    let job = Job { cancel: &Default::default(), sink: &() };
    let layers = layers(2);
    let see = |x, y| nearest(&layers, x, y, [0.0; 2], 0.0);
    let scene = Rgbd::new(photo(size, |x, y| (see(x, y).light)(x, y)), map(size, |x, y| see(x, y).disparity)).unwrap();
    for (dv, du) in [(0.0, 4.0), (-3.5, 0.0), (2.0, -3.0)] {
        let eye = ViewPoint(ViewOffset { dv, du });
        let moved = scene.seen_from(eye, 0.0, size, &job).unwrap();
        let color = |x: u32, y: u32| {
            let (x, y) = (x as f32, y as f32);
            let layer = nearest(&layers, x, y, [du, dv], 0.0);
            (layer.light)(x + du * layer.disparity, y + dv * layer.disparity)
        };
        let truth = Picture::from_fn(size, color);
        let closed = Lens { f_number: FNumber::PHOTO, ..Lens::default() };
        let got = render(&moved, &closed, size, &job).unwrap();
        // What comes in from outside the picture cannot be known.
        let inside = |p: &Picture| {
            let rows = (8..120).flat_map(|y| (8..120).flat_map(move |x| (0..3).map(move |c| (y * 128 + x) * 3 + c)));
            Picture { size: [112, 112], rgb_linear: rows.map(|i| p.rgb_linear[i]).collect() }
        };
        let psnr = psnr(&inside(&got), &inside(&truth));
        assert!(psnr >= 32.0, "from {eye:?}: {psnr} dB");
    }
    assert!(Arc::ptr_eq(scene.seen_from(ViewPoint::default(), 0.3, size, &job).unwrap().photo(), scene.photo()));
}

#[test]
fn what_is_turned_around_stays_where_it_is() {
    let (size, job) = ([96, 64], Job { cancel: &Default::default(), sink: &() });
    let stripes = photo(size, |x, y| [0.5 + 0.3 * (x * 0.7).sin(), 0.5 + 0.2 * (y * 0.4).cos(), 0.4]);
    let flat = Rgbd::new(stripes, map(size, |_, _| 0.75)).unwrap();
    let eye = ViewPoint(ViewOffset { dv: 2.0, du: -3.0 });
    let closed = Lens { f_number: FNumber::PHOTO, ..Lens::default() };
    let seen =
        |pivot_px: f32| render(&flat.seen_from(eye, pivot_px, size, &job).unwrap(), &closed, size, &job).unwrap();
    let before = render(&flat, &closed, size, &job).unwrap();
    assert!(psnr(&seen(0.75), &before) > 45.0 && psnr(&seen(0.0), &before) < 25.0);
}

#[test]
fn a_lens_beside_the_middle_agrees_with_the_light_field() {
    let size = [128, 128];
    let job = Job { cancel: &Default::default(), sink: &() };
    let layers = layers(2);
    let see = |x, y| nearest(&layers, x, y, [0.0; 2], 0.0);
    let scene = Rgbd::new(photo(size, |x, y| (see(x, y).light)(x, y)), map(size, |x, y| see(x, y).disparity)).unwrap();
    let eye = [2.0, -1.0];
    let moved = scene.seen_from(ViewPoint(ViewOffset { du: eye[0], dv: eye[1] }), 0.0, size, &job).unwrap();
    for focus in [-0.6, 0.1] {
        let got = render(&moved, &focused(focus), size, &job).unwrap();
        let psnr = psnr(&got, &added_from(&layers, size, focus, eye));
        assert!(psnr >= 32.0, "focus {focus}: {psnr} dB");
    }
}

#[test]
fn r7_grey_stays_grey_and_light_stays_as_much() {
    let size = [96, 96];
    let disparity = |x: f32, y: f32| match (x - 48.0).hypot(y - 40.0) {
        r if r < 18.0 => 1.2,
        r if r < 30.0 => 0.2,
        _ => -0.8 + y * 0.002,
    };
    let level = linear_from_srgb(119.0 / 255.0);
    let grey = take(&photo(size, |_, _| [level; 3]), map(size, disparity), &focused(0.2));
    assert!(grey.rgb_linear.iter().all(|v| srgb8_from_linear(*v) == 119));
    let noise = noise_photo(size);
    let mean = |p: &Picture| p.rgb_linear.iter().sum::<f32>() / p.rgb_linear.len() as f32;
    let before = take(&noise, map(size, disparity), &Lens { f_number: FNumber::PHOTO, ..focused(0.2) });
    let after = take(&noise, map(size, disparity), &focused(0.2));
    assert!((mean(&after) / mean(&before) - 1.0).abs() < 0.005, "{} {}", mean(&before), mean(&after));
}

#[test]
fn r8_a_small_turn_of_the_lens_changes_every_pixel_a_little() {
    let size = [96, 96];
    let layers = layers(3);
    let see = |x, y| nearest(&layers, x, y, [0.0; 2], 0.0);
    let photo = photo(size, |x, y| (see(x, y).light)(x, y));
    let scene =
        Rgbd::new(photo, map(size, |x, y| see(x, y).disparity)).unwrap().prepare(size, &Cancel::default()).unwrap();
    let whole = Region { at: [0; 2], size };
    let shot = |n: f32, focus: f32| {
        let lens = Lens { f_number: FNumber(n), ..focused(focus) };
        scene.render(&lens, whole, &Job { cancel: &Default::default(), sink: &() }).unwrap()
    };
    let apart = |a: &Picture, b: &Picture| {
        let pairs = a.rgb_linear.iter().zip(&b.rgb_linear);
        pairs.map(|(a, b)| (srgb_from_linear(*a) - srgb_from_linear(*b)).abs()).fold(0.0, f32::max)
    };
    let mut worst = 0.0f32;
    for i in 0..24 {
        let n = 2.8 * 1.1f32.powi(i);
        worst = worst.max(apart(&shot(n, 0.1), &shot(n * 1.01, 0.1)));
    }
    for i in -12..24 {
        let focus = i as f32 * 0.05;
        worst = worst.max(apart(&shot(3.5, focus), &shot(3.5, focus + 0.01)));
    }
    assert!(worst <= 6.0 * STEP, "a jump of {}", worst / STEP);
}

#[test]
fn tiles_fit_together_without_a_seam() {
    let size = [600, 300];
    let layers = layers(3);
    let see = |x: f32, y: f32| nearest(&layers, x % 128.0, y % 128.0, [0.0; 2], 0.0);
    let photo = photo(size, |x, y| (see(x, y).light)(x, y));
    let scene =
        Rgbd::new(photo, map(size, |x, y| see(x, y).disparity)).unwrap().prepare(size, &Cancel::default()).unwrap();
    let job = Job { cancel: &Default::default(), sink: &() };
    let whole = scene.render(&focused(0.1), Region { at: [0; 2], size }, &job).unwrap();
    let part = scene.render(&focused(0.1), Region { at: [131, 77], size: [97, 101] }, &job).unwrap();
    for y in 0..101 {
        for x in 0..97 {
            let (a, b) = (at(&whole, x + 131, y + 77), at(&part, x, y));
            assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-5), "{x} {y}: {a:?} {b:?}");
        }
    }
}

#[test]
fn what_is_kept_sharp_and_what_lies_in_a_tilted_plane_stays_the_photo() {
    let size = [64, 64];
    let photo = noise_photo(size);
    let slanted = || map(size, |x, _| ((x + 0.5) / 64.0 - 0.5) * 0.8);
    let closed = take(&photo, slanted(), &Lens { f_number: FNumber::PHOTO, ..focused(0.0) });
    let kept = take(&photo, slanted(), &Lens { keep_sharp_px: [-0.5, 0.5], ..focused(0.0) });
    let focus = FocalPlane { disparity_px: 0.0, tilt_px: [0.8, 0.0] };
    let tilted = take(&photo, slanted(), &Lens { focus, ..Lens::default() });
    for other in [kept, tilted] {
        assert!(closed.rgb_linear.iter().zip(&other.rgb_linear).all(|(a, b)| (a - b).abs() < 1e-5));
    }
}

#[test]
fn maps_of_another_shape_are_refused_and_flat_ones_may_have_any_shape() {
    let (photo, strip) = (noise_photo([40, 30]), noise_photo([800, 2]));
    let scene = |map| Rgbd::new(Arc::clone(&photo), map).err();
    assert_eq!(Rgbd::new(Arc::clone(&strip), map([100, 1], |x, _| x)).err(), None);
    assert!(Rgbd::new(strip, map([1, 100], |_, y| y)).is_err());
    assert!(matches!(scene(map([30, 40], |x, _| x)), Some(LensError::Shape { .. })));
    assert_eq!(scene(DisparityMap::constant([1, 1], 0.3)), None);
    assert_eq!(scene(map([20, 15], |x, _| x)), None);
}

#[test]
fn a_stopped_job_ends_and_every_tile_tells_its_progress() {
    let photo = noise_photo([40, 30]);
    let scene = Rgbd::new(photo, map([40, 30], |x, _| x * 0.02)).unwrap();
    let cancel = crate::job::Cancel::default();
    cancel.cancel();
    let out = render(&scene, &focused(0.0), [40, 30], &Job { cancel: &cancel, sink: &() });
    assert_eq!(out, Err(LensError::Cancelled(Cancelled)));
}

#[test]
fn grain_and_highlights_are_off_unless_asked_for() {
    let size = [64, 64];
    let photo = photo(size, |x, y| {
        [if (x as i32, y as i32) == (32, 32) { 1.0 } else { 0.2 + 0.05 * hash(x as i32, y as i32, 7) }; 3]
    });
    let shot = |highlights: f32, grain: f32| {
        take(
            &photo,
            DisparityMap::constant(size, 1.0),
            &Lens { highlights, grain, shape: LensShape::Disc, ..focused(0.0) },
        )
    };
    let plain = shot(0.0, 0.0);
    let spread = |p: &Picture| {
        let v: Vec<f32> = (4..20).flat_map(|y| (4..20).map(move |x| (x, y))).map(|(x, y)| at(p, x, y)[1]).collect();
        let mean = v.iter().sum::<f32>() / v.len() as f32;
        (v.iter().map(|a| (a - mean).powi(2)).sum::<f32>() / v.len() as f32).sqrt()
    };
    assert!(spread(&shot(0.0, 1.0)) > 3.0 * spread(&plain));
    assert!(at(&shot(1.0, 0.0), 32, 32)[1] > at(&plain, 32, 32)[1] * 1.2);
    assert_eq!(at(&shot(1.0, 0.0), 8, 8), at(&plain, 8, 8));
}

#[test]
fn a_lens_without_faults_is_the_same_picture() {
    let size = [90, 60];
    let (photo, map) = (noise_photo(size), map(size, |x, y| if x > 40.0 { 0.8 } else { y / 60.0 - 0.9 }));
    let plain = focused(0.1);
    let none =
        Lens { glass: crate::field::Glass { spherical: 0.0, ..Default::default() }, curve_px: 0.0, ..plain.clone() };
    assert_eq!(take(&photo, map.clone(), &plain), take(&photo, map, &none));
}

/// Light of a white dot in the middle, by channel, and how far it is spread from there in the mean.
fn spread_of_dot(disparity_px: f32, lens: &Lens) -> [[f32; 2]; 3] {
    let side = 101usize;
    let dot = photo([side as u32; 2], |x, y| [f32::from(x == 50.0 && y == 50.0); 3]);
    let out = take(&dot, DisparityMap::constant([side as u32; 2], disparity_px), lens);
    std::array::from_fn(|c| {
        let all = (0..side * side).map(|i| ((i % side) as f32, (i / side) as f32));
        let light = all.map(|(x, y)| (at(&out, x as usize, y as usize)[c], (x - 50.0).hypot(y - 50.0)));
        let (sum, far) = light.fold((0.0, 0.0), |(sum, far), (light, r)| (sum + light, far + light * r));
        [sum, far / sum]
    })
}

#[test]
fn fringes_are_green_behind_the_focus_and_magenta_before_it() {
    let lens = Lens { fringes_px: 0.4, ..focused(0.0) };
    for (disparity_px, is_behind) in [(-3.0, true), (3.0, false)] {
        let [red, green, blue] = spread_of_dot(disparity_px, &lens);
        assert!((red[0] - 1.0).abs() < 0.01 && (green[0] - 1.0).abs() < 0.01, "no light is lost");
        assert_eq!(red, blue);
        let wider = green[1] / red[1];
        // Behind by 3 the red disc is 2.6 wide, before by 3 it is 3.4.
        let want = if is_behind { 3.0 / 2.6 } else { 3.0 / 3.4 };
        assert!((wider - want).abs() < 0.03, "{disparity_px}: {wider} for {want}");
    }
}

#[test]
fn a_curved_surface_is_sharp_in_the_middle_and_blurs_the_corners() {
    let lens = Lens { curve_px: 0.5, ..focused(0.0) };
    assert_eq!(lens.defocus_px(0.0, 0.5, 0.5), 0.0);
    assert!((lens.defocus_px(0.0, 0.0, 1.0) + 0.5).abs() < 1e-6 && (lens.defocus_px(0.5, 1.0, 1.0)).abs() < 1e-6);
    let size = [120, 120];
    let (photo, flat) = (noise_photo(size), DisparityMap::constant(size, 0.0));
    let out = take(&photo, flat, &lens);
    let apart = |x: usize, y: usize| {
        let own = take(&photo, DisparityMap::constant(size, 0.0), &focused(0.0));
        (at(&out, x, y)[1] - at(&own, x, y)[1]).abs()
    };
    assert!(apart(60, 60) < STEP, "{}", apart(60, 60));
    let corner: f32 = [(3, 3), (116, 4), (5, 115)].iter().map(|(x, y)| apart(*x, *y)).fold(0.0, f32::max);
    assert!(corner > 10.0 * STEP, "{corner}");
}
