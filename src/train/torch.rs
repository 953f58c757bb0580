//! A training step of a net over pictures on libtorch, by its own operations and its own backward pass: CUDA and cuDNN where
//! they are there, else the processor. Graphs, losses, seeds and the optimiser stay ours; what goes to and fro in a step is what
//! [`device`](crate::device) says, and the weights.

use tch::{Cuda, Device, Kind, TchError, Tensor};

use crate::TrainError;
use crate::nets::{ByArray, Conv, End, Graph, NORM_EPSILON, Node, Statistics, Tensor32, Weights};
use crate::ops::Patch;

/// A forward pass that waits for the gradient of what it said.
pub struct Pass<'a> {
    weights: &'a Weights,
    graph: &'a Graph,
    device: Device,
    keep_norm: bool,
    leaves: Vec<(usize, Tensor)>,
    statistics: Vec<(String, [Tensor; 2], i64)>,
    said: Option<Tensor>,
}

/// What a pass is asked to leave out.
pub struct Asked<'a> {
    /// The views whose maps the last layer computes.
    pub views: &'a [usize],
    /// Normalise by the running statistics, and leave them as they are.
    pub keep_norm: bool,
    /// Factors `[n, channels]` for a layer of so many channels at the two coarsest levels; none where nothing is left out.
    pub thinning: &'a mut dyn FnMut(usize) -> Option<Vec<f32>>,
}

/// Where tensors live: the first device of CUDA, else the processor.
pub fn device() -> Device {
    let device = Device::cuda_if_available();
    if device.is_cuda() {
        // Pictures of a run have few sizes: trying what is fastest for each pays.
        Cuda::cudnn_set_benchmark(true);
        // All that is left to libtorch's own threads is filling buffers; they would spin beside those of the losses.
        tch::set_num_threads(1);
    }
    device
}

fn failed(error: TchError) -> TrainError {
    let why = error.to_string().lines().next().unwrap_or_default().to_owned();
    TrainError::Torch { why }
}

impl<'a> Pass<'a> {
    /// Runs a net of rank 2 on `input` `[n, c, h, w]`; what it says is `[n, views × maps of each, h, w]`.
    ///
    /// # Errors
    /// What libtorch says; an array that the weights lack.
    pub fn new(
        (weights, graph): (&'a Weights, &'a Graph),
        input: &[f32],
        shape: [usize; 4],
        asked: Asked<'_>,
    ) -> Result<(Self, Vec<f32>), TrainError> {
        let (leaves, statistics) = (Vec::new(), Vec::new());
        let (device, keep_norm) = (device(), asked.keep_norm);
        let mut pass = Self { weights, graph, device, keep_norm, leaves, statistics, said: None };
        let x = on_device(input, &shape, device).map_err(failed)?;
        let said = pass.run(x, asked)?;
        let values = values(&said).map_err(failed)?;
        pass.said = Some(said);
        Ok((pass, values))
    }

    fn run(&mut self, x: Tensor, asked: Asked<'_>) -> Result<Tensor, TrainError> {
        let graph = self.graph;
        let areas = graph.areas();
        let coarse = 4.0 * areas.iter().copied().fold(1.0, f64::min);
        let each = graph.arch.rows_per_view();
        let rows: Vec<i64> = asked.views.iter().flat_map(|v| each * v..each * (v + 1)).map(|row| row as i64).collect();
        let mut done: Vec<Tensor> = Vec::with_capacity(graph.nodes.len());
        for (node, area) in graph.nodes.iter().zip(areas) {
            let y = match node {
                Node::Input => x.shallow_clone(),
                Node::Conv(from, conv) => {
                    let mut y = self.conv(conv, &done[*from], &rows)?;
                    let thinned = area <= coarse && conv.end == End::NormElu;
                    if let Some(factors) = thinned.then(|| (asked.thinning)(conv.outputs)).flatten() {
                        let shape = [factors.len() / conv.outputs, conv.outputs, 1, 1];
                        y = on_device(&factors, &shape, self.device).and_then(|f| y.f_mul(&f)).map_err(failed)?;
                    }
                    match conv.added {
                        Some(to) => y.f_add(&done[to]).map_err(failed)?,
                        None => y,
                    }
                }
                Node::Pool(from) => {
                    done[*from].f_avg_pool2d([2, 2], [2, 2], [0, 0], false, true, None::<i64>).map_err(failed)?
                }
                Node::UpConcat(low, skip) => up_concat(&done[*low], &done[*skip]).map_err(failed)?,
            };
            done.push(y);
        }
        Ok(done.pop().unwrap_or(x))
    }

    fn conv(&mut self, conv: &Conv, x: &Tensor, rows: &[i64]) -> Result<Tensor, TrainError> {
        let weight = self.leaf(conv, "weight")?;
        match conv.end {
            End::Tanh { scale } => {
                let bias = self.leaf(conv, "bias")?;
                let rows = Tensor::from_slice(rows).to_device(self.device);
                let said = || {
                    let [weight, bias] = [weight.f_index_select(0, &rows)?, bias.f_index_select(0, &rows)?];
                    let scale = f64::from(scale);
                    padded_conv(x, &weight, Some(&bias), conv.dilation)?
                        .f_div_scalar(scale)?
                        .f_tanh()?
                        .f_mul_scalar(scale)
                };
                said().map_err(failed)
            }
            End::Settled { .. } => {
                let [gamma, beta] = [self.leaf(conv, "gamma")?, self.leaf(conv, "beta")?];
                let [mean, var] = [self.array(conv, "mean")?, self.array(conv, "var")?];
                settled_conv(x, &weight, [gamma, beta, mean, var], conv.patch()).map_err(failed)
            }
            End::NormElu => {
                let [gamma, beta] = [self.leaf(conv, "gamma")?, self.leaf(conv, "beta")?];
                let running = [self.array(conv, "mean")?, self.array(conv, "var")?];
                let z = padded_conv(x, &weight, None, conv.dilation).map_err(failed)?;
                let (per_batch, epsilon) = (!self.keep_norm, f64::from(NORM_EPSILON));
                let [mean, var] = [Some(&running[0]), Some(&running[1])];
                // With a momentum of 1 the running statistics become those of the batch.
                let normed = z.f_batch_norm(Some(&gamma), Some(&beta), mean, var, per_batch, 1.0, epsilon, true);
                let y = normed.and_then(|normed| normed.f_elu()).map_err(failed)?;
                if per_batch {
                    let count = z.numel() as i64 / conv.outputs as i64;
                    self.statistics.push((conv.name.clone(), running, count));
                }
                Ok(y)
            }
        }
    }

    fn find(&self, conv: &Conv, what: &str) -> Result<(usize, &'a Tensor32), TrainError> {
        self.weights.find(&format!("{}.{what}", conv.name))
    }

    fn array(&self, conv: &Conv, what: &str) -> Result<Tensor, TrainError> {
        let (_, array) = self.find(conv, what)?;
        on_device(&array.values, &array.shape, self.device).map_err(failed)
    }

    fn leaf(&mut self, conv: &Conv, what: &str) -> Result<Tensor, TrainError> {
        let (at, array) = self.find(conv, what)?;
        let tensor = on_device(&array.values, &array.shape, self.device).map_err(failed)?;
        if array.trained {
            let leaf = tensor.f_set_requires_grad(true).map_err(failed)?;
            self.leaves.push((at, leaf.shallow_clone()));
            return Ok(leaf);
        }
        Ok(tensor)
    }

    /// Gradients of the trained arrays and the batch's statistics, from the gradient of what the net said.
    ///
    /// # Errors
    /// What libtorch says.
    pub fn finish(self, gradient: &[f32]) -> Result<(ByArray, Statistics), TrainError> {
        let Some(said) = &self.said else { return Ok(Default::default()) };
        self.backward(said, gradient).map_err(failed)
    }

    fn backward(&self, said: &Tensor, gradient: &[f32]) -> Result<(ByArray, Statistics), TchError> {
        let shape: Vec<usize> = said.size().iter().map(|&side| side as usize).collect();
        let gradient = on_device(gradient, &shape, self.device)?;
        said.f_mul(&gradient)?.f_sum(Kind::Float)?.f_backward()?;
        let mut gradients = Vec::with_capacity(self.leaves.len());
        for (at, leaf) in &self.leaves {
            let gradient = leaf.f_grad()?;
            if gradient.defined() {
                gradients.push((*at, values(&gradient)?));
            }
        }
        let mut statistics = Vec::with_capacity(self.statistics.len());
        for (layer, [mean, var], count) in &self.statistics {
            // libtorch's running variance is n/(n−1) times the batch's own.
            let own = (*count - 1) as f32 / *count as f32;
            let mut both = values(mean)?;
            both.extend(values(var)?.iter().map(|v| own * v));
            statistics.push((layer.clone(), both));
        }
        Ok((gradients, statistics))
    }
}

fn on_device(values: &[f32], shape: &[usize], device: Device) -> Result<Tensor, TchError> {
    let shape: Vec<i64> = shape.iter().map(|&side| side as i64).collect();
    Tensor::f_from_slice(values)?.f_reshape(shape)?.f_to_device(device)
}

fn values(tensor: &Tensor) -> Result<Vec<f32>, TchError> {
    let here = tensor.f_detach()?.f_to_device(Device::Cpu)?.f_contiguous()?;
    let mut values = vec![0.0; here.numel()];
    here.f_copy_data(&mut values, here.numel())?;
    Ok(values)
}

/// Edge padding by the dilation, then a valid convolution.
fn padded_conv(x: &Tensor, weight: &Tensor, bias: Option<&Tensor>, dilation: usize) -> Result<Tensor, TchError> {
    let d = dilation as i64;
    x.f_replication_pad2d([d, d, d, d])?.f_conv2d(weight, bias, [1, 1], [0, 0], [d, d], 1)
}

/// A zero-padded convolution of settled normalisation.
fn settled_conv(x: &Tensor, weight: &Tensor, norm: [Tensor; 4], how: Patch) -> Result<Tensor, TchError> {
    let [gamma, beta, mean, var] = norm;
    let (outputs, ..) = weight.size4()?;
    let [before, after] = how.margins().map(|n| n as i64);
    let padded = x.f_constant_pad_nd([before, after, before, after])?;
    let groups = if how.each() { outputs } else { 1 };
    let (stride, dilation) = (how.stride() as i64, how.dilation as i64);
    let z = padded.f_conv2d(weight, None::<&Tensor>, [stride; 2], [0, 0], [dilation; 2], groups)?;
    let (mean, var, epsilon) = (Some(&mean), Some(&var), f64::from(NORM_EPSILON));
    let y = z.f_batch_norm(Some(&gamma), Some(&beta), mean, var, false, 0.0, epsilon, true)?;
    if how.clamped { y.f_clamp(0.0, 6.0) } else { Ok(y) }
}

/// `low` at twice its size (nearest pixel), then `skip`.
fn up_concat(low: &Tensor, skip: &Tensor) -> Result<Tensor, TchError> {
    let (_, _, height, width) = skip.size4()?;
    let large = low.f_upsample_nearest2d([height, width], None::<f64>, None::<f64>)?;
    Tensor::f_cat(&[&large, skip], 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nets::{Arch, Mode, REFERENCE, Tape, values as own_values};
    use crate::ops::Path;

    #[test]
    fn a_step_is_that_of_our_own_operations() {
        let apart = |a: &[f32], b: &[f32]| {
            assert_eq!(a.len(), b.len());
            let of = |values: &mut dyn Iterator<Item = f32>| values.map(|v| f64::from(v).powi(2)).sum::<f64>().sqrt();
            of(&mut a.iter().zip(b).map(|(a, b)| a - b)) / of(&mut a.iter().copied()).max(1e-12)
        };
        let views = [3, REFERENCE];
        for arch in [Arch::Tiny, Arch::TinyDeep, Arch::TinyLite, Arch::AppearanceFlow] {
            let graph = arch.graph();
            let mut weights = Weights::random(&graph, 3);
            for gamma in weights.tensors.iter_mut().filter(|t| t.name.ends_with("gamma")) {
                gamma.values.fill(0.7);
            }
            let shape = [2, graph.input_channels(), 16, 24];
            let wave = |n: usize| (0..n).map(|i| (i as f32 * 0.37).sin()).collect::<Vec<_>>();
            let input = wave(shape.iter().product());
            let mut tape = Tape::new(&weights, Mode::Train, Path::OWN).unwrap();
            let y = tape.run2(&graph, tape.input(input.clone(), shape), Some(&views)).unwrap();
            let ours = own_values(y.clone());
            let weighed = y.clone() * tape.input(wave(ours.len()), y.dims());
            let (gradients, statistics) = tape.finish_step(&weighed.sum().backward());

            let asked = Asked { views: &views, keep_norm: false, thinning: &mut |_| None };
            let (pass, theirs) = Pass::new((&weights, &graph), &input, shape, asked).unwrap();
            assert!(apart(&ours, &theirs) < 1e-3, "{arch:?}: {}", apart(&ours, &theirs));
            let (others, their_statistics) = pass.finish(&wave(theirs.len())).unwrap();
            assert_eq!(gradients.len(), others.len());
            for (at, gradient) in &gradients {
                let other = &others.iter().find(|(other, _)| other == at).unwrap().1;
                let name = &weights.tensors[*at].name;
                assert!(apart(gradient, other) < 1e-3, "{arch:?}, {name}: {}", apart(gradient, other));
            }
            for ((layer, own), (other_layer, other)) in statistics.iter().zip(&their_statistics) {
                assert_eq!(layer, other_layer);
                assert!(apart(own, other) < 1e-3, "{arch:?}, {layer}: {}", apart(own, other));
            }
        }
    }

    #[test]
    fn channels_are_left_out_and_running_statistics_kept_where_it_is_asked() {
        let graph = Arch::Tiny.graph();
        let weights = Weights::random(&graph, 3);
        let shape = [1, graph.input_channels(), 16, 16];
        let input = vec![0.5; shape.iter().product()];
        let run = |keep_norm: bool, factor: f32| {
            let thinning = &mut |channels: usize| (factor != 1.0).then(|| vec![factor; channels]);
            let asked = Asked { views: &[REFERENCE], keep_norm, thinning };
            let (pass, said) = Pass::new((&weights, &graph), &input, shape, asked).unwrap();
            (said.clone(), pass.finish(&vec![1.0; said.len()]).unwrap().1.len())
        };
        let (whole, layers) = run(true, 1.0);
        assert_eq!(layers, 0);
        assert_ne!(whole, run(true, 0.0).0);
        assert!(run(false, 1.0).1 > 0);
    }
}
