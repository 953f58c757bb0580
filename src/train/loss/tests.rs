//! Finite differences of every loss, on maps that keep clear of its kinks.

use super::*;
use crate::rng::Rng;

fn maps() -> Maps {
    Maps { samples: 2, views: vec![REFERENCE, REFERENCE + 1, REFERENCE + 9, 0, 63], height: 6, width: 9 }
}

fn random(n: usize, seed: u64, low: f32, high: f32) -> Vec<f32> {
    let mut rng = Rng::new(seed, 1);
    (0..n).map(|_| rng.range(low, high)).collect()
}

/// Compares the gradient of `loss` with central differences at `depth`; kinks that a step crosses may spoil
/// a few places, never more than 3 in 100.
fn check(depth: &[f32], loss: impl Fn(&[f32], f32, &mut [f32]) -> f32) {
    let (weight, step) = (1.7, 1e-3);
    let mut gradient = vec![0.0; depth.len()];
    loss(depth, weight, &mut gradient);
    let largest = gradient.iter().fold(0.0f32, |m, g| m.max(g.abs()));
    assert!(largest > 0.0, "the gradient is zero everywhere");
    let mut off = 0;
    for i in 0..depth.len() {
        let at = |d: f32| {
            let mut moved = depth.to_vec();
            moved[i] += d;
            f64::from(loss(&moved, weight, &mut vec![0.0; depth.len()])) * f64::from(weight)
        };
        let difference = ((at(step) - at(-step)) / f64::from(2.0 * step)) as f32;
        if (difference - gradient[i]).abs() > 0.05 * largest {
            off += 1;
        }
    }
    assert!(off * 100 <= 3 * depth.len(), "{off} of {} derivatives are off", depth.len());
}

fn truth_with_gaps(n: usize) -> Vec<f32> {
    let mut truth = random(n, 5, -1.0, 1.0);
    truth.iter_mut().step_by(7).for_each(|t| *t = f32::NAN);
    truth
}

#[test]
fn supervised_losses_have_their_derivatives() {
    let maps = maps();
    let (depth, truth) = (random(maps.len(), 1, -1.0, 1.0), truth_with_gaps(maps.len()));
    check(&depth, |d, w, g| supervised(d, &truth, w, g));
    check(&depth, |d, w, g| row_centred(&maps, d, &truth, w, g));
    check(&depth, |d, w, g| ordinal(&maps, d, &truth, Along::Rows, &[0.3, 0.2], w, g));
    check(&depth, |d, w, g| ordinal(&maps, d, &truth, Along::Columns, &[0.3, 0.2], w, g));
    let fits = [((0.7, 0.1), 0.0), ((1.3, -0.2), 0.15)].map(|(affine, trim)| Fit { affine, trim });
    check(&depth, |d, w, g| affine(&maps, d, &truth, &fits, 0.5, w, g));
    check(&depth, |d, w, g| thin_parts(&maps, d, &truth, &[0.2, 0.1], w, g));
}

#[test]
fn print_has_its_derivatives() {
    // Without gaps, beside which nothing is asked for.
    let maps = Maps { height: 12, width: 16, ..maps() };
    let (depth, truth) = (random(maps.len(), 1, -1.0, 1.0), random(maps.len(), 5, -0.1, 0.1));
    check(&depth, |d, w, g| print(&maps, d, &truth, &[0.02, 0.01], w, g));
}

#[test]
fn photometric_and_smoothness_losses_have_their_derivatives() {
    let maps = maps();
    let depth = random(maps.len(), 2, -0.8, 0.8);
    let photos = random(maps.samples * 3 * maps.plane(), 3, 0.0, 1.0);
    let views = random(3 * maps.len(), 4, 0.0, 1.0);
    check(&depth, |d, w, g| photometric(&maps, &photos, &views, d, w, g));
    let flow = random(2 * maps.len(), 6, -3.0, 3.0);
    check(&flow, |f, w, g| flowed(&maps, &photos, &views, f, w, g));
    let added = random(3 * maps.len(), 7, -0.9, 0.9);
    check(&added, |y, w, g| regressed(&maps, &photos, &views, y, w, g));
    check(&depth, |d, w, g| consistency(&maps, d, w, g));
    check(&depth, |d, w, g| total_variation(&maps, d, w, g));
}

#[test]
fn the_truth_costs_nothing() {
    let maps = maps();
    let truth = vec![0.5; maps.len()];
    let mut gradient = vec![0.0; maps.len()];
    let g = &mut gradient;
    assert_eq!(supervised(&truth, &truth, 1.0, g), 0.0);
    assert_eq!(row_centred(&maps, &truth, &truth, 1.0, g), 0.0);
    assert_eq!(consistency(&maps, &truth, 1.0, g), 0.0);
    assert_eq!(total_variation(&maps, &truth, 1.0, g), 0.0);
    assert!(gradient.iter().all(|g| *g == 0.0));
}

#[test]
fn an_affine_change_of_the_truth_is_found_and_costs_nothing() {
    let maps = Maps { samples: 1, ..maps() };
    let truth = truth_with_gaps(maps.len());
    let depth: Vec<f32> = truth.iter().map(|t| if t.is_nan() { 3.0 } else { t / 1.5 + 0.4 }).collect();
    let fit = affine_fit(&depth, &truth);
    assert!((fit.0 - 1.5).abs() < 1e-3 && (fit.1 + 0.6).abs() < 1e-3, "{fit:?}");
    assert!(
        affine(&maps, &depth, &truth, &[Fit { affine: fit, trim: 0.0 }], 0.5, 1.0, &mut vec![0.0; maps.len()]) < 1e-4
    );
}

#[test]
fn trimmed_errors_of_a_map_cost_nothing() {
    let maps = Maps { samples: 1, ..maps() };
    let truth = random(maps.len(), 5, -1.0, 1.0);
    let wrong: Vec<f32> = truth.iter().enumerate().map(|(i, t)| if i % 8 == 0 { t + 3.0 } else { *t }).collect();
    let loss = |trim| {
        let mut gradient = vec![0.0; maps.len()];
        (affine(&maps, &wrong, &truth, &[Fit { affine: (1.0, 0.0), trim }], 0.0, 1.0, &mut gradient), gradient)
    };
    assert!(loss(0.0).0 > 0.3);
    let (value, gradient) = loss(0.2);
    assert!(value < 1e-6 && gradient.iter().step_by(8).all(|g| *g == 0.0), "{value}");
}

#[test]
fn views_rendered_with_no_depth_are_the_photo() {
    let maps = maps();
    let photos = random(maps.samples * 3 * maps.plane(), 3, 0.0, 1.0);
    let views = rendered_views(&maps, &photos, &vec![0.0; maps.len()]);
    for (i, view) in views.chunks(3 * maps.plane()).enumerate() {
        assert_eq!(view, &photos[i / maps.views.len() * 3 * maps.plane()..][..3 * maps.plane()]);
    }
}

#[test]
fn flow_along_the_way_to_a_view_is_its_depth() {
    let maps = maps();
    let photos = random(maps.samples * 3 * maps.plane(), 3, 0.0, 1.0);
    let depth = random(maps.len(), 2, -0.8, 0.8);
    let mut flow = Vec::new();
    for (map, d) in depth.chunks(maps.plane()).enumerate() {
        let (du, dv) = crate::scenes::steps(maps.views[map % maps.views.len()]);
        flow.extend(d.iter().map(|d| du * d).chain(d.iter().map(|d| dv * d)));
    }
    assert_eq!(flowed_views(&maps, &photos, &flow), rendered_views(&maps, &photos, &depth));
}
