//! PNG, WebP, TIFF, BMP, GIF and PNM, by the `image` crate.

use std::io::Cursor;

use image::error::ImageError;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::{MAX_DECODED_BYTES, Raster, Samples, check_size, color};
use crate::io::Problem;
use crate::io::error::part_of_a_sentence;
use crate::io::sniff::Sniffed;

fn image_format(format: Sniffed) -> Option<ImageFormat> {
    Some(match format {
        Sniffed::Jpeg => ImageFormat::Jpeg,
        Sniffed::Png => ImageFormat::Png,
        Sniffed::WebP => ImageFormat::WebP,
        Sniffed::Tiff => ImageFormat::Tiff,
        Sniffed::Bmp => ImageFormat::Bmp,
        Sniffed::Gif => ImageFormat::Gif,
        Sniffed::Pnm => ImageFormat::Pnm,
        Sniffed::Heif | Sniffed::Avif | Sniffed::Pfm | Sniffed::Lfp => return None,
    })
}

/// A decoder that has read the header and found its size bearable.
fn header(bytes: &[u8], format: Sniffed) -> Result<impl ImageDecoder + '_, Problem> {
    let kind = image_format(format).ok_or(Problem::Unknown)?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), kind);
    reader.limits(limits());
    let decoder = reader.into_decoder().map_err(|error| problem(error, format))?;
    let (width, height) = decoder.dimensions();
    let bytes_per_sample =
        u64::from(decoder.color_type().bytes_per_pixel() / decoder.color_type().channel_count()).min(2);
    check_size(width.into(), height.into(), 4 * bytes_per_sample, bytes.len())?;
    Ok(decoder)
}

fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_DECODED_BYTES);
    limits
}

/// Width and height from the header.
pub(super) fn header_size(bytes: &[u8], format: Sniffed) -> Result<[u32; 2], Problem> {
    let (width, height) = header(bytes, format)?.dimensions();
    Ok([width, height])
}

/// Decodes a picture; of an animation, its first frame.
pub(super) fn decode(bytes: &[u8], format: Sniffed) -> Result<Raster, Problem> {
    let mut decoder = header(bytes, format)?;
    let size = decoder.dimensions().into();
    let color_type = decoder.color_type();
    // Broken extras do not make a picture unreadable.
    let mut icc = decoder.icc_profile().ok().flatten();
    let exif = decoder.exif_metadata().ok().flatten();
    let xmp = decoder.xmp_metadata().ok().flatten();
    let orientation = decoder.orientation().map_or(1, |orientation| orientation.to_exif());
    let picture = DynamicImage::from_decoder(decoder).map_err(|error| problem(error, format))?;
    let samples = if let (DynamicImage::ImageLuma8(gray), Some(profile)) = (&picture, &icc)
        && let Some(rgb) = color::srgb_from_gray(gray, profile)
    {
        Samples::Eight(rgb.iter().map(|&[r, g, b]| [r, g, b, 255]).collect())
    } else if color_type.bytes_per_pixel() == color_type.channel_count() {
        Samples::Eight(picture.into_rgba8().into_raw().as_chunks().0.to_vec())
    } else {
        Samples::Sixteen(picture.into_rgba16().into_raw().as_chunks().0.to_vec())
    };
    icc = icc.filter(|icc| color::is_rgb(icc));
    Ok(Raster { size, samples, has_alpha: color_type.has_alpha(), icc, exif, xmp, orientation, warnings: Vec::new() })
}

/// Our words for the library's error.
fn problem(error: ImageError, format: Sniffed) -> Problem {
    let format = format.name();
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
