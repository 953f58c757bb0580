//! Runs a graph on burn's tensors.

use burn::tensor::{Device, Gradients, Tensor, TensorData};
use rayon::prelude::*;

use super::{Conv, End, Graph, Node, Weights};
use crate::TrainError;
use crate::device;
use crate::ops::{self, Path};
use crate::rng::Rng;

/// Added to variances before the root, as in the paper's framework.
pub const NORM_EPSILON: f32 = 1e-5;

/// How batch normalisation takes its statistics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// From the batch; the running statistics follow by a tenth (the variance as it is, not times n/(n−1)).
    Train,
    /// From the running statistics.
    Infer,
}

/// Gradients, each with the index of its array in the weights.
pub type ByArray = Vec<(usize, Vec<f32>)>;
/// Batch statistics `[mean | variance]`, each with the name of its layer.
pub type Statistics = Vec<(String, Vec<f32>)>;

/// The weights of one forward pass as burn tensors, and what the pass leaves behind.
pub struct Tape<'a> {
    weights: &'a Weights,
    device: Device,
    mode: Mode,
    path: Path,
    drop: Option<(f32, Rng)>,
    keep_norm: bool,
    leaves: Vec<Leaf>,
    statistics: Vec<(String, Tensor<2>)>,
}

/// A trained array on the tape; its rank is 1, 4 or 5.
enum Leaf {
    Rank1(usize, Tensor<1>),
    Rank4(usize, Tensor<4>),
    Rank5(usize, Tensor<5>),
}

impl<'a> Tape<'a> {
    /// A tape on the device of a path; gradients are kept in `Mode::Train` only.
    ///
    /// # Errors
    /// A graphics device that is not to be had.
    pub fn new(weights: &'a Weights, mode: Mode, path: Path) -> Result<Self, TrainError> {
        let device = device::of(path)?;
        let device = if mode == Mode::Train { device.autodiff() } else { device };
        let (leaves, statistics) = (Vec::new(), Vec::new());
        Ok(Self { weights, device, mode, path, drop: None, keep_norm: false, leaves, statistics })
    }

    /// Leaves out `part` of the channels, drawn anew for every sample, at a net's two coarsest levels: it is
    /// there that it learns photos by heart.
    pub fn dropping(self, part: f32, rng: Rng) -> Self {
        Self { drop: (part > 0.0).then_some((part, rng)), ..self }
    }

    /// Normalises by the running statistics, as inference does, and leaves them as they are.
    pub fn keeping_norm(self, keep_norm: bool) -> Self {
        Self { keep_norm, ..self }
    }

    /// The device that inputs must be on.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// `[n, c, h, w]` from values.
    pub fn input<const D: usize>(&self, values: Vec<f32>, shape: [usize; D]) -> Tensor<D> {
        Tensor::from_data(TensorData::new(values, shape), &self.device)
    }

    /// Runs a net of rank 2. With `views`, the last layer computes the maps of these alone.
    ///
    /// # Shapes
    /// - `x`: `[n, c, h, w]`
    /// - result: `[n, views × maps of each, h, w]`
    pub fn run2(&mut self, graph: &Graph, x: Tensor<4>, views: Option<&[usize]>) -> Result<Tensor<4>, TrainError> {
        let mut done: Vec<Tensor<4>> = Vec::with_capacity(graph.nodes.len());
        let areas = graph.areas();
        let coarse = 4.0 * areas.iter().copied().fold(1.0, f64::min);
        let each = graph.arch.rows_per_view();
        let rows: Option<Vec<usize>> = views.map(|views| views.iter().flat_map(|v| each * v..each * (v + 1)).collect());
        for (node, area) in graph.nodes.iter().zip(areas) {
            let y = match node {
                Node::Input => x.clone(),
                Node::Conv(from, conv) => {
                    let y = self.conv2(conv, done[*from].clone(), rows.as_deref())?;
                    let y = if area <= coarse && conv.end == End::NormElu { self.thinned(y) } else { y };
                    if let Some(to) = conv.added { y + done[to].clone() } else { y }
                }
                Node::Pool(from) => ops::pool(done[*from].clone(), self.path),
                Node::UpConcat(low, skip) => ops::up_concat(done[*low].clone(), done[*skip].clone(), self.path),
            };
            done.push(y);
        }
        Ok(done.pop().unwrap_or(x))
    }

    /// Runs a net of rank 3, `[n, c, v, h, w]` in and out.
    pub fn run3(&mut self, graph: &Graph, mut x: Tensor<5>) -> Result<Tensor<5>, TrainError> {
        for conv in graph.convs() {
            let weight = self.leaf5(&format!("{}.weight", conv.name))?;
            x = self.finish(conv, x, weight)?;
        }
        Ok(x)
    }

    /// The map with some of its channels 0, the others larger by as much.
    fn thinned(&mut self, y: Tensor<4>) -> Tensor<4> {
        let [samples, channels, ..] = y.dims();
        let mask = self.drop.as_mut().and_then(|(part, rng)| thinning(*part, samples * channels, rng));
        let Some(mask) = mask else { return y };
        y * self.input(mask, [samples, channels, 1, 1])
    }

    fn conv2(&mut self, conv: &Conv, x: Tensor<4>, rows: Option<&[usize]>) -> Result<Tensor<4>, TrainError> {
        let weight = self.leaf4(&format!("{}.weight", conv.name))?;
        match (conv.end, rows) {
            (End::Tanh { scale }, Some(rows)) => {
                let rows = TensorData::new(rows.iter().map(|&row| row as i64).collect(), [rows.len()]);
                let rows = Tensor::from_data(rows, &self.device);
                let bias = self.leaf1(&format!("{}.bias", conv.name))?.select(0, rows.clone());
                Ok(ops::conv_tanh(x, weight.select(0, rows), bias, (conv.dilation, scale), self.path))
            }
            (End::Settled { .. }, _) => {
                let norm = self.vectors(conv, ["gamma", "beta", "mean", "var"])?;
                Ok(ops::conv_settled(x, weight, norm, conv.patch(), self.path))
            }
            _ => self.finish(conv, x, weight),
        }
    }

    fn vectors<const N: usize>(&mut self, conv: &Conv, what: [&str; N]) -> Result<[Tensor<1>; N], TrainError> {
        let found: Result<Vec<_>, _> =
            what.into_iter().map(|what| self.leaf1(&format!("{}.{what}", conv.name))).collect();
        Ok(found?.try_into().expect("as many as were asked for"))
    }

    fn finish<const D: usize>(
        &mut self,
        conv: &Conv,
        x: Tensor<D>,
        weight: Tensor<D>,
    ) -> Result<Tensor<D>, TrainError> {
        if let End::Tanh { scale } = conv.end {
            let [bias] = self.vectors(conv, ["bias"])?;
            return Ok(ops::conv_tanh(x, weight, bias, (conv.dilation, scale), self.path));
        }
        if self.mode == Mode::Infer || self.keep_norm {
            let norm = self.vectors(conv, ["gamma", "beta", "mean", "var"])?;
            return Ok(ops::conv_folded_elu(x, weight, norm, conv.dilation, self.path));
        }
        let norm = self.vectors(conv, ["gamma", "beta"])?;
        let (y, statistics) = ops::conv_norm_elu(x, weight, norm, conv.dilation, self.path);
        self.statistics.push((conv.name.clone(), statistics));
        Ok(y)
    }

    fn load<const D: usize>(&self, name: &str) -> Result<(usize, Tensor<D>, bool), TrainError> {
        let (at, array) = self.weights.find(name)?;
        let tensor = Tensor::from_data(TensorData::new(array.values.clone(), array.shape.clone()), &self.device);
        let trained = array.trained && self.mode == Mode::Train;
        Ok((at, if trained { tensor.require_grad() } else { tensor }, trained))
    }

    fn leaf1(&mut self, name: &str) -> Result<Tensor<1>, TrainError> {
        let (at, tensor, trained) = self.load(name)?;
        if trained {
            self.leaves.push(Leaf::Rank1(at, tensor.clone()));
        }
        Ok(tensor)
    }

    fn leaf4(&mut self, name: &str) -> Result<Tensor<4>, TrainError> {
        let (at, tensor, trained) = self.load(name)?;
        if trained {
            self.leaves.push(Leaf::Rank4(at, tensor.clone()));
        }
        Ok(tensor)
    }

    fn leaf5(&mut self, name: &str) -> Result<Tensor<5>, TrainError> {
        let (at, tensor, trained) = self.load(name)?;
        if trained {
            self.leaves.push(Leaf::Rank5(at, tensor.clone()));
        }
        Ok(tensor)
    }

    /// Gradients of the trained arrays after `backward`, each with its index in the weights; and the batch
    /// statistics `[mean | variance]` of each normalised layer.
    pub fn finish_step(self, gradients: &Gradients) -> (ByArray, Statistics) {
        let taken = self.leaves.iter().filter_map(|leaf| match leaf {
            Leaf::Rank1(at, t) => t.grad(gradients).map(|g| (*at, values(g))),
            Leaf::Rank4(at, t) => t.grad(gradients).map(|g| (*at, values(g))),
            Leaf::Rank5(at, t) => t.grad(gradients).map(|g| (*at, values(g))),
        });
        (taken.collect(), self.statistics.into_iter().map(|(name, t)| (name, values(t))).collect())
    }
}

/// Factors of so many channels of samples, `part` of them 0 and the others larger by as much; none where none is left out.
pub fn thinning(part: f32, channels: usize, rng: &mut Rng) -> Option<Vec<f32>> {
    let kept = 1.0 / (1.0 - part);
    (part > 0.0).then(|| (0..channels).map(|_| if rng.chance(part) { 0.0 } else { kept }).collect())
}

/// A tensor's values, the last axis fastest.
pub fn values<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    let data = tensor.into_data();
    data.try_into_vec().expect("all our tensors are f32")
}

/// So many zeros, set by all threads.
pub fn zeros(n: usize) -> Vec<f32> {
    (0..n).into_par_iter().with_min_len(1 << 16).map(|_| 0.0).collect()
}

impl Weights {
    /// Moves the running statistics by `momentum` towards those of a batch.
    pub fn follow(&mut self, statistics: &[(String, Vec<f32>)], momentum: f32) {
        for (layer, values) in statistics {
            let (mean, var) = values.split_at(values.len() / 2);
            for (what, batch) in [("mean", mean), ("var", var)] {
                let name = format!("{layer}.{what}");
                if let Some(running) = self.tensors.iter_mut().find(|t| t.name == name) {
                    for (r, b) in running.values.iter_mut().zip(batch) {
                        *r += momentum * (b - *r);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nets::Arch;

    #[test]
    fn a_larger_net_begins_as_the_one_it_holds_and_learns_more() {
        for ([small, large], new) in
            [([Arch::Tiny, Arch::TinyDeep], "_more"), ([Arch::TinyDeep, Arch::TinyLite], "seen")]
        {
            let [small, large] = [small, large].map(Arch::graph);
            let own = Weights::random(&small, 1);
            let grown = own.grown(&large, 2).unwrap();
            assert!(grown.trained_values() > own.trained_values());
            let picture: Vec<f32> = (0..5 * 16 * 16).map(|i| (i as f32 * 0.37).sin()).collect();
            let depths = |weights: &Weights, graph: &Graph| {
                let mut tape = Tape::new(weights, Mode::Train, Path::OWN).unwrap();
                let x = tape.input(picture.clone(), [1, 5, 16, 16]);
                let y = tape.run2(graph, x, None).unwrap();
                let gradients = y.clone().abs().sum().backward();
                (values(y), tape.finish_step(&gradients).0)
            };
            let (before, (after, gradients)) = (depths(&own, &small).0, depths(&grown, &large));
            assert_eq!(before, after);
            let moves =
                |(at, g): &(usize, Vec<f32>)| grown.tensors[*at].name.contains(new) && g.iter().any(|g| g.abs() > 0.0);
            assert!(gradients.iter().any(moves), "what is added has no gradient");
            assert!(grown.grown(&small, 2).is_none(), "a net never shrinks");
        }
    }

    #[test]
    fn left_out_channels_are_zero_and_the_others_make_up_for_them() {
        let weights = Weights::random(&Arch::Tiny.graph(), 1);
        let mut tape = Tape::new(&weights, Mode::Train, Path::OWN).unwrap().dropping(0.25, Rng::new(5, 0));
        let ones = tape.input(vec![1.0; 1000 * 4], [10, 100, 2, 2]);
        let thinned = values(tape.thinned(ones));
        let channels = thinned.chunks(4).map(|channel| channel.iter().sum::<f32>() / 4.0);
        assert!(channels.clone().all(|mean| mean == 0.0 || (mean - 4.0 / 3.0).abs() < 1e-6));
        let left_out = channels.filter(|mean| *mean == 0.0).count();
        assert!((200..300).contains(&left_out), "{left_out} of 1000");
    }
}
