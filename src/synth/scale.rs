//! How far the ray depths of a light field reach that is made of depth which only orders.
//!
//! A picture wants to be refocused far before and behind: *deep* is the nets' own scale, the focal plane at the subject.
//! *Lytro* is what a camera of the paper would have seen: `D' = 0.3 · (D − D_f)`, the focal plane `D_f` at the lower
//! quartile. Both are those by which the worst of six recorded light fields comes out best. Found on any five of them, they
//! bring the corner views of the sixth nearer to the true ones than copies of the photo are.

use std::str::FromStr;

use thiserror::Error;

use crate::field::{DisparityMap, FieldError};

/// Ray depths of a Lytro over those of the nets.
const LYTRO_GAIN: f32 = 0.3;
/// The share of a Lytro's picture that lies behind its focal plane.
const LYTRO_BEHIND: f32 = 0.25;

/// How far ray depths reach.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Scale {
    /// As the source of depth has them.
    #[default]
    Deep,
    /// As a Lytro of the paper's settings would have seen.
    Lytro,
}

/// A name that is no scale.
#[derive(Debug, Error, PartialEq, Eq)]
#[error("{0:?} is no scale of depth: use deep or lytro")]
pub struct NoScale(String);

impl FromStr for Scale {
    type Err = NoScale;

    fn from_str(name: &str) -> Result<Self, NoScale> {
        match name {
            "deep" => Ok(Self::Deep),
            "lytro" => Ok(Self::Lytro),
            other => Err(NoScale(other.to_owned())),
        }
    }
}

impl Scale {
    /// Ray depths of this scale over those of the nets.
    pub fn gain(self) -> f32 {
        match self {
            Self::Deep => 1.0,
            Self::Lytro => LYTRO_GAIN,
        }
    }

    /// A map of the deep scale on this one.
    ///
    /// # Errors
    /// Values beyond all measure.
    pub fn of(self, map: DisparityMap) -> Result<DisparityMap, FieldError> {
        if self == Self::Deep || map.disparity_px().is_empty() {
            return Ok(map);
        }
        let (size, mut values) = (map.size(), map.into_disparity_px());
        let place = ((values.len() - 1) as f32 * LYTRO_BEHIND) as usize;
        let focus = *values.clone().select_nth_unstable_by(place, f32::total_cmp).1;
        values.iter_mut().for_each(|d| *d = self.gain() * (*d - focus));
        DisparityMap::new(size, values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lytro_sees_less_depth_and_most_of_it_before_its_focal_plane() {
        let map = DisparityMap::new([101, 1], (0..=100).map(|i| i as f32 / 50.0 - 1.7).collect()).unwrap();
        let seen = Scale::Lytro.of(map.clone()).unwrap();
        assert_eq!(seen.at(25, 0), 0.0);
        let spread = |map: &DisparityMap| map.range_px()[1] - map.range_px()[0];
        assert!((spread(&seen) - LYTRO_GAIN * spread(&map)).abs() < 1e-5);
        assert!(seen.at(100, 0) > 0.0, "near stays near");
        assert_eq!(Scale::Deep.of(map.clone()).unwrap(), map);
    }

    #[test]
    fn scales_have_names() {
        assert_eq!(("deep".parse(), "lytro".parse()), (Ok(Scale::Deep), Ok(Scale::Lytro)));
        assert!("wide".parse::<Scale>().unwrap_err().to_string().contains("deep or lytro"));
    }
}
