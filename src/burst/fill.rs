//! Inverse depths everywhere: what was measured, and where nothing could be, the depth net's map fitted to it.

use super::sweep::Measured;
use crate::field::{Moments, Raster, View, sides};
use crate::job::{Cancel, Cancelled};
use crate::synth::upsample::EdgeAware;

/// How far what was measured flows over even colour, as a share of the long side: beside it, and where nothing else is.
const REACH: [f32; 2] = [0.04, 0.4];
/// What a measurement counts at least: better than nothing.
const LEAST: f32 = 1e-3;
/// Certainty that was not found nearby: above this, a guess counts as much as what flows in.
const SCARCE: f32 = 0.02;
/// Least correlation of a guess with what was measured at which it says anything.
const AGREES: f32 = 0.3;
/// Rounds of reweighting of the fit.
const ROUNDS: usize = 6;

/// Inverse depths of every pixel. `guess` orders the same pixels, larger is nearer.
///
/// # Errors
/// Cancelled.
pub fn filled(
    measured: &Measured,
    guess: Option<&Raster<f32>>,
    photo: &View,
    cancel: &Cancel,
) -> Result<Raster<f32>, Cancelled> {
    let (size, long) = (photo.size(), photo.size()[0].max(photo.size()[1]) as f32);
    let difference = |a: usize, b: usize| {
        let [a, b] = [photo.pixels()[a], photo.pixels()[b]];
        (0..3).map(|c| f32::from(a[c].abs_diff(b[c]))).sum::<f32>() / 765.0
    };
    let guess = guess.and_then(|guess| fitted(guess, measured));
    let zero = Raster::filled(size, 0.0);
    let base = guess.as_ref().unwrap_or(&zero);
    let pixels = || measured.inverse_depth.pixels().iter().zip(measured.certain.pixels()).zip(base.pixels());
    let flow = |reach: f32| -> Result<Vec<[f32; 2]>, Cancelled> {
        let mut flow: Vec<[f32; 2]> = pixels().map(|((rho, c), b)| [(rho - b) * c.max(LEAST), c.max(LEAST)]).collect();
        EdgeAware::new(sides(size), reach * long, difference).smooth(&mut flow, cancel)?;
        Ok(flow)
    };
    let (near, far) = (flow(REACH[0])?, flow(REACH[1])?);
    let of = |i: usize| {
        let certain = measured.certain.pixels()[i];
        let ([a, ca], [b, cb]) = (near[i], far[i]);
        let wide = b / cb;
        // Nearby first; where hardly anything was measured nearby, from farther away, or not at all where a guess is.
        let wide = if guess.is_some() { wide * cb / (cb + SCARCE) } else { wide };
        let flowed = (a + wide * SCARCE) / (ca + SCARCE);
        let unmeasured = base.pixels()[i] + flowed;
        unmeasured + (measured.inverse_depth.pixels()[i] - unmeasured) * certain
    };
    let [w, _] = sides(size);
    Ok(Raster::par_from_fn(size, |x, y| of(y * w + x)))
}

/// The guess with the gain and shift that bring it nearest to what was measured; none where both contradict each other.
pub fn fitted(guess: &Raster<f32>, measured: &Measured) -> Option<Raster<f32>> {
    let pairs = || guess.pixels().iter().zip(measured.inverse_depth.pixels()).zip(measured.certain.pixels());
    let sure = pairs().filter(|(_, certain)| **certain > 0.5).map(|((a, b), _)| (*a, *b));
    let moments = Moments::of(sure);
    if moments.correlation() < AGREES {
        return None;
    }
    let (mut gain, mut shift) = (0.0f64, 0.0f64);
    for round in 0..ROUNDS {
        // Weighted least squares; from the second round on by how far off each is (a sum of distances).
        let mut sums = [0.0f64; 5];
        for ((a, b), certain) in pairs() {
            let (a, b) = (f64::from(*a), f64::from(*b));
            let off = (gain * a + shift - b).abs();
            let usual = 0.05 * f64::from(moments.spread[1] as f32) + 1e-9;
            let weight = f64::from(*certain) * if round == 0 { 1.0 } else { 1.0 / (1.0 + off / usual) };
            [weight, weight * a, weight * b, weight * a * a, weight * a * b]
                .iter()
                .zip(&mut sums)
                .for_each(|(v, s)| *s += v);
        }
        let [n, a, b, aa, ab] = sums;
        let spread = aa - a * a / n;
        if n < 1.0 || spread < 1e-12 {
            return None;
        }
        gain = (ab - a * b / n) / spread;
        shift = (b - gain * a) / n;
    }
    (gain > 0.0).then(|| guess.clone().map(|a| (gain * f64::from(a) + shift) as f32))
}
