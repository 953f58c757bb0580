//! One 3×3 layer in a training step by F(4×4, 3×3): the convolution of a batch, and both its gradients.
//!
//! With d the 6×6 inputs of a tile, w the weights and g the gradient of its 4×4 results, all by channels:
//! ```text
//! forward          y = Aᵀ [ Σ_in (G w Gᵀ) ⊙ (Bᵀ d B) ] A
//! data gradient    ∂d = B [ Σ_out (G w Gᵀ) ⊙ (A g Aᵀ) ] Bᵀ, added up where tiles overlap and where edges were repeated
//! weight gradient  ∂w = Gᵀ [ Σ_tiles (A g Aᵀ) ⊙ (Bᵀ d B) ] G
//! ```
//! Each is the exact transpose of the forward pass. For each of the 36 components the sums are a product of matrices.
//! As many pictures go through together as leave their components in the last-level cache.

mod pixels;
pub(in crate::kernel) mod products;
pub(in crate::kernel) mod tiles;
pub(in crate::kernel) mod weights;

use std::ops::Range;

use rayon::prelude::*;

use self::products::{Products, TILES};
use self::tiles::{Channels, Pass};
use self::weights::GroupWeights;
use super::plane::origins;
use super::plane_tile::COMPONENTS;
use crate::kernel::conv::Sums;
use crate::kernel::isa::{Isa, on_isa};
use crate::kernel::padded::{RowAt, SendPtr};
use crate::kernel::shape::{ConvShape, Kernel, Padding};

/// Channels that lie together.
const GROUP: usize = 16;
/// Memory of the components of the pictures that go through together.
const ROUND_BYTES: usize = 24 << 20;

/// A 3×3 convolution of a batch.
pub(in crate::kernel) struct PlaneBatch<'a> {
    shape: &'a ConvShape,
    isa: Isa,
    /// Tiles of one picture.
    origins: Vec<[u32; 2]>,
}

/// Components of tiles `[component][group][tile][16]`, or of weights, whose "tiles" are channels.
struct Components {
    /// Holds the memory; its length stays 0.
    _values: Vec<f32>,
    first: SendPtr,
    groups: usize,
    tiles: usize,
}

impl Components {
    /// Room for components, nothing set.
    fn new(groups: usize, tiles: usize) -> Self {
        let mut values: Vec<f32> = Vec::with_capacity(COMPONENTS * Self::step_of(groups, tiles) + GROUP);
        let aligned = values.as_ptr().align_offset(64).min(GROUP);
        // SAFETY: there is room for a group more.
        let first = SendPtr(unsafe { values.as_mut_ptr().add(aligned) });
        Self { _values: values, first, groups, tiles }
    }

    /// One line more, lest all components of a tile fall into one set of the cache.
    fn step_of(groups: usize, tiles: usize) -> usize {
        groups * tiles * GROUP + GROUP
    }

    fn step(&self) -> usize {
        Self::step_of(self.groups, self.tiles)
    }

    fn at(&self, component: usize, group: usize, tile: usize) -> *mut f32 {
        debug_assert!(component < COMPONENTS && group < self.groups && tile < self.tiles);
        // SAFETY: inside, as every caller counts below these sizes.
        unsafe { self.first.at(component * self.step() + (group * self.tiles + tile) * GROUP) }
    }

    /// Sets the tiles of a group from `tile` on to 0.
    fn clear(&self, group: usize, tile: usize) {
        for component in (0..COMPONENTS).filter(|_| tile < self.tiles) {
            // SAFETY: the rest of this group's tiles.
            unsafe { self.at(component, group, tile).write_bytes(0, (self.tiles - tile) * GROUP) };
        }
    }
}

impl<'a> PlaneBatch<'a> {
    /// Whether a convolution gains by it.
    pub(in crate::kernel) fn pays(shape: &ConvShape) -> bool {
        let channels = [shape.channels_in, shape.channels_out];
        shape.kernel == Kernel::Plane && channels.iter().all(|&c| c >= GROUP) && channels[0] * channels[1] >= 512
    }

    pub(in crate::kernel) fn new(shape: &'a ConvShape, isa: Isa) -> Self {
        assert_eq!(shape.kernel, Kernel::Plane, "Winograd's algorithm for planes");
        Self { shape, isa, origins: origins([shape.height, shape.width], shape.dilation) }
    }

    /// `w ∗ x` and its sums, the rows of `x` being written by `x`.
    pub(in crate::kernel) fn forward(
        &self,
        x: &(impl Fn(&mut [f32], RowAt) + Sync),
        weights: &[f32],
    ) -> (Vec<f32>, Sums) {
        let channels = [self.shape.channels_in, self.shape.channels_out];
        let weights = self.components_of(weights, false);
        let mut z = Vec::with_capacity(self.shape.output_len());
        let to = SendPtr(z.as_mut_ptr());
        let mut sums = vec![[0.0; 2]; channels[1]];
        for pictures in self.rounds() {
            let [inputs, results] = channels.map(|channels| self.room(channels, &pictures));
            self.gather(Pass::Input, &pictures, channels[0], x, &inputs);
            (0..COMPONENTS).into_par_iter().with_max_len(1).for_each(|component| {
                let products = Self::products(component, &inputs, &weights, &results);
                on_isa!(self.isa, winograd_products(&products));
            });
            for (i, more) in self.scatter(Pass::Results, &pictures, channels[1], &results, to).into_iter().enumerate() {
                let sum = &mut sums[i % channels[1]];
                *sum = [sum[0] + more[0], sum[1] + more[1]];
            }
        }
        // SAFETY: the tiles cover every pixel of every channel.
        unsafe { z.set_len(self.shape.output_len()) };
        (z, sums)
    }

    /// The gradients with respect to the weights and, if wanted, the input. Rows of input and output gradient are
    /// written by `x` and `gradient`.
    pub(in crate::kernel) fn gradients(
        &self,
        x: &(impl Fn(&mut [f32], RowAt) + Sync),
        gradient: &(impl Fn(&mut [f32], RowAt) + Sync),
        weights: &[f32],
        wants_x: bool,
    ) -> (Vec<f32>, Option<Vec<f32>>) {
        let channels = [self.shape.channels_in, self.shape.channels_out];
        let back = wants_x.then(|| self.components_of(weights, true));
        let sums = self.weight_room(channels);
        (0..sums.groups).for_each(|group| sums.clear(group, 0));
        let len = if wants_x { self.shape.input_len() } else { 0 };
        let mut to_x = Vec::with_capacity(len);
        let to = SendPtr(to_x.as_mut_ptr());
        for pictures in self.rounds() {
            let [inputs, results] = channels.map(|channels| self.room(channels, &pictures));
            self.gather(Pass::Input, &pictures, channels[0], x, &inputs);
            self.gather(Pass::ResultGradient, &pictures, channels[1], gradient, &results);
            (0..COMPONENTS).into_par_iter().with_max_len(1).for_each(|component| {
                let products = Self::products(component, &inputs, &sums, &results);
                on_isa!(self.isa, winograd_weight_gradient(&products));
                if let Some(back) = &back {
                    // The inputs have done their part; their gradients take their place.
                    let products = Self::products(component, &results, back, &inputs);
                    on_isa!(self.isa, winograd_products(&products));
                }
            });
            if wants_x {
                self.scatter(Pass::InputGradient, &pictures, channels[0], &inputs, to);
            }
        }
        // SAFETY: `scatter` has written every plane, if it was asked for.
        unsafe { to_x.set_len(len) };
        (self.weights_of(&sums), wants_x.then_some(to_x))
    }

    /// Pictures (each view is one) that go through together.
    fn rounds(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let groups = self.shape.channels_in.div_ceil(GROUP) + self.shape.channels_out.div_ceil(GROUP);
        let bytes = COMPONENTS * groups * self.origins.len() * GROUP * size_of::<f32>();
        let (all, together) = (self.shape.batch * self.shape.views, (ROUND_BYTES / bytes).max(1));
        (0..all).step_by(together).map(move |first| first..(first + together).min(all))
    }

    fn room(&self, channels: usize, pictures: &Range<usize>) -> Components {
        Components::new(channels.div_ceil(GROUP), (pictures.len() * self.origins.len()).next_multiple_of(TILES))
    }

    fn weight_room(&self, [from, to]: [usize; 2]) -> Components {
        Components::new(to.div_ceil(GROUP), from.next_multiple_of(GROUP))
    }

    fn products(component: usize, inputs: &Components, weights: &Components, results: &Components) -> Products {
        Products {
            groups: [inputs.groups, results.groups],
            tiles: inputs.tiles,
            inputs: inputs.at(component, 0, 0),
            weights: weights.at(component, 0, 0),
            results: results.at(component, 0, 0),
        }
    }

    /// Transforms `channels` channels of some pictures, whose rows are written by `fill`.
    fn gather(
        &self,
        pass: Pass,
        pictures: &Range<usize>,
        channels: usize,
        fill: &(impl Fn(&mut [f32], RowAt) + Sync),
        to: &Components,
    ) {
        let ConvShape { views, width, .. } = *self.shape;
        self.groups(pictures, to).for_each(|(index, group)| {
            let picture = pictures.start + index;
            pixels::with_room(self.pixels(), width, |values, rows| {
                let (inside, outside) = values.split_at_mut(self.pixels() * GROUP);
                outside.fill(0.0);
                for (y, pixels) in inside.chunks_exact_mut(width * GROUP).enumerate() {
                    for (channel, row) in (group * GROUP..).zip(rows.chunks_exact_mut(width)) {
                        if channel < channels {
                            fill(row, RowAt { image: picture / views, channel, view: picture % views, y });
                        } else {
                            row.fill(0.0);
                        }
                    }
                    pixels::interleave(rows, pixels);
                }
                let channels = self.channels(pass, values, to, group, index);
                on_isa!(self.isa, winograd_channels(&channels));
            });
            if index + 1 == pictures.len() {
                to.clear(group, pictures.len() * self.origins.len());
            }
        });
    }

    /// Transforms back into the planes of `to` `[n, channels, v, y, x]`; answers each plane's sum and sum of squares,
    /// `[picture][channel]`.
    fn scatter(&self, pass: Pass, pictures: &Range<usize>, channels: usize, from: &Components, to: SendPtr) -> Sums {
        let (views, pixels) = (self.shape.views, self.pixels());
        let of_group = |(index, group): (usize, usize)| {
            let picture = pictures.start + index;
            pixels::with_room(pixels, 0, |values, _| {
                values.fill(0.0);
                let tiles = self.channels(pass, values, from, group, index);
                on_isa!(self.isa, winograd_channels(&tiles));
                let each = group * GROUP..channels.min((group + 1) * GROUP);
                let sums = each.map(|channel| {
                    let at = (picture / views * channels + channel) * views + picture % views;
                    // SAFETY: this plane is this task's alone.
                    let plane = unsafe { std::slice::from_raw_parts_mut(to.at(at * pixels), pixels) };
                    pixels::channel(values, channel % GROUP, plane);
                    on_isa!(self.isa, sum_and_squares(plane))
                });
                sums.collect::<Vec<_>>()
            })
        };
        self.groups(pictures, from).map(of_group).flatten_iter().collect()
    }

    /// All (picture, group of channels).
    fn groups(
        &self,
        pictures: &Range<usize>,
        components: &Components,
    ) -> impl IndexedParallelIterator<Item = (usize, usize)> + use<> {
        let groups = components.groups;
        (0..pictures.len() * groups).into_par_iter().with_max_len(1).map(move |i| (i / groups, i % groups))
    }

    fn pixels(&self) -> usize {
        self.shape.height * self.shape.width
    }

    /// The `index`-th picture of a round.
    fn channels(&self, pass: Pass, pixels: &mut [f32], all: &Components, group: usize, index: usize) -> Channels<'_> {
        Channels {
            pass,
            pixels: pixels.as_mut_ptr(),
            size: [self.shape.height, self.shape.width],
            dilation: self.shape.dilation,
            edge: self.shape.padding == Padding::Edge,
            origins: &self.origins,
            components: all.at(0, group, index * self.origins.len()),
            step: all.step(),
        }
    }

    /// Components of `weights`, from input to output channels, or `back`.
    fn components_of(&self, weights: &[f32], back: bool) -> Components {
        assert_eq!(weights.len(), self.shape.weights_len(), "number of weights");
        let ConvShape { channels_in, channels_out, .. } = *self.shape;
        let [from, to] = if back { [channels_out, channels_in] } else { [channels_in, channels_out] };
        let components = self.weight_room([from, to]);
        self.each_weight(&components, SendPtr(weights.as_ptr().cast_mut()), back, |weights| {
            on_isa!(self.isa, winograd_weights(&weights));
        });
        components
    }

    /// The weights whose components these are.
    fn weights_of(&self, components: &Components) -> Vec<f32> {
        let mut weights = vec![0.0; self.shape.weights_len()];
        self.each_weight(components, SendPtr(weights.as_mut_ptr()), false, |weights| {
            on_isa!(self.isa, winograd_weights_gradient(&weights));
        });
        weights
    }

    fn each_weight(&self, components: &Components, taps: SendPtr, back: bool, f: impl Fn(GroupWeights) + Sync) {
        let (count, taps_len) = (components.tiles, self.shape.kernel.taps());
        let ConvShape { channels_in, channels_out, .. } = *self.shape;
        let [from, to] = if back { [channels_out, channels_in] } else { [channels_in, channels_out] };
        let steps = if back { [channels_in, 1] } else { [1, channels_in] };
        (0..components.groups * count).into_par_iter().with_min_len(GROUP).for_each(|i| {
            let (group, channel) = (i / count, i % count);
            let lanes = if channel < from { (to - group * GROUP).min(GROUP) } else { 0 };
            let first = (channel.min(from - 1) * steps[0] + group * GROUP * steps[1]) * taps_len;
            f(GroupWeights {
                // SAFETY: the taps of these two channels; each pair is one task's.
                taps: unsafe { taps.at(first) },
                lane_step: steps[1] * taps_len,
                lanes,
                components: components.at(0, group, channel),
                step: components.step(),
            });
        });
    }
}
