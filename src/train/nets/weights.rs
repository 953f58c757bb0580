//! A net's weights as named arrays, in the order of its convolutions.

use rayon::prelude::*;

use super::encoder::PREFIX;
use super::{Conv, End, Graph, LAST, REFERENCE, VIEWS};
use crate::TrainError;
use crate::rng::Rng;

/// A named array of f32.
#[derive(Clone, Debug, PartialEq)]
pub struct Tensor32 {
    /// `layer.weight`, `layer.gamma`, `layer.beta`, `layer.bias`, `layer.mean`, `layer.var`.
    pub name: String,
    /// Sizes, outermost first.
    pub shape: Vec<usize>,
    /// Values, the last axis fastest.
    pub values: Vec<f32>,
    /// Whether the optimiser changes it (running statistics: no).
    pub trained: bool,
}

impl Tensor32 {
    /// Whether it is of the last layer, whose rows are views (of the occlusion net: colours).
    pub fn is_of_last_layer(&self) -> bool {
        self.name.strip_prefix(LAST).is_some_and(|what| what.starts_with('.'))
    }

    /// Whether it is of the encoder beside a U-Net.
    pub fn is_of_encoder(&self) -> bool {
        self.name.starts_with(PREFIX)
    }
}

/// Values in 8 bits: each of so many channels has a step of its own.
pub struct Bytes {
    /// Multiples of the channels' steps.
    pub values: Vec<i8>,
    /// The steps.
    pub steps: Vec<f32>,
}

impl Bytes {
    /// The nearest to these values.
    pub fn of(values: &[f32], channels: usize) -> Self {
        let each = || values.chunks((values.len() / channels).max(1));
        let step = |channel: &[f32]| channel.iter().fold(f32::MIN_POSITIVE, |most, v| most.max(v.abs())) / 127.0;
        let steps: Vec<f32> = each().map(step).collect();
        let rounded = each().zip(&steps).flat_map(|(of, step)| of.iter().map(move |v| (v / step).round() as i8));
        Self { values: rounded.collect(), steps }
    }

    /// The values that they stand for.
    pub fn floats(&self) -> Vec<f32> {
        let each = self.values.chunks((self.values.len() / self.steps.len().max(1)).max(1)).zip(&self.steps);
        each.flat_map(|(of, step)| of.iter().map(move |v| f32::from(*v) * step)).collect()
    }
}

/// All arrays of a net.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Weights {
    /// The arrays, in a fixed order.
    pub tensors: Vec<Tensor32>,
}

impl Weights {
    /// He-initialised weights from a seed. The last layer starts small and *tied*: all its rows equal, so that a depth
    /// net begins with one map for all views (64 free maps fall into local minima).
    pub fn random(graph: &Graph, seed: u64) -> Self {
        let mut rng = Rng::new(seed, 0x6e65_7473);
        let mut tensors = Vec::new();
        for conv in graph.convs() {
            let (shape, products) = (conv.weight_shape(graph.rank), conv.products(graph.rank));
            let values = match conv.end {
                End::NormElu | End::Settled { .. } => {
                    normal(&mut rng, conv.outputs * products, (2.0 / products as f32).sqrt())
                }
                End::Tanh { .. } => tied(&mut rng, conv, products),
            };
            tensors.push(Tensor32 { name: format!("{}.weight", conv.name), shape, values, trained: true });
            tensors.extend(vectors(conv));
        }
        Self { tensors }
    }

    /// The weights of a larger net that computes what this one does, as it begins; none if `graph` does not hold this one.
    pub fn grown(&self, graph: &Graph, seed: u64) -> Option<Self> {
        let mut grown = Self::random(graph, seed);
        for own in &self.tensors {
            let place = grown.tensors.iter_mut().find(|t| t.name == own.name && t.shape == own.shape)?;
            place.values.clone_from(&own.values);
        }
        Some(grown)
    }

    /// The array of a name.
    pub fn get(&self, name: &str) -> Result<&Tensor32, TrainError> {
        self.find(name).map(|(_, array)| array)
    }

    /// The same with its index.
    pub fn find(&self, name: &str) -> Result<(usize, &Tensor32), TrainError> {
        let found = self.tensors.iter().enumerate().find(|(_, t)| t.name == name);
        found.ok_or_else(|| TrainError::Missing { name: name.to_owned() })
    }

    /// Multiplies what the last layer says before its tanh: ray depths by nearly as much, as they keep far from ±4 px.
    pub fn amplify(&mut self, gain: f32) {
        let last = self.tensors.iter_mut().filter(|t| t.is_of_last_layer());
        last.for_each(|tensor| tensor.values.iter_mut().for_each(|value| *value *= gain));
    }

    /// Gives every row of a depth net's last layer what the reference view's row has: one map for all views.
    pub fn tie_views(&mut self) {
        for tensor in self.tensors.iter_mut().filter(|t| t.is_of_last_layer() && t.shape[0] == VIEWS) {
            let row = tensor.values.len() / VIEWS;
            let reference = tensor.values[REFERENCE * row..][..row].to_vec();
            tensor.values.chunks_mut(row).for_each(|values| values.copy_from_slice(&reference));
        }
    }

    /// Moves every value by `part` of the way to another net's.
    pub fn approach(&mut self, other: &Self, part: f32) {
        for (to, from) in self.tensors.iter_mut().zip(&other.tensors) {
            let pairs = to.values.par_iter_mut().zip(&from.values).with_min_len(8192);
            pairs.for_each(|(to, from)| *to += part * (from - *to));
        }
    }

    /// Number of values that the optimiser changes.
    pub fn trained_values(&self) -> usize {
        self.tensors.iter().filter(|t| t.trained).map(|t| t.values.len()).sum()
    }

    /// `Err` unless names and shapes are those of `graph`.
    pub fn check(&self, graph: &Graph) -> Result<(), TrainError> {
        let wanted = Self::random(graph, 0);
        let same = self.tensors.len() == wanted.tensors.len()
            && self.tensors.iter().zip(&wanted.tensors).all(|(a, b)| a.name == b.name && a.shape == b.shape);
        if same { Ok(()) } else { Err(TrainError::Architecture { wanted: graph.arch.name() }) }
    }
}

fn normal(rng: &mut Rng, n: usize, deviation: f32) -> Vec<f32> {
    (0..n).map(|_| rng.normal() * deviation).collect()
}

/// One random row, repeated for every output; the occlusion net's rows differ, as colours do.
fn tied(rng: &mut Rng, conv: &Conv, n: usize) -> Vec<f32> {
    if conv.outputs == VIEWS {
        let row = normal(rng, n, 0.3 / (n as f32).sqrt());
        row.iter().copied().cycle().take(n * conv.outputs).collect()
    } else {
        normal(rng, n * conv.outputs, 0.05 / (n as f32).sqrt())
    }
}

/// The arrays of a convolution beside its weights.
fn vectors(conv: &Conv) -> Vec<Tensor32> {
    let vector = |what: &str, value: f32, trained| Tensor32 {
        name: format!("{}.{what}", conv.name),
        shape: vec![conv.outputs],
        values: vec![value; conv.outputs],
        trained,
    };
    match conv.end {
        End::NormElu | End::Settled { .. } => vec![
            vector("gamma", if conv.added.is_some() && conv.end == End::NormElu { 0.0 } else { 1.0 }, true),
            vector("beta", 0.0, true),
            vector("mean", 0.0, false),
            vector("var", 1.0, false),
        ],
        End::Tanh { .. } => vec![vector("bias", 0.0, true)],
    }
}
