//! The losses of predicted ray depths, beside each other, and their gradient.

use rayon::prelude::*;

use crate::batch::Batch;
use crate::config::LossWeights;
use crate::loss::{self, Along};
use crate::nets::zeros;
use crate::step::Parts;

/// Long side at which the losses' weights are meant; ray depths in px shrink with the picture.
const UNIT_SIDE_PX: f32 = 288.0;

/// The share of the largest errors that is trimmed where the truth is worth nothing.
const MOST_TRIMMED: f32 = 0.25;

/// A loss: its value, and its weighed gradient added to what it is given.
type Loss<'a> = Box<dyn Fn(&mut [f32]) -> f32 + Send + Sync + 'a>;

/// A loss of ray depths among others.
struct Term<'a> {
    name: &'static str,
    /// Whether what the truth of a sample is worth counts; a mask is worth as much whatever the map beside it is.
    by_worth: bool,
    loss: Loss<'a>,
}

/// All losses of a batch of predicted ray depths, and their weighed gradient.
pub(crate) fn depth_losses(batch: &Batch, depth: &[f32], weights: &LossWeights) -> (Parts, Vec<f32>) {
    let maps = &batch.maps;
    let small = maps.width.max(maps.height) as f32 / UNIT_SIDE_PX;
    let photos = if weights.w_photometric > 0.0 { batch.photos() } else { Vec::new() };
    let mut terms = Vec::new();
    towards_truth(batch, depth, weights, small, &mut terms);
    of_pictures((batch, &photos), depth, weights, small, &mut terms);
    // Beside each other, as one alone is too short for the threads of a large machine.
    let run = |term: &Term<'_>| {
        let mut gradient = zeros(depth.len());
        ((term.loss)(&mut gradient), gradient)
    };
    let done: Vec<(f32, Vec<f32>)> = terms.par_iter().map(run).collect();
    let mut parts: Parts = terms.iter().zip(&done).map(|(term, (loss, _))| (term.name, *loss)).collect();
    parts.insert("reference", reference_error(batch, depth) / small);
    let mut gradient = zeros(depth.len());
    let one = maps.views.len() * maps.plane();
    gradient.par_chunks_mut(one).zip(&batch.worth).enumerate().for_each(|(sample, (gradient, worth))| {
        for (term, (_, of_term)) in terms.iter().zip(&done) {
            // What is worth less moves the net less; the losses told are those of all.
            let worth = if term.by_worth { *worth } else { 1.0 };
            let of_sample = &of_term[sample * one..][..one];
            gradient.iter_mut().zip(of_sample).for_each(|(sum, g)| *sum += worth * g);
        }
    });
    (parts, gradient)
}

/// Losses against known ray depths.
fn towards_truth<'a>(
    batch: &'a Batch,
    depth: &'a [f32],
    weights: &'a LossWeights,
    small: f32,
    terms: &mut Vec<Term<'a>>,
) {
    let (maps, truth) = (&batch.maps, &batch.truth[..]);
    let mut add = |name, weight: f32, loss: Loss<'a>| {
        if weight > 0.0 {
            terms.push(Term { name, by_worth: true, loss });
        }
    };
    let weight = weights.w_supervised / small;
    add("supervised", weight, Box::new(move |g| loss::supervised(depth, truth, weight, g) / small));
    let weight = weights.w_row / small;
    add("row", weight, Box::new(move |g| loss::row_centred(maps, depth, truth, weight, g) / small));
    // What is true is true in its finer steps, too.
    let finer = |worth: &f32| if *worth < 1.0 { 1.0 } else { 0.4 };
    let apart: Vec<f32> = batch.worth.iter().map(|w| weights.ordinal_apart_px * small * finer(w)).collect();
    let pairs = [("ordinal", Along::Rows, weights.w_ordinal), ("columns", Along::Columns, weights.w_columns)];
    for (name, along, weight) in pairs {
        let (apart, weight) = (apart.clone(), weight / small);
        add(name, weight, Box::new(move |g| loss::ordinal(maps, depth, truth, along, &apart, weight, g) / small));
    }
    let (weight, edges) = (weights.w_affine / small, weights.w_edges);
    add(
        "affine",
        weight,
        Box::new(move |g| loss::affine(maps, depth, truth, &fits(batch, depth), edges, weight, g) / small),
    );
    // A map that another net made knows no thin parts.
    let known = |(apart, worth): (&f32, &f32)| if *worth < 1.0 { 0.0 } else { *apart };
    let apart: Vec<f32> = apart.iter().zip(&batch.worth).map(known).collect();
    let weight = weights.w_thin / small;
    add("thin", weight, Box::new(move |g| loss::thin_parts(maps, depth, truth, &apart, weight, g) / small));
}

/// What brings each sample's prediction to its truth.
fn fits(batch: &Batch, depth: &[f32]) -> Vec<loss::Fit> {
    let size = batch.maps.views.len() * batch.maps.plane();
    let samples = depth.par_chunks(size).zip(batch.truth.par_chunks(size));
    let fit = |((d, t), worth): ((&[f32], &[f32]), &f32)| loss::Fit {
        affine: loss::affine_fit(d, t),
        trim: MOST_TRIMMED * (1.0 - worth),
    };
    samples.zip(&batch.worth).map(fit).collect()
}

/// Losses by the views and the masks, and regularisers. Of the reference view alone, views tell nothing.
fn of_pictures<'a>(
    (batch, photos): (&'a Batch, &'a [f32]),
    depth: &'a [f32],
    weights: &'a LossWeights,
    small: f32,
    terms: &mut Vec<Term<'a>>,
) {
    let maps = &batch.maps;
    let mut add = |name, weight: f32, by_worth: bool, loss: Loss<'a>| {
        if weight > 0.0 {
            terms.push(Term { name, by_worth, loss });
        }
    };
    let weight = if maps.views.len() > 1 { weights.w_photometric } else { 0.0 };
    add(
        "photometric",
        weight,
        true,
        Box::new(move |g| loss::photometric(maps, photos, &batch.views, depth, weight, g)),
    );
    let weight = weights.w_consistency / small;
    add("consistency", weight, true, Box::new(move |g| loss::consistency(maps, depth, weight, g) / small));
    let weight = weights.w_tv / small;
    add("tv", weight, true, Box::new(move |g| loss::total_variation(maps, depth, weight, g) / small));
    let (margin, weight) = (2.0 * weights.ordinal_apart_px * small, weights.w_subject / small);
    let subjects = &batch.subjects[..];
    add(
        "subject",
        weight,
        false,
        Box::new(move |g| loss::subject_order(maps, depth, subjects, margin, weight, g) / small),
    );
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
