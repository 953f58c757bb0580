//! JPEG, straight to RGBA by zune-jpeg: that is the fastest way from a phone's file to the screen.

use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

use super::{Raster, Samples, check_size, color};
use crate::io::Problem;
use crate::io::jpeg_parts::{self, JpegParts};

const FORMAT: &str = "JPEG";

/// Decodes the first picture of a JPEG file.
pub(crate) fn decode(bytes: &[u8]) -> Result<Raster, Problem> {
    decode_parts(bytes, &jpeg_parts::parse(bytes))
}

/// Width and height from the header.
pub(crate) fn header_size(bytes: &[u8]) -> Result<[u32; 2], Problem> {
    header(bytes).map(|(_, size, _)| size)
}

type Decoder<'a> = JpegDecoder<ZCursor<&'a [u8]>>;

/// A decoder that gives one kind of pixels; it must know from the start, as it picks its routines then.
fn decoder(bytes: &[u8], out: ColorSpace) -> Decoder<'_> {
    let options = DecoderOptions::default().set_strict_mode(false).set_max_width(65_535).set_max_height(65_535);
    JpegDecoder::new_with_options(ZCursor::new(bytes), options.jpeg_set_out_colorspace(out))
}

fn header(bytes: &[u8]) -> Result<(Decoder<'_>, [u32; 2], ColorSpace), Problem> {
    let mut decoder = decoder(bytes, ColorSpace::RGBA);
    decoder.decode_headers().map_err(|error| Problem::damaged(FORMAT, error))?;
    let (width, height) = decoder.dimensions().ok_or_else(|| Problem::damaged(FORMAT, "it has no size"))?;
    let space = decoder.input_colorspace().ok_or_else(|| Problem::damaged(FORMAT, "it has no colours"))?;
    check_size(width as u64, height as u64, 4, bytes.len())?;
    Ok((decoder, [width as u32, height as u32], space))
}

/// Decodes a JPEG that has been taken apart already.
pub(crate) fn decode_parts(bytes: &[u8], parts: &JpegParts) -> Result<Raster, Problem> {
    let end = parts.end.ok_or(Problem::Truncated { format: FORMAT })?;
    let bytes = &bytes[..end];
    let (mut decoder, size, space) = header(bytes)?;
    let icc = decoder.icc_profile();
    let (pixels, icc) = match space {
        ColorSpace::YCbCr => (rgba(&mut decoder, size)?, icc.filter(|icc| color::is_rgb(icc))),
        ColorSpace::Luma => gray(&read(bytes, ColorSpace::Luma)?, icc),
        ColorSpace::CMYK => cmyk(read(bytes, ColorSpace::CMYK)?, icc),
        _ => (rgba_from_rgb(read(bytes, ColorSpace::RGB)?.as_chunks().0), icc.filter(|icc| color::is_rgb(icc))),
    };
    let exif = parts.exif().map(<[u8]>::to_vec);
    let orientation = Raster::orientation_of(exif.as_deref());
    let xmp = parts.xmp().map(<[u8]>::to_vec);
    Ok(Raster { size, samples: Samples::Eight(pixels), has_alpha: false, icc, exif, xmp, orientation })
}

fn read(bytes: &[u8], space: ColorSpace) -> Result<Vec<u8>, Problem> {
    decoder(bytes, space).decode().map_err(|error| Problem::damaged(FORMAT, error))
}

/// The usual case, decoded into place.
fn rgba(decoder: &mut Decoder, [width, height]: [u32; 2]) -> Result<Vec<[u8; 4]>, Problem> {
    let mut pixels = vec![[0; 4]; width as usize * height as usize];
    decoder.decode_into(pixels.as_flattened_mut()).map_err(|error| Problem::damaged(FORMAT, error))?;
    Ok(pixels)
}

fn rgba_from_rgb(rgb: &[[u8; 3]]) -> Vec<[u8; 4]> {
    rgb.iter().map(|&[r, g, b]| [r, g, b, 255]).collect()
}

/// Grey with a grey profile becomes sRGB; grey with an RGB profile keeps it.
fn gray(gray: &[u8], icc: Option<Vec<u8>>) -> (Vec<[u8; 4]>, Option<Vec<u8>>) {
    match icc.as_deref().and_then(|icc| color::srgb_from_gray(gray, icc)) {
        Some(rgb) => (rgba_from_rgb(&rgb), None),
        None => (gray.iter().map(|&y| [y, y, y, 255]).collect(), icc.filter(|icc| color::is_rgb(icc))),
    }
}

/// CMYK becomes sRGB: with its profile, else by plain multiplication of what the inks let through. Files of Adobe's
/// programs, which nearly all are, store the inks inverted.
fn cmyk(mut inks: Vec<u8>, icc: Option<Vec<u8>>) -> (Vec<[u8; 4]>, Option<Vec<u8>>) {
    let through = |ink: u8, black: u8| ((u32::from(ink) * u32::from(black) + 127) / 255) as u8;
    let plain = |inks: &[u8]| {
        inks.as_chunks().0.iter().map(|&[c, m, y, k]| [through(c, k), through(m, k), through(y, k), 255]).collect()
    };
    let Some(icc) = icc else { return (plain(&inks), None) };
    inks.iter_mut().for_each(|ink| *ink = 255 - *ink);
    if let Some(rgb) = color::srgb_from_cmyk(&inks, &icc) {
        return (rgba_from_rgb(&rgb), None);
    }
    inks.iter_mut().for_each(|ink| *ink = 255 - *ink);
    (plain(&inks), None)
}
