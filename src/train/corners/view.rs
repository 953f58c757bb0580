//! How the corners, warped to a view between them, move with its ray depths.

use plenoscope::synth::corners::Between;

use crate::warp::{sample, tap};

/// Adds to `gradient` `[h, w]` what a gradient with respect to [`Between::warped`] is with respect to the ray depths.
pub fn warped_gradient(view: &Between<'_>, depth: &[f32], of_warped: &[f32], gradient: &mut [f32]) {
    let ([w, h], p) = (view.size, depth.len());
    for (c, (du, dv)) in view.offsets().into_iter().enumerate() {
        for (i, d) in depth.iter().enumerate() {
            let (x, y) = (tap((i % w) as f32 + du * d, w), tap((i / w) as f32 + dv * d, h));
            for k in 0..3 {
                let (_, dx, dy) = sample(&view.corners[c][k * p..][..p], w, x, y);
                gradient[i] += of_warped[(3 * c + k) * p + i] * (dx * du + dy * dv);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    const SIZE: [usize; 2] = [12, 8];

    fn random(seed: u64, n: usize) -> Vec<f32> {
        let mut rng = Rng::new(seed, 0);
        (0..n).map(|_| rng.unit()).collect()
    }

    #[test]
    fn the_gradient_is_that_of_finite_differences() {
        let colours: Vec<Vec<f32>> = (0..4).map(|c| random(c, 3 * 96)).collect();
        let corners: [&[f32]; 4] = std::array::from_fn(|c| &colours[c][..]);
        let between = Between { corners, layer: 18, size: SIZE };
        let weights = random(9, 12 * 96);
        let depth: Vec<f32> = random(5, 96).iter().map(|d| 0.6 * d - 0.3).collect();
        let value =
            |depth: &[f32]| -> f64 { between.warped(depth).iter().zip(&weights).map(|(a, b)| f64::from(a * b)).sum() };
        let mut gradient = vec![0.0; 96];
        warped_gradient(&between, &depth, &weights, &mut gradient);
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
