//! How bright a picture is: a count of its values, and how much of it is clipped.

use rayon::prelude::*;

/// A count of a picture's sRGB values.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Shares of the fullest of [`Histogram::BINS`] steps, of red, green and blue.
    pub bins: [Vec<f32>; 3],
    /// Share of pixels of which a channel is black.
    pub dark: f32,
    /// Share of pixels of which a channel is full.
    pub bright: f32,
}

/// Counts of one part of a picture.
#[derive(Clone)]
struct Counts {
    values: [[u32; 256]; 3],
    clipped: [u64; 2],
}

impl Histogram {
    /// Steps from black to white.
    pub const BINS: usize = 64;

    /// Counts an sRGB picture of 8 bits, `[y, x, 4]`.
    pub fn of_srgb8(rgba: &[u8]) -> Self {
        let none = || Counts { values: [[0; 256]; 3], clipped: [0; 2] };
        let parts = rgba.par_chunks(1 << 18).map(|part| part.chunks_exact(4).fold(none(), Counts::with));
        let Counts { values, clipped } = parts.reduce(none, Counts::and);
        let step = 256 / Self::BINS;
        let bins = values.map(|values| values.chunks(step).map(|bin| bin.iter().sum::<u32>()).collect::<Vec<_>>());
        // The ends may be many times as full as all else.
        let inner = bins.iter().flat_map(|bins| &bins[1..Self::BINS - 1]).copied().max().unwrap_or(0).max(1) as f32;
        let pixels = (rgba.len() / 4).max(1) as f32;
        let [dark, bright] = clipped.map(|count| count as f32 / pixels);
        Self { bins: bins.map(|bins| bins.into_iter().map(|n| (n as f32 / inner).min(1.0)).collect()), dark, bright }
    }
}

impl Counts {
    fn with(mut self, pixel: &[u8]) -> Self {
        for (values, value) in self.values.iter_mut().zip(pixel) {
            values[usize::from(*value)] += 1;
        }
        for (count, end) in self.clipped.iter_mut().zip([0, 255]) {
            *count += u64::from(pixel[..3].contains(&end));
        }
        self
    }

    fn and(mut self, other: Self) -> Self {
        for (mine, theirs) in self.values.iter_mut().flatten().zip(other.values.iter().flatten()) {
            *mine += theirs;
        }
        (0..2).for_each(|end| self.clipped[end] += other.clipped[end]);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_counted_and_clipped_ends_are_told() {
        let grey = [100, 100, 100, 255].repeat(6);
        let ends = [[0, 90, 255, 255].to_vec(), [255, 255, 255, 255].to_vec()].concat();
        let histogram = Histogram::of_srgb8(&[grey, ends].concat());
        assert_eq!((histogram.dark, histogram.bright), (0.125, 0.25));
        assert_eq!((histogram.bins[0][25], histogram.bins[1][25], histogram.bins[1][22]), (1.0, 1.0, 1.0 / 6.0));
        assert_eq!(Histogram::of_srgb8(&[]).dark, 0.0);
    }
}
