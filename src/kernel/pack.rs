//! Weights in the order in which the tiles read them.

use super::shape::Kernel;

/// Channels of the result that a tile computes together.
pub(super) const BLOCK: usize = 8;

/// Weights of one convolution, packed `[c_out / 8][c_in][tap][8]`, missing channels zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Packed {
    pub(super) values: Vec<f32>,
    pub(super) channels_in: usize,
    pub(super) channels_out: usize,
    pub(super) taps: usize,
}

impl Packed {
    /// Packs `weights` `[c_out, c_in, taps]`, as [`Conv::pack`](super::Conv::pack) does, where the size of the picture
    /// is not known yet.
    pub fn of(weights: &[f32], channels_out: usize, channels_in: usize, kernel: Kernel) -> Self {
        let taps = kernel.taps();
        Self::from_fn(channels_out, channels_in, taps, |o, i, tap| weights[(o * channels_in + i) * taps + tap])
    }

    /// The weights as they were, `[c_out, c_in, taps]`.
    pub fn plain(&self) -> Vec<f32> {
        let place = |i: usize| {
            let (o, rest) = (i / (self.channels_in * self.taps), i % (self.channels_in * self.taps));
            (o / BLOCK * self.channels_in * self.taps + rest) * BLOCK + o % BLOCK
        };
        (0..self.channels_out * self.channels_in * self.taps).map(|i| self.values[place(i)]).collect()
    }

    /// Packs the weights of the data gradient: in and out exchanged, taps in reverse order.
    pub(super) fn transposed(weights: &[f32], channels_out: usize, channels_in: usize, kernel: Kernel) -> Self {
        let taps = kernel.taps();
        Self::from_fn(channels_in, channels_out, taps, |o, i, tap| {
            weights[(i * channels_in + o) * taps + taps - 1 - tap]
        })
    }

    fn from_fn(
        channels_out: usize,
        channels_in: usize,
        taps: usize,
        weight: impl Fn(usize, usize, usize) -> f32,
    ) -> Self {
        let mut values = vec![0.0; channels_out.div_ceil(BLOCK) * channels_in * taps * BLOCK];
        for o in 0..channels_out {
            for i in 0..channels_in {
                for tap in 0..taps {
                    let at = ((o / BLOCK * channels_in + i) * taps + tap) * BLOCK + o % BLOCK;
                    values[at] = weight(o, i, tap);
                }
            }
        }
        Self { values, channels_in, channels_out, taps }
    }

    /// The weights of the `block`-th group of 8 channels.
    pub(super) fn block(&self, block: usize) -> &[f32] {
        &self.values[block * self.block_len()..][..self.block_len()]
    }

    fn block_len(&self) -> usize {
        self.channels_in * self.taps * BLOCK
    }
}
