//! What every sample must keep: the same bytes, and views that agree with their ray depths.

use super::layer::tap_rgb;
use super::*;
use crate::scenes::raster::Raster;

/// A picture of soft random texture with a disc as subject and a ramp as nearness.
fn picture(id: &str, seed: u64, size: [usize; 2]) -> Picture {
    let mut rng = Rng::new(seed, 0);
    let mut colours = Raster::from_fn(size, |_, _| [0; 3].map(|_: i32| rng.range(0.0, 255.0)));
    colours.blur(2.0);
    let rgb = colours.map(|texel| texel.map(|c| ((c - 128.0) * 4.0 + 128.0).clamp(0.0, 255.0) as u8));
    let [w, h] = size.map(|side| side as f32);
    let inside = |x: usize, y: usize| (x as f32 - w / 2.0).hypot(y as f32 - h / 2.0) < h / 4.0;
    let mask = Raster::from_fn(size, |x, y| if inside(x, y) { 255u8 } else { 0 });
    let near = Raster::from_fn(size, |x, y| if inside(x, y) { 220u8 } else { (40.0 + 120.0 * y as f32 / h) as u8 });
    Picture::new(id.to_owned(), rgb, Some(mask), Some(near))
}

fn source(mix: Mix, views_per_sample: usize, seed: u64) -> Source {
    let config = Config { long_side: 96, crop: [96, 72], views_per_sample, mix, seed, ..Config::default() };
    let library = Library {
        pictures: vec![
            picture("flowers/a", 1, [115, 86]),
            picture("everyday/b", 2, [115, 86]),
            picture("flowers/c", 3, [86, 115]),
        ],
        ..Library::default()
    };
    Source::from_library(&config, library)
}

const KINDS: [Mix; 3] = [
    Mix { lifted: 1.0, collage: 0.0, pseudo: 0.0, real: 0.0, solid: 0.0 },
    Mix { lifted: 0.0, collage: 1.0, pseudo: 0.0, real: 0.0, solid: 0.0 },
    Mix { lifted: 0.0, collage: 0.0, pseudo: 1.0, real: 0.0, solid: 0.0 },
];

#[test]
fn a_sample_is_told_by_seed_and_index_alone() {
    for mix in KINDS {
        let [a, b] = [source(mix, 4, 5), source(mix, 4, 5)];
        let late = b.sample(9);
        (0..3).for_each(|index| drop(a.sample(index)));
        assert_eq!(a.sample(9), late);
        assert_ne!(a.sample(10).rgb, late.rgb);
        assert_ne!(source(mix, 4, 6).sample(9).rgb, late.rgb);
    }
}

#[test]
fn light_falls_on_colours_and_leaves_the_map() {
    for mix in KINDS {
        let [plain, mut lit, mut again] = [source(mix, 2, 5), source(mix, 2, 5), source(mix, 2, 5)];
        (lit.config.shading, again.config.shading) = (0.5, 0.5);
        let both = || (0..12).map(|index| (plain.sample(index), lit.sample(index)));
        assert!(both().all(|(plain, lit)| plain.disparity == lit.disparity && plain.subject == lit.subject));
        let count = both().filter(|(plain, lit)| plain.rgb != lit.rgb).count();
        assert!((2..11).contains(&count), "{count}");
        assert!((0..12).rev().all(|index| again.sample(index) == lit.sample(index)));
    }
}

#[test]
fn where_a_subject_is_told_it_is_in_front() {
    let source = source(KINDS[2], 1, 5);
    let samples: Vec<Sample> = (0..40).map(|index| source.sample(index)).collect();
    let (told, hidden): (Vec<_>, Vec<_>) = samples.iter().partition(|sample| sample.subject.is_some());
    assert!(told.len() > 15 && hidden.len() > 5, "{} told, {} behind a guest", told.len(), hidden.len());
    for sample in told {
        let mask = sample.subject.as_ref().unwrap();
        let least = |inside: bool| {
            let of = sample.disparity.iter().zip(mask).filter(|(_, m)| (**m > 127) == inside);
            of.map(|(d, _)| *d).fold(f32::MAX, f32::min)
        };
        assert!(!mask.contains(&255) || least(true) > least(false), "{}", sample.origin);
    }
}

#[test]
fn one_kind_of_photos_is_enough() {
    for id in ["flowers/a", "everyday/b"] {
        for mix in KINDS {
            let config = source(mix, 1, 7).config;
            let library = Library { pictures: vec![picture(id, 1, [115, 86])], ..Library::default() };
            let engine = Source::from_library(&config, library);
            assert!((0..12).all(|index| engine.sample(index).origin.starts_with(id)));
        }
    }
}

#[test]
fn the_reference_comes_first_and_a_batch_shares_its_views() {
    let mut all = source(Mix::default(), 64, 1);
    assert_eq!(all.sample(0).views[0], REFERENCE);
    all.config.views_per_sample = 7;
    all.config.views_group = 4;
    let views = |index| all.views(index);
    assert!(views(8) == views(11) && views(8) != views(12));
    let mut sorted = views(8);
    sorted.sort_unstable();
    sorted.dedup();
    assert_eq!(sorted.len(), 7);
}

#[test]
fn shapes_and_ranges_are_as_documented() {
    for mix in KINDS {
        let engine = source(mix, 3, 2);
        for index in 0..6 {
            let sample = engine.sample_sized(index, [64, 80]);
            let disparity = &sample.disparity;
            assert_eq!((sample.rgb.len(), disparity.len()), (3 * 3 * 64 * 80, 3 * 64 * 80));
            assert!(sample.rgb.iter().all(|v| (0.0..=1.0).contains(v)));
            let range = engine.config.range_px();
            assert!(disparity.iter().all(|d| (-range..0.5 * range).contains(d)), "{:?}", sample.kind);
            assert!(sample.yx[0] < sample.yx[1] && sample.yx[2] < sample.yx[3]);
            assert!(sample.yx.iter().all(|at| (-1.01..=1.01).contains(at)), "{:?}", sample.yx);
        }
    }
}

/// Mean and share of large differences between a view and the reference seen along its ray depths, where the
/// reference shows the same surface.
fn disagreement(sample: &Sample) -> (f32, f32, f32) {
    let ([w, h], count) = (sample.size, sample.size[0] * sample.size[1]);
    let disparity = &sample.disparity;
    let picture = |k: usize| -> Vec<[f32; 3]> {
        (0..count).map(|i| [0, 1, 2].map(|c| sample.rgb[(k * 3 + c) * count + i])).collect()
    };
    let reference = picture(0);
    let (mut sum, mut large, mut seen, mut all) = (0.0, 0.0, 0.0f32, 0.0f32);
    for (k, &layer) in sample.views.iter().enumerate().skip(1) {
        let ((du, dv), view) = (steps(layer), picture(k));
        for i in 0..count {
            let d = disparity[k * count + i];
            let (x, y) = ((i % w) as f32 + du * d, (i / w) as f32 + dv * d);
            if x < 3.0 || y < 3.0 || x > (w - 4) as f32 || y > (h - 4) as f32 {
                continue;
            }
            all += 1.0;
            // Far enough from every edge of depth, in the reference and in the view.
            let near = |map: &[f32], x: usize, y: usize| {
                (y - 2..=y + 3).all(|y| (x - 2..=x + 3).all(|x| (map[y * w + x] - d).abs() < 0.06))
            };
            if !near(&disparity[..count], x as usize, y as usize) {
                continue;
            }
            let there = tap_rgb(&reference, sample.size, x, y);
            let difference = (0..3).map(|c| (there[c] - view[i][c]).abs()).sum::<f32>() / 3.0;
            seen += 1.0;
            sum += difference;
            large += f32::from(u8::from(difference > 0.06));
        }
    }
    (sum / seen, large / seen, seen / all)
}

#[test]
fn views_agree_with_their_ray_depths_where_nothing_is_hidden() {
    for mix in KINDS {
        let mut engine = source(mix, 8, 3);
        engine.config.augment = mix.collage > 0.0;
        for index in 0..8 {
            let sample = engine.sample(index);
            let (mean, large, seen) = disagreement(&sample);
            assert!(mean < 0.02 && large < 0.02, "{:?} {index}: mean {mean}, large {large}, seen {seen}", sample.kind);
            assert!(seen > 0.2, "{:?} {index}: only {seen} of the rays were compared", sample.kind);
        }
    }
}

#[test]
fn a_subject_is_nearer_than_its_surround_and_hides_it() {
    let engine = source(KINDS[0], 64, 4);
    let sample = engine.constructed(0, (0..64).map(|i| if i == 0 { 36 } else { i - usize::from(i <= 36) }).collect());
    let count = sample.size[0] * sample.size[1];
    let (disparity, subject) = (&sample.disparity[..count], sample.subject.as_ref().unwrap());
    let mean = |inside: bool| {
        let values: Vec<f32> = (0..count).filter(|&i| (subject[i] > 127) == inside).map(|i| disparity[i]).collect();
        values.iter().sum::<f32>() / values.len() as f32
    };
    assert!(mean(true) > mean(false) + 0.1);
}

#[test]
fn a_guest_stands_before_everything_that_it_covers() {
    let engine = source(KINDS[2], 1, 6);
    let canvas = Canvas::new([96, 72], engine.config.range_px());
    let full = canvas.full();
    for seed in 0..8 {
        let rgb = Raster::from_fn(full, |_, _| [0.5; 3]);
        let ramp = Raster::from_fn(full, |x, _| canvas.disparity(x as f32 / full[0] as f32));
        let layers = vec![layer::Layer::whole(rgb, ramp, false)];
        let mut scene = Scene { layers, margin: canvas.margin, size: canvas.size };
        engine.add_guest(&mut Rng::new(seed, 0), &canvas, &mut scene);
        let [ground, guest] = &scene.layers[..] else { panic!("no guest came") };
        let covered = (0..full[0] * full[1]).filter(|&i| guest.rgba.px[i][3] > 0.5);
        assert!(covered.clone().count() > 20);
        assert!(covered.clone().all(|i| guest.disparity.px[i] > ground.disparity.px[i]));
    }
}

#[test]
fn photos_without_masks_are_enough() {
    let size = [115, 86];
    let ramp = Raster::from_fn(size, |_, y| (40 + y) as u8);
    let bare = Picture::new("everyday/a".to_owned(), Raster::from_fn(size, |x, _| [x as u8; 3]), None, Some(ramp));
    let config = Config { long_side: 96, crop: [96, 72], views_per_sample: 1, mix: KINDS[2], ..Config::default() };
    let source = Source::from_library(&config, Library { pictures: vec![bare], ..Library::default() });
    assert!((0..20).all(|index| source.sample(index).subject.is_none()));
}

#[test]
fn a_fine_scene_is_a_window_of_a_larger_one() {
    let mut source = source(KINDS[0], 1, 5);
    let (crop, views) = ([48, 32], vec![REFERENCE]);
    let drawn = |source: &Source, index| source.solid(&mut Rng::new(7, index), index, crop, views.clone());
    assert_eq!(drawn(&source, 3).yx, [-1.0, 1.0, -1.0, 1.0]);
    source.config.fine = 1.0;
    let mut sizes = std::collections::BTreeSet::new();
    let corners: std::collections::BTreeSet<_> = (0..8)
        .map(|index| {
            let sample = drawn(&source, index);
            assert_eq!(sample, drawn(&source, index));
            assert_eq!((sample.size, sample.disparity.len(), sample.rgb.len()), (crop, 48 * 32, 3 * 48 * 32));
            let [top, bottom, left, right] = sample.yx;
            // 31 of 63 steps and 47 of 95, or 31 of 95 and 47 of 143, of a picture that spans 2.
            let is_of = |high: f32, wide: f32| {
                (bottom - top - 62.0 / high).abs() < 1e-5 && (right - left - 94.0 / wide).abs() < 1e-5
            };
            assert!(is_of(63.0, 95.0) || is_of(95.0, 143.0));
            sizes.insert((94.0 / (right - left)).round() as u32);
            assert!(top >= -1.0 && left >= -1.0 && bottom < 1.001 && right < 1.001);
            [top, left].map(f32::to_bits)
        })
        .collect();
    assert!(corners.len() > 4, "windows lie anywhere");
    assert_eq!(sizes.len(), 2, "pictures are of both sizes: {sizes:?}");
    let canvas = source.canvas(&mut Rng::new(7, 3), crop);
    let whole = source.solid_of(3, crop.map(|side| 2 * side), views.clone(), &canvas);
    let cut = whole.cut([10, 20], crop);
    let pixel = |sample: &Sample, x: usize, y: usize| sample.disparity[y * sample.size[0] + x];
    assert!((0..32).all(|y| (0..48).all(|x| pixel(&cut, x, y) == pixel(&whole, x + 10, y + 20))));
    assert_eq!(cut.rgb[2 * 48 * 32], whole.rgb[2 * 96 * 64 + 20 * 96 + 10]);
}
