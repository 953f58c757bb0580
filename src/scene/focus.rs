//! From a place of the picture to the disparity that is to be sharp, and the place that a picture is most likely about.
//!
//! The nearest thing is seldom what a photo is about (petals reach out beyond the head of a flower, grass beyond both),
//! and the picture's middle may miss it. What is nearer than the rest is split off (Otsu 1979). Each place counts by how near it
//! lies to the middle and how much its colours stand out ([`Salience`]), more so where it is near, and the focus goes to where
//! that mass is densest. What lies farthest does not count: a sky between flowers stands out by its colours.

use super::Salience;
use crate::field::DisparityMap;

/// Side of the square whose median disparity is taken, as a share of the map's width: 5 of 540 px.
const MEDIAN_SHARE: f32 = 5.0 / 540.0;

/// The disparity at a place, x and y from 0 to 1, in pixels per view step of the map's width.
pub fn disparity_at(map: &DisparityMap, place: [f32; 2]) -> f32 {
    median_at(map.size(), place, |x, y| map.at(x, y))
}

/// As [`disparity_at`], of values that lie in no map of their own: the median of a small square, so that a stray ray does
/// not move the focus.
pub fn median_at([w, h]: [u32; 2], place: [f32; 2], at: impl Fn(u32, u32) -> f32) -> f32 {
    let reach = (w as f32 * MEDIAN_SHARE / 2.0) as i64;
    let around = |place: f32, side: u32| {
        let center = (place.clamp(0.0, 1.0) * side as f32) as i64;
        (center.min(i64::from(side) - 1) - reach..=center.min(i64::from(side) - 1) + reach)
            .map(move |at| at.clamp(0, i64::from(side) - 1) as u32)
    };
    let at = &at;
    let mut values: Vec<f32> = around(place[1], h).flat_map(|y| around(place[0], w).map(move |x| at(x, y))).collect();
    values.sort_by(f32::total_cmp);
    values[values.len() / 2]
}

/// Part of a scene that may lie beyond either end.
const TAIL: f32 = 0.02;

/// Disparities between which almost all of a map lies, far and near.
pub fn ends(map: &DisparityMap) -> [f32; 2] {
    ends_of(&samples(map))
}

fn ends_of(samples: &[Sample]) -> [f32; 2] {
    let mut all: Vec<f32> = samples.iter().map(|sample| sample.disparity_px).collect();
    all.sort_by(f32::total_cmp);
    let at = |share: f32| all[((all.len() - 1) as f32 * share).round() as usize];
    [at(TAIL), at(1.0 - TAIL)]
}

/// Pixels that are looked at in each direction.
const SAMPLES: u32 = 96;
/// Standard deviation of the weight around the picture's middle, as a share of its sides.
const SPREAD: f32 = 0.22;
/// How far a step towards the denser part looks (mean shift; Comaniciu and Meer 2002), and the steps.
const REACH: f32 = 0.09;
const SHIFTS: usize = 16;
/// Disparities that are told apart when near and far are split.
const BINS: usize = 64;
/// A part that has more than this share of the weight does not stand out; and how often it is split at most.
const MOST: f32 = 0.5;
const SPLITS: usize = 3;
/// How much a near place counts whose colours do not stand out, and one that is not near whose colours do (down to nothing at
/// the farthest), against a near one whose colours do.
const NEAR_ALONE: f32 = 0.05;
const ANYWHERE: f32 = 0.6;
/// Less difference than this between near and far is a flat scene, as a share of the width.
const FLAT_SHARE: f32 = 0.02 / 540.0;

/// Where the subject of a photo most likely is, x and y from 0 to 1: the middle of what stands out near the picture's centre,
/// by its depth and by its colours, and the centre itself where nothing lies at another depth.
pub fn subject(map: &DisparityMap, salience: &Salience) -> [f32; 2] {
    let flat_px = FLAT_SHARE * map.size()[0] as f32;
    let samples = samples(map);
    let Some(border) = standing_out(&samples, flat_px) else { return [0.5, 0.5] };
    let [far, _] = ends_of(&samples);
    let tells = |sample: &Sample| {
        let colour = salience.at(sample.place).powi(2);
        let near = if sample.disparity_px >= border { colour + NEAR_ALONE } else { 0.0 };
        let before_the_farthest = ((sample.disparity_px - far) / (border - far).max(flat_px)).clamp(0.0, 1.0);
        near + ANYWHERE * before_the_farthest * colour
    };
    let told: Vec<(&Sample, f32)> = samples.iter().map(|sample| (sample, tells(sample))).collect();
    let mean = |weight: &dyn Fn(&Sample) -> f32| {
        let weighted = || told.iter().map(|(sample, told)| (sample, weight(sample) * sample.weight * told));
        let mass: f32 = weighted().map(|(_, weight)| weight).sum();
        [0, 1].map(|axis| weighted().map(|(sample, weight)| sample.place[axis] * weight).sum::<f32>() / mass.max(1e-9))
    };
    let mut middle = mean(&|_| 1.0);
    // Between two things lies neither: towards the denser one, to its middle.
    for _ in 0..SHIFTS {
        middle = mean(&|sample| (-squared(sample.place, middle) / (2.0 * REACH * REACH)).exp());
    }
    // The centre of a ring is not on it: the nearest place that tells as much as others.
    let usual = told.iter().map(|(_, told)| told).sum::<f32>() / told.len() as f32;
    let distance = |at: &[f32; 2]| squared(*at, middle);
    let on_it = told.iter().filter(|(_, told)| *told >= usual).map(|(sample, _)| sample.place);
    on_it.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(middle)
}

/// From which disparity on something is nearer than the rest; split again while it is most of what there is (flowers before
/// leaves before a ground).
fn standing_out(samples: &[Sample], flat_px: f32) -> Option<f32> {
    let near = |border: f32| samples.iter().copied().filter(|s| s.disparity_px >= border).collect::<Vec<_>>();
    let mass = |samples: &[Sample]| samples.iter().map(|sample| sample.weight).sum::<f32>();
    let mut border = near_from(samples, flat_px)?;
    for _ in 0..SPLITS {
        let part = near(border);
        match near_from(&part, flat_px) {
            Some(further) if mass(&part) > MOST * mass(samples) => border = further,
            _ => break,
        }
    }
    Some(border)
}

fn squared(a: [f32; 2], b: [f32; 2]) -> f32 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}

#[derive(Clone, Copy)]
struct Sample {
    place: [f32; 2],
    disparity_px: f32,
    weight: f32,
}

fn samples(map: &DisparityMap) -> Vec<Sample> {
    let [w, h] = map.size();
    let (nx, ny) = (SAMPLES.min(w), SAMPLES.min(h));
    let sample = |i: u32, j: u32| {
        let place = [(i as f32 + 0.5) / nx as f32, (j as f32 + 0.5) / ny as f32];
        let (x, y) = ((place[0] * w as f32) as u32, (place[1] * h as f32) as u32);
        let away = ((place[0] - 0.5).powi(2) + (place[1] - 0.5).powi(2)) / (2.0 * SPREAD * SPREAD);
        Sample { place, disparity_px: map.at(x, y), weight: (-away).exp() }
    };
    let all = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j)));
    all.map(|(i, j)| sample(i, j)).collect()
}

/// The disparity from which on the near part begins: where the two parts' means differ most, by weight.
fn near_from(samples: &[Sample], flat_px: f32) -> Option<f32> {
    let low = samples.iter().map(|s| s.disparity_px).fold(f32::INFINITY, f32::min);
    let high = samples.iter().map(|s| s.disparity_px).fold(f32::NEG_INFINITY, f32::max);
    if high - low <= flat_px {
        return None;
    }
    let step = (high - low) / BINS as f32;
    let mut bins = [(0.0f32, 0.0f32); BINS];
    for sample in samples {
        let bin = &mut bins[(((sample.disparity_px - low) / step) as usize).min(BINS - 1)];
        bin.0 += sample.weight;
        bin.1 += sample.weight * sample.disparity_px;
    }
    let (all, sum) = bins.iter().fold((0.0, 0.0), |(n, s), bin| (n + bin.0, s + bin.1));
    let (mut below, mut sum_below, mut best) = (0.0, 0.0, (0.0, low));
    for (i, bin) in bins.iter().enumerate().take(BINS - 1) {
        below += bin.0;
        sum_below += bin.1;
        let above = all - below;
        if below > 0.0 && above > 0.0 {
            let between = below * above * ((sum - sum_below) / above - sum_below / below).powi(2);
            if between > best.0 {
                best = (between, low + step * (i + 1) as f32);
            }
        }
    }
    Some(best.1)
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use super::*;

    fn scene(disparity: impl Fn(f32, f32) -> f32) -> DisparityMap {
        let (w, h) = (120u32, 90u32);
        let map: Vec<f32> =
            (0..w * h).map(|i| disparity((i % w) as f32 / w as f32, (i / w) as f32 / h as f32)).collect();
        DisparityMap::new([w, h], map).unwrap()
    }

    fn distance(at: [f32; 2], to: [f32; 2]) -> f32 {
        ((at[0] - to[0]).powi(2) + (at[1] - to[1]).powi(2)).sqrt()
    }

    #[test]
    fn the_head_of_a_flower_and_not_the_petal_that_reaches_out() {
        // A head at (0.55, 0.4) with petals around it; one petal, and the grass below, are nearer than the head.
        let flower = scene(|x, y| {
            let r = distance([x, y], [0.55, 0.4]);
            match () {
                () if y > 0.93 => 1.5,
                () if r < 0.1 => 0.6,
                () if r < 0.25 && x < 0.45 => 1.0,
                () if r < 0.25 => 0.5,
                () => -1.0,
            }
        });
        assert!(
            distance(subject(&flower, &Salience::even()), [0.55, 0.4]) < 0.1,
            "{:?}",
            subject(&flower, &Salience::even())
        );
    }

    #[test]
    fn of_two_flowers_one_and_not_the_leaves_between_them() {
        let centers = [[0.3, 0.55], [0.75, 0.4]];
        let flowers =
            scene(|x, y| if centers.iter().any(|center| distance([x, y], *center) < 0.15) { 0.0 } else { -1.0 - y });
        let at = subject(&flowers, &Salience::even());
        assert!(centers.iter().any(|center| distance(at, *center) < 0.1), "{at:?}");
    }

    #[test]
    fn flowers_before_leaves_before_a_wall() {
        let centers = [[0.3, 0.5], [0.7, 0.45]];
        let bed = scene(|x, y| match () {
            () if centers.iter().any(|center| distance([x, y], *center) < 0.12) => 0.0,
            () if y > 0.35 => -0.6,
            () => -1.8,
        });
        let at = subject(&bed, &Salience::even());
        assert!(centers.iter().any(|center| distance(at, *center) < 0.1), "{at:?}");
    }

    #[test]
    fn a_ring_is_met_on_the_ring_and_a_wall_in_the_middle() {
        let ring = scene(|x, y| if (0.15..0.25).contains(&distance([x, y], [0.5, 0.5])) { 1.0 } else { -1.0 });
        let r = distance(subject(&ring, &Salience::even()), [0.5, 0.5]);
        assert!((0.14..0.26).contains(&r), "{r}");
        assert_eq!(subject(&scene(|_, _| 0.3), &Salience::even()), [0.5, 0.5]);
    }

    #[test]
    fn the_red_flower_and_not_the_nearer_leaf_beside_it() {
        let red = [0.6, 0.45];
        let plant = scene(|x, y| match () {
            () if distance([x, y], red) < 0.15 => 0.0,
            () if distance([x, y], [0.3, 0.75]) < 0.2 => 1.2,
            () => -0.6 + 0.5 * y,
        });
        let row = |y: usize| {
            let pixel = |x: usize| {
                let is_red = distance([x as f32 / 120.0, y as f32 / 90.0], red) < 0.15;
                if is_red { [220, 60, 90, 255] } else { [60, 110, 50, 255] }
            };
            Cow::Owned((0..120).flat_map(pixel).collect())
        };
        let [colours, none] =
            [Salience::of([120, 90], row), Salience::even()].map(|salience| subject(&plant, &salience));
        assert!(distance(colours, red) < 0.1, "{colours:?}");
        assert!(distance(none, red) > 0.1, "{none:?}");
    }

    #[test]
    fn the_flowers_and_not_the_sky_between_them() {
        let sky = |x: f32, y: f32| distance([x, y], [0.5, 0.45]) < 0.12;
        let bed = scene(|x, y| if sky(x, y) { -2.0 } else { 0.3 * y });
        let colour = |x: f32, y: f32| if sky(x, y) { [150, 190, 240, 255] } else { [200, 160, 20, 255] };
        let row = |y: usize| Cow::Owned((0..120).flat_map(|x| colour(x as f32 / 120.0, y as f32 / 90.0)).collect());
        let [x, y] = subject(&bed, &Salience::of([120, 90], row));
        assert!(!sky(x, y), "{x}, {y}");
    }

    #[test]
    fn a_stray_ray_does_not_move_the_focus() {
        let map = |stray: bool| {
            let value = |i: u32| if stray && i == 60 * 540 + 200 { 9.0 } else { (i / 540) as f32 };
            DisparityMap::new([540, 120], (0..540 * 120).map(value).collect()).unwrap()
        };
        let place = [200.5 / 540.0, 60.5 / 120.0];
        assert_eq!((disparity_at(&map(true), place), disparity_at(&map(false), place)), (60.0, 60.0));
        let small = DisparityMap::new([4, 2], (0..8).map(|i| i as f32).collect()).unwrap();
        assert_eq!(disparity_at(&small, [0.3, 0.9]), 5.0, "a small map has no square around a pixel");
        assert_eq!(disparity_at(&small, [7.0, -3.0]), 3.0);
    }
}
