//! A depth or disparity map of one's own: PFM, or an 8- or 16-bit grey picture.
//!
//! A picture does not say which end is near, so both readings are offered ([`DepthMap::previews`]) and a guess is made:
//! what is lower in a photo is mostly nearer.

use std::path::Path;

use crate::field::DisparityMap;
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

/// A map as it was read.
///
/// # Shapes
/// - `values`: `[y, x]`, 0 … 1 from a picture, as they are from a PFM
#[derive(Clone, Debug, PartialEq)]
pub struct DepthMap {
    /// Width and height.
    pub size: [u32; 2],
    /// The values.
    pub values: Vec<f32>,
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
    Ok(DepthMap { size, values, is_disparity: false })
}

impl DepthMap {
    /// Values where larger is nearer.
    pub fn nearness(&self, end: NearEnd) -> Vec<f32> {
        match end {
            NearEnd::White => self.values.clone(),
            NearEnd::Black if self.is_disparity => self.values.iter().map(|n| -n).collect(),
            NearEnd::Black => self.values.iter().map(|n| 1.0 - n).collect(),
        }
    }

    /// The end that is near, guessed: the lower part of a photo is mostly nearer than the upper.
    pub fn near_end_guess(&self) -> NearEnd {
        let third = self.values.len() / 3;
        let mean = |part: &[f32]| part.iter().filter(|v| v.is_finite()).sum::<f32>() / part.len().max(1) as f32;
        let below = mean(&self.values[self.values.len() - third..]);
        if self.is_disparity || below >= mean(&self.values[..third]) { NearEnd::White } else { NearEnd::Black }
    }

    /// Disparity, the far end at `range_px[0]` and the near end at `range_px[1]`; a PFM keeps its own numbers.
    pub fn disparity(&self, end: NearEnd, range_px: [f32; 2]) -> DisparityMap {
        let near = self.nearness(end);
        let px = |n: f32| if self.is_disparity { n } else { range_px[0] + n * (range_px[1] - range_px[0]) };
        DisparityMap { size: self.size, disparity_px: near.into_iter().map(px).collect() }
    }

    /// Both readings, the guess first, to be shown side by side.
    pub fn previews(&self, range_px: [f32; 2]) -> [(NearEnd, DisparityMap); 2] {
        let guess = self.near_end_guess();
        let other = if guess == NearEnd::White { NearEnd::Black } else { NearEnd::White };
        [guess, other].map(|end| (end, self.disparity(end, range_px)))
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
        assert_eq!((white_near.values[11] * 65_535.0).round(), 507.0);
        let black_near = parse(&png(|y| 60_000 - y as u16 * 10_000)).unwrap();
        let [(end, near), (_, other)] = black_near.previews([-1.0, 1.0]);
        assert_eq!(end, NearEnd::Black);
        assert!(near.disparity_px[11] > near.disparity_px[0] && other.disparity_px[11] < other.disparity_px[0]);
    }

    #[test]
    fn a_pfm_keeps_its_numbers() {
        let mut bytes = Vec::new();
        pfm::write_pfm(&mut bytes, [1, 2], &[3.5, -1.25]).unwrap();
        let map = parse(&bytes).unwrap();
        assert_eq!(map.disparity(map.near_end_guess(), [0.0, 1.0]).disparity_px, [3.5, -1.25]);
    }
}
