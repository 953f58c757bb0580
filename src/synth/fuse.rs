//! The depth that a phone measured together with the depth net's.

use super::{SynthError, upsample};
use crate::field::{DisparityMap, Filter, Moments, View, correlation, resample};
use crate::job::Job;

/// Least correlation at which the net may set the phone's scale.
const AGREES: f32 = 0.2;

/// The phone's order and relief, on the scale that fits the net best; edges from the photo.
///
/// The phone's map is affine-unknown (larger is nearer). Where the two contradict each other, the phone's map is
/// given the spread of the net's.
///
/// # Errors
/// Cancelled; values beyond all measure.
pub fn fuse(net: &DisparityMap, phone: &DisparityMap, guide: &View, job: &Job) -> Result<DisparityMap, SynthError> {
    let phone_small = resample::<1>(phone.disparity_px(), phone.size(), net.size(), Filter::Linear);
    let (gain, shift) = affine_fit(&phone_small, net.disparity_px());
    let ratio = net.scale_to(phone.size());
    let disparity_px = phone.disparity_px().iter().map(|d| (gain * d + shift) * ratio).collect();
    upsample::to_guide(&DisparityMap::new(phone.size(), disparity_px)?, guide, job)
}

/// How far the depth net and another map of the same picture agree on what is near: their correlation, −1 … 1, at the
/// net's size.
pub fn agreement(net: &DisparityMap, other: &DisparityMap) -> f32 {
    let other = resample::<1>(other.disparity_px(), other.size(), net.size(), Filter::Linear);
    correlation(other.iter().copied().zip(net.disparity_px().iter().copied()))
}

/// Gain and shift that bring `from` nearest to `to` (least squares), with the gain kept positive.
fn affine_fit(from: &[f32], to: &[f32]) -> (f32, f32) {
    let moments = Moments::of(from.iter().copied().zip(to.iter().copied()));
    let ([from_mean, to_mean], [from_spread, to_spread]) = (moments.mean, moments.spread);
    if from_spread < 1e-6 {
        return (1.0, (to_mean - from_mean) as f32);
    }
    let agrees = moments.correlation() > AGREES;
    let gain = if agrees { moments.covariance / from_spread.powi(2) } else { to_spread.max(0.1) / from_spread };
    (gain as f32, (to_mean - gain * from_mean) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_of_other_sizes_agree_or_contradict_each_other() {
        let ramp = |size: [u32; 2], gain: f32| {
            let values = (0..size[0] * size[1]).map(|i| gain * (i % size[0]) as f32 / size[0] as f32);
            DisparityMap::new(size, values.collect()).unwrap()
        };
        let net = ramp([30, 20], 1.0);
        assert!(agreement(&net, &ramp([90, 60], 4.0)) > 0.99);
        assert!(agreement(&net, &ramp([90, 60], -0.1)) < -0.99);
        assert_eq!(agreement(&net, &DisparityMap::constant([9, 6], 0.5)), 0.0);
    }

    #[test]
    fn the_fit_finds_gain_and_shift_and_never_turns_near_into_far() {
        let from: Vec<f32> = (0..100).map(|i| i as f32 / 10.0).collect();
        let to: Vec<f32> = from.iter().map(|f| 0.3 * f - 1.0).collect();
        let (gain, shift) = affine_fit(&from, &to);
        assert!((gain - 0.3).abs() < 1e-4 && (shift + 1.0).abs() < 1e-3);
        let turned: Vec<f32> = to.iter().map(|t| -t).collect();
        assert!(affine_fit(&from, &turned).0 > 0.0);
        assert!(affine_fit(&[1.0; 9], &[2.0; 9]).0.is_finite());
    }
}
