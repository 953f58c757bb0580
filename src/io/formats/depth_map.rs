//! A depth or disparity map of one's own: PFM, or an 8- or 16-bit grey picture.
//!
//! A picture does not say which end is near, so both readings are offered ([`DepthMap::previews`]) and a guess is made:
//! what is lower in a photo is mostly nearer.

use std::path::Path;
use std::sync::Arc;

use crate::field::{DisparityMap, FieldError, Raster, RelativeDepth};
use crate::io::file_type::FileType;
use crate::io::open::read_file;
use crate::io::raster;
use crate::io::{OpenError, Problem};

/// Which end of a map's values is near.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NearEnd {
    /// Large values are near: disparity, nearness.
    White,
    /// Small values are near: depth.
    Black,
}

/// What a map says of its photo.
#[derive(Clone, Debug, PartialEq)]
pub enum GivenDepth {
    /// Disparities, used as they are.
    Disparity(Arc<DisparityMap>),
    /// An order without a scale: the photo's edges guide it.
    Order(Arc<RelativeDepth>),
}

impl GivenDepth {
    /// As disparity, whatever it is.
    pub fn disparity(&self) -> Arc<DisparityMap> {
        match self {
            Self::Disparity(map) => Arc::clone(map),
            Self::Order(map) => Arc::new(map.disparity()),
        }
    }
}

/// A map as it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthMap {
    /// The values: 0 … 1 from a picture, as they are from a PFM.
    pub values: Raster<f32>,
    /// Whether it is a PFM, whose values are disparities in px per view step at its own width.
    pub is_disparity: bool,
}

/// Reads a map, told by content.
///
/// # Errors
/// [`OpenError`], if it is no PFM and no picture.
pub fn read(path: &Path) -> Result<DepthMap, OpenError> {
    read_file(path).and_then(|bytes| parse(&bytes)).map_err(OpenError::at(Some(path)))
}

/// Reads a map from memory.
pub(crate) fn parse(bytes: &[u8]) -> Result<DepthMap, Problem> {
    if let Some(read) = FileType::of(bytes)?.map {
        return read(bytes);
    }
    let raster = raster::decode(bytes)?;
    let (size, values) = raster::orient(raster.gray(), raster.size, raster.orientation);
    Ok(DepthMap { values: Raster::new(size, values)?, is_disparity: false })
}

impl DepthMap {
    /// Width and height.
    pub fn size(&self) -> [u32; 2] {
        self.values.size()
    }

    /// Values where larger is nearer.
    pub fn nearness(&self, end: NearEnd) -> RelativeDepth {
        RelativeDepth::of(match end {
            NearEnd::White => self.values.clone(),
            NearEnd::Black if self.is_disparity => self.values.clone().map(|n| -n),
            NearEnd::Black => self.values.clone().map(|n| 1.0 - n),
        })
    }

    /// The end that is near, guessed: the lower part of a photo is mostly nearer than the upper.
    pub fn near_end_guess(&self) -> NearEnd {
        let values = self.values.pixels();
        let third = values.len() / 3;
        let mean = |part: &[f32]| part.iter().filter(|v| v.is_finite()).sum::<f32>() / part.len().max(1) as f32;
        let below = mean(&values[values.len() - third..]);
        if self.is_disparity || below >= mean(&values[..third]) { NearEnd::White } else { NearEnd::Black }
    }

    /// What the map says if this end is near; a PFM keeps its own numbers.
    ///
    /// # Errors
    /// Disparities that are no numbers.
    pub fn read_as(&self, end: NearEnd) -> Result<GivenDepth, FieldError> {
        let near = self.nearness(end);
        Ok(match self.is_disparity {
            true => GivenDepth::Disparity(Arc::new(DisparityMap::new(near.size(), near.nearness().to_vec())?)),
            false => GivenDepth::Order(Arc::new(near)),
        })
    }

    /// Both readings, the guess first, to be shown side by side.
    ///
    /// # Errors
    /// Disparities that are no numbers.
    pub fn previews(&self) -> Result<[(NearEnd, GivenDepth); 2], FieldError> {
        let guess = self.near_end_guess();
        let other = if guess == NearEnd::White { NearEnd::Black } else { NearEnd::White };
        Ok([(guess, self.read_as(guess)?), (other, self.read_as(other)?)])
    }
}

#[cfg(test)]
mod tests {
    use super::super::pfm;
    use super::*;

    /// 2×6, 16 bits, brighter downwards.
    fn png(value: impl Fn(u32) -> u16) -> Vec<u8> {
        let picture = image::ImageBuffer::<image::Luma<u16>, _>::from_fn(2, 6, |_, y| image::Luma([value(y)]));
        let mut bytes = std::io::Cursor::new(Vec::new());
        image::DynamicImage::ImageLuma16(picture).write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn sixteen_bits_are_kept_and_the_lower_end_is_taken_as_near() {
        let white_near = parse(&png(|y| y as u16 * 100 + 7)).unwrap();
        assert_eq!(white_near.near_end_guess(), NearEnd::White);
        assert_eq!((white_near.values.pixels()[11] * 65_535.0).round(), 507.0);
        let black_near = parse(&png(|y| 60_000 - y as u16 * 10_000)).unwrap();
        let [(end, near), (_, other)] = black_near.previews().unwrap();
        assert_eq!(end, NearEnd::Black);
        let [near, other] = [near, other].map(|given| given.disparity());
        assert!(near.at(1, 5) > near.at(0, 0) && other.at(1, 5) < other.at(0, 0));
    }

    #[test]
    fn a_pfm_keeps_its_numbers() {
        let mut bytes = Vec::new();
        pfm::write_pfm(&mut bytes, [1, 2], &[3.5, -1.25]).unwrap();
        let map = parse(&bytes).unwrap();
        assert_eq!(map.read_as(map.near_end_guess()).unwrap().disparity().disparity_px(), [3.5, -1.25]);
    }
}
