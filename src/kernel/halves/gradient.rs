//! Both gradients.

use std::ops::Range;

use rayon::prelude::*;

use super::planes::{Layout, Pairs, Weights};
use super::product::{Product, Step};
use super::{ACROSS, HalfBatch, TAPS, TILE};
use crate::kernel::gradient::{added_up, fold};
use crate::kernel::isa::on_isa;
use crate::kernel::padded::by_chunks;
use crate::kernel::shape::{ConvShape, Padding};

/// Products of 32 pixels each that are added up at a time: their numbers stay in the second-level cache.
const BLOCK: usize = 64;

/// The gradient of a result, for that of the weights: `[image][group of 16 channels][pair of pixels][16]`, 0 on the margin.
struct Pixels {
    values: Vec<u32>,
    /// Groups of an image, an even number.
    groups: usize,
    /// Values of a group.
    group: usize,
    /// Products of 32 pixels of an image.
    steps: usize,
}

/// A convolution's input for the gradient of its weights: planes of channels.
struct Planes {
    values: Vec<u16>,
    layout: Layout,
}

impl HalfBatch<'_> {
    /// The gradients with respect to the weights and, if wanted, the input. `gradient` writes pieces of the output
    /// gradient from an index on.
    pub(in crate::kernel) fn gradients(
        &self,
        x: &[f32],
        gradient: &(impl Fn(&mut [f32], usize) + Sync),
        weights: &[f32],
        wants_x: bool,
    ) -> (Vec<f32>, Option<Vec<f32>>) {
        let to_x = wants_x.then(|| self.data_gradient(&self.pairs(gradient), weights));
        let planes = self.planes(x);
        (self.weight_gradient(&planes, &self.pixels(&planes.layout, gradient)), to_x)
    }

    fn data_gradient(&self, gradient: &Pairs, weights: &[f32]) -> Vec<f32> {
        let ConvShape { channels_in: channels, channels_out, padding, .. } = *self.shape;
        let turned = |i: usize, o: usize, tap: usize| weights[(o * channels + i) * TAPS + TAPS - 1 - tap];
        let wide = self.multiply(gradient, &Weights::pack([channels, channels_out], turned)).0;
        let reach = self.shape.reach();
        if padding == Padding::Edge { fold(self.shape, reach, &wide) } else { wide }
    }

    fn planes(&self, x: &[f32]) -> Planes {
        let ConvShape { channels_in: channels, height, width, dilation, padding, .. } = *self.shape;
        let layout = Layout::new(self.shape, channels.next_multiple_of(TILE), dilation, padding, size_of::<u16>());
        let values = by_chunks(layout.images * layout.planes, layout.step, |plane, values| {
            let (image, channel) = (plane / layout.planes, plane % layout.planes);
            for y in (0..height).filter(|_| channel < channels) {
                let row = &x[((image * channels + channel) * height + y) * width..][..width];
                layout.put(values, y, |to| on_isa!(self.isa, halve_row(row, to)));
            }
        });
        Planes { values, layout }
    }

    /// The gradient of the result as pairs of channels, with zeros round it.
    fn pairs(&self, gradient: &(impl Fn(&mut [f32], usize) + Sync)) -> Pairs {
        let ConvShape { dilation, padding, .. } = *self.shape;
        // With edge padding the margin has a gradient too.
        let margin = if padding == Padding::Edge { 2 * dilation } else { dilation };
        Pairs::build(self.shape, self.isa, self.shape.channels_out, (margin, Padding::Zero), gradient)
    }

    /// The gradient of the result beside an input so laid out.
    fn pixels(&self, x: &Layout, gradient: &(impl Fn(&mut [f32], usize) + Sync)) -> Pixels {
        let ConvShape { batch, channels_out: channels, height, width, .. } = *self.shape;
        let groups = channels.div_ceil(TILE).next_multiple_of(2);
        let steps = (height * x.width).div_ceil(ACROSS);
        let group = steps * ACROSS / 2 * TILE;
        let values = by_chunks(batch * groups, group, |index, pixels: &mut [u32]| {
            let (image, first) = (index / groups, index % groups * TILE);
            let (mut row, mut pairs) = (vec![0.0; width], vec![0_u32; TILE * x.width / 2]);
            for (y, pixels) in pixels.chunks_mut(x.width / 2 * TILE).enumerate().take(height) {
                for (channel, pairs) in (first..channels).zip(pairs.chunks_mut(x.width / 2)) {
                    gradient(&mut row, ((image * channels + channel) * height + y) * width);
                    on_isa!(self.isa, pair_pixels(&row, pairs));
                }
                let (from, to, n) = (pairs.as_ptr().cast(), pixels.as_mut_ptr().cast(), x.width / 2);
                on_isa!(self.isa, transpose(from, [n, TILE], to, [TILE, n]));
            }
        });
        Pixels { values, groups, group, steps }
    }

    fn weight_gradient(&self, x: &Planes, gradient: &Pixels) -> Vec<f32> {
        let ConvShape { batch, channels_in, channels_out, .. } = *self.shape;
        let [inputs, results] = [x.layout.planes, gradient.groups * TILE];
        let blocks = gradient.steps.div_ceil(BLOCK);
        let sums = added_up(batch * blocks, |tasks| {
            let mut sums = vec![0.0; TAPS * inputs * results];
            for task in tasks {
                let first = task % blocks * BLOCK;
                self.block(x, gradient, task / blocks, first..(first + BLOCK).min(gradient.steps), &mut sums);
            }
            sums
        });
        let mut weights = vec![0.0; self.shape.weights_len()];
        weights.par_chunks_mut(TAPS * channels_in).enumerate().take(channels_out).for_each(|(o, weights)| {
            for (i, weights) in weights.chunks_mut(TAPS).enumerate() {
                weights.iter_mut().enumerate().for_each(|(tap, w)| *w = sums[(tap * inputs + i) * results + o]);
            }
        });
        weights
    }

    /// Adds what some products of one image bring, to `[tap][c_in][c_out]`.
    fn block(&self, x: &Planes, gradient: &Pixels, image: usize, steps: Range<usize>, sums: &mut [f32]) {
        let (inputs, results) = (x.layout.planes, gradient.groups * TILE);
        let tiles = self.halves.tiles(TILE);
        let [pixel, word] = [size_of::<u16>(), size_of::<u32>()];
        let places: Vec<Step> = steps.map(|step| [step * ACROSS * pixel, step * ACROSS / 2 * TILE * word]).collect();
        for (i, o) in (0..inputs).step_by(2 * TILE).flat_map(|i| (0..results).step_by(2 * TILE).map(move |o| (i, o))) {
            let plane = &x.values[(image * inputs + i) * x.layout.step..];
            let columns = &gradient.values[(image * gradient.groups + o / TILE) * gradient.group..];
            for tap in 0..TAPS {
                let distance = (tap / 3 * x.layout.width + tap % 3) * self.shape.dilation;
                let product = Product {
                    rows: plane[distance..].as_ptr().cast(),
                    row_step: x.layout.step * pixel,
                    more_rows: (i + TILE < inputs).then_some(TILE * x.layout.step * pixel),
                    columns: columns.as_ptr().cast(),
                    column_step: TILE * word,
                    more_columns: gradient.group * word,
                    adds: true,
                };
                let to = &mut sums[(tap * inputs + i) * results + o..];
                // SAFETY: planes have room for their last tiles; groups and sums are whole numbers of tiles.
                unsafe { product.onto(&tiles, &places, to.as_mut_ptr(), results) };
            }
        }
    }
}
