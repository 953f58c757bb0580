//! One step of training: forward, losses, backward, optimiser.

use std::collections::BTreeMap;

use burn::tensor::Tensor;
use plenoscope::kernel::Halves;
use rayon::prelude::*;

use crate::TrainError;
use crate::batch::{Batch, blank_patches, drop_coordinates};
use crate::checkpoint::Checkpoint;
use crate::config::{Config, LossWeights};
use crate::depth_losses::depth_losses;
use crate::device::Place;
use crate::loss::{self, Maps};
#[cfg(feature = "torch")]
use crate::nets::thinning;
use crate::nets::{ByArray, Graph, Mode, Statistics, Tape, Weights, values, zeros};
use crate::ops::Path;
use crate::optimizer::Step;
use crate::rng::Rng;
use crate::scenes::steps;
#[cfg(feature = "torch")]
use crate::torch;
use crate::warp::{RayEnd, ray_end};

/// Values of the losses of a step, by name, before they are weighed.
pub type Parts = BTreeMap<&'static str, f32>;

/// What a step reports.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// The losses.
    pub parts: Parts,
    /// Norm of the gradient before clipping.
    pub norm: f32,
}

/// Tell the chance of left-out channels and of blank patches from that of the data.
const DROPPING: u64 = 0x6472_6f70;
const BLANKING: u64 = 0x626c_616e;

/// The scalar whose gradient with respect to `y` is `gradient`: Σ y·gradient. Losses are computed outside the tensor
/// library; this is how their gradient enters its backward pass.
pub(crate) fn with_gradient<const D: usize>(tape: &Tape<'_>, y: Tensor<D>, gradient: Vec<f32>) -> Tensor<1> {
    let shape = y.dims();
    (y * tape.input(gradient, shape)).sum()
}

pub(crate) fn path(config: &Config) -> Path {
    match config.device {
        Place::Gpu => Path::Graphics,
        Place::Cpu if config.stock => Path::Stock,
        // libtorch does steps alone.
        Place::Cpu | Place::Torch => Path::OWN,
    }
}

pub(crate) fn training<'a>(weights: &'a Weights, config: &Config) -> Result<Tape<'a>, TrainError> {
    let path = match path(config) {
        Path::Own(_) if config.halves => Path::Own(Halves::best()),
        path => path,
    };
    Ok(Tape::new(weights, Mode::Train, path)?.keeping_norm(config.keep_norm))
}

pub(crate) fn update(
    net: &mut Checkpoint,
    config: &Config,
    done: f64,
    gradients: &[(usize, Vec<f32>)],
    statistics: &[(String, Vec<f32>)],
) -> f32 {
    let lr = config.learning_rate(net.progress.step, done);
    net.weights.follow(statistics, config.momentum);
    let step = Step { lr, encoder: config.encoder_lr, weight_decay: config.weight_decay, clip: config.clip };
    let norm = net.adam.step(&mut net.weights, gradients, step);
    net.follow(config.average);
    norm
}

/// A step of the depth net alone; `done` = 0 … 1 of the run behind it.
pub fn depth_step(
    net: &mut Checkpoint,
    graph: &Graph,
    batch: &Batch,
    config: &Config,
    done: f64,
) -> Result<Report, TrainError> {
    let (maps, channels) = (&batch.maps, graph.input_channels());
    let mut input = batch.net_input(graph.arch.has_coordinates());
    let mut by_chance = Rng::new(config.seed ^ BLANKING, net.progress.step);
    blank_patches(&mut input, channels, [maps.width, maps.height], config.blank, &mut by_chance);
    drop_coordinates(&mut input, channels, maps.plane(), config.drop_yx, &mut by_chance);
    let losses = |depth: &[f32]| depth_losses(batch, depth, &config.losses);
    let (parts, mut gradients, statistics) = learn((net, graph), batch, input, config, losses)?;
    share_rows(&net.weights, &mut gradients, &batch.maps.views);
    let norm = update(net, config, done, &gradients, &statistics);
    Ok(Report { parts, norm })
}

/// The losses of what a net over pictures says of `input`, the gradients of its weights and the batch's statistics. `losses`
/// gives its parts and the gradient of what was said.
pub(crate) fn learn(
    (net, graph): (&Checkpoint, &Graph),
    batch: &Batch,
    input: Vec<f32>,
    config: &Config,
    losses: impl FnOnce(&[f32]) -> (Parts, Vec<f32>),
) -> Result<(Parts, ByArray, Statistics), TrainError> {
    let by_chance = Rng::new(config.seed ^ DROPPING, net.progress.step);
    #[cfg(feature = "torch")]
    if config.device == Place::Torch {
        let (maps, mut by_chance) = (&batch.maps, by_chance);
        graph.check_size(maps.width, maps.height)?;
        let shape = [maps.samples, graph.input_channels(), maps.height, maps.width];
        let thinning = &mut |channels| thinning(config.drop, maps.samples * channels, &mut by_chance);
        let asked = torch::Asked { views: &maps.views, keep_norm: config.keep_norm, thinning };
        let (pass, said) = torch::Pass::new((&net.weights, graph), &input, shape, asked)?;
        let (parts, gradient) = losses(&said);
        let (gradients, statistics) = pass.finish(&gradient)?;
        return Ok((parts, gradients, statistics));
    }
    let mut tape = training(&net.weights, config)?.dropping(config.drop, by_chance);
    let y = forward(&mut tape, graph, batch, input)?;
    let (parts, gradient) = losses(&values(y.clone()));
    let gradients = with_gradient(&tape, y, gradient).backward();
    let (gradients, statistics) = tape.finish_step(&gradients);
    Ok((parts, gradients, statistics))
}

/// Rows of the last layer whose views a step leaves out get the mean gradient of those it computes: the features
/// change under all of them, and a row that stood still while they do would lag behind.
fn share_rows(weights: &Weights, gradients: &mut [(usize, Vec<f32>)], views: &[usize]) {
    for (at, gradient) in gradients.iter_mut().filter(|(at, _)| weights.tensors[*at].is_of_last_layer()) {
        let row = gradient.len() / weights.tensors[*at].shape[0];
        let mut mean = vec![0.0; row];
        for view in views {
            let own = &gradient[view * row..][..row];
            mean.iter_mut().zip(own).for_each(|(m, g)| *m += g / views.len() as f32);
        }
        for (view, own) in gradient.chunks_mut(row).enumerate().filter(|(view, _)| !views.contains(view)) {
            debug_assert!(own.iter().all(|g| *g == 0.0), "view {view} was left out");
            own.copy_from_slice(&mean);
        }
    }
}

/// The net on a batch's reference views: `[n, views of the batch × maps of each, h, w]`.
pub(crate) fn predict(tape: &mut Tape<'_>, graph: &Graph, batch: &Batch) -> Result<Tensor<4>, TrainError> {
    forward(tape, graph, batch, batch.net_input(graph.arch.has_coordinates()))
}

fn forward(tape: &mut Tape<'_>, graph: &Graph, batch: &Batch, input: Vec<f32>) -> Result<Tensor<4>, TrainError> {
    let maps = &batch.maps;
    graph.check_size(maps.width, maps.height)?;
    let x = tape.input(input, [maps.samples, graph.input_channels(), maps.height, maps.width]);
    tape.run2(graph, x, Some(&maps.views))
}

/// Ray depths that a depth net gives for a batch, from its running statistics.
pub fn infer_depths(weights: &Weights, graph: &Graph, batch: &Batch, config: &Config) -> Result<Vec<f32>, TrainError> {
    let mut tape = Tape::new(weights, Mode::Infer, path(config))?;
    predict(&mut tape, graph, batch).map(values)
}

/// Ray depths `[n, 64, h, w]` of all views, whichever the batch holds.
pub fn infer_all_depths(
    weights: &Weights,
    graph: &Graph,
    batch: &Batch,
    config: &Config,
) -> Result<Vec<f32>, TrainError> {
    let maps = &batch.maps;
    let mut tape = Tape::new(weights, Mode::Infer, path(config))?;
    let shape = [maps.samples, graph.input_channels(), maps.height, maps.width];
    let x = tape.input(batch.net_input(graph.arch.has_coordinates()), shape);
    tape.run2(graph, x, None).map(values)
}

/// The Lambertian views of these ray depths, and the same after the occlusion net, `[n, v, 3, h, w]` in 0 … 1.
pub fn infer_views(
    weights: &Weights,
    graph: &Graph,
    batch: &Batch,
    depth: &[f32],
    config: &Config,
) -> Result<(Vec<f32>, Vec<f32>), TrainError> {
    let maps = &batch.maps;
    let rendered = loss::rendered_views(maps, &batch.photos(), depth);
    let mut tape = Tape::new(weights, Mode::Infer, path(config))?;
    let x = occlusion_input(&tape, maps, &rendered, depth);
    let residual = values(tape.run3(graph, x)?);
    let (p, nv) = (maps.plane(), maps.views.len());
    let mut full = rendered.clone();
    for (i, r) in residual.iter().enumerate() {
        let (n, c, v) = (i / (3 * nv * p), i / (nv * p) % 3, i / p % nv);
        full[((n * nv + v) * 3 + c) * p + i % p] += 0.5 * r;
    }
    Ok((rendered, full))
}

/// A step of the occlusion net: ‖L̂ − L‖₁ with L̂ = õ(L_r, D) + L_r (paper, §4.3), views rendered with `depth`.
pub fn occlusion_step(
    net: &mut Checkpoint,
    graph: &Graph,
    batch: &Batch,
    depth: &[f32],
    config: &Config,
    done: f64,
) -> Result<Report, TrainError> {
    let mut tape = training(&net.weights, config)?;
    let rendered = loss::rendered_views(&batch.maps, &batch.photos(), depth);
    let x = occlusion_input(&tape, &batch.maps, &rendered, depth);
    let residual = tape.run3(graph, x)?;
    let (parts, gradient) = occlusion_loss(batch, &rendered, &values(residual.clone()), &config.losses);
    let gradients = with_gradient(&tape, residual, gradient).backward();
    let (gradients, statistics) = tape.finish_step(&gradients);
    let norm = update(net, config, done, &gradients, &statistics);
    Ok(Report { parts, norm })
}

/// `[n, 4, v, h, w]`: the rendered views in −1 … 1, then their ray depths.
fn occlusion_input(tape: &Tape<'_>, maps: &Maps, rendered: &[f32], depth: &[f32]) -> Tensor<5> {
    let (p, nv) = (maps.plane(), maps.views.len());
    let mut input = zeros(4 * maps.len());
    input.par_chunks_mut(p).enumerate().for_each(|(plane, input)| {
        let (n, c, v) = (plane / (4 * nv), plane / nv % 4, plane % nv);
        if c == 3 {
            return input.copy_from_slice(&depth[(n * nv + v) * p..][..p]);
        }
        let view = &rendered[((n * nv + v) * 3 + c) * p..][..p];
        input.iter_mut().zip(view).for_each(|(input, value)| *input = 2.0 * value - 1.0);
    });
    tape.input(input, [maps.samples, 4, nv, maps.height, maps.width])
}

/// Mean |L_r + õ − L| over views, colours and pixels in 0 … 1, and beside it the same without the residual; for all
/// rays, then for hidden ones. The gradient with respect to the residual `[n, 3, v, h, w]` (in −1 … 1) is that of the
/// mean in which hidden rays weigh `w_hidden` and those that leave the crop `w_outside`.
fn occlusion_loss(batch: &Batch, rendered: &[f32], residual: &[f32], weights: &LossWeights) -> (Parts, Vec<f32>) {
    let (p, nv) = (batch.maps.plane(), batch.maps.views.len());
    let ends = ends_of_rays(batch);
    let mut gradient = zeros(residual.len());
    let of_plane = |(plane, (gradient, residuals)): (usize, (&mut [f32], &[f32]))| {
        let (n, c, v) = (plane / (3 * nv), plane / nv % 3, plane % nv);
        let at = ((n * nv + v) * 3 + c) * p;
        let (rendered, view, ends) = (&rendered[at..][..p], &batch.views[at..][..p], &ends[(n * nv + v) * p..][..p]);
        let mut sums = [[0.0f64; 2]; 2];
        for (i, g) in gradient.iter_mut().enumerate() {
            let without = rendered[i] - view[i];
            let with = without + 0.5 * residuals[i];
            let of = &mut sums[usize::from(ends[i] == RayEnd::Hidden)];
            *of = [of[0] + f64::from(with.abs()), of[1] + f64::from(without.abs())];
            let weight = match ends[i] {
                RayEnd::Seen => 1.0,
                RayEnd::Hidden => weights.w_hidden,
                RayEnd::Outside => weights.w_outside,
            };
            *g = if with == 0.0 { 0.0 } else { weight * with.signum() / residual.len() as f32 };
        }
        sums
    };
    let planes = gradient.par_chunks_mut(p).zip(residual.par_chunks(p)).enumerate().map(of_plane);
    let sums = planes
        .collect::<Vec<_>>()
        .into_iter()
        .fold([[0.0f64; 2]; 2], |a, b| [0, 1].map(|end| [0, 1].map(|which| a[end][which] + b[end][which])));
    let [rest, hidden] = sums;
    let hidden_count = 3 * ends.iter().filter(|&&end| end == RayEnd::Hidden).count();
    let mean = |sum: f64, count: usize| (sum / count.max(1) as f64) as f32;
    let parts = [
        ("full", mean(rest[0] + hidden[0], residual.len())),
        ("lambertian", mean(rest[1] + hidden[1], residual.len())),
        ("hidden_full", mean(hidden[0], hidden_count)),
        ("hidden_lambertian", mean(hidden[1], hidden_count)),
    ];
    (Parts::from(parts), gradient)
}

/// Where the rays `[n, v, h, w]` end. Those without a true ray depth count as seen.
fn ends_of_rays(batch: &Batch) -> Vec<RayEnd> {
    let (p, nv) = (batch.maps.plane(), batch.maps.views.len());
    let end = |map: usize, i: usize| {
        let photo = &batch.truth[(map / nv * nv + batch.maps.reference()) * p..][..p];
        ray_end(photo, batch.maps.width, i, steps(batch.maps.views[map % nv]), batch.truth[map * p + i])
    };
    let rays = batch.maps.samples * nv * p;
    (0..rays).into_par_iter().with_min_len(p).map(|ray| end(ray / p, ray % p)).collect()
}

/// A step of both nets as the paper does: ‖L_r − L‖₁ + ‖L̂ − L‖₁ + λ_c ψ_c + λ_tv ψ_tv. The ray depths enter the
/// occlusion net with their gradient stopped; the rendered views do not.
pub fn joint_step(
    [depth_net, occlusion_net]: [&mut Checkpoint; 2],
    graphs: &[Graph; 2],
    batch: &Batch,
    config: &Config,
    done: f64,
) -> Result<Report, TrainError> {
    let mut depth_tape = training(&depth_net.weights, config)?;
    let y = predict(&mut depth_tape, &graphs[0], batch)?;
    let depth = values(y.clone());
    let (mut parts, mut gradient) = depth_losses(batch, &depth, &config.losses);

    let mut tape = training(&occlusion_net.weights, config)?;
    let rendered = loss::rendered_views(&batch.maps, &batch.photos(), &depth);
    let x = occlusion_input(&tape, &batch.maps, &rendered, &depth).require_grad();
    let residual = tape.run3(&graphs[1], x.clone())?;
    let (more, to_residual) = occlusion_loss(batch, &rendered, &values(residual.clone()), &config.losses);
    let gradients = with_gradient(&tape, residual, to_residual.clone()).backward();
    let through_net = x.grad(&gradients).map(values).unwrap_or_default();
    let to_views = gradient_of_views(&batch.maps, &to_residual, &through_net);
    loss::rendered_gradient(&batch.maps, &batch.photos(), &depth, &to_views, &mut gradient);
    parts.extend(more);

    let (gradients, statistics) = tape.finish_step(&gradients);
    update(occlusion_net, config, done, &gradients, &statistics);
    let gradients = with_gradient(&depth_tape, y, gradient).backward();
    let (gradients, statistics) = depth_tape.finish_step(&gradients);
    let norm = update(depth_net, config, done, &gradients, &statistics);
    Ok(Report { parts, norm })
}

/// Gradient with respect to the rendered views `[n, v, 3, h, w]` in 0 … 1: directly (L̂ contains L_r; twice that of the
/// residual, which is in −1 … 1) and through the net's input, whose depth channel is left out.
fn gradient_of_views(maps: &Maps, to_residual: &[f32], through_net: &[f32]) -> Vec<f32> {
    let (p, nv) = (maps.plane(), maps.views.len());
    let mut to_views = zeros(to_residual.len());
    to_views.par_chunks_mut(p).enumerate().for_each(|(plane, to_view)| {
        let (n, v, c) = (plane / (3 * nv), plane / 3 % nv, plane % 3);
        let direct = &to_residual[((n * 3 + c) * nv + v) * p..][..p];
        let through = &through_net[((n * 4 + c) * nv + v) * p..][..p];
        for (to, (direct, through)) in to_view.iter_mut().zip(direct.iter().zip(through)) {
            *to = 2.0 * (direct + through);
        }
    });
    to_views
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nets::REFERENCE;

    #[test]
    fn rays_end_in_sight_behind_something_or_beside_the_crop() {
        // The leftmost view of the reference's row, then the reference: its left half is near.
        let maps = Maps { samples: 1, views: vec![REFERENCE - 4, REFERENCE], height: 2, width: 8 };
        let left_view = [0.0, 0.0, 0.0, 0.0, 0.0, f32::NAN, 1.0, 0.0];
        let next_row = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0];
        let reference = [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0];
        let truth = [left_view, next_row, reference, reference].concat();
        let batch = Batch {
            views: vec![0.0; 3 * maps.len()],
            truth,
            first_sample: 0,
            yx: vec![[0.0; 4]],
            worth: vec![1.0],
            subjects: vec![Vec::new()],
            maps,
        };
        let ends = ends_of_rays(&batch);
        let (h, s, o) = (RayEnd::Hidden, RayEnd::Seen, RayEnd::Outside);
        assert_eq!(ends[..8], [h, h, h, h, s, s, s, s]);
        assert_eq!(ends[8..16], [o, o, o, o, s, s, s, s]);
        assert!(ends[16..].iter().all(|end| *end == s));
    }
}
