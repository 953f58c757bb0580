//! One view between the four corners: what they say of it, how its nets are given that.

use rayon::prelude::*;

use crate::field::{self, ViewGrid};

/// Numbers of the corners in `[v, u]` order, upper left to lower right.
pub const CORNERS: [usize; 4] = [0, 7, 56, 63];
/// Largest ray depth between four corners in px per view step: 14 px from one corner to the next.
pub const RANGE_PX: f32 = 2.0;
/// Ray depths that corners are compared at, over that range: 0.6 px from one to the next at a corner.
pub const LEVELS: usize = 48;
/// Colours, 0 … 1, that a unit of the colour net's answer adds to the blend.
pub const RESIDUAL_GAIN: f32 = 0.5;
/// The deviation of corners that show another place each is small against their colours.
const DEVIATION_GAIN: f32 = 4.0;

/// A view that is looked for, and the four that are given, upper left to lower right.
pub struct Between<'a> {
    /// Colours `[3, h, w]` of the corners, 0 … 1.
    pub corners: [&'a [f32]; 4],
    /// Number of the view that is looked for, `[v, u]` order.
    pub layer: usize,
    /// Width and height in pixels.
    pub size: [usize; 2],
}

impl Between<'_> {
    /// Channels of [`features`](Self::features).
    pub const AGREEMENT_CHANNELS: usize = 2 * LEVELS;
    /// Channels of [`colour_input`](Self::colour_input): four corners, the ray depth, and where the view lies.
    pub const COLOUR_CHANNELS: usize = 4 * 3 + 1 + 2;

    fn plane(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Steps from each corner to the view, right and down.
    pub fn offsets(&self) -> [(f32, f32); 4] {
        let (u, v) = steps(self.layer);
        CORNERS.map(|corner| {
            let (cu, cv) = steps(corner);
            (u - cu, v - cv)
        })
    }

    /// How much each corner counts: bilinear in the place of the view between them.
    pub fn shares(&self) -> [f32; 4] {
        let [(u, v), .., (opposite_u, opposite_v)] = self.offsets();
        let [right, down] = [u / (u - opposite_u), v / (v - opposite_v)];
        [(1.0 - right) * (1.0 - down), right * (1.0 - down), (1.0 - right) * down, right * down]
    }

    /// The four pixels of a corner around the end of the ray of pixel `i`, `d` px a view step away, and where between them.
    #[inline]
    fn place(&self, i: usize, (du, dv): (f32, f32), d: f32) -> ([usize; 4], [f32; 2]) {
        let w = self.size[0];
        field::corners(self.size, (i % w) as f32 + du * d, (i / w) as f32 + dv * d)
    }

    /// Mean and deviation of the corners' brightness at each of [`LEVELS`] ray depths (Kalantari et al. 2016, §3.1):
    /// where the depth is right they agree.
    ///
    /// # Shapes
    /// - result: `[2 × levels, h, w]`, means in −1 … 1, then deviations
    pub fn features(&self) -> Vec<f32> {
        let p = self.plane();
        let grey =
            self.corners.map(|rgb| (0..p).map(|i| (rgb[i] + rgb[p + i] + rgb[2 * p + i]) / 3.0).collect::<Vec<_>>());
        let offsets = self.offsets();
        let mut out = vec![0.0; 2 * LEVELS * p];
        let (means, deviations) = out.split_at_mut(LEVELS * p);
        let planes = means.par_chunks_exact_mut(p).zip(deviations.par_chunks_exact_mut(p)).enumerate();
        planes.for_each(|(level, (means, deviations))| {
            let d = RANGE_PX * (2.0 * level as f32 / (LEVELS - 1) as f32 - 1.0);
            for i in 0..p {
                let seen: [f32; 4] = std::array::from_fn(|c| {
                    let (pixels, shares) = self.place(i, offsets[c], d);
                    field::between(pixels.map(|pixel| grey[c][pixel]), shares)
                });
                let mean = seen.iter().sum::<f32>() / 4.0;
                let variance = seen.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / 4.0;
                means[i] = 2.0 * mean - 1.0;
                deviations[i] = DEVIATION_GAIN * variance.sqrt();
            }
        });
        out
    }

    /// The corners as the view sees them through its ray depths `[h, w]`: `[4 × 3, h, w]` in 0 … 1.
    pub fn warped(&self, depth: &[f32]) -> Vec<f32> {
        let (p, offsets) = (self.plane(), self.offsets());
        let mut out = vec![0.0; 12 * p];
        for (c, out) in out.chunks_exact_mut(3 * p).enumerate() {
            for (i, d) in depth.iter().enumerate() {
                let (pixels, shares) = self.place(i, offsets[c], *d);
                (0..3).for_each(|k| {
                    out[k * p + i] = field::between(pixels.map(|px| self.corners[c][k * p + px]), shares)
                });
            }
        }
        out
    }

    /// What the colour net is given: the warped corners in −1 … 1, the ray depths, and where the view lies, `[15, h, w]`.
    pub fn colour_input(&self, warped: &[f32], depth: &[f32]) -> Vec<f32> {
        let (p, (u, v)) = (self.plane(), steps(self.layer));
        let mut out: Vec<f32> = warped.iter().map(|value| 2.0 * value - 1.0).collect();
        out.extend(depth.iter().map(|d| d / RANGE_PX));
        [u, v].iter().for_each(|step| out.extend(std::iter::repeat_n(step / 4.0, p)));
        out
    }

    /// The warped corners, each as much as it counts: `[3, h, w]`.
    pub fn blended(&self, warped: &[f32]) -> Vec<f32> {
        let (n, shares) = (3 * self.plane(), self.shares());
        (0..n).map(|i| (0..4).map(|c| shares[c] * warped[c * n + i]).sum()).collect()
    }
}

/// Steps of a view from the reference view, right and down.
fn steps(layer: usize) -> (f32, f32) {
    let grid = ViewGrid::PAPER;
    let offset = grid.offset(grid.view_from_layer(layer));
    (offset.du, offset.dv)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [12, 8];

    #[test]
    fn shares_are_all_of_a_corner_at_it_and_sum_to_one() {
        let colours = vec![0.5; 3 * 96];
        let at = |layer| Between { corners: [&colours[..]; 4], layer, size: SIZE }.shares();
        for (corner, layer) in CORNERS.into_iter().enumerate() {
            assert!(at(layer).iter().enumerate().all(|(c, share)| *share == f32::from(u8::from(c == corner))));
        }
        assert!((at(27).iter().sum::<f32>() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn corners_of_a_plane_agree_at_its_depth_alone() {
        let d = RANGE_PX * (2.0 * 30.0 / (LEVELS - 1) as f32 - 1.0);
        let seen = |layer: usize| -> Vec<f32> {
            let (u, v) = steps(layer);
            let value = |x: f32, y: f32| 0.5 + 0.2 * (0.9 * x).sin() + 0.2 * (1.3 * y + 0.4 * x).cos();
            let one: Vec<f32> = (0..96).map(|i| value((i % 12) as f32 + u * d, (i / 12) as f32 + v * d)).collect();
            [&one[..], &one, &one].concat()
        };
        let views = CORNERS.map(seen);
        let between = Between { corners: views.each_ref().map(|v| &v[..]), layer: 36, size: SIZE };
        let features = between.features();
        let middle = 4 * 12 + 6;
        let deviation = |level: usize| features[(LEVELS + level) * 96 + middle];
        let best = (0..LEVELS).min_by(|a, b| deviation(*a).total_cmp(&deviation(*b))).unwrap();
        assert!(best.abs_diff(30) <= 1, "{best}");
    }
}
