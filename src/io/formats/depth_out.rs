//! Ray depths of one view: PFM (exact), 16-bit PNG (white is near), and a JPEG with GDepth inside.

use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use jpeg_encoder::{ColorType as JpegColor, Encoder, SamplingFactor};
use png::{BitDepth, ColorType};

use super::out;
use super::pfm;
use crate::field::{DisparityMap, Photo, View};
use crate::io::save::{Carry, SaveError, exif};

/// Writes a map as PFM: every bit is kept.
///
/// # Errors
/// [`SaveError`]; then nothing has been written.
pub fn write_pfm(path: &Path, map: &DisparityMap) -> Result<(), SaveError> {
    out::single(path, |out| pfm::write_pfm(out, map.size(), map.disparity_px()))
}

/// Writes a map as 16-bit grey PNG, white near; the range stands in the text chunks `DisparityMin` and `DisparityMax`.
///
/// # Errors
/// [`SaveError`]; then nothing has been written.
pub fn write_png16(path: &Path, map: &DisparityMap) -> Result<(), SaveError> {
    let [far, near] = map.range_px();
    let scale = if near > far { 65_535.0 / (near - far) } else { 0.0 };
    let value = |d: f32| (((d - far) * scale).round().clamp(0.0, 65_535.0) as u16).to_be_bytes();
    let rows = map.disparity_px().chunks_exact(map.size()[0] as usize);
    let rows = rows.map(|row| row.iter().flat_map(|&d| value(d)).collect());
    let texts = [("DisparityMin", far.to_string()), ("DisparityMax", near.to_string())];
    out::single(path, |out| out::png(out, map.size(), (ColorType::Grayscale, BitDepth::Sixteen), &texts, rows))
}

/// Longest content of a segment, less its head.
const MAX_SEGMENT_BYTES: usize = 65_500;

/// What a map is the depth of.
#[derive(Clone, Copy, Debug)]
pub enum Seen<'a> {
    /// A photo, at its own size, with its EXIF block.
    Photo(&'a Photo),
    /// A view of a light field.
    View(&'a View),
}

impl Seen<'_> {
    fn size(self) -> [u32; 2] {
        match self {
            Self::Photo(photo) => photo.size(),
            Self::View(view) => view.size(),
        }
    }

    fn rgba(&self) -> &[u8] {
        match self {
            Self::Photo(photo) => photo.srgb8(),
            Self::View(view) => view.rgba(),
        }
    }

    /// The photo's EXIF block for an upright picture without thumbnail.
    fn exif(self) -> Option<Vec<u8>> {
        let Self::Photo(photo) = self else { return None };
        let edit = exif::Edit { size: photo.size(), strip_gps: false, thumbnail: None };
        exif::edited(photo.metadata().exif.as_deref()?, &edit)
    }
}

/// Writes an sRGB JPEG with the map as GDepth (`RangeInverse`, 16 bits, white far, stretched to the picture), in
/// extended XMP as phones write it. Units are left open: disparity alone knows no metres.
///
/// # Errors
/// [`SaveError`]; then nothing has been written.
pub fn write_gdepth(path: &Path, seen: Seen, map: &DisparityMap, quality: u8) -> Result<(), SaveError> {
    let why = |error: &dyn std::fmt::Display| SaveError::Encode { why: error.to_string(), path: path.to_owned() };
    let [width, height] = seen.size().map(|side| u16::try_from(side).unwrap_or(u16::MAX));
    let carry = Carry { depth: Some(Arc::new(map.clone())), ..Carry::default() };
    let mut jpeg = Vec::new();
    let mut encoder = Encoder::new(&mut jpeg, quality);
    encoder.set_sampling_factor(SamplingFactor::R_4_4_4);
    // A block too long for a segment is left out: the picture matters more.
    if let Some(block) = seen.exif().filter(|block| block.len() < MAX_SEGMENT_BYTES) {
        encoder.add_app_segment(1, &[b"Exif\0\0", &block[..]].concat()).map_err(|error| why(&error))?;
    }
    for segment in carry.segments(None).map_err(|error| why(&error))? {
        encoder.add_app_segment(1, &segment).map_err(|error| why(&error))?;
    }
    encoder.encode(seen.rgba(), width, height, JpegColor::Rgba).map_err(|error| why(&error))?;
    out::single(path, |out| out.write_all(&jpeg))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::{DepthKind, Opened, open_bytes};

    fn map() -> DisparityMap {
        DisparityMap::new([64, 48], (0..64 * 48).map(|n| (n % 64) as f32 / 16.0 - 1.5).collect()).unwrap()
    }

    #[test]
    fn a_gdepth_jpeg_opens_as_a_photo_with_its_depth() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("depth.jpg");
        let view = View::new([128, 96], [90, 120, 60, 255].repeat(128 * 96)).unwrap();
        write_gdepth(&path, Seen::View(&view), &map(), 90).unwrap();
        let Opened::Photo(file) = open_bytes(&std::fs::read(&path).unwrap(), None).unwrap() else { panic!("a photo") };
        assert!(file.warnings.is_empty(), "{:?}", file.warnings);
        let depth = file.depth.as_ref().unwrap();
        assert_eq!((depth.kind, depth.map.size(), depth.metric), (DepthKind::Gdepth, [64, 48], false));
        let back = depth.map.stretched([-1.0, 1.0]);
        assert!(back.at(63, 5) > 0.95 && back.at(0, 5) < -0.95, "right is near, as it was written");
        let worst = |(got, x): (&f32, usize)| {
            (got - (back.at(0, 0) * (63 - x) as f32 + back.at(63, 0) * x as f32) / 63.0).abs()
        };
        let row = back.disparity_px()[..64].iter().zip(0..64).map(worst);
        assert!(row.fold(0.0, f32::max) < 1e-4, "and linear in disparity, to 16 bits");
    }

    #[test]
    fn a_photo_keeps_its_size_and_its_exif_block() {
        let dir = tempfile::tempdir().unwrap();
        let (source, path) = (dir.path().join("photo.jpg"), dir.path().join("depth.jpg"));
        // Orientation 6: the photo stands upright in the file that is written.
        let block = b"Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0";
        let mut jpeg = Vec::new();
        let mut encoder = Encoder::new(&mut jpeg, 90);
        encoder.add_app_segment(1, block).unwrap();
        encoder.encode(&[90; 96 * 48], 96, 48, JpegColor::Luma).unwrap();
        std::fs::write(&source, jpeg).unwrap();
        let open = |path: &Path| match open_bytes(&std::fs::read(path).unwrap(), None).unwrap() {
            Opened::Photo(file) => file,
            Opened::LightField(_) => panic!("a photo"),
        };
        write_gdepth(&path, Seen::Photo(&open(&source).photo), &map(), 90).unwrap();
        let file = open(&path);
        assert_eq!((file.info.size, file.info.orientation), ([48, 96], 1));
        assert!(file.photo.metadata().exif.is_some() && file.depth.is_some());
    }

    #[test]
    fn a_16_bit_map_keeps_its_order_and_a_pfm_every_bit() {
        let dir = tempfile::tempdir().unwrap();
        let (png, float) = (dir.path().join("d.png"), dir.path().join("d.pfm"));
        write_png16(&png, &map()).unwrap();
        write_pfm(&float, &map()).unwrap();
        assert_eq!(pfm::read_pfm(&float).unwrap(), map());
        let read = super::super::depth_map::read(&png).unwrap();
        assert_eq!((read.values.pixels()[0], read.values.pixels()[63]), (0.0, 1.0));
        let truth = map();
        let worst = read.values.pixels().iter().zip(truth.disparity_px()).map(|(v, d)| (v - (d + 1.5) / 3.9375).abs());
        assert!(worst.fold(0.0, f32::max) < 1e-5);
    }
}
