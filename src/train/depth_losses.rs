//! All losses of predicted ray depths, and their weighed gradient.

use rayon::prelude::*;

use crate::batch::Batch;
use crate::config::LossWeights;
use crate::loss::{self, Along, Maps};
use crate::nets::zeros;
use crate::step::Parts;

/// Long side at which the losses' weights are meant; ray depths in px shrink with the picture.
const UNIT_SIDE_PX: f32 = 288.0;

/// The share of the largest errors that is trimmed where the truth is worth nothing.
const MOST_TRIMMED: f32 = 0.25;

/// The part of what makes a pair of the ordinal loss by which print may stand out.
const PRINT_SLACK: f32 = 0.25;

/// All losses of a batch of predicted ray depths, and their weighed gradient.
pub(crate) fn depth_losses(batch: &Batch, depth: &[f32], weights: &LossWeights) -> (Parts, Vec<f32>) {
    let maps = &batch.maps;
    let mut gradient = zeros(depth.len());
    let g = &mut gradient[..];
    let truth = &batch.truth[..];
    let small = maps.width.max(maps.height) as f32 / UNIT_SIDE_PX;
    let mut parts = Parts::new();
    parts.insert("reference", reference_error(batch, depth) / small);
    // Of the reference view alone, views tell nothing.
    if weights.w_photometric > 0.0 && maps.views.len() > 1 {
        parts.insert(
            "photometric",
            loss::photometric(maps, &batch.photos(), &batch.views, depth, weights.w_photometric, g),
        );
    }
    if weights.w_supervised > 0.0 {
        parts.insert("supervised", loss::supervised(depth, truth, weights.w_supervised / small, g) / small);
    }
    if weights.w_row > 0.0 {
        parts.insert("row", loss::row_centred(maps, depth, truth, weights.w_row / small, g) / small);
    }
    // What is true is true in its finer steps, too.
    let finer = |worth: &f32| if *worth < 1.0 { 1.0 } else { 0.4 };
    let apart: Vec<f32> = batch.worth.iter().map(|w| weights.ordinal_apart_px * small * finer(w)).collect();
    let pairs = [("ordinal", Along::Rows, weights.w_ordinal), ("columns", Along::Columns, weights.w_columns)];
    for (name, along, weight) in pairs.into_iter().filter(|(.., weight)| *weight > 0.0) {
        parts.insert(name, loss::ordinal(maps, depth, truth, along, &apart, weight / small, g) / small);
    }
    if weights.w_affine > 0.0 {
        let size = maps.views.len() * maps.plane();
        let samples = depth.par_chunks(size).zip(truth.par_chunks(size));
        let fit = |((d, t), worth): ((&[f32], &[f32]), &f32)| loss::Fit {
            affine: loss::affine_fit(d, t),
            trim: MOST_TRIMMED * (1.0 - worth),
        };
        let fits: Vec<_> = samples.zip(&batch.worth).map(fit).collect();
        parts.insert(
            "affine",
            loss::affine(maps, depth, truth, &fits, weights.w_edges, weights.w_affine / small, g) / small,
        );
    }
    // A map that another net made knows no thin parts.
    let known = |(apart, worth): (&f32, &f32)| if *worth < 1.0 { 0.0 } else { *apart };
    let apart: Vec<f32> = apart.iter().zip(&batch.worth).map(known).collect();
    if weights.w_thin > 0.0 {
        parts.insert("thin", loss::thin_parts(maps, depth, truth, &apart, weights.w_thin / small, g) / small);
    }
    if weights.w_print > 0.0 {
        let slack: Vec<f32> = apart.iter().map(|apart| PRINT_SLACK * apart).collect();
        parts.insert("print", loss::print(maps, depth, truth, &slack, weights.w_print / small, g) / small);
    }
    smoothness(maps, depth, weights, small, g, &mut parts);
    // What is worth less moves the net less; the losses told are those of all.
    let one = maps.views.len() * maps.plane();
    gradient.chunks_mut(one).zip(&batch.worth).for_each(|(g, worth)| g.iter_mut().for_each(|g| *g *= worth));
    // A mask is worth as much whatever the map beside it is.
    if weights.w_subject > 0.0 {
        let (margin, weight) = (2.0 * weights.ordinal_apart_px * small, weights.w_subject / small);
        let loss = loss::subject_order(maps, depth, &batch.subjects, margin, weight, &mut gradient);
        parts.insert("subject", loss / small);
    }
    (parts, gradient)
}

/// Mean |D − D*| of the reference views alone: a figure to watch, not a loss.
fn reference_error(batch: &Batch, depth: &[f32]) -> f32 {
    let (plane, all) = (batch.maps.plane(), batch.maps.views.len() * batch.maps.plane());
    let here = batch.maps.reference() * plane..(batch.maps.reference() + 1) * plane;
    let samples = depth.chunks(all).zip(batch.truth.chunks(all));
    let pairs = samples.flat_map(|(d, t)| d[here.clone()].iter().zip(&t[here.clone()]));
    let errors: Vec<f32> = pairs.filter(|(_, t)| !t.is_nan()).map(|(d, t)| (d - t).abs()).collect();
    errors.iter().sum::<f32>() / errors.len().max(1) as f32
}

fn smoothness(maps: &Maps, depth: &[f32], weights: &LossWeights, small: f32, g: &mut [f32], parts: &mut Parts) {
    if weights.w_consistency > 0.0 {
        parts.insert("consistency", loss::consistency(maps, depth, weights.w_consistency / small, g) / small);
    }
    if weights.w_tv > 0.0 {
        parts.insert("tv", loss::total_variation(maps, depth, weights.w_tv / small, g) / small);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::tests::toy;
    use crate::config::Config;

    fn of(batch: &Batch, weights: &LossWeights) -> (Parts, Vec<f32>) {
        let depth: Vec<f32> = (0..batch.maps.len()).map(|i| (i as f32 * 0.7).sin()).collect();
        depth_losses(batch, &depth, weights)
    }

    fn none() -> LossWeights {
        LossWeights {
            w_supervised: 0.0,
            w_photometric: 0.0,
            w_affine: 0.0,
            w_row: 0.0,
            w_ordinal: 0.0,
            w_columns: 0.0,
            w_subject: 0.0,
            w_consistency: 0.0,
            w_tv: 0.0,
            ..Config::default().losses
        }
    }

    #[test]
    fn the_gradient_is_the_sum_of_that_of_each_loss() {
        let batch = toy(2, (16, 8))(1).unwrap();
        let each = [
            LossWeights { w_supervised: 0.7, ..none() },
            LossWeights { w_photometric: 0.3, ..none() },
            LossWeights { w_tv: 0.2, ..none() },
        ];
        let all = LossWeights { w_supervised: 0.7, w_photometric: 0.3, w_tv: 0.2, ..none() };
        let (parts, gradient) = of(&batch, &all);
        let names: Vec<&str> = parts.keys().copied().collect();
        assert_eq!(names, ["photometric", "reference", "supervised", "tv"]);
        let alone = each.map(|weights| of(&batch, &weights).1);
        for (i, g) in gradient.iter().enumerate() {
            let sum: f32 = alone.iter().map(|gradient| gradient[i]).sum();
            assert!((g - sum).abs() < 1e-7, "{i}: {g}, {sum}");
        }
    }

    #[test]
    fn what_is_worth_less_moves_the_net_less_and_a_mask_as_much() {
        let mut batch = toy(2, (16, 8))(1).unwrap();
        batch.subjects = vec![(0..16 * 8).map(|i| if i % 16 < 8 { 255 } else { 0 }).collect(); 2];
        let [by_truth, by_mask] =
            [LossWeights { w_supervised: 1.0, ..none() }, LossWeights { w_subject: 1.0, ..none() }];
        let before = [&by_truth, &by_mask].map(|weights| of(&batch, weights));
        batch.worth = vec![1.0, 0.5];
        let after = [&by_truth, &by_mask].map(|weights| of(&batch, weights));
        let half = batch.maps.len() / 2;
        assert_eq!(before[0].0, after[0].0, "losses told are those of all");
        assert_eq!(before[0].1[..half], after[0].1[..half]);
        assert!(before[0].1[half..].iter().zip(&after[0].1[half..]).all(|(b, a)| 0.5 * b == *a));
        assert!(before[1].1.iter().any(|g| *g != 0.0));
        assert_eq!(before[1], after[1]);
    }
}
