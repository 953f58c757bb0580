//! Bytes of a picture file → its pixels, as they lie in the file; then → a [`Photo`], upright and opaque.
//!
//! Transparency: a photo is composited onto white, as a print would show it; a light field's views keep their alpha
//! until their reader has used it (ESLF marks missing rays with it).

pub(crate) mod avif;
mod color;
pub(crate) mod hdr;
pub(crate) mod heif;
pub(crate) mod jpeg;
mod orient;
mod reduce;
pub(crate) mod still;
mod tiff_xmp;

use std::sync::Arc;

use super::file_type::FileType;
use super::{Problem, exif};
use crate::field::{Metadata, Photo, PhotoPixels, View};

pub(crate) use color::profile_name;
pub(crate) use orient::orient;

/// The most bytes that the pixels of one picture may take, once it is open.
pub(crate) const MAX_DECODED_BYTES: u64 = 1 << 30;
/// The most that they may take in a file of which a reduced picture is kept: 600 megapixels of 8 bits.
pub(crate) const MAX_WHOLE_BYTES: u64 = 9 << 28;
/// Bytes of pixels that any header may claim: 64 megapixels of 8 bits.
const UNQUESTIONED_BYTES: u64 = 256 << 20;
/// Pixels beyond that which a byte of the file may stand for. Photos have 2 to 20; of an even surface deflate makes 1032
/// bytes from one, each of up to eight pixels.
const MAX_PIXELS_PER_BYTE: u64 = 8 * 1032;

/// A decoded picture as it lies in the file: not turned, alpha kept.
#[derive(Debug)]
pub(crate) struct Raster {
    pub(crate) size: [u32; 2],
    pub(crate) samples: Samples,
    pub(crate) has_alpha: bool,
    /// Profile of an RGB picture; other profiles have been applied already.
    pub(crate) icc: Option<Vec<u8>>,
    pub(crate) exif: Option<Vec<u8>>,
    pub(crate) xmp: Option<Vec<u8>>,
    /// EXIF orientation, 1 … 8.
    pub(crate) orientation: u8,
    /// What the person should know.
    pub(crate) warnings: Vec<String>,
}

/// RGBA pixels, row by row.
#[derive(Debug)]
pub(crate) enum Samples {
    Eight(Vec<[u8; 4]>),
    Sixteen(Vec<[u16; 4]>),
}

/// Refuses a header whose pixels would not fit into memory, or that claims far more of them than its file can hold,
/// before anything is allocated.
pub(crate) fn check_size(width: u64, height: u64, bytes_per_pixel: u64, file_bytes: usize) -> Result<(), Problem> {
    check_size_within(MAX_DECODED_BYTES, [width, height], bytes_per_pixel, file_bytes)
}

/// The same for a picture that is reduced where it has more.
pub(crate) fn check_whole(size: [u32; 2], bytes_per_pixel: u64, file_bytes: usize) -> Result<(), Problem> {
    check_size_within(MAX_WHOLE_BYTES, size.map(u64::from), bytes_per_pixel, file_bytes)
}

/// The same with a limit of its own, for all views of a light field together.
pub(crate) fn check_size_within(
    max_bytes: u64,
    [width, height]: [u64; 2],
    bytes_per_pixel: u64,
    file_bytes: usize,
) -> Result<(), Problem> {
    let pixels = width.saturating_mul(height);
    let bytes = pixels.saturating_mul(bytes_per_pixel);
    if pixels == 0 {
        return Err(Problem::damaged("picture", "a side of 0 pixels"));
    }
    if bytes > max_bytes {
        return Err(Problem::TooLarge { width, height, limit_mib: max_bytes >> 20 });
    }
    if bytes > UNQUESTIONED_BYTES && pixels > MAX_PIXELS_PER_BYTE.saturating_mul(file_bytes as u64) {
        return Err(Problem::Implausible { width, height, file_kib: file_bytes.div_ceil(1024) });
    }
    Ok(())
}

/// Decodes the pixels of any format that has them.
pub(crate) fn decode(bytes: &[u8]) -> Result<Raster, Problem> {
    let kind = FileType::of(bytes)?;
    (kind.pixels.ok_or(Problem::Unknown)?.decode)(bytes, kind)
}

fn rgba_from_rgb<T: Copy>(rgb: &[[T; 3]], opaque: T) -> Vec<[T; 4]> {
    rgb.iter().map(|&[r, g, b]| [r, g, b, opaque]).collect()
}

/// A picture that only needs its pixels: 8-bit RGBA, upright, with its alpha.
pub(crate) fn decode_rgba8(bytes: &[u8]) -> Result<([u32; 2], Vec<[u8; 4]>), Problem> {
    let raster = decode(bytes)?;
    let pixels = match raster.samples {
        Samples::Eight(px) => px,
        Samples::Sixteen(px) => px.iter().map(|px| px.map(color::eight_from_sixteen)).collect(),
    };
    Ok(orient(pixels, raster.size, raster.orientation))
}

/// A view of a light field: 8-bit RGBA, upright and opaque.
pub(crate) fn decode_view(bytes: &[u8]) -> Result<View, Problem> {
    let (size, pixels) = decode_rgba8(bytes)?;
    Ok(View::new(size, opaque(pixels, true).into_flattened())?)
}

/// Width and height from a picture's header, before orientation.
pub(crate) fn header_size(bytes: &[u8]) -> Result<[u32; 2], Problem> {
    let kind = FileType::of(bytes)?;
    (kind.pixels.ok_or(Problem::Unknown)?.header_size)(bytes, kind)
}

impl Raster {
    /// The first channel as 0 … 1, for maps that are stored as grey pictures.
    pub(crate) fn gray(&self) -> Vec<f32> {
        match &self.samples {
            Samples::Eight(px) => px.iter().map(|px| f32::from(px[0]) / 255.0).collect(),
            Samples::Sixteen(px) => px.iter().map(|px| f32::from(px[0]) / 65_535.0).collect(),
        }
    }

    /// The upright, opaque photo with its sRGB working copy; sRGB 8-bit pixels are it themselves.
    pub(crate) fn into_photo(self) -> Result<(Photo, Vec<String>), Problem> {
        let mut warnings = self.warnings;
        let metadata = Metadata {
            icc: self.icc.map(Arc::from),
            exif: self.exif.map(Arc::from),
            xmp: self.xmp.map(Arc::from),
            orientation: self.orientation,
        };
        let icc = metadata.icc.clone();
        let photo = match self.samples {
            Samples::Eight(px) => {
                let (size, px) = orient(px, self.size, self.orientation);
                let px = Arc::new(opaque(px, self.has_alpha).into_flattened());
                let pixels = PhotoPixels::Eight(Arc::clone(&px));
                match color::srgb8_from_eight(icc.as_deref(), &mut warnings) {
                    Some(by) => Photo::converted(size, pixels, by, metadata)?,
                    None => Photo::new(size, pixels, px, metadata)?,
                }
            }
            Samples::Sixteen(px) => {
                let (size, px) = orient(px, self.size, self.orientation);
                let pixels = PhotoPixels::Sixteen(Arc::new(opaque(px, self.has_alpha).into_flattened()));
                let by = color::srgb8_from_sixteen(icc.as_deref(), &mut warnings);
                Photo::converted(size, pixels, by, metadata)?
            }
        };
        Ok((photo, warnings))
    }

    /// EXIF orientation of a block that may be missing.
    pub(crate) fn orientation_of(exif: Option<&[u8]>) -> u8 {
        exif.map_or(1, exif::orientation)
    }
}

/// Composites onto white, in the encoded values as browsers do.
fn opaque<T: Channel>(mut pixels: Vec<[T; 4]>, has_alpha: bool) -> Vec<[T; 4]> {
    if has_alpha {
        for px in &mut pixels {
            let alpha = px[3].into();
            let onto_white = |value: T| T::round((value.into() * alpha + T::MAX * (T::MAX - alpha)) / T::MAX);
            *px = [onto_white(px[0]), onto_white(px[1]), onto_white(px[2]), T::round(T::MAX)];
        }
    }
    pixels
}

/// A sample of 8 or 16 bits.
trait Channel: Copy + Into<f32> {
    const MAX: f32;
    fn round(value: f32) -> Self;
}

impl Channel for u8 {
    const MAX: f32 = 255.0;
    fn round(value: f32) -> Self {
        (value + 0.5) as Self
    }
}

impl Channel for u16 {
    const MAX: f32 = 65535.0;
    fn round(value: f32) -> Self {
        (value + 0.5) as Self
    }
}
