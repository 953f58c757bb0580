//! Real lenses against the formulas of optics.

use std::sync::Arc;

use super::*;
use crate::field::{DisparityMap, Photo, RelativeDepth, Strength};
use crate::io::{DepthKind, EmbeddedDepth};
use crate::job::{Cancel, Job};
use crate::scene::{Content, Maker, Making, Need, OnePhoto, Subject};

const SIZE: [u32; 2] = [240, 160];
const FULL_FRAME: &Format = &FORMATS[0];

/// A photo of something at 2 m before a wall at 8 m, whose phone measured that, or only knows the order.
fn scene(metric: bool, f35_mm: Option<f32>, strength: f32) -> Scene {
    let photo = Arc::new(Photo::from_srgb8(SIZE, vec![128; 240 * 160 * 4]).unwrap());
    let is_near = |i: u32| (80..160).contains(&(i % 240)) && (50..110).contains(&(i / 240));
    let nearness = (0..240 * 160).map(|i| if is_near(i) { 1.0 / 2.0 } else { 1.0 / 8.0 }).collect();
    let map = RelativeDepth::new(SIZE, nearness).unwrap();
    let phone = Some(Arc::new(EmbeddedDepth { kind: DepthKind::DynamicDepth, map, metric }));
    let content =
        Content::Photo(OnePhoto { photo, f35_mm, phone, own_map: None, splats: None, truth: None, several: None });
    let subject = Arc::new(Subject { name: "phone".to_owned(), path: None, file: None, info: None, content });
    let how = Making { strength: Some(Strength(strength)), ..Making::default() };
    let job = Job { cancel: &Cancel::default(), sink: &() };
    Maker::default().scene(&subject, &how, Need::Map, &job).unwrap()
}

fn edit(f_number: f32) -> Edit {
    Edit { f_number: FNumber(f_number), focus: Focus::At([0.5, 0.5]), ..Edit::default() }
}

fn is_near(a: Option<f32>, b: f32, part: f32) -> bool {
    a.is_some_and(|a| (a - b).abs() < part * b)
}

#[test]
fn metres_give_the_lens_that_took_the_photo() {
    for (f35, n) in [(26.0, 1.8), (50.0, 2.8), (85.0, 5.6)] {
        let reading = scene(true, Some(f35), 1.0).reading(&edit(n), FULL_FRAME, 4000);
        assert_eq!(reading.scale, Scale::Measured);
        assert!((reading.focal_mm - f35).abs() < 1e-3 && (reading.f_number - n).abs() < 1e-3, "{reading:?}");
        assert!(is_near(reading.focus_m, 2.0, 0.01), "{reading:?}");
        // Hyperfocal distance f²/(N·c), and the limits of sharpness for a focus at 2 m.
        let hyperfocal = f35 * f35 / (n * CONFUSION_MM) / 1000.0;
        assert!(is_near(reading.hyperfocal_m, hyperfocal, 1e-3), "{reading:?} {hyperfocal}");
        assert!(is_near(reading.near_m, 1.0 / (0.5 + 1.0 / hyperfocal), 0.01), "{reading:?}");
        let far = 0.5 - 1.0 / hyperfocal;
        assert!(if far > 0.0 { is_near(reading.far_m, 1.0 / far, 0.02) } else { reading.far_m.is_none() });
    }
}

#[test]
fn the_blur_on_the_sensor_is_that_of_a_thin_lens() {
    // f = 50 mm at f/2, focus at 2 m, wall at 8 m: c = f²/N · (1/2 − 1/8), less the photo's own f/28.
    let reading = scene(true, Some(50.0), 1.0).reading(&edit(2.0), FULL_FRAME, 3600);
    let thin = 0.05f32.powi(2) / 2.0 * (0.5 - 0.125) * 1e6;
    let added = thin * FNumber(2.0).added_views() / FNumber(2.0).views_across();
    assert!((reading.background_um - added).abs() < 0.01 * added, "{reading:?} {added}");
    // 36 mm are 3600 px.
    assert!((reading.background_px - reading.background_um / 10.0).abs() < 1e-2);
}

#[test]
fn another_format_is_the_same_aperture() {
    let (scene, edit) = (scene(true, Some(36.0), 1.0), edit(2.0));
    let full = scene.reading(&edit, FULL_FRAME, 1000);
    for format in &FORMATS {
        let reading = scene.reading(&edit, format, 1000);
        let wide = |reading: &Reading| reading.focal_mm / reading.f_number;
        assert!((wide(&reading) - wide(&full)).abs() < 1e-2 && reading.near_m == full.near_m, "{reading:?}");
        assert!(reading.title().contains(format.name));
    }
    assert_eq!([full.title(), full.headline()], ["36 mm f/2 on full frame"; 2]);
}

#[test]
fn strength_is_a_wider_lens() {
    let [plain, deep] =
        [1.0, 2.0].map(|strength| scene(true, Some(50.0), strength).reading(&edit(4.0), FULL_FRAME, 1000));
    assert!((deep.f_number - plain.f_number / 2.0).abs() < 1e-4 && is_near(deep.focus_m, 2.0, 0.01), "{deep:?}");
    assert!((deep.background_px / plain.background_px - 2.0).abs() < 0.01);
    assert!(is_near(deep.hyperfocal_m, plain.hyperfocal_m.unwrap() * 2.0, 1e-3));
}

#[test]
fn an_order_says_that_it_is_relative_until_a_distance_is_given() {
    let scene = scene(false, None, 1.0);
    let plain = scene.reading(&edit(2.0), FULL_FRAME, 1000);
    assert_eq!((plain.scale, plain.focus_m, plain.hyperfocal_m), (Scale::Relative, None, None));
    let lines = plain.lines().join("\n");
    assert!(lines.contains("relative") && lines.contains("28 mm is assumed"), "{lines}");
    assert_eq!(plain.headline(), "f/2 on full frame, if taken with 28 mm · relative, as no distance is known");
    let known = scene.with_distance(&edit(2.0), Some(0.6));
    let reading = scene.reading(&known, FULL_FRAME, 1000);
    assert!(reading.scale == Scale::Given && is_near(reading.focus_m, 0.6, 1e-3), "{reading:?}");
    // It belongs to the thing: who focuses elsewhere reads that distance, and what is farthest is very far away.
    let far = scene.reading(&Edit { focus: Focus::At([0.05, 0.05]), ..known }, FULL_FRAME, 1000);
    assert!(far.scale == Scale::Given && far.focus_m.is_none() && far.lines()[0].contains("very far"), "{far:?}");
    let of_far = scene.with_distance(&Edit { focus: Focus::At([0.05, 0.05]), ..edit(2.0) }, Some(3.0));
    assert_eq!(scene.reading(&of_far, FULL_FRAME, 1000).scale, Scale::Relative, "the far end fixes nothing");
}

#[test]
fn a_distance_corrects_what_was_measured() {
    let scene = scene(true, Some(50.0), 1.0);
    let reading = scene.reading(&scene.with_distance(&edit(2.0), Some(1.0)), FULL_FRAME, 1000);
    assert!(is_near(reading.focus_m, 1.0, 1e-3), "{reading:?}");
    let wall = Edit { focus: Focus::At([0.05, 0.05]), ..scene.with_distance(&edit(2.0), Some(1.0)) };
    assert!(is_near(scene.reading(&wall, FULL_FRAME, 1000).focus_m, 4.0, 0.02), "all is twice as near");
}

#[test]
fn a_known_lens_sets_the_slider() {
    let scene = scene(true, Some(85.0), 1.0);
    let (lenses, _) = known_lenses();
    let lens = lenses.iter().find(|lens| lens.name.contains("85 mm f/1.4G")).unwrap();
    let (f, is_cut) = scene.f_number_of(&edit(3.5), lens, 1.4);
    assert!((f.0 - 1.4).abs() < 1e-3 && !is_cut);
    // The same aperture before a wide angle of view is more than the slider has.
    let wide = self::scene(true, Some(26.0), 1.0);
    assert_eq!(wide.f_number_of(&edit(3.5), lens, 1.4), (FNumber::WIDEST, true));
    let stopped = wide.f_number_of(&edit(3.5), lens, 8.0).0;
    assert!((stopped.0 - 26.0 / 85.0 * 8.0).abs() < 1e-3);
}

#[test]
fn odd_numbers_make_no_odd_readings() {
    let scene = scene(true, Some(50.0), 1.0);
    for metres in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-30] {
        let reading = scene.reading(&scene.with_distance(&edit(2.0), Some(metres)), FULL_FRAME, 1000);
        assert!(reading.f_number.is_finite() && reading.focus_m.is_none_or(f32::is_finite), "{metres}: {reading:?}");
    }
    for f35_mm in [0.0, -5.0, f32::NAN, 1e9] {
        let reading = self::scene(false, Some(f35_mm), 1.0).reading(&edit(2.0), FULL_FRAME, 1000);
        assert!((reading.focal_mm, reading.focal_is_known) == (USUAL_F35_MM, false), "{f35_mm}: {reading:?}");
    }
    let flat = DisparityMap::constant([4, 4], 0.0);
    assert_eq!(crate::scene::focus::ends(&flat), [0.0; 2]);
}

#[test]
fn the_length_of_a_thing_tells_how_far_it_is() {
    let scene = scene(false, Some(50.0), 1.0);
    let [w, h] = scene.subject().size().map(|side| side as f32);
    // A tenth of the longer side, upright: 3.6 mm of film behind 50 mm show 20 cm at 2.78 m.
    let half = 0.05 * w.max(h) / h;
    let ends = [[0.5, 0.5 - half], [0.5, 0.5 + half]];
    let known = scene.with_length(&edit(2.0), ends, 0.2).unwrap();
    assert!((known.distance.unwrap().metres - 0.2 * 50.0 / 3.6).abs() < 1e-3, "{:?}", known.distance);
    assert!((scene.length_of(&known, ends).unwrap() - 0.2).abs() < 1e-4);
    let reading = scene.reading(&Edit { focus: Focus::At([0.5, 0.5]), ..known }, FULL_FRAME, 1000);
    assert!(reading.scale == Scale::Given && is_near(reading.focus_m, 0.2 * 50.0 / 3.6, 1e-2), "{reading:?}");
    assert!(scene.with_length(&edit(2.0), [[0.5, 0.5]; 2], 0.2).is_none(), "a point has no length");
}
