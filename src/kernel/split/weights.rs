//! Weights as halves, tile after tile as products read them.

use std::ops::Range;

use super::TILE;
use super::picture::{Layout, Line, halves_of};
use crate::kernel::halves::rounded;

/// What a weight may miss a whole multiple of its row's step by, in steps: what f32 loses on the way, and no more.
const NEAR: f32 = 1e-4;
/// Steps from 0 to the largest weight of a row that was rounded to 8 bits.
const STEPS: f32 = 127.0;

/// The weights of several layers. They lie one behind the other, as together they are large enough for huge pages: on
/// small ones, a net that runs for the first time in a while waits for addresses as long as it computes.
pub(in crate::kernel) type Store = Vec<Line>;

/// Where a layer's weights lie in the store: `[16 results][block][tap][parts][pair of channels][16 results][2]`.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::kernel) struct Weights {
    lines: Range<usize>,
    /// Of input and result; results are whole groups of 16.
    pub(in crate::kernel) channels: [usize; 2],
    /// High and low halves; or high ones alone, where they are the weights: those of a net in 8 bits are whole numbers of
    /// steps.
    pub(super) parts: usize,
    /// What the sums of each result are multiplied by.
    pub(super) steps: Vec<f32>,
}

impl Weights {
    /// Puts weights `[c_out, c_in, 3, 3]` into the store.
    pub(in crate::kernel) fn new(
        store: &mut Store,
        weights: &[f32],
        channels @ [channels_in, channels_out]: [usize; 2],
    ) -> Self {
        assert!(channels_out.is_multiple_of(TILE), "{channels_out} results are no whole groups");
        assert_eq!(weights.len(), channels_in * channels_out * 9, "number of weights");
        let depth = Layout::depth(channels_in);
        let blocks = channels_in.div_ceil(2 * depth);
        let whole: Option<Vec<f32>> = weights.chunks_exact(channels_in * 9).map(step).collect();
        let parts = if whole.is_some() { 1 } else { 2 };
        let steps = whole.unwrap_or_else(|| vec![1.0; channels_out]);
        let lines = store.len()..store.len() + channels_out / TILE * blocks * 9 * parts * depth;
        store.resize(lines.end, Line::ZERO);
        let to = Line::halves(&mut store[lines.clone()]);
        for (i, taps) in weights.chunks_exact(9).enumerate() {
            let (result, channel) = (i / channels_in, i % channels_in);
            let block = result / TILE * blocks + channel / (2 * depth);
            let place = (channel % (2 * depth) / 2 * TILE + result % TILE) * 2 + channel % 2;
            for (tap, weight) in taps.iter().enumerate() {
                let halves = if parts == 1 { [whole_number(weight / steps[result]), 0] } else { halves_of(*weight) };
                for (part, half) in halves.into_iter().enumerate().take(parts) {
                    to[((block * 9 + tap) * parts + part) * depth * Line::LEN + place] = half;
                }
            }
        }
        Self { lines, channels, parts, steps }
    }

    /// Of all results.
    pub(super) fn bytes(&self) -> usize {
        self.lines.len() * size_of::<Line>()
    }

    /// Groups of 16 results.
    pub(super) fn groups(&self) -> usize {
        self.channels[1] / TILE
    }

    /// The first byte of a group.
    pub(super) fn group(&self, store: &Store, group: usize) -> *const u8 {
        store[self.lines.start + group * (self.lines.len() / self.groups())..].as_ptr().cast()
    }
}

/// The step that all weights of a row are whole multiples of, if they are such as rounding to 8 bits leaves.
fn step(row: &[f32]) -> Option<f32> {
    let largest = row.iter().fold(0.0_f32, |most, weight| most.max(weight.abs()));
    let step = if largest > 0.0 { largest / STEPS } else { 1.0 };
    let is_whole = |weight: &f32| (weight / step - (weight / step).round()).abs() <= NEAR;
    row.iter().all(is_whole).then_some(step)
}

/// The nearest whole number, of at most 8 bits, which a half keeps.
fn whole_number(value: f32) -> u16 {
    rounded(value.round()) as u16
}
