//! Views from the four corners of a light field (class of Kalantari et al. 2016).
//!
//! A *disparity net* looks at how far the corners agree at each ray depth, as the view that is looked for would see them; the
//! corners are warped by what it says. A *colour net* corrects their blend. Both learn from ‖L̂ − L‖₁ and ‖blend − L‖₁ at
//! views of the light field that neither is given.

mod view;

use std::collections::BTreeMap;

use burn::tensor::Tensor;
use plenoscope::synth::corners::{Between, CORNERS, RANGE_PX, RESIDUAL_GAIN};
use rayon::prelude::*;

use crate::TrainError;
use crate::batch::Batch;
use crate::checkpoint::Checkpoint;
use crate::config::Config;
use crate::nets::{Mode, Tape, VIEWS, values};
use crate::rng::Rng;
use crate::step::{Report, path, training, update, with_gradient};
use view::warped_gradient;

/// Views of each sample that a step learns from.
const VIEWS_A_STEP: usize = 2;
/// Views that are made at once.
const AT_ONCE: usize = 4;
/// Tells the choice of views from that of the data.
const CHOOSING: u64 = 0x636f_726e;

/// The view of a sample, the corners around it, and its true colours `[3, h, w]`.
struct Looked<'a> {
    between: Between<'a>,
    truth: &'a [f32],
}

/// A view of a batch; `None` where the batch lacks a corner or the view.
fn looked(batch: &Batch, sample: usize, layer: usize) -> Option<Looked<'_>> {
    let (maps, n) = (&batch.maps, 3 * batch.maps.plane());
    let of = |layer: usize| {
        let place = maps.views.iter().position(|view| *view == layer)?;
        Some(&batch.views[(sample * maps.views.len() + place) * n..][..n])
    };
    let [a, b, c, d] = CORNERS.map(of);
    let between = Between { corners: [a?, b?, c?, d?], layer, size: [maps.width, maps.height] };
    Some(Looked { between, truth: of(layer)? })
}

fn incomplete() -> TrainError {
    TrainError::Data {
        why: "its batches lack the corner views: this stage needs whole light fields (--preset paper)".into(),
    }
}

/// The views that a step learns from, drawn anew for each sample.
fn chosen<'a>(batch: &'a Batch, config: &Config, step: u64) -> Result<Vec<Looked<'a>>, TrainError> {
    let mut rng = Rng::new(config.seed ^ CHOOSING, step);
    let inner: Vec<usize> = (0..VIEWS).filter(|layer| !CORNERS.contains(layer)).collect();
    let slots = (0..batch.maps.samples).flat_map(|sample| [sample; VIEWS_A_STEP]);
    slots.map(|sample| looked(batch, sample, inner[rng.below(inner.len())]).ok_or_else(incomplete)).collect()
}

/// What both nets make of some views.
struct Made {
    depth: Tensor<4>,
    colour_input: Tensor<4>,
    residual: Tensor<4>,
    /// Ray depths `[h, w]` of each view.
    depths: Vec<Vec<f32>>,
    /// Warped corners of each view.
    warped: Vec<Vec<f32>>,
}

/// `heard` makes the colour net's input a leaf whose gradient is kept, where that is wanted.
fn forward(
    [disparity, colour]: [&mut Tape<'_>; 2],
    nets: [&Checkpoint; 2],
    views: &[&Between<'_>],
    heard: impl FnOnce(Tensor<4>) -> Tensor<4>,
) -> Result<Made, TrainError> {
    let graphs = nets.map(|net| net.arch.graph());
    let [w, h] = views.first().map_or([0, 0], |view| view.size);
    let features: Vec<Vec<f32>> = views.par_iter().map(|view| view.features()).collect();
    let x = disparity.input(features.concat(), [views.len(), graphs[0].input_channels(), h, w]);
    let depth = disparity.run2(&graphs[0], x, None)?;
    let depths: Vec<Vec<f32>> = values(depth.clone()).chunks(w * h).map(<[f32]>::to_vec).collect();
    let warped: Vec<Vec<f32>> = views.par_iter().zip(&depths).map(|(view, depth)| view.warped(depth)).collect();
    let input = views.iter().zip(&depths).zip(&warped);
    let input: Vec<Vec<f32>> = input.map(|((view, depth), warped)| view.colour_input(warped, depth)).collect();
    let colour_input = heard(colour.input(input.concat(), [views.len(), graphs[1].input_channels(), h, w]));
    let residual = colour.run2(&graphs[1], colour_input.clone(), None)?;
    Ok(Made { depth, colour_input, residual, depths, warped })
}

/// Sign with 0 for 0.
fn sign(x: f32) -> f32 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// Losses of the views, and gradients with respect to the residuals in −1 … 1 and, of the blends alone, to the warped corners.
struct Losses {
    full: f32,
    blended: f32,
    of_residual: Vec<f32>,
    of_warped: Vec<Vec<f32>>,
}

fn losses(views: &[Looked<'_>], warped: &[Vec<f32>], residual: &[f32]) -> Losses {
    let n = views.first().map_or(0, |view| view.truth.len());
    let k = 1.0 / (n * views.len()).max(1) as f32;
    let each = views.par_iter().zip(warped).zip(residual.par_chunks(n.max(1)));
    let found: Vec<_> = each
        .map(|((view, warped), residual)| {
            let (blend, shares) = (view.between.blended(warped), view.between.shares());
            let (mut sums, mut of_residual, mut of_warped) = ([0.0f64; 2], vec![0.0; n], vec![0.0; 4 * n]);
            for i in 0..n {
                let without = blend[i] - view.truth[i];
                let with = without + RESIDUAL_GAIN * residual[i];
                sums = [sums[0] + f64::from(with.abs()), sums[1] + f64::from(without.abs())];
                of_residual[i] = RESIDUAL_GAIN * k * sign(with);
                (0..4).for_each(|c| of_warped[c * n + i] = k * shares[c] * (sign(with) + sign(without)));
            }
            (sums, of_residual, of_warped)
        })
        .collect();
    let [full, blended] = [0, 1].map(|which| found.iter().map(|(sums, ..)| sums[which]).sum::<f64>() as f32 * k);
    let (mut of_residual, mut of_warped) = (Vec::new(), Vec::new());
    for (_, residual, warped) in found {
        of_residual.extend(residual);
        of_warped.push(warped);
    }
    Losses { full, blended, of_residual, of_warped }
}

/// A step of both nets; `done` = 0 … 1 of the run behind it.
pub fn step(
    [disparity_net, colour_net]: [&mut Checkpoint; 2],
    batch: &Batch,
    config: &Config,
    done: f64,
) -> Result<Report, TrainError> {
    let views = chosen(batch, config, disparity_net.progress.step)?;
    let between: Vec<&Between<'_>> = views.iter().map(|view| &view.between).collect();
    let (mut disparity, mut colour) =
        (training(&disparity_net.weights, config)?, training(&colour_net.weights, config)?);
    let made = forward([&mut disparity, &mut colour], [disparity_net, colour_net], &between, Tensor::require_grad)?;
    let Losses { full, blended, of_residual, mut of_warped } =
        losses(&views, &made.warped, &values(made.residual.clone()));

    let gradients = with_gradient(&colour, made.residual, of_residual).backward();
    let through_net = made.colour_input.grad(&gradients).map(values).unwrap_or_default();
    let p = batch.maps.plane();
    let each = views.par_iter().zip(&mut of_warped).zip(&made.depths).zip(through_net.par_chunks(15 * p));
    let of_depth: Vec<Vec<f32>> = each
        .map(|(((view, of_warped), depth), through)| {
            of_warped.iter_mut().zip(through).for_each(|(g, through)| *g += 2.0 * through);
            let mut gradient: Vec<f32> = through[12 * p..13 * p].iter().map(|g| g / RANGE_PX).collect();
            warped_gradient(&view.between, depth, of_warped, &mut gradient);
            gradient
        })
        .collect();
    let (gradients, statistics) = colour.finish_step(&gradients);
    let of_disparity = with_gradient(&disparity, made.depth, of_depth.concat()).backward();
    let (of_disparity, means) = disparity.finish_step(&of_disparity);
    update(colour_net, config, done, &gradients, &statistics);
    let norm = update(disparity_net, config, done, &of_disparity, &means);
    Ok(Report { parts: BTreeMap::from([("views", full), ("blended", blended)]), norm })
}

/// All 64 views `[n, 64, 3, h, w]` in 0 … 1 from the corners of a batch, and their ray depths `[n, 64, h, w]`.
pub fn infer(nets: [&Checkpoint; 2], batch: &Batch, config: &Config) -> Result<(Vec<f32>, Vec<f32>), TrainError> {
    let all = (0..batch.maps.samples).flat_map(|sample| (0..VIEWS).map(move |layer| (sample, layer)));
    let all: Vec<Looked<'_>> =
        all.map(|(sample, layer)| looked(batch, sample, layer).ok_or_else(incomplete)).collect::<Result<_, _>>()?;
    let (mut views, mut depths) = (Vec::new(), Vec::new());
    for some in all.chunks(AT_ONCE) {
        let between: Vec<&Between<'_>> = some.iter().map(|view| &view.between).collect();
        let [disparity, colour] = nets.map(|net| Tape::new(net.best(), Mode::Infer, path(config)));
        let made = forward([&mut disparity?, &mut colour?], nets, &between, |input| input)?;
        let residual = values(made.residual);
        for (k, view) in some.iter().enumerate() {
            let n = view.truth.len();
            let blend = view.between.blended(&made.warped[k]);
            let given = CORNERS.iter().position(|corner| *corner == view.between.layer);
            match given {
                Some(corner) => views.extend_from_slice(view.between.corners[corner]),
                None => {
                    let both = blend.iter().zip(&residual[k * n..]);
                    views.extend(both.map(|(blend, r)| (blend + RESIDUAL_GAIN * r).clamp(0.0, 1.0)));
                }
            }
            depths.extend_from_slice(&made.depths[k]);
        }
    }
    Ok((views, depths))
}

/// All 64 views `[n, 64, 3, h, w]` in 0 … 1 as the corners alone give them, blended where they are: what a method that is given
/// them must beat.
pub fn blended(batch: &Batch) -> Result<Vec<f32>, TrainError> {
    let all = (0..batch.maps.samples).flat_map(|sample| (0..VIEWS).map(move |layer| (sample, layer)));
    let blend = |(sample, layer)| {
        let between = looked(batch, sample, layer).ok_or_else(incomplete)?.between;
        Ok(between.blended(&between.corners.concat()))
    };
    Ok(all.map(blend).collect::<Result<Vec<_>, TrainError>>()?.concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loss::Maps;
    use crate::nets::Arch;
    use crate::scenes::steps;

    const SIZE: [usize; 2] = [20, 16];

    /// All views of a textured plane at 0.4 px per view step.
    fn plane() -> Batch {
        let maps = Maps { samples: 1, views: (0..VIEWS).collect(), height: SIZE[1], width: SIZE[0] };
        let value = |x: f32, y: f32| 0.5 + 0.25 * (0.9 * x).sin() + 0.2 * (1.1 * y + 0.5 * x).cos();
        let of = |layer: usize| {
            let (u, v) = steps(layer);
            (0..3 * maps.plane()).map(move |i| {
                let i = i % (SIZE[0] * SIZE[1]);
                value((i % SIZE[0]) as f32 + 0.4 * u, (i / SIZE[0]) as f32 + 0.4 * v)
            })
        };
        Batch {
            first_sample: 0,
            views: (0..VIEWS).flat_map(of).collect(),
            truth: vec![f32::NAN; maps.len()],
            yx: vec![[-1.0, 1.0, -1.0, 1.0]],
            worth: vec![1.0],
            subjects: vec![Vec::new()],
            maps,
        }
    }

    #[test]
    fn both_nets_learn_a_light_field_by_heart() {
        let (batch, config) = (plane(), Config { lr: 4e-3, warm_up: 1, lr_end: 1.0, clip: 0.0, ..Config::default() });
        let mut disparity = Checkpoint::new(Arch::CornerDisparity, 1);
        let mut colour = Checkpoint::new(Arch::CornerColour, 1);
        let mut told = Vec::new();
        for _ in 0..40 {
            told.push(step([&mut disparity, &mut colour], &batch, &config, 0.0).unwrap().parts["views"]);
            disparity.progress.step += 1;
            colour.progress.step += 1;
        }
        let mean = |part: &[f32]| part.iter().sum::<f32>() / part.len() as f32;
        assert!(mean(&told[32..]) < 0.6 * mean(&told[..8]), "{told:?}");
        let (views, depths) = infer([&disparity, &colour], &batch, &config).unwrap();
        assert_eq!((views.len(), depths.len()), (batch.views.len(), batch.maps.len()));
        let n = 3 * batch.maps.plane();
        assert_eq!(views[63 * n..], batch.views[63 * n..], "what was given stays");
        let plain = blended(&batch).unwrap();
        assert_eq!(plain[7 * n..8 * n], batch.views[7 * n..8 * n], "at a corner the blend is the corner");
        for i in 0..n {
            let four = CORNERS.map(|layer| batch.views[layer * n + i]);
            let [least, most] =
                [four.into_iter().reduce(f32::min).unwrap(), four.into_iter().reduce(f32::max).unwrap()];
            assert!((least - 1e-6..=most + 1e-6).contains(&plain[27 * n + i]), "elsewhere it lies between them");
        }
    }

    #[test]
    fn a_batch_without_its_corners_is_named() {
        let batch = crate::batch::tests::toy(1, (16, 12))(0).unwrap();
        let nets = [Checkpoint::new(Arch::CornerDisparity, 1), Checkpoint::new(Arch::CornerColour, 1)];
        let found = infer(nets.each_ref(), &batch, &Config::default());
        assert!(found.unwrap_err().to_string().contains("corner views"));
    }
}
