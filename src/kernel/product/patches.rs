//! The patches of a picture that a convolution multiplies its weights with, as columns of a matrix.

use std::ops::Range;

/// A convolution's shape: a picture `[channels, rows, columns]` and a kernel with its strides, dilations and zero padding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patches {
    /// Channels of the picture.
    pub channels: usize,
    /// Rows and columns of the picture.
    pub size: [usize; 2],
    /// Rows and columns of the kernel.
    pub kernel: [usize; 2],
    /// Pixels from one patch to the next, down and across.
    pub stride: [usize; 2],
    /// Pixels from one tap to the next, down and across.
    pub dilation: [usize; 2],
    /// Zeros above and to the left.
    pub before: [usize; 2],
    /// Rows and columns of the result.
    pub output: [usize; 2],
}

impl Patches {
    /// Values of the padded picture along an axis that the kernel passes over.
    pub(super) fn reach(&self, axis: usize) -> usize {
        (self.output[axis].max(1) - 1) * self.stride[axis] + (self.kernel[axis].max(1) - 1) * self.dilation[axis] + 1
    }

    /// Values in a patch, `[channel][row][column]`.
    pub fn depth(&self) -> usize {
        self.channels * self.kernel[0] * self.kernel[1]
    }

    /// How many patches there are, row by row.
    pub fn pixels(&self) -> usize {
        self.output[0] * self.output[1]
    }

    /// Values of the picture.
    pub fn input_len(&self) -> usize {
        self.channels * self.size[0] * self.size[1]
    }

    /// Writes the patches of `pixels` as columns of `target` `[depth][width]`, which is 0 before.
    pub(super) fn pack(&self, x: &[f32], pixels: Range<usize>, target: &mut [f32], width: usize) {
        let [height, row_len] = self.size;
        let mut rows = target.chunks_exact_mut(width);
        for plane in x.chunks_exact(height * row_len) {
            for tap in 0..self.kernel[0] * self.kernel[1] {
                let Some(target) = rows.next() else { return };
                self.pack_tap(plane, tap, pixels.clone(), target);
            }
        }
    }

    /// One tap of one channel for all patches, row by row of the result.
    fn pack_tap(&self, plane: &[f32], tap: usize, pixels: Range<usize>, target: &mut [f32]) {
        let [height, row_len] = self.size;
        let offset = [tap / self.kernel[1] * self.dilation[0], tap % self.kernel[1] * self.dilation[1]];
        let (mut pixel, columns) = (pixels.start, self.output[1]);
        while pixel < pixels.end {
            let (y, x) = (pixel / columns, pixel % columns);
            let count = (columns - x).min(pixels.end - pixel);
            let target = &mut target[pixel - pixels.start..][..count];
            pixel += count;
            let row = (y * self.stride[0] + offset[0]).wrapping_sub(self.before[0]);
            if row >= height {
                continue;
            }
            let source = &plane[row * row_len..][..row_len];
            // Columns of the patches that lie in the picture.
            let at = |x: usize| x * self.stride[1] + offset[1];
            let inside = |x: &usize| (self.before[1]..self.before[1] + row_len).contains(&at(*x));
            let skipped = (x..x + count).take_while(|x| at(*x) < self.before[1]).count();
            let Some(first) = Some(x + skipped).filter(inside) else { continue };
            let source = &source[at(first) - self.before[1]..];
            let target = &mut target[skipped..];
            if self.stride[1] == 1 {
                let n = source.len().min(target.len());
                target[..n].copy_from_slice(&source[..n]);
            } else {
                target
                    .iter_mut()
                    .zip(source.iter().step_by(self.stride[1]))
                    .for_each(|(target, value)| *target = *value);
            }
        }
    }
}
