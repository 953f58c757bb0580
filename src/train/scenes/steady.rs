//! Swept maps without their noise: grain that stands still in all views is taken for depth where there is little
//! texture.
//!
//! The weighted median of Ma et al. 2013: of what lies around a pixel, and the more of it the more alike its colour is.

use rayon::prelude::*;

use super::raster::{Raster, Rgb};

/// How far around a pixel is looked, as a share of the long side, and every which row and column of that.
const REACH_SHARE: f32 = 0.026;
const STRIDE: usize = 2;
/// Difference of colour, 0 … 1 over all channels, at which a neighbour counts e^−½.
const ALIKE: f32 = 0.1;
/// Deviation of the blur in px that takes the grain from the colours.
const GRAIN_PX: f32 = 1.0;

/// A map beside its photo of the same size.
pub fn steadied(map: &Raster<f32>, mut photo: Rgb) -> Raster<f32> {
    photo.blur(GRAIN_PX);
    let [w, h] = map.size;
    let reach = ((REACH_SHARE * w.max(h) as f32) as usize).max(STRIDE);
    let median = |i: usize| {
        let (x, y, own) = (i % w, i / w, photo.px[i]);
        let mut around: Vec<[f32; 2]> = (y.saturating_sub(reach)..=(y + reach).min(h - 1))
            .step_by(STRIDE)
            .flat_map(|y| (x.saturating_sub(reach)..=(x + reach).min(w - 1)).step_by(STRIDE).map(move |x| y * w + x))
            .map(|j| {
                let off: f32 = (0..3).map(|c| (photo.px[j][c] - own[c]).powi(2)).sum();
                [map.px[j], (-off / (2.0 * ALIKE * ALIKE)).exp()]
            })
            .collect();
        weighted_median(&mut around)
    };
    Raster { size: map.size, px: (0..w * h).into_par_iter().map(median).collect() }
}

/// Of values and their weights, at least one of them.
fn weighted_median(values: &mut [[f32; 2]]) -> f32 {
    values.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let half = values.iter().map(|[_, weight]| weight).sum::<f32>() / 2.0;
    let mut sum = 0.0;
    let reached = values.iter().find(|[_, weight]| {
        sum += weight;
        sum >= half
    });
    reached.or(values.last()).map_or(0.0, |[value, _]| *value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn specks_and_stripes_go_and_edges_of_colour_stay() {
        let size = [240, 180];
        let near = |x: usize| x >= 120;
        let photo = Raster::from_fn(size, |x, _| if near(x) { [0.8, 0.7, 0.2] } else { [0.2, 0.4, 0.3] });
        let truth = Raster::from_fn(size, |x, _| if near(x) { 0.6f32 } else { -0.4 });
        let mut rng = Rng::new(3, 0);
        let mut grain = |y: usize, true_one: f32| {
            let is_grain = y.is_multiple_of(6) || rng.chance(0.15);
            if is_grain { rng.range(-1.0, 1.0) } else { true_one }
        };
        let noisy = Raster::from_fn(size, |x, y| grain(y, truth.at(x, y)));
        let wrong = |map: &Raster<f32>| map.px.iter().zip(&truth.px).filter(|(a, b)| (*a - *b).abs() > 0.05).count();
        let steady = steadied(&noisy, photo);
        assert!(wrong(&noisy) > 11_000 && wrong(&steady) < 250, "{} of {}", wrong(&steady), wrong(&noisy));
        assert!((0..180).all(|y| steady.at(117, y) < 0.0 && steady.at(123, y) > 0.0));
    }

    #[test]
    fn the_weights_count() {
        assert_eq!(weighted_median(&mut [[3.0, 0.1], [1.0, 1.0], [2.0, 0.2]]), 1.0);
        assert_eq!(weighted_median(&mut [[3.0, 1.0], [1.0, 1.0], [2.0, 1.0]]), 2.0);
    }
}
