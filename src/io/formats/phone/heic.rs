//! HEIC photos, decoded by heifer: turned by `irot` and `imir`, with Apple's depth map or both eyes of a spatial photo.
//!
//! The gain map of an HDR photo is left alone: the base picture is what every screen shows.

use heifer::heifer_isobmff::boxes::Property;
use heifer::heifer_isobmff::{HeifFile, ItemId};

use super::apple::Scale;
use super::spatial;
use crate::field::RelativeDepth;
use crate::io::decoder::{self, Decoded, RgbaPixels, Task};
use crate::io::file_type::FileType;
use crate::io::formats;
use crate::io::raster::heif::{Cicp, check_parts, is_heic, turn};
use crate::io::raster::{MAX_DECODED_BYTES, Raster, Samples, check_size, hdr};
use crate::io::xmp::Xmp;
use crate::io::{EmbeddedDepth, PhotoFile, Problem};

pub(crate) const FORMAT: &str = "HEIC";
/// HEIC photos.
pub(crate) const TYPE: FileType = FileType {
    name: FORMAT,
    suffixes: &["heic", "heif", "hif"],
    begins: is_heic,
    photo: Some(|bytes, _job| open(bytes)),
    ..FileType::UNKNOWN
};
const DEPTH_URN: [&str; 2] = ["urn:mpeg:hevc:2015:auxid:2", "urn:mpeg:mpegB:cicp:systems:auxiliary:depth"];

/// Opens a HEIC photo and the depth in it.
fn open(bytes: &[u8]) -> Result<PhotoFile, Problem> {
    let file = HeifFile::parse(bytes).map_err(problem)?;
    let mut warnings = Vec::new();
    // The depth is decoded while the picture comes through its pipe.
    let (photo, depth) = rayon::join(
        || PhotoFile::from_raster(decode_photo(bytes, &file)?, FORMAT),
        || formats::depth_in(&mut warnings, |reader| reader.heic.and_then(|read| read(&file, bytes))),
    );
    let mut photo = photo?;
    depth.into_iter().for_each(|depth| photo.set_depth(depth));
    if spatial::stereo_pair(bytes).is_some() {
        photo.info.notes.push(("spatial photo".to_owned(), "two eyes".to_owned()));
    }
    warnings.into_iter().for_each(|text| photo.warn(text));
    Ok(photo)
}

fn problem(error: impl std::fmt::Display) -> Problem {
    let text = error.to_string();
    if text.contains("unexpected end") { Problem::Truncated { format: FORMAT } } else { Problem::damaged(FORMAT, text) }
}

/// Decodes a picture beside the main one, if its size is bearable: a size, pixels, and what white is.
pub(super) fn decode_item(file: &HeifFile, bytes: &[u8], id: ItemId) -> Result<Other, Problem> {
    check_item(file, bytes.len(), id, DEEP_BYTES)?;
    let Decoded { size, pixels, told, .. } = decoder::decode(Task::HeicItem(id), bytes)?;
    match pixels.into_samples() {
        Samples::Sixteen(pixels) => Ok(Other { size, pixels, white: f32::from(told[0]) }),
        Samples::Eight(_) => Err(Problem::damaged(FORMAT, "a picture beside the main one is odd")),
    }
}

/// A picture beside the main one.
pub(super) struct Other {
    pub(super) size: [u32; 2],
    pub(super) pixels: Vec<[u16; 4]>,
    /// The largest value.
    pub(super) white: f32,
}

/// The decoder's part of [`decode_item`].
pub(crate) fn decode_other(bytes: &[u8], id: ItemId) -> Result<Decoded, Problem> {
    let file = HeifFile::parse(bytes).map_err(problem)?;
    check_item(&file, bytes.len(), id, DEEP_BYTES)?;
    let image = heifer::decode_item(&file, id, 0).map_err(problem)?;
    let told = [image.max_value(), 0, 0, 0];
    let pixels = RgbaPixels::Samples(Samples::Sixteen(image.data.as_chunks().0.to_vec()));
    Ok(Decoded { size: [image.width, image.height], pixels, has_alpha: image.has_alpha, told })
}

/// The decoder's part of a photo: its pixels, turned.
pub(crate) fn decode_pixels(bytes: &[u8]) -> Result<Decoded, Problem> {
    let file = HeifFile::parse(bytes).map_err(problem)?;
    let bytes_per_pixel = photo_bytes(&file);
    check_item(&file, bytes.len(), file.primary_id, bytes_per_pixel)?;
    let options = heifer::Options { max_threads: 0, max_pixels: MAX_DECODED_BYTES / bytes_per_pixel };
    let (size, has_alpha, pixels) = if bytes_per_pixel < DEEP_BYTES {
        let image = heifer::decode_rgba8(bytes, &options).map_err(problem)?;
        ([image.width, image.height], image.has_alpha, RgbaPixels::Bytes(image.data))
    } else {
        let image = heifer::decode_with_options(bytes, &options).map_err(problem)?;
        let max = u32::from(image.max_value());
        let widen = |value: u16| ((u32::from(value) * 65_535 + max / 2) / max) as u16;
        let pixels = image.data.as_chunks().0.iter().map(|px| px.map(widen)).collect();
        ([image.width, image.height], image.has_alpha, RgbaPixels::Samples(Samples::Sixteen(pixels)))
    };
    Ok(Decoded { size, pixels, has_alpha, told: [0; 4] })
}

/// Bytes of a pixel that is decoded to 16 bits a channel.
const DEEP_BYTES: u64 = 8;

/// Bytes that a pixel of the photo is decoded to.
fn photo_bytes(file: &HeifFile) -> u64 {
    if bits(file, file.primary_id) <= 8 { DEEP_BYTES / 2 } else { DEEP_BYTES }
}

/// Refuses an item that is too large, or that is put together without end.
fn check_item(file: &HeifFile, file_bytes: usize, id: ItemId, bytes_per_pixel: u64) -> Result<(), Problem> {
    if let Some((width, height)) = file.image_size(id).map_err(problem)? {
        check_size(width.into(), height.into(), bytes_per_pixel, file_bytes)?;
    }
    check_parts(file, id, FORMAT)
}

fn decode_photo(bytes: &[u8], file: &HeifFile) -> Result<Raster, Problem> {
    let id = file.primary_id;
    check_item(file, bytes.len(), id, photo_bytes(file))?;
    let Decoded { size, pixels, has_alpha, .. } = decoder::decode(Task::Heic, bytes)?;
    let samples = pixels.into_samples();
    let metadata = heifer::item_metadata(file, id).unwrap_or_default();
    let cicp = Cicp::of(file, id);
    let (samples, was_hdr) = match cicp.filter(|_| metadata.icc_profile.is_none()) {
        Some(cicp) => hdr::to_sdr(samples, cicp.transfer),
        None => (samples, false),
    };
    Ok(Raster {
        size,
        samples,
        has_alpha,
        icc: metadata.icc_profile.or_else(|| cicp?.profile()),
        exif: metadata.exif,
        xmp: metadata.xmp,
        // The container's own turns have been applied; EXIF must not turn the picture again.
        orientation: 1,
        warnings: if was_hdr { vec![hdr::WARNING.to_owned()] } else { Vec::new() },
    })
}

/// Bits of a channel: of the picture, or of its first tile.
fn bits(file: &HeifFile, id: ItemId) -> u8 {
    let own = |id| file.hevc_config(id).ok().flatten().map(|config| config.bit_depth_luma);
    own(id).or_else(|| own(*file.referenced_items(id, b"dimg").first()?)).unwrap_or(16)
}

/// What the other eye of a spatial photo sees; none where there is none, or it is damaged.
pub(crate) fn other_eye(bytes: &[u8]) -> Option<PhotoFile> {
    let file = is_heic(bytes).then(|| HeifFile::parse(bytes).ok()).flatten()?;
    let id = spatial::stereo_pair(bytes)?.into_iter().find(|eye| *eye != file.primary_id)?;
    let image = decode_item(&file, bytes, id).ok()?;
    let widen = |value: u16| (f32::from(value) / image.white * 65_535.0 + 0.5) as u16;
    let samples = Samples::Sixteen(image.pixels.iter().map(|px| px.map(widen)).collect());
    let metadata = heifer::item_metadata(&file, id).unwrap_or_default();
    let icc = metadata.icc_profile.or_else(|| Cicp::of(&file, id)?.profile());
    let (size, orientation) = (image.size, missing_turn(&file, id));
    let raster = Raster {
        size,
        samples,
        has_alpha: false,
        icc,
        exif: metadata.exif,
        xmp: None,
        orientation,
        warnings: Vec::new(),
    };
    PhotoFile::from_raster(raster, FORMAT).ok()
}

/// The auxiliary depth picture, wherever it hangs.
pub(crate) fn read_depth(file: &HeifFile, bytes: &[u8]) -> Option<Result<EmbeddedDepth, String>> {
    let is_depth = |id| {
        let urn =
            |p: &Property| matches!(p, Property::AuxiliaryType(urn) if DEPTH_URN.iter().any(|d| urn.starts_with(d)));
        file.item_properties(id).is_ok_and(|mut properties| properties.any(urn))
    };
    let id = file.items.iter().map(|item| item.id).find(|&id| is_depth(id))?;
    Some(decode_depth(file, bytes, id).map_err(|problem| problem.to_string()))
}

fn decode_depth(file: &HeifFile, bytes: &[u8], id: ItemId) -> Result<EmbeddedDepth, Problem> {
    let image = decode_item(file, bytes, id)?;
    let values = image.pixels.iter().map(|px| f32::from(px[0]) / image.white).collect();
    let map = RelativeDepth::new(image.size, values)?;
    let packet = file.xmp(id).ok().flatten().unwrap_or_default();
    let xmp = Xmp::parse(&packet).unwrap_or_default();
    let depth = Scale::from_xmp(&xmp).apply(map);
    Ok(depth.oriented(missing_turn(file, id))?)
}

/// What a picture beside the main one is still to be turned by: one without turns of its own lies as the photo does before
/// its turns.
fn missing_turn(file: &HeifFile, id: ItemId) -> u8 {
    let [photo, own] = [turn(file, file.primary_id), turn(file, id)];
    if own == 1 { photo } else { 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_photo_of_8_bits_may_have_200_megapixels_and_one_of_more_bits_half_as_many() {
        let mut bytes = heifer::encode_rgb8(16, 16, &[128; 3 * 16 * 16], &heifer::EncodeOptions::default()).unwrap();
        let sizes: Vec<usize> = (0..bytes.len() - 16).filter(|&at| &bytes[at..at + 4] == b"ispe").collect();
        for at in sizes {
            bytes[at + 8..at + 12].copy_from_slice(&16_384u32.to_be_bytes());
            bytes[at + 12..at + 16].copy_from_slice(&12_288u32.to_be_bytes());
        }
        let file = HeifFile::parse(&bytes).unwrap();
        let check = |bytes_per_pixel| check_item(&file, 1 << 20, file.primary_id, bytes_per_pixel);
        check(photo_bytes(&file)).unwrap();
        let refused = check(DEEP_BYTES);
        assert!(matches!(refused, Err(Problem::TooLarge { width: 16_384, height: 12_288, .. })), "{refused:?}");
    }
}
