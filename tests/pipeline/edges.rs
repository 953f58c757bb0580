//! What a net knows of a picture's depth arrives at the size of the views: nothing is washed out, and nothing is added.

use plenoscope::field::{DisparityMap, Filter, Photo, Raster, View, resample, sides};
use plenoscope::io::sample::sample;
use plenoscope::job::{Cancel, Job};
use plenoscope::synth::{reference_view, upsample};

/// The size at which usual nets answer, and that of the views.
const NET: [u32; 2] = [518, 350];
const VIEW: [u32; 2] = [540, 360];

fn guided(map: &DisparityMap, guide: &View) -> DisparityMap {
    upsample::to_guide(map, guide, &Job { cancel: &Cancel::default(), sink: &() }).unwrap()
}

/// The map as a camera of another size would see it.
fn seen(map: &DisparityMap, size: [u32; 2]) -> DisparityMap {
    let scale = map.scale_to(size);
    let values = resample::<1>(map.disparity_px(), map.size(), size, Filter::Linear);
    DisparityMap::new(size, values.into_iter().map(|d| d * scale).collect()).unwrap()
}

/// Gaussian blur.
fn blurred(map: &DisparityMap, sigma_px: f32) -> DisparityMap {
    let reach = (3.0 * sigma_px).ceil() as i32;
    let [w, h] = sides(map.size()).map(|side| side as i32);
    let weight = |i: i32| (-((i * i) as f32) / (2.0 * sigma_px * sigma_px)).exp();
    let sum: f32 = (-reach..=reach).map(weight).sum();
    let pass = |map: &Raster<f32>, [dx, dy]: [i32; 2]| {
        Raster::from_fn(map.size(), |x, y| {
            let at = |i: i32| [(x as i32 + i * dx).clamp(0, w - 1), (y as i32 + i * dy).clamp(0, h - 1)];
            (-reach..=reach).map(|i| weight(i) * map.at(at(i)[0] as usize, at(i)[1] as usize)).sum::<f32>() / sum
        })
    };
    let map = Raster::new(map.size(), map.disparity_px().to_vec()).unwrap();
    let both = pass(&pass(&map, [1, 0]), [0, 1]);
    DisparityMap::new(both.size(), both.into_pixels()).unwrap()
}

/// Share of the pixels that are wrong by more than a tenth of the range.
fn wrong(map: &DisparityMap, truth: &DisparityMap) -> f32 {
    let [low, high] = truth.range_px();
    let pairs = map.disparity_px().iter().zip(truth.disparity_px());
    pairs.filter(|(d, t)| (**d - **t).abs() > (high - low) / 10.0).count() as f32 / truth.disparity_px().len() as f32
}

#[test]
fn a_map_that_is_right_stays_right_and_a_soft_one_becomes_sharper() {
    let sample = sample().unwrap();
    let view = reference_view(&sample.photo, VIEW[0], &Job { cancel: &Cancel::default(), sink: &() }).unwrap();
    let truth = seen(&sample.disparity, VIEW);
    let net = seen(&sample.disparity, NET);
    let sharp = wrong(&guided(&net, &view), &truth);
    assert!(sharp <= 0.001, "{sharp} of the pixels are wrong");
    let soft = blurred(&net, 2.0);
    let (settled, plain) = (wrong(&guided(&soft, &view), &truth), wrong(&seen(&soft, VIEW), &truth));
    assert!(settled <= 0.05 && settled < plain, "{settled} of the pixels are wrong where {plain} were");
    let small = blurred(&sample.disparity.resized([128, 85]).unwrap(), 1.0);
    let (settled, plain) = (wrong(&guided(&small, &view), &truth), wrong(&seen(&small, VIEW), &truth));
    assert!(settled < plain, "{settled} of the pixels are wrong from a small map where {plain} were");
}

#[test]
fn a_larger_map_is_reduced_without_depths_in_between() {
    let sample = sample().unwrap();
    let view = reference_view(&sample.photo, VIEW[0], &Job { cancel: &Cancel::default(), sink: &() }).unwrap();
    let out = guided(&sample.disparity, &view);
    let [width, height] = sample.disparity.size();
    let scale = out.scale_to([width, height]);
    // The photo's pixels under a pixel of the view.
    let under = |i: u32, from: u32, to: u32| i * from / to..((i + 1) * from).div_ceil(to).min(from);
    for y in 0..VIEW[1] {
        for x in 0..VIEW[0] {
            let d = out.at(x, y) * scale;
            let mut places = under(y, height, VIEW[1]).flat_map(|y| under(x, width, VIEW[0]).map(move |x| (x, y)));
            assert!(places.any(|(x, y)| (sample.disparity.at(x, y) - d).abs() < 1e-3), "{d} at {x}, {y} is invented");
        }
    }
}

/// Before a slanted ground: a printed board, flat, and a thin stem of the ground's colour but darker.
fn board_and_stem() -> (Photo, DisparityMap) {
    let size = [1080, 720];
    let on_board = |x: usize, y: usize| (120..480).contains(&x) && (140..600).contains(&y);
    let on_stem = |x: usize, y: usize| (760..768).contains(&x) && y >= 80;
    let color = |x: usize, y: usize| match (on_board(x, y), on_stem(x, y)) {
        (true, _) if (x / 18 + y / 26).is_multiple_of(2) => [30, 30, 40, 255],
        (true, _) => [230, 225, 210, 255],
        (_, true) => [40, 70, 30, 255],
        _ => [120, 150, 110, 255],
    };
    let depth = |x: usize, y: usize| match (on_board(x, y), on_stem(x, y)) {
        (true, _) => 1.0,
        (_, true) => 0.6,
        _ => -1.6 + 0.002 * y as f32,
    };
    let rgba = Raster::from_fn(size, color).into_pixels().into_flattened();
    let depth = DisparityMap::new(size, Raster::from_fn(size, depth).into_pixels()).unwrap();
    (Photo::from_srgb8(size, rgba).unwrap(), depth)
}

#[test]
fn print_is_no_depth_and_a_thin_stem_is_not_lost() {
    let (photo, depth) = board_and_stem();
    let view = reference_view(&photo, VIEW[0], &Job { cancel: &Cancel::default(), sink: &() }).unwrap();
    let sharp = seen(&depth, NET);
    // What of the stem a map that is blurred so much still knows of its height.
    let maps = [(sharp.clone(), 0.8), (blurred(&sharp, 2.0), 0.5), (blurred(&seen(&depth, [384, 256]), 1.0), 0.5)];
    for (number, (map, height)) in maps.iter().enumerate() {
        let out = guided(map, &view);
        for y in 84..286 {
            for x in 74..226 {
                let d = out.at(x, y);
                assert!((d - 0.5).abs() < 0.06, "map {number}: the board is {d} deep at {x}, {y}");
            }
        }
        for y in 50..330 {
            let ground = -0.8 + 0.002 * y as f32;
            let stem = (379..386).map(|x| out.at(x, y)).fold(f32::MIN, f32::max);
            assert!(stem - ground > height * (0.3 - ground), "map {number}: the stem is {stem} deep at row {y}");
            let beside = out.at(400, y);
            assert!((beside - ground).abs() < 0.06, "map {number}: the ground is {beside} deep at row {y}");
        }
    }
}
