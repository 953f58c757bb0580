//! The photo as linear light: read where it lies, or reduced to another size.

use std::sync::Arc;

use rayon::prelude::*;

use crate::field::{Photo, PhotoPixels, Transfer};

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
    Eight { size: [u32; 2], px: Arc<[u8]>, transfer: Transfer },
    Sixteen { size: [u32; 2], px: Arc<[u16]>, transfer: Transfer },
    Linear { size: [u32; 2], px: Arc<[[f32; 3]]> },
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

    pub(super) fn size(&self) -> [u32; 2] {
        match self {
            Self::Eight { size, .. } | Self::Sixteen { size, .. } | Self::Linear { size, .. } => *size,
        }
    }

    /// One pixel.
    #[inline]
    pub(super) fn at(&self, x: usize, y: usize) -> [f32; 3] {
        let at = y * self.size()[0] as usize + x;
        match self {
            Self::Eight { px, transfer, .. } => std::array::from_fn(|c| transfer.linear_from_8(c, px[at * 4 + c])),
            Self::Sixteen { px, transfer, .. } => std::array::from_fn(|c| transfer.linear_from_16(c, px[at * 4 + c])),
            Self::Linear { px, .. } => px[at],
        }
    }

    /// Pixels of a row from `x`, as many as fit into `out`; outside the picture the edge goes on.
    pub(super) fn row(&self, x: i32, y: i32, out: &mut [[f32; 3]]) {
        let [width, height] = self.size().map(|s| s as i32);
        let y = y.clamp(0, height - 1) as usize;
        let columns = (x..).map(|x| x.clamp(0, width - 1) as usize);
        let start = y * width as usize;
        match self {
            Self::Eight { px, transfer, .. } => out.iter_mut().zip(columns).for_each(|(pixel, x)| {
                let at = (start + x) * 4;
                *pixel = std::array::from_fn(|c| transfer.linear_from_8(c, px[at + c]));
            }),
            Self::Sixteen { px, transfer, .. } => out.iter_mut().zip(columns).for_each(|(pixel, x)| {
                let at = (start + x) * 4;
                *pixel = std::array::from_fn(|c| transfer.linear_from_16(c, px[at + c]));
            }),
            Self::Linear { px, .. } => out.iter_mut().zip(columns).for_each(|(pixel, x)| *pixel = px[start + x]),
        }
    }

    /// The same at a smaller size: each pixel is the mean of the area that it covers.
    pub(super) fn reduced(&self, size: [u32; 2]) -> Self {
        if size == self.size() {
            return self.clone();
        }
        let [cols, rows] = [0, 1].map(|axis| areas(self.size()[axis], size[axis]));
        let width = size[0] as usize;
        let mut px = vec![[0.0f32; 3]; width * size[1] as usize];
        px.par_chunks_mut(width).zip(&rows).for_each(|(out, row)| {
            let mut source = vec![[0.0; 3]; self.size()[0] as usize];
            let mut sum = vec![[0.0f32; 3]; source.len()];
            for (i, &share) in row.shares.iter().enumerate() {
                self.row(0, (row.first + i) as i32, &mut source);
                sum.iter_mut().zip(&source).for_each(|(s, p)| (0..3).for_each(|c| s[c] += share * p[c]));
            }
            for (pixel, col) in out.iter_mut().zip(&cols) {
                for (p, &share) in sum[col.first..].iter().zip(&col.shares) {
                    (0..3).for_each(|c| pixel[c] += share * p[c]);
                }
            }
        });
        Self::Linear { size, px: px.into() }
    }
}

/// The source pixels under one target pixel, with shares that add up to 1.
struct Area {
    first: usize,
    shares: Vec<f32>,
}

fn areas(source: u32, target: u32) -> Vec<Area> {
    let scale = f64::from(source) / f64::from(target);
    let area = |i: u32| {
        let (from, to) = (f64::from(i) * scale, (f64::from(i) + 1.0) * scale);
        let first = from.floor() as usize;
        let last = (to.ceil() as usize).clamp(first + 1, source as usize);
        let share = |p: usize| ((to.min(p as f64 + 1.0) - from.max(p as f64)) / scale) as f32;
        Area { first, shares: (first..last).map(share).collect() }
    };
    (0..target).map(area).collect()
}
