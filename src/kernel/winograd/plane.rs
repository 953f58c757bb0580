//! Consecutive 3×3 convolutions of many channels by Winograd's F(4×4, 3×3), activations channel-last in between.

use std::cell::RefCell;
use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicBool, Ordering};

use super::plane_order::{Planes, channel_last, transpose};
use super::plane_tile::{COMPONENTS, GROUP, TILES, TOGETHER, Tiles, scratch_len};
use super::transform::{POINTS, of_weights};
use super::{Layer, plane_components};
use crate::job::Cancelled;
use crate::kernel::Halves;
use crate::kernel::ending::{Ending, Limits};
use crate::kernel::isa::{Isa, on_isa};
use crate::kernel::shape::Padding;
use crate::kernel::split;
use crate::kernel::team;
use crate::kernel::tile::Activation;

/// Products of channels from which on a layer by itself pays for being brought to channel-last and back.
const LEAST_ALONE: usize = 1024;

thread_local! {
    /// A thread's transformed tiles.
    static SCRATCH: RefCell<Vec<f32>> = const { RefCell::new(Vec::new()) };
}

/// 3×3 convolutions that follow each other, weights transformed.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneChain {
    isa: Isa,
    layers: Vec<Ready>,
    /// Weights as halves.
    store: split::Store,
}

/// A layer whose weights are ready.
#[derive(Clone, Debug, PartialEq)]
struct Ready {
    weights: Weights,
    bias: Vec<f32>,
    channels: [usize; 2],
    dilation: usize,
    padding: Padding,
    activation: Activation,
    is_residual: bool,
}

/// What a layer is multiplied with.
#[derive(Clone, Debug, PartialEq)]
enum Weights {
    /// Transformed, `[component][c_out / 16][c_in][16]`.
    Transformed(Vec<f32>),
    /// As halves in the chain's store, for tiles.
    Split(Halves, split::Weights),
}

impl PlaneChain {
    /// Whether a convolution with these channels can be part of one, where it gains by it.
    pub fn takes(channels: [usize; 2]) -> bool {
        channels.iter().all(|channels| channels.is_multiple_of(GROUP))
    }

    /// Whether a convolution with these channels gains by it with no other before and behind it.
    pub fn pays_alone(channels: [usize; 2]) -> bool {
        Self::takes(channels) && channels[0] * channels[1] >= LEAST_ALONE
    }

    /// Makes the weights of `layers` ready, all of which it [takes](Self::takes); each reads the channels that the one
    /// before it makes. With `halves` all products are split ones, and no layer is Winograd's.
    pub fn new(layers: &[Layer], isa: Isa, halves: Option<Halves>) -> Self {
        let mut store = split::Store::new();
        let layers = layers.iter().map(|layer| Ready::new(layer, halves, &mut store)).collect();
        store.shrink_to_fit();
        Self { isa, layers, store }
    }

    /// Channels of the result.
    pub fn channels_out(&self) -> usize {
        self.layers.last().map_or(0, |layer| layer.channels[1])
    }

    /// Runs the chain on `x` `[c, y, x]` of `[rows, columns]`; after `Ok` every value of `out` is written.
    ///
    /// # Errors
    /// [`Cancelled`] once `cancel` is set.
    pub fn run(
        &self,
        x: &[f32],
        size: [usize; 2],
        out: &mut [MaybeUninit<f32>],
        cancel: Option<&AtomicBool>,
    ) -> Result<(), Cancelled> {
        let part = Planes { values: x, is_doubled: false };
        self.run_between(&[part], size, (Limits::NONE, Ending::default()), out, cancel)
    }

    /// The same on the channels of several parts, kept within limits, and with an ending of its result.
    ///
    /// # Errors
    /// [`Cancelled`] once `cancel` is set.
    pub fn run_between(
        &self,
        parts: &[Planes],
        size: [usize; 2],
        (before, ending): (Limits, Ending),
        out: &mut [MaybeUninit<f32>],
        cancel: Option<&AtomicBool>,
    ) -> Result<(), Cancelled> {
        assert!(ending.summand.is_none_or(|summand| summand.len() == out.len()), "length of the summand");
        let pixels = size[0] * size[1];
        let mut values = channel_last(self.isa, parts, size, before);
        for layer in &self.layers {
            let len = pixels * layer.channels[1];
            let mut next = Vec::with_capacity(len);
            layer.run(self, &values, size, &mut next.spare_capacity_mut()[..len], cancel)?;
            // SAFETY: the tiles cover every pixel, and all channels of it.
            unsafe { next.set_len(len) };
            values = next;
        }
        transpose(self.isa, &values, out, self.channels_out(), ending);
        Ok(())
    }
}

impl Ready {
    fn new(layer: &Layer, halves: Option<Halves>, store: &mut split::Store) -> Self {
        let Layer { channels, dilation, padding, activation, is_residual, .. } = *layer;
        assert_eq!(layer.weights.len(), channels[0] * channels[1] * 9, "number of weights");
        assert!(!is_residual || channels[0] == channels[1], "a sum of {channels:?} channels");
        let weights = match halves {
            Some(halves) => Weights::Split(halves, split::Weights::new(store, layer.weights, channels)),
            None => Weights::Transformed(transform(layer.weights, channels)),
        };
        Self { weights, bias: layer.bias.to_vec(), channels, dilation, padding, activation, is_residual }
    }

    fn run(
        &self,
        chain: &PlaneChain,
        x: &[f32],
        size: [usize; 2],
        out: &mut [MaybeUninit<f32>],
        cancel: Option<&AtomicBool>,
    ) -> Result<(), Cancelled> {
        let pixels = size[0] * size[1];
        assert_eq!([x.len(), out.len()], self.channels.map(|c| c * pixels), "lengths of input and result");
        match &self.weights {
            Weights::Transformed(weights) => self.transformed(chain.isa, weights, (x, size), out, cancel),
            Weights::Split(halves, weights) => self.split(chain, *halves, weights, (x, size)).run(out, cancel),
        }
    }

    /// The layer by split products.
    fn split<'a>(
        &'a self,
        &PlaneChain { isa, ref store, .. }: &'a PlaneChain,
        halves: Halves,
        weights: &'a split::Weights,
        (x, size): (&'a [f32], [usize; 2]),
    ) -> split::Layer<'a> {
        let Self { ref bias, dilation, padding, activation, is_residual, .. } = *self;
        split::Layer { isa, halves, x, size, store, weights, bias, dilation, padding, activation, is_residual }
    }

    /// Computes the layer by Winograd's algorithm.
    fn transformed(
        &self,
        isa: Isa,
        weights: &[f32],
        (x, size): (&[f32], [usize; 2]),
        out: &mut [MaybeUninit<f32>],
        cancel: Option<&AtomicBool>,
    ) -> Result<(), Cancelled> {
        let Self { channels, dilation, padding, activation, is_residual, ref bias, .. } = *self;
        let zeros = vec![0.0; if padding == Padding::Zero { channels[0] } else { 0 }];
        let origins = origins(size, dilation);
        let tiles = &Tiles {
            x: x.as_ptr(),
            out: out.as_mut_ptr().cast(),
            size,
            channels,
            dilation,
            outside: if zeros.is_empty() { std::ptr::null() } else { zeros.as_ptr() },
            weights,
            bias,
            activation,
            is_residual,
            origins: &origins,
        };
        if plane_components::pays(channels) {
            return plane_components::run(isa, tiles, cancel);
        }
        // Small pictures go in smaller blocks, so that all threads have some.
        let share = origins.len().div_ceil(2 * rayon::current_num_threads());
        let block = share.next_multiple_of(TOGETHER).min(TILES);
        let stopped = || cancel.is_some_and(|flag| flag.load(Ordering::Relaxed));
        team::each(origins.len().div_ceil(block), |task| {
            if stopped() {
                return;
            }
            let part = task * block..((task + 1) * block).min(origins.len());
            let tiles = Tiles { origins: &origins[part], ..*tiles };
            SCRATCH.with_borrow_mut(|scratch| {
                scratch.resize(scratch_len(channels).max(scratch.len()), 0.0);
                on_isa!(isa, winograd_plane(&tiles, scratch.as_mut_ptr()));
            });
        });
        if stopped() { Err(Cancelled) } else { Ok(()) }
    }
}

/// Transformed weights `[component][c_out / 16][c_in][16]`.
fn transform(weights: &[f32], [c_in, c_out]: [usize; 2]) -> Vec<f32> {
    let mut all = vec![0.0; COMPONENTS * c_in * c_out];
    for (i, taps) in weights.chunks_exact(9).enumerate() {
        let (o, c) = (i / c_in, i % c_in);
        let at = (o / GROUP * c_in + c) * GROUP + o % GROUP;
        for (component, weight) in transformed(taps).into_iter().enumerate() {
            all[component * c_in * c_out + at] = weight;
        }
    }
    all
}

/// Nine taps, transformed along both axes.
fn transformed(taps: &[f32]) -> [f32; COMPONENTS] {
    let rows = [0, 3, 6].map(|row| of_weights([taps[row], taps[row + 1], taps[row + 2]]));
    let mut all = [0.0; COMPONENTS];
    for j in 0..POINTS {
        for (i, value) in of_weights(rows.map(|row| row[j])).into_iter().enumerate() {
            all[i * POINTS + j] = value;
        }
    }
    all
}

/// First results of all tiles: in each of the d² interleaved pictures, every fourth row and column.
fn origins(size: [usize; 2], dilation: usize) -> Vec<[u32; 2]> {
    let columns = firsts(size[1], dilation);
    firsts(size[0], dilation).into_iter().flat_map(|y| columns.iter().map(move |&x| [y, x])).collect()
}

/// First results of all tiles along one axis.
pub(super) fn firsts(size: usize, dilation: usize) -> Vec<u32> {
    let starts = (0..size).step_by(4 * dilation);
    starts.flat_map(|start| (start..(start + dilation).min(size)).map(|at| at as u32)).collect()
}
