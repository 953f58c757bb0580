//! 3×3×3 kernels of few channels: rows of tiles go through all views, and what lies in between stays in cache.

use std::ops::Range;

use rayon::prelude::*;

use super::components::Components;
use super::pixels::Room;
use super::products::{Products, Source, TILES};
use super::tiles::{Channels, Pass, Places};
use super::{COMPONENTS, GROUP, pieces, pixels, views, weights};
use crate::kernel::conv::Sums;
use crate::kernel::isa::{Isa, on_isa};
use crate::kernel::padded::SendPtr;
use crate::kernel::shape::{ConvShape, Kernel, Padding};
use crate::kernel::winograd::transform::{POINTS, RESULTS};

/// Groups of views that are held: those that a group's results are made of.
const HELD: usize = 3;
/// Last rows of a strip of input gradients, which the next strip adds to.
const CARRIED: usize = POINTS - RESULTS;

/// A 3×3×3 convolution of a batch of light fields.
pub(in crate::kernel) struct VolumeBatch<'a> {
    shape: &'a ConvShape,
    isa: Isa,
    /// Groups of views.
    groups: usize,
}

/// Writes some values of `[n, channels, v, y, x]` from an index on.
type Fill<'a> = &'a (dyn Fn(&mut [f32], usize) + Sync);

/// A row of tiles of one light field.
struct Row {
    image: usize,
    row: usize,
    places: Places,
}

impl<'a> VolumeBatch<'a> {
    /// Whether a convolution gains by it.
    pub(in crate::kernel) fn pays(shape: &ConvShape) -> bool {
        Self::can(shape) && shape.views > 1
    }

    /// Whether a convolution can be done by it.
    pub(in crate::kernel) fn can(shape: &ConvShape) -> bool {
        let channels = shape.channels_in.max(shape.channels_out);
        shape.kernel == Kernel::Volume && shape.dilation == 1 && channels <= views::CHANNELS
    }

    pub(in crate::kernel) fn new(shape: &'a ConvShape, isa: Isa) -> Self {
        assert!(Self::can(shape), "Winograd's algorithm for {shape:?}");
        Self { shape, isa, groups: views::groups(shape.views) }
    }

    /// `w ∗ x` and its sums.
    pub(in crate::kernel) fn forward(&self, x: &[f32], weights: &[f32]) -> (Vec<f32>, Sums) {
        let ConvShape { batch, channels_in, channels_out, .. } = *self.shape;
        let x = pieces(self.shape, x);
        let weights = weights::forward(self.isa, &views::planes(self.shape, weights, false), views::PLANES);
        let mut z = Vec::with_capacity(self.shape.output_len());
        let target = SendPtr(z.as_mut_ptr());
        let tasks = batch * self.rows();
        let chunks = tasks.min(4 * rayon::current_num_threads());
        let of_chunk = |chunk: usize| {
            let [inputs, results] = [HELD, 1].map(|groups| self.room(groups));
            let mut sums = vec![[0.0; 2]; channels_out];
            for task in tasks * chunk / chunks..tasks * (chunk + 1) / chunks {
                let row = self.row(task / self.rows(), task % self.rows());
                for group in 0..self.groups {
                    for group in self.fresh(group) {
                        self.gather(Pass::Input, &row, group, channels_in, &x, &inputs);
                    }
                    self.multiply(group, channels_in, [&inputs, &weights, &results]);
                    self.finish(&row, group, &results, target, &mut sums);
                }
            }
            sums
        };
        let all: Vec<Sums> = (0..chunks).into_par_iter().with_max_len(1).map(of_chunk).collect();
        // SAFETY: the rows of tiles cover every pixel of every view.
        unsafe { z.set_len(self.shape.output_len()) };
        let add = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        (z, (0..channels_out).map(|c| all.iter().map(|sums| sums[c]).fold([0.0; 2], add)).collect())
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
        let back = || weights::forward(self.isa, &views::planes(self.shape, weights, true), views::PLANES);
        let back = wants_x.then(back);
        let len = if wants_x { self.shape.input_len() } else { 0 };
        let mut to_x = Vec::with_capacity(len);
        let target = SendPtr(to_x.as_mut_ptr());
        // Bands of a light field compute the rows of tiles beside them too, so there are no more than threads to feed.
        let bands = (2 * rayon::current_num_threads()).div_ceil(self.shape.batch).min(self.rows());
        let of_band = |task: usize| {
            let (image, band) = (task / bands, task % bands);
            let rows = self.rows() * band / bands..self.rows() * (band + 1) / bands;
            let sums = weights::room(views::PLANES);
            sums.clear(0);
            self.band(image, rows, [&x, gradient], [&sums, back.as_ref().unwrap_or(&sums)], wants_x.then_some(target));
            sums
        };
        let sums = (0..self.shape.batch * bands).into_par_iter().with_max_len(1).map(of_band).collect::<Vec<_>>();
        // SAFETY: the bands cover every pixel of every view, if they were asked for.
        unsafe { to_x.set_len(len) };
        let sums = sums.into_iter().reduce(|mut a, b| {
            a.add(&b);
            a
        });
        let planes = sums.map(|sums| weights::gradient(self.isa, &sums, views::PLANES)).unwrap_or_default();
        (views::volume(self.shape, &planes), wants_x.then_some(to_x))
    }

    /// Adds to `sums` and writes the rows of pixels that belong to some rows of tiles.
    fn band(
        &self,
        image: usize,
        own: Range<usize>,
        [x, gradient]: [Fill; 2],
        [sums, back]: [&Components; 2],
        to_x: Option<SendPtr>,
    ) {
        let ConvShape { channels_in, channels_out, height, width, .. } = *self.shape;
        let [inputs, results, input_gradients] = [HELD, HELD, 1].map(|groups| self.room(groups));
        let strip = POINTS * width * GROUP;
        let mut carried = vec![0.0; if to_x.is_some() { self.groups * CARRIED * width * GROUP } else { 0 }];
        // The rows of tiles beside the band's add to its first and last rows of pixels.
        let beside = usize::from(to_x.is_some());
        let rows = own.start.saturating_sub(beside)..(own.end + beside).min(self.rows());
        for at in rows.clone() {
            let row = self.row(image, at);
            for group in 0..self.groups {
                for group in self.fresh(group) {
                    self.gather(Pass::ResultGradient, &row, group, channels_out, gradient, &results);
                    if own.contains(&at) {
                        self.gather(Pass::Input, &row, group, channels_in, x, &inputs);
                    }
                }
                if own.contains(&at) {
                    self.each_product(group, channels_in, [&inputs, sums, &results], group % HELD, |products| {
                        on_isa!(self.isa, winograd_weight_gradient(products));
                    });
                }
                let Some(to) = to_x else { continue };
                self.multiply(group, channels_out, [&results, back, &input_gradients]);
                pixels::with_room(self.isa, POINTS * width, |room| {
                    let carried = &mut carried[group * CARRIED * width * GROUP..][..CARRIED * width * GROUP];
                    let (first, rest) = room.pixels.split_at_mut(carried.len());
                    first.copy_from_slice(carried);
                    rest.fill(0.0);
                    self.transform(Pass::InputGradient, &row, room.pixels, &input_gradients, 0);
                    carried.copy_from_slice(&room.pixels[strip - carried.len()..strip]);
                    let last = RESULTS * own.end;
                    let end = if at + 1 == rows.end { height } else { RESULTS * (at + 1) - 1 };
                    let ready = (RESULTS * at).saturating_sub(1).max(RESULTS * own.start)..end.min(last);
                    self.take(room, &row, group, channels_in, 1, ready, to, |_, _| ());
                });
            }
        }
    }

    /// Rows of tiles.
    fn rows(&self) -> usize {
        self.shape.height.div_ceil(RESULTS)
    }

    fn row(&self, image: usize, row: usize) -> Row {
        let edge = self.shape.padding == Padding::Edge;
        Row { image, row, places: Places::strip([self.shape.height, self.shape.width], row, edge) }
    }

    /// Room for the components of some groups of a row of tiles.
    fn room(&self, groups: usize) -> Components {
        let tiles = self.shape.width.div_ceil(RESULTS);
        let components = Components::new(groups, tiles.next_multiple_of(TILES));
        components.clear(tiles);
        components
    }

    /// Groups that are read for a group's results and for none before it.
    fn fresh(&self, group: usize) -> Range<usize> {
        let end = (group + 2).min(self.groups);
        if group == 0 { 0..end } else { (group + 1).min(end)..end }
    }

    /// Transforms `channels` channels of a group, whose values are written by `fill`.
    fn gather(&self, pass: Pass, row: &Row, group: usize, channels: usize, fill: Fill, to: &Components) {
        let (width, pixels) = (self.shape.width, self.shape.height * self.shape.width);
        let (before, rows) = if pass == Pass::Input { (1, POINTS) } else { (0, RESULTS) };
        // Rows of the strip that are in the picture, and the pixel of the picture where they begin.
        let first = before - before.min(RESULTS * row.row);
        let last = (self.shape.height + before - RESULTS * row.row).min(rows);
        let start = (RESULTS * row.row + first - before) * width;
        pixels::with_room(self.isa, POINTS * width, |mut room| {
            room.fill(first * width..last * width, |lane, pixel, values| {
                match self.plane(channels, row, group, lane) {
                    Some(plane) => fill(values, plane * pixels + start + pixel - first * width),
                    None => values.fill(0.0),
                }
            });
            self.transform(pass, row, room.pixels, to, group % HELD);
        });
    }

    fn transform(&self, pass: Pass, row: &Row, pixels: &mut [f32], components: &Components, group: usize) {
        let (pixels, step, components) = (pixels.as_mut_ptr(), components.step(), components.at(0, group, 0));
        on_isa!(self.isa, winograd_channels(&Channels { pass, pixels, places: &row.places, components, step }));
    }

    /// Transforms a group's results back into `to` `[n, channels, v, y, x]`, and adds to `sums`.
    fn finish(&self, row: &Row, group: usize, results: &Components, to: SendPtr, sums: &mut [[f64; 2]]) {
        let ConvShape { channels_out, height, width, .. } = *self.shape;
        pixels::with_room(self.isa, POINTS * width, |room| {
            self.transform(Pass::Results, row, room.pixels, results, 0);
            let ready = RESULTS * row.row..(RESULTS * (row.row + 1)).min(height);
            self.take(room, row, group, channels_out, 0, ready, to, |channel, values| {
                let [sum, squares] = on_isa!(self.isa, sum_and_squares(values));
                sums[channel] = [sums[channel][0] + sum, sums[channel][1] + squares];
            });
        });
    }

    /// Writes rows of pixels from a strip that begins so many rows `before` the tiles into `to` `[n, channels, v, y, x]`,
    /// and shows them to `see`.
    #[allow(clippy::too_many_arguments, reason = "what is taken, from where, and to where")]
    fn take(
        &self,
        mut room: Room,
        row: &Row,
        group: usize,
        channels: usize,
        before: usize,
        rows: Range<usize>,
        to: SendPtr,
        mut see: impl FnMut(usize, &[f32]),
    ) {
        let (width, pixels) = (self.shape.width, self.shape.height * self.shape.width);
        let strip = |y: usize| (y + before - RESULTS * row.row) * width;
        if rows.is_empty() {
            return;
        }
        room.take(strip(rows.start)..strip(rows.end), |lane, pixel, values| {
            let Some(plane) = self.plane(channels, row, group, lane) else { return };
            let at = plane * pixels + rows.start * width + pixel - strip(rows.start);
            // SAFETY: these rows are this task's alone.
            unsafe { to.at(at).copy_from_nonoverlapping(values.as_ptr(), values.len()) };
            see(lane % views::CHANNELS, values);
        });
    }

    /// Which plane of `[n, channels, v]` a lane of a group is.
    fn plane(&self, channels: usize, row: &Row, group: usize, lane: usize) -> Option<usize> {
        let (channel, view) = (lane % views::CHANNELS, group * views::VIEWS + lane / views::CHANNELS);
        let views = self.shape.views;
        (channel < channels && view < views).then(|| (row.image * channels + channel) * views + view)
    }

    /// A group of `to`, its only one: from those of `from`, which have so many channels.
    fn multiply(&self, group: usize, channels: usize, all: [&Components; 3]) {
        self.each_product(group, channels, all, 0, |products| on_isa!(self.isa, winograd_products(products)));
    }

    /// Each component of a group, which lies at `place` in `to`.
    fn each_product(
        &self,
        group: usize,
        channels: usize,
        [from, weights, to]: [&Components; 3],
        place: usize,
        f: impl Fn(&Products),
    ) {
        let kernel = views::kernel_of(group, self.groups);
        for component in 0..COMPONENTS {
            let mut sources = [Source { values: std::ptr::null(), channels: 0, row: 0 }; views::SOURCES];
            for (i, source) in sources.iter_mut().enumerate() {
                let Some(view) = views::source(group, i, self.shape.views) else { continue };
                let lane = view % views::VIEWS * views::CHANNELS;
                // SAFETY: the lane is inside of the group.
                let values = unsafe { from.at(component, view / views::VIEWS % HELD, 0).add(lane) };
                *source = Source { values, channels, row: i * views::CHANNELS };
            }
            f(&Products {
                sources: &sources,
                weights: weights.at(component, kernel, 0),
                rows: weights.tiles,
                groups: 1,
                tiles: from.tiles,
                results: to.at(component, place, 0),
            });
        }
    }
}
