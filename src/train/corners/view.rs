//! One view between the four corners, in plain Rust: what the corners say of it, and how that moves with its ray depths.

use crate::nets::{CORNER_LEVELS, CORNER_RANGE_PX};
use crate::scenes::steps;
use crate::warp::{Tap, sample, tap};

/// The deviation of corners that show another place each is small against their colours.
const DEVIATION_GAIN: f32 = 4.0;

/// A view that is looked for, and the four that are given, upper left to lower right.
pub struct Between<'a> {
    /// Colours `[3, h, w]` of the corners, 0 … 1.
    pub corners: [&'a [f32]; 4],
    /// Number of the view that is looked for, `[v, u]` order.
    pub layer: usize,
    /// Numbers of the corners.
    pub layers: [usize; 4],
    /// Width and height in pixels.
    pub size: [usize; 2],
}

impl Between<'_> {
    fn plane(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Steps from each corner to the view.
    fn offsets(&self) -> [(f32, f32); 4] {
        let (u, v) = steps(self.layer);
        self.layers.map(|corner| {
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

    /// Where pixel `i` of the view lies in a corner, its ray depth being `d` px per view step.
    #[inline]
    fn taps(&self, i: usize, (du, dv): (f32, f32), d: f32) -> [Tap; 2] {
        let [w, h] = self.size;
        [tap((i % w) as f32 + du * d, w), tap((i / w) as f32 + dv * d, h)]
    }

    /// Mean and deviation of the corners' brightness at each of [`CORNER_LEVELS`] ray depths (Kalantari et al. 2016, §3.1):
    /// where the depth is right they agree.
    ///
    /// # Shapes
    /// - result: `[2 × levels, h, w]`, means in −1 … 1, then deviations
    pub fn features(&self) -> Vec<f32> {
        let p = self.plane();
        let grey =
            self.corners.map(|rgb| (0..p).map(|i| (rgb[i] + rgb[p + i] + rgb[2 * p + i]) / 3.0).collect::<Vec<_>>());
        let offsets = self.offsets();
        let mut out = vec![0.0; 2 * CORNER_LEVELS * p];
        let (means, deviations) = out.split_at_mut(CORNER_LEVELS * p);
        for level in 0..CORNER_LEVELS {
            let d = CORNER_RANGE_PX * (2.0 * level as f32 / (CORNER_LEVELS - 1) as f32 - 1.0);
            for i in 0..p {
                let seen: [f32; 4] = std::array::from_fn(|c| {
                    let [x, y] = self.taps(i, offsets[c], d);
                    sample(&grey[c], self.size[0], x, y).0
                });
                let mean = seen.iter().sum::<f32>() / 4.0;
                let variance = seen.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / 4.0;
                means[level * p + i] = 2.0 * mean - 1.0;
                deviations[level * p + i] = DEVIATION_GAIN * variance.sqrt();
            }
        }
        out
    }

    /// The corners as the view sees them through its ray depths `[h, w]`: `[4 × 3, h, w]` in 0 … 1.
    pub fn warped(&self, depth: &[f32]) -> Vec<f32> {
        let (p, offsets) = (self.plane(), self.offsets());
        let mut out = vec![0.0; 12 * p];
        for (c, out) in out.chunks_exact_mut(3 * p).enumerate() {
            for (i, d) in depth.iter().enumerate() {
                let [x, y] = self.taps(i, offsets[c], *d);
                (0..3).for_each(|k| out[k * p + i] = sample(&self.corners[c][k * p..][..p], self.size[0], x, y).0);
            }
        }
        out
    }

    /// Adds to `gradient` `[h, w]` what a gradient with respect to [`Self::warped`] is with respect to the ray depths.
    pub fn warped_gradient(&self, depth: &[f32], of_warped: &[f32], gradient: &mut [f32]) {
        let (p, offsets) = (self.plane(), self.offsets());
        for (c, (du, dv)) in offsets.into_iter().enumerate() {
            for (i, d) in depth.iter().enumerate() {
                let [x, y] = self.taps(i, (du, dv), *d);
                for k in 0..3 {
                    let (_, dx, dy) = sample(&self.corners[c][k * p..][..p], self.size[0], x, y);
                    gradient[i] += of_warped[(3 * c + k) * p + i] * (dx * du + dy * dv);
                }
            }
        }
    }

    /// What the colour net is given: the warped corners in −1 … 1, the ray depths, and where the view lies, `[15, h, w]`.
    pub fn colour_input(&self, warped: &[f32], depth: &[f32]) -> Vec<f32> {
        let (p, (u, v)) = (self.plane(), steps(self.layer));
        let mut out: Vec<f32> = warped.iter().map(|value| 2.0 * value - 1.0).collect();
        out.extend(depth.iter().map(|d| d / CORNER_RANGE_PX));
        [u, v].iter().for_each(|step| out.extend(std::iter::repeat_n(step / 4.0, p)));
        out
    }

    /// The warped corners, each as much as it counts: `[3, h, w]`.
    pub fn blended(&self, warped: &[f32]) -> Vec<f32> {
        let (n, shares) = (3 * self.plane(), self.shares());
        (0..n).map(|i| (0..4).map(|c| shares[c] * warped[c * n + i]).sum()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::CORNERS;
    use crate::rng::Rng;

    const SIZE: [usize; 2] = [12, 8];

    fn random(seed: u64, n: usize) -> Vec<f32> {
        let mut rng = Rng::new(seed, 0);
        (0..n).map(|_| rng.unit()).collect()
    }

    #[test]
    fn shares_are_all_of_a_corner_at_it_and_sum_to_one() {
        let colours = random(1, 3 * 96);
        let at = |layer| Between { corners: [&colours[..]; 4], layer, layers: CORNERS, size: SIZE }.shares();
        for (corner, layer) in CORNERS.into_iter().enumerate() {
            assert!(at(layer).iter().enumerate().all(|(c, share)| *share == f32::from(u8::from(c == corner))));
        }
        assert!((at(27).iter().sum::<f32>() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn corners_of_a_plane_agree_at_its_depth_alone() {
        let d = CORNER_RANGE_PX * (2.0 * 30.0 / (CORNER_LEVELS - 1) as f32 - 1.0);
        let seen = |layer: usize| -> Vec<f32> {
            let (u, v) = steps(layer);
            let value = |x: f32, y: f32| 0.5 + 0.2 * (0.9 * x).sin() + 0.2 * (1.3 * y + 0.4 * x).cos();
            let one: Vec<f32> = (0..96).map(|i| value((i % 12) as f32 + u * d, (i / 12) as f32 + v * d)).collect();
            [&one[..], &one, &one].concat()
        };
        let views = CORNERS.map(seen);
        let between = Between { corners: views.each_ref().map(|v| &v[..]), layer: 36, layers: CORNERS, size: SIZE };
        let features = between.features();
        let middle = 4 * 12 + 6;
        let deviation = |level: usize| features[(CORNER_LEVELS + level) * 96 + middle];
        let best = (0..CORNER_LEVELS).min_by(|a, b| deviation(*a).total_cmp(&deviation(*b))).unwrap();
        assert!(best.abs_diff(30) <= 1, "{best}");
    }

    #[test]
    fn the_gradient_is_that_of_finite_differences() {
        let colours: Vec<Vec<f32>> = (0..4).map(|c| random(c, 3 * 96)).collect();
        let corners: [&[f32]; 4] = std::array::from_fn(|c| &colours[c][..]);
        let between = Between { corners, layer: 18, layers: CORNERS, size: SIZE };
        let weights = random(9, 12 * 96);
        let depth: Vec<f32> = random(5, 96).iter().map(|d| 0.6 * d - 0.3).collect();
        let value =
            |depth: &[f32]| -> f64 { between.warped(depth).iter().zip(&weights).map(|(a, b)| f64::from(a * b)).sum() };
        let mut gradient = vec![0.0; 96];
        between.warped_gradient(&depth, &weights, &mut gradient);
        let h = 1e-3;
        let mut near = 0;
        for i in 0..96 {
            let moved = |by: f32| {
                let mut depth = depth.clone();
                depth[i] += by;
                value(&depth)
            };
            let found = ((moved(h) - moved(-h)) / f64::from(2.0 * h)) as f32;
            // Not where a step crosses from one pixel to the next.
            near += usize::from((found - gradient[i]).abs() < 0.02 * (1.0 + found.abs()));
        }
        assert!(near >= 88, "{near} of 96");
    }
}
