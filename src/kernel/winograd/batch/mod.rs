//! One layer of a training step by F(4×4, 3×3): the convolution of a batch, and both its gradients.
//!
//! With d the 6×6 inputs of a tile, w the weights and g the gradient of its 4×4 results, all by channels:
//! ```text
//! forward          y = Aᵀ [ Σ_in (G w Gᵀ) ⊙ (Bᵀ d B) ] A
//! data gradient    ∂d = B [ Σ_out (G w Gᵀ) ⊙ (A g Aᵀ) ] Bᵀ, added up where tiles overlap and where edges were repeated
//! weight gradient  ∂w = Gᵀ [ Σ_tiles (A g Aᵀ) ⊙ (Bᵀ d B) ] G
//! ```
//! The gradients are the exact transposes of the forward pass. For each of the 36 components the sums are products of
//! matrices. Of planes ([`PlaneBatch`]), as many pictures go through together as leave their components in the last-level
//! cache; of volumes with few channels ([`VolumeBatch`]), so much that they stay in the second-level cache.

mod components;
pub(in crate::kernel) mod pixels;
pub(in crate::kernel) mod products;
pub(in crate::kernel) mod tiles;
mod views;
mod volume;
pub(in crate::kernel) mod weights;

pub(in crate::kernel) use volume::VolumeBatch;

use std::ops::Range;

use rayon::prelude::*;

use self::components::Components;
use self::products::{Products, Source, TILES};
use self::tiles::{Channels, Pass, Places};
use super::plane_tile::COMPONENTS;
use crate::kernel::conv::Sums;
use crate::kernel::isa::{Isa, on_isa};
use crate::kernel::padded::SendPtr;
use crate::kernel::shape::{ConvShape, Kernel, Padding};

/// Channels that lie together.
const GROUP: usize = 16;
/// Memory of the components of the pictures that go through together.
const ROUND_BYTES: usize = 16 << 20;

/// A 3×3 convolution of a batch.
pub(in crate::kernel) struct PlaneBatch<'a> {
    shape: &'a ConvShape,
    isa: Isa,
    /// The tiles of one picture.
    places: Places,
}

impl<'a> PlaneBatch<'a> {
    /// Whether a convolution gains by it.
    pub(in crate::kernel) fn pays(shape: &ConvShape) -> bool {
        let channels = [shape.channels_in, shape.channels_out];
        shape.kernel == Kernel::Plane && channels.iter().all(|&c| c >= GROUP)
    }

    pub(in crate::kernel) fn new(shape: &'a ConvShape, isa: Isa) -> Self {
        assert_eq!(shape.kernel, Kernel::Plane, "Winograd's algorithm for planes");
        let places = Places::new([shape.height, shape.width], shape.dilation, shape.padding == Padding::Edge);
        Self { shape, isa, places }
    }

    /// `w ∗ x` and its sums.
    pub(in crate::kernel) fn forward(&self, x: &[f32], weights: &[f32]) -> (Vec<f32>, Sums) {
        let x = pieces(self.shape, x);
        let channels = [self.shape.channels_in, self.shape.channels_out];
        let weights = weights::forward(self.isa, weights, channels);
        let mut z = Vec::with_capacity(self.shape.output_len());
        let to = SendPtr(z.as_mut_ptr());
        let mut sums = vec![[0.0; 2]; channels[1]];
        for pictures in self.rounds() {
            let [inputs, results] = channels.map(|channels| self.room(channels, &pictures));
            self.gather(Pass::Input, &pictures, channels[0], &x, &inputs);
            (0..COMPONENTS).into_par_iter().with_max_len(1).for_each(|component| {
                multiply(self.isa, component, [&inputs, &weights, &results]);
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

    /// The gradients with respect to the weights and, if wanted, the input. `gradient` writes pieces of the output
    /// gradient from an index on.
    pub(in crate::kernel) fn gradients(
        &self,
        x: &[f32],
        gradient: &(impl Fn(&mut [f32], usize) + Sync),
        weights: &[f32],
        wants_x: bool,
    ) -> (Vec<f32>, Option<Vec<f32>>) {
        let x = pieces(self.shape, x);
        let channels = [self.shape.channels_in, self.shape.channels_out];
        let back = wants_x.then(|| weights::back(self.isa, weights, channels));
        let sums = weights::room(channels);
        sums.clear(0);
        let len = if wants_x { self.shape.input_len() } else { 0 };
        let mut to_x = Vec::with_capacity(len);
        let to = SendPtr(to_x.as_mut_ptr());
        for pictures in self.rounds() {
            let [inputs, results] = channels.map(|channels| self.room(channels, &pictures));
            self.gather(Pass::Input, &pictures, channels[0], &x, &inputs);
            self.gather(Pass::ResultGradient, &pictures, channels[1], gradient, &results);
            (0..COMPONENTS).into_par_iter().with_max_len(1).for_each(|component| {
                multiply_weights(self.isa, component, [&inputs, &sums, &results]);
                if let Some(back) = &back {
                    // The inputs have done their part; their gradients take their place.
                    multiply(self.isa, component, [&results, back, &inputs]);
                }
            });
            if wants_x {
                self.scatter(Pass::InputGradient, &pictures, channels[0], &inputs, to);
            }
        }
        // SAFETY: `scatter` has written every plane, if it was asked for.
        unsafe { to_x.set_len(len) };
        (weights::gradient(self.isa, &sums, channels), wants_x.then_some(to_x))
    }

    /// Pictures (each view is one) that go through together.
    fn rounds(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let groups = self.shape.channels_in.div_ceil(GROUP) + self.shape.channels_out.div_ceil(GROUP);
        let bytes = COMPONENTS * groups * self.places.tiles() * GROUP * size_of::<f32>();
        let (all, together) = (self.shape.batch * self.shape.views, (ROUND_BYTES / bytes).max(1));
        (0..all).step_by(together).map(move |first| first..(first + together).min(all))
    }

    fn room(&self, channels: usize, pictures: &Range<usize>) -> Components {
        let tiles = pictures.len() * self.places.tiles();
        let components = Components::new(channels.div_ceil(GROUP), tiles.next_multiple_of(TILES));
        components.clear(tiles);
        components
    }

    /// Transforms `channels` channels of some pictures, whose values are written by `fill`.
    fn gather(
        &self,
        pass: Pass,
        pictures: &Range<usize>,
        channels: usize,
        fill: &(impl Fn(&mut [f32], usize) + Sync),
        to: &Components,
    ) {
        self.groups(pictures, to).for_each(|(index, group)| {
            pixels::with_room(self.isa, self.pixels(), |mut room| {
                room.fill(0..self.pixels(), |lane, pixel, values| {
                    match self.plane(channels, pictures.start + index, group, lane) {
                        Some(plane) => fill(values, plane * self.pixels() + pixel),
                        None => values.fill(0.0),
                    }
                });
                let channels = self.channels(pass, room.pixels, to, group, index);
                on_isa!(self.isa, winograd_channels(&channels));
            });
        });
    }

    /// Transforms back into the planes of `to` `[n, channels, v, y, x]`; answers each plane's sum and sum of squares,
    /// `[picture][channel]`.
    fn scatter(&self, pass: Pass, pictures: &Range<usize>, channels: usize, from: &Components, to: SendPtr) -> Sums {
        let of_group = |(index, group): (usize, usize)| {
            pixels::with_room(self.isa, self.pixels(), |mut room| {
                room.pixels.fill(0.0);
                let tiles = self.channels(pass, room.pixels, from, group, index);
                on_isa!(self.isa, winograd_channels(&tiles));
                let mut sums = vec![[0.0; 2]; GROUP.min(channels - group * GROUP)];
                room.take(0..self.pixels(), |lane, pixel, values| {
                    let Some(plane) = self.plane(channels, pictures.start + index, group, lane) else { return };
                    // SAFETY: this plane is this task's alone.
                    unsafe {
                        to.at(plane * self.pixels() + pixel).copy_from_nonoverlapping(values.as_ptr(), values.len())
                    };
                    let [sum, squares] = on_isa!(self.isa, sum_and_squares(values));
                    sums[lane] = [sums[lane][0] + sum, sums[lane][1] + squares];
                });
                sums
            })
        };
        self.groups(pictures, from).map(of_group).flatten_iter().collect()
    }

    /// Which plane of `[n, channels, v]` a lane of a group is.
    fn plane(&self, channels: usize, picture: usize, group: usize, lane: usize) -> Option<usize> {
        let (views, channel) = (self.shape.views, group * GROUP + lane);
        (channel < channels).then(|| (picture / views * channels + channel) * views + picture % views)
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
            places: &self.places,
            components: all.at(0, group, index * self.places.tiles()),
            step: all.step(),
        }
    }
}

/// Writes pieces of a convolution's input `x` from an index on.
fn pieces<'a>(shape: &ConvShape, x: &'a [f32]) -> impl Fn(&mut [f32], usize) + Sync + use<'a> {
    assert_eq!(x.len(), shape.input_len(), "length of the input");
    move |values, at| values.copy_from_slice(&x[at..][..values.len()])
}

/// One component of the results: `to` = `from` · `weights`.
fn multiply(isa: Isa, component: usize, all: [&Components; 3]) {
    each_product(component, all, |products| on_isa!(isa, winograd_products(products)));
}

/// One component of the weights' gradient: `weights` += `from`ᵀ · `to`.
fn multiply_weights(isa: Isa, component: usize, all: [&Components; 3]) {
    each_product(component, all, |products| on_isa!(isa, winograd_weight_gradient(products)));
}

/// All groups of `from` with all of `to`.
fn each_product(component: usize, [from, weights, to]: [&Components; 3], f: impl FnOnce(&Products)) {
    let source = |group| Source { values: from.at(component, group, 0), channels: GROUP, row: group * GROUP };
    f(&Products {
        sources: &(0..from.groups).map(source).collect::<Vec<_>>(),
        weights: weights.at(component, 0, 0),
        rows: weights.tiles,
        groups: to.groups,
        tiles: from.tiles,
        results: to.at(component, 0, 0),
    });
}
