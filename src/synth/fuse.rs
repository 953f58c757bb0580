//! The depth that a phone measured together with the depth net's.

use super::resample::{Filter, resample};
use super::upsample;
use crate::field::{DisparityMap, View};
use crate::job::{Cancelled, Job};

/// Least correlation at which the net may set the phone's scale.
const AGREES: f32 = 0.2;

/// The phone's order and relief, on the scale that fits the net best; edges from the photo.
///
/// The phone's map is affine-unknown (larger is nearer). Where the two contradict each other, the phone's map is
/// given the spread of the net's.
///
/// # Errors
/// Cancelled.
pub fn fuse(net: &DisparityMap, phone: &DisparityMap, guide: &View, job: &Job) -> Result<DisparityMap, Cancelled> {
    let size = net.size.map(|side| side as usize);
    let phone_small = resample::<1>(&phone.disparity_px, phone.size.map(|side| side as usize), size, Filter::Linear);
    let (gain, shift) = affine_fit(&phone_small, &net.disparity_px);
    let ratio = phone.size[0] as f32 / net.size[0] as f32;
    let disparity_px = phone.disparity_px.iter().map(|d| (gain * d + shift) * ratio).collect();
    upsample::to_guide(&DisparityMap { size: phone.size, disparity_px }, guide, job)
}

/// Gain and shift that bring `from` nearest to `to` (least squares), with the gain kept positive.
fn affine_fit(from: &[f32], to: &[f32]) -> (f32, f32) {
    let n = from.len() as f32;
    let mean = |values: &[f32]| values.iter().sum::<f32>() / n;
    let (mf, mt) = (mean(from), mean(to));
    let spread = |values: &[f32], m: f32| (values.iter().map(|v| (v - m).powi(2)).sum::<f32>() / n).sqrt();
    let (sf, st) = (spread(from, mf), spread(to, mt));
    if sf < 1e-6 {
        return (1.0, mt - mf);
    }
    let covariance = from.iter().zip(to).map(|(f, t)| (f - mf) * (t - mt)).sum::<f32>() / n;
    let agreement = if st < 1e-6 { 0.0 } else { covariance / (sf * st) };
    let gain = if agreement > AGREES { covariance / (sf * sf) } else { st.max(0.1) / sf };
    (gain, mt - gain * mf)
}

#[cfg(test)]
mod tests {
    use super::*;

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
