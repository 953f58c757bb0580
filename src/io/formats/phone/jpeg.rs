//! JPEG photos: GDepth, Dynamic Depth, and Apple's second picture.

use super::apple::{self, Scale};
use super::{dynamic, gdepth, unit_map};
use crate::io::jpeg_parts::{self, JpegParts};
use crate::io::raster::{self, Raster, orient};
use crate::io::sniff::Sniffed;
use crate::io::xmp::Xmp;
use crate::io::{EmbeddedDepth, PhotoFile, Problem};

const XMP_NOTE: &str = "http://ns.adobe.com/xmp/note/";
/// Pictures behind the first one that are looked at.
const MAX_PICTURES: usize = 16;

/// What the extras gave.
#[derive(Default)]
struct Extras {
    depth: Option<EmbeddedDepth>,
    original: Option<Raster>,
    warnings: Vec<String>,
}

/// Opens a JPEG and the depth in it.
pub(crate) fn open(bytes: &[u8]) -> Result<PhotoFile, Problem> {
    let parts = jpeg_parts::parse(bytes);
    let mut main = raster::jpeg::decode_parts(bytes, &parts)?;
    let extras = extras(bytes, &parts);
    let orientation = main.orientation;
    let mut notes = Vec::new();
    if let Some(original) = extras.original {
        notes.push(("photo".to_owned(), "the all-in-focus original (GImage)".to_owned()));
        let (exif, xmp) = (main.exif.take(), main.xmp.take());
        main = Raster { exif: original.exif.or(exif), xmp, orientation, ..original };
    }
    main.xmp = main.xmp.filter(|xmp| !describes_extras(xmp));
    let mut file = PhotoFile::from_raster(main, Sniffed::Jpeg)?;
    file.info.notes = notes;
    if let Some(depth) = extras.depth {
        let (size, inverse_depth) = orient(depth.inverse_depth, depth.size, orientation);
        file.set_depth(EmbeddedDepth { size, inverse_depth, ..depth });
    }
    extras.warnings.into_iter().for_each(|text| file.warn(text));
    Ok(file)
}

/// An export keeps the XMP, but not one that points to data which is not exported.
fn describes_extras(xmp: &[u8]) -> bool {
    let has = |what: &[u8]| xmp.windows(what.len()).any(|window| window == what);
    has(b"HasExtendedXMP") || has(b"/dd/1.0/") || has(b"photos/1.0/depthmap/") || has(b"photos/1.0/container/")
}

fn extras(bytes: &[u8], parts: &JpegParts) -> Extras {
    let mut extras = Extras::default();
    let end = parts.end.unwrap_or(bytes.len());
    if let Some(packet) = parts.xmp() {
        match Xmp::parse(packet) {
            Ok(xmp) => google(&xmp, parts, bytes, &mut extras),
            Err(reason) => extras.warnings.push(reason),
        }
    }
    if extras.depth.is_none() {
        apple_picture(&bytes[end..], &mut extras);
    }
    extras
}

fn google(xmp: &Xmp, parts: &JpegParts, bytes: &[u8], extras: &mut Extras) {
    let mut told = |reason: String| extras.warnings.push(format!("the depth map is left out — {reason}"));
    let extended =
        xmp.get(XMP_NOTE, "HasExtendedXMP").map(|guid| parts.extended_xmp(guid).and_then(|x| Xmp::parse(&x)));
    let extended = match extended {
        Some(Ok(extended)) => Some(extended),
        Some(Err(reason)) => {
            if xmp.has(gdepth::DEPTH) {
                told(reason);
            }
            return;
        }
        None => None,
    };
    let data = extended.as_ref().unwrap_or(xmp);
    let depth = if xmp.has(dynamic::DEPTH) {
        Some(dynamic::depth(xmp, bytes, parts.end.unwrap_or(bytes.len())))
    } else if xmp.has(gdepth::DEPTH) || data.has(gdepth::DEPTH) {
        Some(gdepth::depth(xmp, data))
    } else {
        None
    };
    match depth {
        Some(Ok(depth)) => extras.depth = Some(depth),
        Some(Err(reason)) => told(reason),
        None => return,
    }
    match gdepth::original(data) {
        Some(Ok(original)) => extras.original = Some(original),
        Some(Err(reason)) => extras.warnings.push(format!("the all-in-focus original is left out — {reason}")),
        None => {}
    }
}

/// Looks for a depth map among the pictures behind the first (MPO files of Apple's portrait mode).
fn apple_picture(mut rest: &[u8], extras: &mut Extras) {
    for _ in 0..MAX_PICTURES {
        let Some(start) = rest.windows(3).position(|three| three == [0xff, 0xd8, 0xff]) else { return };
        rest = &rest[start..];
        let parts = jpeg_parts::parse(rest);
        let xmp = parts.xmp().and_then(|packet| Xmp::parse(packet).ok());
        if let Some(xmp) = xmp.filter(|xmp| xmp.has(apple::PIXEL_DATA) && Scale::is_depth_map(xmp)) {
            match unit_map(rest) {
                Ok(map) => extras.depth = Some(Scale::from_xmp(&xmp).apply(map)),
                Err(problem) => extras.warnings.push(format!("the depth map is left out — {problem}")),
            }
            return;
        }
        let Some(end) = parts.end else { return };
        rest = &rest[end..];
    }
}
