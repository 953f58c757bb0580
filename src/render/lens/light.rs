//! The photo as linear light: read where it lies, or reduced to another size.

use std::sync::Arc;

use rayon::prelude::*;

use crate::field::{Filter, Photo, PhotoPixels, Size, Taps, Transfer, pixels, sides};
use crate::job::{Cancel, Cancelled};

/// In which primaries the picture is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Space {
    /// The photo's own, with all its bits: for files.
    #[default]
    Own,
    /// Those of sRGB, from the working copy: for screens.
    Srgb,
}

impl Space {
    /// The curve between a photo's stored values and light.
    pub(super) fn transfer(self, photo: &Photo) -> Transfer {
        match self {
            Self::Own => Transfer::of_profile(photo.metadata().icc.as_deref()),
            Self::Srgb => Transfer::srgb(),
        }
    }
}

/// Where light comes from.
#[derive(Clone)]
pub(super) enum Light {
    Eight { size: Size, px: Arc<Vec<u8>>, transfer: Transfer },
    Sixteen { size: Size, px: Arc<Vec<u16>>, transfer: Transfer },
    Linear { size: Size, px: Arc<[[f32; 3]]> },
}

impl Light {
    pub(super) fn of(photo: &Photo, space: Space) -> Self {
        let (size, transfer) = (photo.size(), space.transfer(photo));
        match photo.pixels() {
            _ if space == Space::Srgb => Self::Eight { size, px: Arc::clone(photo.srgb8()), transfer },
            PhotoPixels::Eight(px) => Self::Eight { size, px: Arc::clone(px), transfer },
            PhotoPixels::Sixteen(px) => Self::Sixteen { size, px: Arc::clone(px), transfer },
        }
    }

    pub(super) fn size(&self) -> Size {
        match self {
            Self::Eight { size, .. } | Self::Sixteen { size, .. } | Self::Linear { size, .. } => *size,
        }
    }

    /// One pixel.
    #[inline]
    pub(super) fn at(&self, x: usize, y: usize) -> [f32; 3] {
        self.pixel(y * self.size()[0] as usize + x)
    }

    /// The pixel of a number `y · width + x`.
    #[inline]
    pub(super) fn pixel(&self, at: usize) -> [f32; 3] {
        match self {
            Self::Eight { px, transfer, .. } => std::array::from_fn(|c| transfer.linear_from_8(c, px[at * 4 + c])),
            Self::Sixteen { px, transfer, .. } => std::array::from_fn(|c| transfer.linear_from_16(c, px[at * 4 + c])),
            Self::Linear { px, .. } => px[at],
        }
    }

    /// Pixels of a row from `x`, as many as fit into `out`; outside the picture the edge goes on.
    pub(super) fn row(&self, x: i32, y: i32, out: &mut [[f32; 3]]) {
        let [width, height] = self.size().map(|s| s as i32);
        let start = y.clamp(0, height - 1) as usize * width as usize;
        // What lies beside the picture, and what lies in it.
        let left = (-x).clamp(0, out.len() as i32) as usize;
        let inside = (width - x.max(0)).clamp(0, (out.len() - left) as i32) as usize;
        let (before, rest) = out.split_at_mut(left);
        let (within, after) = rest.split_at_mut(inside);
        before.fill_with(|| self.pixel(start));
        after.fill_with(|| self.pixel(start + width as usize - 1));
        let first = start + x.clamp(0, width - 1) as usize;
        match self {
            Self::Eight { px, transfer, .. } => {
                let pixels = px.as_chunks::<4>().0[first..].iter().zip(within);
                pixels.for_each(|(px, out)| *out = std::array::from_fn(|c| transfer.linear_from_8(c, px[c])));
            }
            Self::Sixteen { px, transfer, .. } => {
                let pixels = px.as_chunks::<4>().0[first..].iter().zip(within);
                pixels.for_each(|(px, out)| *out = std::array::from_fn(|c| transfer.linear_from_16(c, px[c])));
            }
            Self::Linear { px, .. } => within.copy_from_slice(&px[first..first + inside]),
        }
    }

    /// The same at a smaller size: each pixel is the mean of the area that it covers.
    pub(super) fn reduced(&self, size: Size, cancel: &Cancel) -> Result<Self, Cancelled> {
        if size == self.size() {
            return Ok(self.clone());
        }
        let [cols, rows] = [0, 1].map(|axis| Taps::new(sides(self.size())[axis], sides(size)[axis], Filter::Area));
        let width = size[0] as usize;
        let mut px = vec![[0.0f32; 3]; pixels(size)];
        px.par_chunks_mut(width).enumerate().try_for_each(|(y, out)| {
            cancel.check()?;
            let (first, shares) = rows.of(y);
            let mut source = vec![[0.0; 3]; self.size()[0] as usize];
            let mut sum = vec![[0.0f32; 3]; source.len()];
            for (i, &share) in shares.iter().enumerate() {
                self.row(0, (first + i) as i32, &mut source);
                sum.iter_mut().zip(&source).for_each(|(s, p)| (0..3).for_each(|c| s[c] += share * p[c]));
            }
            for (x, pixel) in out.iter_mut().enumerate() {
                let (first, shares) = cols.of(x);
                for (p, &share) in sum[first..].iter().zip(shares) {
                    (0..3).for_each(|c| pixel[c] += share * p[c]);
                }
            }
            Ok(())
        })?;
        Ok(Self::Linear { size, px: px.into() })
    }
}
