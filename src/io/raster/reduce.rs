//! Pictures that are too large to be kept: means of squares of their pixels, in the place where the pixels lie.

use super::{MAX_DECODED_BYTES, Raster, Samples};

impl Raster {
    /// As many pixels as may be kept. A picture of fewer stays what it is.
    pub(crate) fn reduced(mut self) -> Self {
        self.reduce_to(MAX_DECODED_BYTES);
        self
    }

    fn reduce_to(&mut self, bytes: u64) {
        let side = side(self.samples.bytes(), bytes);
        if side > 1 {
            self.size = match &mut self.samples {
                Samples::Eight(px) => means(px, self.size, side, |sum, count| ((sum + count / 2) / count) as u8),
                Samples::Sixteen(px) => means(px, self.size, side, |sum, count| ((sum + count / 2) / count) as u16),
            };
        }
    }

    /// Width and height as it is seen.
    pub(crate) fn upright_size(&self) -> [u32; 2] {
        let [width, height] = self.size;
        if self.orientation >= 5 { [height, width] } else { [width, height] }
    }
}

impl Samples {
    fn bytes(&self) -> u64 {
        match self {
            Self::Eight(px) => size_of_val(px.as_slice()) as u64,
            Self::Sixteen(px) => size_of_val(px.as_slice()) as u64,
        }
    }
}

/// Side of the squares of which one pixel is made.
fn side(bytes: u64, most: u64) -> usize {
    (1..).find(|side| bytes.div_ceil(side * side) <= most).unwrap_or(1) as usize
}

/// Each square becomes its mean, by `mean` of a sum and a count. What does not fill a square at the far edges is left out.
fn means<T: Copy + Into<u32>>(
    px: &mut Vec<[T; 4]>,
    [width, height]: [u32; 2],
    side: usize,
    mean: impl Fn(u32, u32) -> T,
) -> [u32; 2] {
    let wide = width as usize;
    let [cols, rows] = [wide, height as usize].map(|length| (length / side).max(1));
    let across = side.min(wide);
    let down = side.min(height as usize);
    let count = (across * down) as u32;
    for y in 0..rows {
        for x in 0..cols {
            let mut sum = [0u32; 4];
            for row in y * side..y * side + down {
                for from in &px[row * wide + x * side..][..across] {
                    sum.iter_mut().zip(from).for_each(|(sum, from)| *sum += (*from).into());
                }
            }
            // It lies before all that is still to be read.
            px[y * cols + x] = sum.map(|sum| mean(sum, count));
        }
    }
    px.truncate(cols * rows);
    px.shrink_to_fit();
    [cols as u32, rows as u32]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(size: [u32; 2], orientation: u8) -> Raster {
        let [w, h] = size;
        let px = (0..h).flat_map(|y| (0..w).map(move |x| [(10 * x) as u8, (20 * y) as u8, 7, 255])).collect();
        let samples = Samples::Eight(px);
        Raster { size, samples, has_alpha: false, icc: None, exif: None, xmp: None, orientation, warnings: Vec::new() }
    }

    #[test]
    fn squares_become_their_means_and_the_rest_is_left_out() {
        let mut raster = picture([7, 5], 6);
        assert_eq!(raster.upright_size(), [5, 7]);
        raster.reduce_to(7 * 5 * 4 / 4);
        assert_eq!((raster.size, raster.upright_size()), ([3, 2], [2, 3]));
        let Samples::Eight(px) = raster.samples else { unreachable!() };
        // Columns 0 and 1 are 0 and 10, rows 0 and 1 are 0 and 20.
        assert_eq!(px, [[5, 10], [25, 10], [45, 10], [5, 50], [25, 50], [45, 50]].map(|[r, g]| [r, g, 7, 255]));
    }

    #[test]
    fn a_picture_that_may_be_kept_stays_and_a_thin_one_becomes_shorter() {
        let mut kept = picture([6, 4], 1);
        kept.reduce_to(6 * 4 * 4);
        assert_eq!(kept.size, [6, 4]);
        let mut thin = picture([9, 1], 1);
        thin.reduce_to(9);
        assert_eq!(thin.size, [4, 1]);
    }
}
