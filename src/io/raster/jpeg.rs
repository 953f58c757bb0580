//! JPEG, straight to RGBA by zune-jpeg: that is the fastest way from a phone's file to the screen.

use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

use super::{MAX_DECODED_BYTES, Raster, Samples, check_whole, color, rgba_from_rgb};
use crate::io::Problem;
use crate::io::jpeg_parts::{self, JpegParts};

const FORMAT: &str = "JPEG";
/// Zeros behind the data of a file that is tried for missing data: fewer than a row of blocks could be made of.
const SPARE_BYTES: usize = 16;
/// A block of 8×8 pixels takes a bit or more, whatever is in it, and colours at half the size add half a block: no byte
/// stands for more pixels. Below [`LITTLE`] pixels nobody counts.
const MAX_PIXELS_PER_BYTE: u64 = 8 * 64 * 2 / 3;
const LITTLE: u64 = 8 << 20;
/// Bytes of a number while all passes of a progressive picture are gathered, and of a pixel beside them.
const NUMBER_BYTES: u64 = 2;
const PIXEL_BYTES: u64 = 4;
const NOT_WHOLE: &str = "the picture's data are damaged or end early, so a part of it is grey or blurred";

/// Decodes the first picture of a JPEG file.
pub(crate) fn decode(bytes: &[u8]) -> Result<Raster, Problem> {
    decode_parts(bytes, &jpeg_parts::parse(bytes))
}

/// Width and height from the header.
pub(crate) fn header_size(bytes: &[u8]) -> Result<[u32; 2], Problem> {
    header(bytes).map(|(_, size, _)| size)
}

type Decoder<'a> = JpegDecoder<ZCursor<&'a [u8]>>;

/// A decoder that gives one kind of pixels; it must know from the start, as it picks its routines then. A strict one
/// gives up where another one guesses.
fn decoder(bytes: &[u8], out: ColorSpace, is_strict: bool) -> Decoder<'_> {
    let options = DecoderOptions::default().set_strict_mode(is_strict).set_max_width(65_535).set_max_height(65_535);
    JpegDecoder::new_with_options(ZCursor::new(bytes), options.jpeg_set_out_colorspace(out))
}

fn header(bytes: &[u8]) -> Result<(Decoder<'_>, [u32; 2], ColorSpace), Problem> {
    let mut decoder = decoder(bytes, ColorSpace::RGBA, false);
    decoder.decode_headers().map_err(|error| Problem::damaged(FORMAT, error))?;
    let (width, height) = decoder.dimensions().ok_or_else(|| Problem::damaged(FORMAT, "it has no size"))?;
    let space = decoder.input_colorspace().ok_or_else(|| Problem::damaged(FORMAT, "it has no colours"))?;
    let size = [width as u32, height as u32];
    check_whole(size, 4, bytes.len())?;
    Ok((decoder, size, space))
}

/// Decodes a JPEG that has been taken apart already.
pub(crate) fn decode_parts(bytes: &[u8], parts: &JpegParts) -> Result<Raster, Problem> {
    let end = parts.end.ok_or(Problem::Truncated { format: FORMAT })?;
    let bytes = &bytes[..end];
    let (decoder, size, space) = header(bytes)?;
    check_data(size, parts.held_numbers().unwrap_or(0), bytes.len())?;
    let icc = decoder.icc_profile();
    let rgb_icc = |icc: Option<Vec<u8>>| icc.filter(|icc| color::is_rgb(icc));
    let (pixels, icc, is_whole) = match space {
        ColorSpace::YCbCr => {
            let (pixels, is_whole) = read::<4>(bytes, parts, size, ColorSpace::RGBA)?;
            (pixels, rgb_icc(icc), is_whole)
        }
        ColorSpace::Luma => {
            let (luma, is_whole) = read::<1>(bytes, parts, size, ColorSpace::Luma)?;
            let (pixels, icc) = gray(luma.as_flattened(), icc);
            (pixels, icc, is_whole)
        }
        ColorSpace::CMYK => {
            let (inks, is_whole) = read::<4>(bytes, parts, size, ColorSpace::CMYK)?;
            let (pixels, icc) = cmyk(inks.into_flattened(), icc);
            (pixels, icc, is_whole)
        }
        _ => {
            let (rgb, is_whole) = read::<3>(bytes, parts, size, ColorSpace::RGB)?;
            (rgba_from_rgb(&rgb, 255), rgb_icc(icc), is_whole)
        }
    };
    let exif = parts.exif().map(<[u8]>::to_vec);
    let orientation = Raster::orientation_of(exif.as_deref());
    let xmp = parts.xmp().map(<[u8]>::to_vec);
    let warnings = if is_whole { Vec::new() } else { vec![NOT_WHOLE.to_owned()] };
    Ok(Raster { size, samples: Samples::Eight(pixels), has_alpha: false, icc, exif, xmp, orientation, warnings })
}

/// Refuses a header whose pixels the data cannot hold, and passes that would not fit into memory together.
fn check_data(size: [u32; 2], held_numbers: u64, file_bytes: usize) -> Result<(), Problem> {
    let [width, height] = size.map(u64::from);
    let pixels = width * height;
    if pixels > LITTLE && pixels > MAX_PIXELS_PER_BYTE * file_bytes as u64 {
        return Err(Problem::Implausible { width, height, file_kib: file_bytes.div_ceil(1024) });
    }
    if held_numbers > 0 && held_numbers * NUMBER_BYTES + pixels * PIXEL_BYTES > MAX_DECODED_BYTES {
        return Err(Problem::TooLarge { width, height, limit_mib: MAX_DECODED_BYTES >> 20 });
    }
    Ok(())
}

/// All pixels of `N` channels, and whether the data were there for all of them.
fn read<const N: usize>(
    bytes: &[u8],
    parts: &JpegParts,
    [width, height]: [u32; 2],
    space: ColorSpace,
) -> Result<(Vec<[u8; N]>, bool), Problem> {
    let mut pixels = vec![[0; N]; width as usize * height as usize];
    let lenient = |bytes: &[u8], pixels: &mut [u8]| {
        decoder(bytes, space, false).decode_into(pixels).map_err(|error| Problem::damaged(FORMAT, error))
    };
    if parts.is_progressive() {
        lenient(bytes, pixels.as_flattened_mut())?;
        return Ok((pixels, parts.has_all_passes()));
    }
    // Behind the end marker the decoder reads zeros for as long as it likes; without it, it runs out of data. It reads a
    // little ahead.
    let open_ended = [&bytes[..bytes.len() - 2], &[0; SPARE_BYTES]].concat();
    let mut strict = decoder(&open_ended, space, true);
    if strict.decode_headers().is_err() {
        // Oddities of the header say nothing of the data.
        lenient(bytes, pixels.as_flattened_mut())?;
        return Ok((pixels, true));
    }
    let is_whole = strict.decode_into(pixels.as_flattened_mut()).is_ok();
    if !is_whole {
        lenient(&open_ended, pixels.as_flattened_mut())?;
    }
    Ok((pixels, is_whole))
}

/// Grey with a grey profile becomes sRGB; grey with an RGB profile keeps it.
fn gray(gray: &[u8], icc: Option<Vec<u8>>) -> (Vec<[u8; 4]>, Option<Vec<u8>>) {
    match icc.as_deref().and_then(|icc| color::srgb_from_gray(gray, icc)) {
        Some(rgb) => (rgba_from_rgb(&rgb, 255), None),
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
        return (rgba_from_rgb(&rgb, 255), None);
    }
    inks.iter_mut().for_each(|ink| *ink = 255 - *ink);
    (plain(&inks), None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_that_the_data_cannot_hold_are_refused() {
        // A header of 49 megapixels over 20 KiB, plain or progressive.
        for held_numbers in [0, 3 * 49_000_000] {
            let refused = check_data([7000, 7000], held_numbers, 20 << 10);
            assert!(matches!(refused, Err(Problem::Implausible { file_kib: 20, .. })));
        }
        // The flattest picture that there can be, one cut off early, and a small one.
        for (size, bytes) in [([7000, 7000], 150 << 10), ([4000, 3000], 60 << 10), ([2000, 1500], 700)] {
            assert!(check_data(size, 1, bytes).is_ok(), "{size:?}");
        }
        // Colours at half the size leave room for half as many pixels again; a plain picture holds no numbers.
        let pixels = 12_288 * 11_000;
        assert!(matches!(check_data([12_288, 11_000], 3 * pixels, 40 << 20), Err(Problem::TooLarge { .. })));
        assert!(check_data([12_288, 11_000], pixels * 3 / 2, 40 << 20).is_ok());
        assert!(check_data([16_000, 16_000], 0, 40 << 20).is_ok());
    }
}
