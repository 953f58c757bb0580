//! The encoders, and which metadata each format can carry.

use std::io::{Seek, Write};
use std::path::Path;

use rayon::prelude::*;
use tiff::Directory;
use tiff::encoder::{DirectoryEncoder, TiffEncoder, TiffKindStandard, colortype};
use tiff::tags::{Tag, Type};

use super::carry::SEGMENT_BYTES;
use super::exif::{self, Field};
use super::{Format, Keep, PictureOptions, Pixels, Samples, SaveError, jpeg, xmp};

const TIFF_XMP: u16 = 700;
const BYTE: u16 = 1;
const UNDEFINED: u16 = 7;
const THUMBNAIL_SIDE: usize = 160;
/// Longest side of a JPEG, and of a lossless WebP.
const JPEG_SIDE: u32 = 65535;
const WEBP_SIDE: u32 = 16384;

/// The blocks that go along.
struct Blocks {
    icc: Option<Vec<u8>>,
    exif: Option<Vec<u8>>,
    /// The contents of a JPEG's segments, else at most one packet.
    xmp: Vec<Vec<u8>>,
}

fn odd(why: impl ToString) -> SaveError {
    SaveError::Encode { why: why.to_string(), path: Path::new("").to_owned() }
}

fn io(error: &std::io::Error) -> SaveError {
    SaveError::from_io(error, Path::new(""))
}

/// Writes a picture in a format, with the metadata that is to go along.
pub fn encode(
    out: &mut (impl Write + Seek),
    format: Format,
    pixels: &Pixels,
    options: &PictureOptions,
) -> Result<(), SaveError> {
    let blocks = Blocks::of(pixels, format, options)?;
    match format {
        Format::Png => png(out, pixels, blocks),
        Format::Jpeg => write_jpeg(out, pixels, &blocks, options.quality),
        Format::Tiff => tiff(out, pixels, blocks),
        Format::WebP => webp(out, pixels, blocks),
    }
}

impl Blocks {
    fn of(pixels: &Pixels, format: Format, options: &PictureOptions) -> Result<Self, SaveError> {
        let metadata = &options.origin.metadata;
        let icc = metadata.icc.as_deref().map(<[u8]>::to_vec);
        if options.keep == Keep::Nothing {
            return Ok(Self { icc, exif: None, xmp: Vec::new() });
        }
        let strip_gps = options.keep == Keep::WithoutPosition;
        let photos = metadata.xmp.as_deref().and_then(|xmp| xmp::edited(xmp, strip_gps));
        let photos = photos.and_then(|xmp| String::from_utf8(xmp).ok());
        let xmp = options.carry.blocks(photos.as_deref(), format).map_err(|e| io(&e))?;
        let exif = metadata.exif.as_deref().and_then(|exif| {
            let thumbnail = thumbnail(pixels);
            let edit = |thumbnail| exif::edited(exif, &exif::Edit { size: pixels.size, strip_gps, thumbnail });
            // What does not fit into a JPEG's segment with its thumbnail goes without.
            edit(thumbnail.as_deref()).filter(|block| block.len() + 6 <= SEGMENT_BYTES).or_else(|| edit(None))
        });
        Ok(Self { icc, exif, xmp })
    }
}

/// The picture at 160 pixels as a JPEG.
fn thumbnail(pixels: &Pixels) -> Option<Vec<u8>> {
    let [width, height] = pixels.size.map(|n| n as usize);
    let step = width.max(height).div_ceil(THUMBNAIL_SIDE).max(1);
    let (small_w, small_h) = ((width / step).max(1), (height / step).max(1));
    let value = |i: usize| match &pixels.samples {
        Samples::Eight(px) => u32::from(px[i]),
        Samples::Sixteen(px) => u32::from(px[i] >> 8),
    };
    let mean = |x: usize, y: usize, channel: usize| {
        let (rows, cols) = (y * step..((y + 1) * step).min(height), x * step..((x + 1) * step).min(width));
        let count = (rows.len() * cols.len()) as u32;
        let sum: u32 = rows.flat_map(|y| cols.clone().map(move |x| (y * width + x) * 3 + channel)).map(value).sum();
        (sum / count.max(1)) as u8
    };
    let mut small = vec![0; small_w * small_h * 3];
    small.par_chunks_mut(small_w * 3).enumerate().for_each(|(y, row)| {
        row.iter_mut().enumerate().for_each(|(i, to)| *to = mean(i / 3, y, i % 3));
    });
    let mut out = Vec::new();
    let encoder = jpeg_encoder::Encoder::new(&mut out, 80);
    encoder.encode(&small, small_w as u16, small_h as u16, jpeg_encoder::ColorType::Rgb).ok()?;
    Some(out)
}

fn png(out: &mut impl Write, pixels: &Pixels, blocks: Blocks) -> Result<(), SaveError> {
    let error = |error: png::EncodingError| match error {
        png::EncodingError::IoError(e) => io(&e),
        other => odd(other),
    };
    let mut info = png::Info::with_size(pixels.size[0], pixels.size[1]);
    info.color_type = png::ColorType::Rgb;
    info.srgb = blocks.icc.is_none().then_some(png::SrgbRenderingIntent::Perceptual);
    info.icc_profile = blocks.icc.map(Into::into);
    info.exif_metadata = blocks.exif.map(Into::into);
    if let Some(xmp) = blocks.xmp.into_iter().next().and_then(|xmp| String::from_utf8(xmp).ok()) {
        info.utf8_text.push(png::text_metadata::ITXtChunk::new("XML:com.adobe.xmp", xmp));
    }
    info.bit_depth = match pixels.samples {
        Samples::Eight(_) => png::BitDepth::Eight,
        Samples::Sixteen(_) => png::BitDepth::Sixteen,
    };
    let mut encoder = png::Encoder::with_info(out, info).map_err(error)?;
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().map_err(error)?;
    let mut stream = writer.stream_writer_with_size(1 << 18).map_err(error)?;
    match &pixels.samples {
        Samples::Eight(px) => stream.write_all(px).map_err(|e| io(&e))?,
        Samples::Sixteen(px) => {
            for part in px.chunks(1 << 16) {
                let bytes: Vec<u8> = part.iter().flat_map(|v| v.to_be_bytes()).collect();
                stream.write_all(&bytes).map_err(|e| io(&e))?;
            }
        }
    }
    stream.finish().map_err(error)?;
    writer.finish().map_err(error)
}

fn write_jpeg(out: &mut impl Write, pixels: &Pixels, blocks: &Blocks, quality: u8) -> Result<(), SaveError> {
    let error = |error: jpeg_encoder::EncodingError| match error {
        jpeg_encoder::EncodingError::IoError(e) => io(&e),
        other => odd(other),
    };
    let [width, height] = pixels.size;
    if width.max(height) > JPEG_SIDE {
        return Err(odd("a JPEG is at most 65535 pixels wide and high; choose PNG or TIFF, or a smaller size"));
    }
    let exif = blocks.exif.iter().map(|block| [b"Exif\0\0", &**block].concat());
    let segments: Vec<_> =
        exif.chain(blocks.xmp.iter().cloned()).filter(|segment| segment.len() <= SEGMENT_BYTES).collect();
    let how = jpeg::Options { quality, segments: &segments, icc: blocks.icc.as_deref() };
    jpeg::encode(out, &pixels.to_eight(), [width as u16, height as u16], &how).map_err(error)
}

fn webp(out: &mut impl Write, pixels: &Pixels, blocks: Blocks) -> Result<(), SaveError> {
    let [width, height] = pixels.size;
    if width.max(height) > WEBP_SIDE {
        return Err(odd("a WebP is at most 16384 pixels wide and high; choose PNG or TIFF, or a smaller size"));
    }
    let mut encoder = image_webp::WebPEncoder::new(out);
    if let Some(icc) = blocks.icc {
        encoder.set_icc_profile(icc);
    }
    if let Some(exif) = blocks.exif {
        encoder.set_exif_metadata(exif);
    }
    if let Some(xmp) = blocks.xmp.into_iter().next() {
        encoder.set_xmp_metadata(xmp);
    }
    encoder.encode(&pixels.to_eight(), width, height, image_webp::ColorType::Rgb8).map_err(|error| match error {
        image_webp::EncodingError::IoError(e) => io(&e),
        other => odd(other),
    })
}

fn tiff(out: &mut (impl Write + Seek), pixels: &Pixels, blocks: Blocks) -> Result<(), SaveError> {
    write_tiff(out, pixels, blocks).map_err(|error| match error {
        tiff::TiffError::IoError(e) => io(&e),
        other => odd(other),
    })
}

fn write_tiff(out: &mut (impl Write + Seek), pixels: &Pixels, blocks: Blocks) -> tiff::TiffResult<()> {
    let [width, height] = pixels.size;
    let mut encoder = TiffEncoder::new(out)?.with_compression(tiff::encoder::Compression::Lzw);
    encoder = encoder.with_predictor(tiff::tags::Predictor::Horizontal);
    let [mut texts, own, gps] = blocks.exif.as_deref().and_then(exif::fields).unwrap_or_default();
    texts.extend(blocks.icc.map(|data| Field { tag: Tag::IccProfile.to_u16(), kind: UNDEFINED, data }));
    texts.extend(blocks.xmp.into_iter().next().map(|data| Field { tag: TIFF_XMP, kind: BYTE, data }));
    let mut pointers = Vec::new();
    for (tag, fields) in [(Tag::ExifDirectory, own), (Tag::GpsDirectory, gps)] {
        if !fields.is_empty() {
            let mut directory = encoder.extra_directory()?;
            write_fields(&mut directory, &fields)?;
            pointers.push((tag, directory.finish_with_offsets()?.offset));
        }
    }
    macro_rules! image {
        ($color:ty, $px:expr) => {{
            let mut image = encoder.new_image::<$color>(width, height)?;
            let directory = image.encoder();
            write_fields(directory, &texts)?;
            for (tag, pointer) in pointers {
                directory.write_tag(tag, pointer)?;
            }
            image.write_data($px)
        }};
    }
    match &pixels.samples {
        Samples::Eight(px) => image!(colortype::RGB8, px),
        Samples::Sixteen(px) => image!(colortype::RGB16, px),
    }
}

/// Writes fields as they are; those of an unknown type or a broken length are left out.
fn write_fields<W: Write + Seek>(
    directory: &mut DirectoryEncoder<'_, W, TiffKindStandard>,
    fields: &[Field],
) -> tiff::TiffResult<()> {
    let mut entries = Directory::empty();
    for Field { tag, kind, data } in fields {
        let entry = Type::from_u16(*kind).map(|kind| directory.write_entry_bytes(kind, data));
        match entry {
            Some(Ok(entry)) => entries.extend([(Tag::from_u16_exhaustive(*tag), entry)]),
            Some(Err(tiff::TiffError::UsageError(_))) | None => {}
            Some(Err(error)) => return Err(error),
        }
    }
    directory.extend_from(&entries);
    Ok(())
}
