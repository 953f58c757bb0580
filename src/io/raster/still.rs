//! PNG, WebP, TIFF, BMP, GIF and PNM, by the `image` crate.

use std::io::Cursor;

use image::error::ImageError;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::{MAX_DECODED_BYTES, Raster, Samples, check_whole, color, rgba_from_rgb, tiff_xmp};
use crate::io::Problem;
use crate::io::error::part_of_a_sentence;
use crate::io::file_type::{FileType, Pixels};

pub(crate) const PNG: FileType = still("PNG", &["png"], |bytes| bytes.starts_with(b"\x89PNG"));
pub(crate) const TIFF: FileType = still("TIFF", &["tif", "tiff"], |bytes| {
    matches!(bytes, [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..])
});
pub(crate) const WEBP: FileType =
    still("WebP", &["webp"], |bytes| bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP"));
pub(crate) const BMP: FileType = still("BMP", &["bmp"], |bytes| bytes.starts_with(b"BM"));
pub(crate) const GIF: FileType = still("GIF", &["gif"], |bytes| bytes.starts_with(b"GIF8"));
pub(crate) const PNM: FileType =
    still("PNM", &["ppm", "pgm"], |bytes| matches!(bytes, [b'P', b'1'..=b'7', b'\n' | b'\r' | b' ', ..]));

const fn still(name: &'static str, suffixes: &'static [&'static str], begins: fn(&[u8]) -> bool) -> FileType {
    FileType { name, suffixes, begins, pixels: Some(Pixels { decode, header_size }), ..FileType::UNKNOWN }
}

/// Bytes of what stands beside the pixels, unpacked; some profiles have a megabyte.
const MOST_BESIDE_BYTES: u64 = 64 << 20;
/// Canvases that a decoder of an animation may have in memory; they hold three.
const CANVASES: u64 = 8;

/// A decoder that has read the header and found its size bearable.
fn header<'a>(bytes: &'a [u8], format: &FileType) -> Result<impl ImageDecoder + use<'a>, Problem> {
    // The library knows each format by the suffix that stands first.
    let kind = format.suffixes.first().and_then(ImageFormat::from_extension).ok_or(Problem::Unknown)?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), kind);
    reader.limits(limits_beside());
    let mut decoder = reader.into_decoder().map_err(|error| problem(error, format))?;
    let (width, height) = decoder.dimensions();
    let bytes_per_sample =
        u64::from(decoder.color_type().bytes_per_pixel() / decoder.color_type().channel_count()).min(2);
    check_whole([width, height], 4 * bytes_per_sample, bytes.len())?;
    // The first frame of an animation may claim to be larger than its canvas.
    let all = if kind == ImageFormat::Gif { limits_of_frames((width, height)) } else { limits(decoder.total_bytes()) };
    decoder.set_limits(all).map_err(|error| problem(error, format))?;
    Ok(decoder)
}

/// What a decoder may allocate before it comes to the pixels: profiles and texts, which lie packed in a PNG.
pub(crate) fn limits_beside() -> Limits {
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST_BESIDE_BYTES);
    limits
}

/// What a decoder of frames may allocate: some canvases, however large a frame claims to be.
pub(crate) fn limits_of_frames((width, height): (u32, u32)) -> Limits {
    let mut limits = limits_beside();
    let canvas = 4 * u64::from(width) * u64::from(height);
    limits.max_alloc = limits.max_alloc.map(|beside| beside + CANVASES * canvas);
    limits
}

/// What a decoder may allocate: a picture in one strip lies in memory twice.
fn limits(picture_bytes: u64) -> Limits {
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_DECODED_BYTES.max(2 * picture_bytes));
    limits
}

/// Width and height from the header.
fn header_size(bytes: &[u8], format: &FileType) -> Result<[u32; 2], Problem> {
    let (width, height) = header(bytes, format)?.dimensions();
    Ok([width, height])
}

/// Decodes a picture; of an animation, its first frame.
fn decode(bytes: &[u8], format: &FileType) -> Result<Raster, Problem> {
    let mut decoder = header(bytes, format)?;
    let size = decoder.dimensions().into();
    let color_type = decoder.color_type();
    // Broken extras do not make a picture unreadable.
    let mut icc = decoder.icc_profile().ok().flatten();
    let exif = decoder.exif_metadata().ok().flatten();
    let xmp = decoder.xmp_metadata().ok().flatten().or_else(|| tiff_xmp::packet(bytes).map(<[u8]>::to_vec));
    let orientation = decoder.orientation().map_or(1, |orientation| orientation.to_exif());
    let picture = DynamicImage::from_decoder(decoder).map_err(|error| problem(error, format))?;
    let samples = if let (DynamicImage::ImageLuma8(gray), Some(profile)) = (&picture, &icc)
        && let Some(rgb) = color::srgb_from_gray(gray, profile)
    {
        Samples::Eight(rgba_from_rgb(&rgb, u8::MAX))
    } else if color_type.bytes_per_pixel() == color_type.channel_count() {
        Samples::Eight(match picture {
            DynamicImage::ImageRgb8(rgb) => rgba_from_rgb(rgb.as_raw().as_chunks().0, u8::MAX),
            picture => picture.into_rgba8().into_raw().as_chunks().0.to_vec(),
        })
    } else {
        Samples::Sixteen(match picture {
            DynamicImage::ImageRgb16(rgb) => rgba_from_rgb(rgb.as_raw().as_chunks().0, u16::MAX),
            picture => picture.into_rgba16().into_raw().as_chunks().0.to_vec(),
        })
    };
    icc = icc.filter(|icc| color::is_rgb(icc));
    Ok(Raster { size, samples, has_alpha: color_type.has_alpha(), icc, exif, xmp, orientation, warnings: Vec::new() })
}

/// Our words for the library's error.
fn problem(error: ImageError, format: &FileType) -> Problem {
    let format = format.name;
    match error {
        ImageError::IoError(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
            Problem::Truncated { format }
        }
        ImageError::Unsupported(error) => {
            let reason = part_of_a_sentence(&error.to_string());
            Problem::Unsupported { format, reason, advice: "save it as an ordinary JPEG or PNG" }
        }
        // Its own words begin with the format, which our sentence names already.
        error => match std::error::Error::source(&error) {
            Some(source) => Problem::damaged(format, source),
            None => Problem::damaged(format, error),
        },
    }
}
