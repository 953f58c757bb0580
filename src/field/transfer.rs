//! The transfer curve of a colour space as tables: linear light from stored values and back, exact both ways.
//!
//! A photo is refocused in its own primaries (Display P3 stays Display P3): only the curve is undone for the sum.

use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use super::color::linear_from_srgb;

/// Below 2⁻²⁰ every curve that is met rounds to the first few values.
const LOWEST_BITS: u32 = (127 - 20) << 23;

/// Linear light from stored values, and the stored value nearest to a linear light.
#[derive(Clone)]
pub struct Transfer(Arc<[Curve; 3]>);

/// One channel: linear light of all 65,536 values, and where two neighbours meet.
#[derive(Clone)]
struct Curve {
    linear: Arc<[f32]>,
    /// Of the 256 values of 8 bits, close together: they are read for every pixel of a photo.
    linear_8: [f32; 256],
    eight: Arc<Inverse>,
    sixteen: Arc<Inverse>,
}

/// Finds a stored value by a start table over the float's leading bits, then a few steps.
struct Inverse {
    /// Bits of a float below the ones that index the start table.
    dropped: u32,
    start: Vec<u16>,
    /// `upper[i]`: the light above which the value is `i + 1` or more.
    upper: Vec<f32>,
}

impl std::fmt::Debug for Transfer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Transfer").field(&self.0[0].linear[32768]).finish()
    }
}

impl Default for Transfer {
    fn default() -> Self {
        Self::srgb()
    }
}

impl Transfer {
    /// The curve of sRGB and Display P3 (IEC 61966-2-1).
    pub fn srgb() -> Self {
        static CURVE: LazyLock<Transfer> = LazyLock::new(|| {
            let curve = Curve::new(linear_from_srgb);
            Transfer(Arc::new([curve.clone(), curve.clone(), curve]))
        });
        CURVE.clone()
    }

    /// The curves of an ICC profile; sRGB's where there is none, or none that can be read.
    pub fn of_profile(icc: Option<&[u8]>) -> Self {
        // Its tables take some milliseconds, and one photo's are asked for again and again.
        static LAST: Mutex<Option<(Box<[u8]>, Transfer)>> = Mutex::new(None);
        let Some(icc) = icc else { return Self::srgb() };
        let last = || LAST.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, known)) = last().as_ref().filter(|(profile, _)| **profile == *icc) {
            return known.clone();
        }
        let made = Self::from_icc(icc).unwrap_or_else(Self::srgb);
        *last() = Some((icc.into(), made.clone()));
        made
    }

    fn from_icc(icc: &[u8]) -> Option<Self> {
        let profile = moxcms::ColorProfile::new_from_slice(icc).ok()?;
        let trc = [profile.red_trc.as_ref()?, profile.green_trc.as_ref()?, profile.blue_trc.as_ref()?];
        let mut curves = Vec::with_capacity(3);
        for (channel, curve) in trc.iter().enumerate() {
            if channel > 0 && *curve == trc[channel - 1] {
                curves.push(Curve::clone(&curves[channel - 1]));
                continue;
            }
            let evaluator = curve.make_linear_evaluator().ok()?;
            curves.push(Curve::new(|v| evaluator.evaluate_value(v)));
        }
        let strict = |c: &Curve| c.linear.windows(2).all(|w| w[0] <= w[1]) && c.linear[65535] > 0.5;
        let curves: [Curve; 3] = curves.try_into().ok()?;
        curves.iter().all(strict).then(|| Self(Arc::new(curves)))
    }

    /// Linear light of an 8-bit value in a channel (0 red, 1 green, 2 blue).
    #[inline]
    pub fn linear_from_8(&self, channel: usize, value: u8) -> f32 {
        self.0[channel].linear_8[usize::from(value)]
    }

    /// Linear light of a 16-bit value in a channel.
    #[inline]
    pub fn linear_from_16(&self, channel: usize, value: u16) -> f32 {
        self.0[channel].linear[usize::from(value)]
    }

    /// The 8-bit value nearest to a linear light.
    #[inline]
    pub fn eight_from_linear(&self, channel: usize, light: f32) -> u8 {
        self.0[channel].eight.nearest(light) as u8
    }

    /// The 16-bit value nearest to a linear light.
    #[inline]
    pub fn sixteen_from_linear(&self, channel: usize, light: f32) -> u16 {
        self.0[channel].sixteen.nearest(light)
    }

    /// The 8-bit values of linear light, both `[.., 3]`.
    pub fn eight_bits(&self, light: &[f32], values: &mut [u8]) {
        let pixels = values.as_chunks_mut::<3>().0.iter_mut().zip(light.as_chunks::<3>().0);
        pixels.for_each(|(pixel, light)| *pixel = std::array::from_fn(|c| self.eight_from_linear(c, light[c])));
    }

    /// The 16-bit values of linear light, both `[.., 3]`.
    pub fn sixteen_bits(&self, light: &[f32], values: &mut [u16]) {
        let pixels = values.as_chunks_mut::<3>().0.iter_mut().zip(light.as_chunks::<3>().0);
        pixels.for_each(|(pixel, light)| *pixel = std::array::from_fn(|c| self.sixteen_from_linear(c, light[c])));
    }
}

impl Curve {
    fn new(linear_from: impl Fn(f32) -> f32) -> Self {
        let linear: Arc<[f32]> = (0..=65535).map(|v| linear_from(v as f32 / 65535.0)).collect();
        let eight = Inverse::new(255, 14, |v| linear_from(v / 255.0));
        let sixteen = Inverse::new(65535, 10, |v| linear_from(v / 65535.0));
        let linear_8 = std::array::from_fn(|v| linear[v * 257]);
        Self { linear, linear_8, eight: Arc::new(eight), sixteen: Arc::new(sixteen) }
    }
}

impl Inverse {
    fn new(max: u16, dropped: u32, linear_from: impl Fn(f32) -> f32) -> Self {
        let upper: Vec<f32> = (0..max).map(|v| linear_from(f32::from(v) + 0.5)).collect();
        let mut at = 0;
        let start = (LOWEST_BITS..=1.0f32.to_bits()).step_by(1 << dropped).map(|bits| {
            while at < upper.len() && upper[at] <= f32::from_bits(bits) {
                at += 1;
            }
            at as u16
        });
        Self { dropped, start: start.collect(), upper }
    }

    fn nearest(&self, light: f32) -> u16 {
        // A NaN is black.
        let light = if light > 0.0 { light.min(1.0) } else { 0.0 };
        let bits = light.to_bits();
        let mut at = if bits < LOWEST_BITS { 0 } else { self.start[((bits - LOWEST_BITS) >> self.dropped) as usize] };
        while let Some(&upper) = self.upper.get(usize::from(at))
            && upper <= light
        {
            at += 1;
        }
        at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check_round_trip(transfer: &Transfer) {
        for channel in 0..3 {
            for value in 0..=u16::MAX {
                assert_eq!(transfer.sixteen_from_linear(channel, transfer.linear_from_16(channel, value)), value);
            }
            for value in 0..=u8::MAX {
                assert_eq!(transfer.eight_from_linear(channel, transfer.linear_from_8(channel, value)), value);
            }
        }
    }

    #[test]
    fn every_value_survives_the_round_trip_in_srgb_and_other_profiles() {
        check_round_trip(&Transfer::srgb());
        let adobe = moxcms::ColorProfile::new_adobe_rgb().encode().unwrap();
        check_round_trip(&Transfer::of_profile(Some(&adobe)));
    }

    #[test]
    fn a_broken_profile_is_taken_for_srgb() {
        let light = Transfer::of_profile(Some(b"not a profile")).linear_from_8(0, 128);
        assert_eq!(light, Transfer::srgb().linear_from_8(0, 128));
    }

    #[test]
    fn light_out_of_range_is_clamped() {
        let transfer = Transfer::srgb();
        assert_eq!(transfer.eight_from_linear(0, f32::NAN), 0);
        assert_eq!(transfer.eight_from_linear(1, -1.0), 0);
        assert_eq!(transfer.eight_from_linear(2, 7.0), 255);
        assert_eq!(transfer.sixteen_from_linear(2, f32::INFINITY), 65535);
    }
}
