//! JPEG photos, and what lies in them beside the picture: the table's lines look there for depth.

use super::gdepth;
use crate::io::file_type::{FileType, Pixels};
use crate::io::formats;
use crate::io::jpeg_parts::{self, JpegParts};
use crate::io::raster::{self, Raster};
use crate::io::xmp::Xmp;
use crate::io::{PhotoFile, Problem, carried};

/// JPEG photos.
pub(crate) const TYPE: FileType = FileType {
    name: "JPEG",
    suffixes: &["jpg", "jpeg", "mpo"],
    begins: |bytes| bytes.starts_with(&[0xff, 0xd8, 0xff]),
    photo: Some(|bytes, _job| open(bytes)),
    pixels: Some(Pixels {
        decode: |bytes, _| raster::jpeg::decode(bytes),
        header_size: |bytes, _| raster::jpeg::header_size(bytes),
    }),
    ..FileType::UNKNOWN
};
const XMP_NOTE: &str = "http://ns.adobe.com/xmp/note/";

/// What a JPEG holds beside its picture.
pub(crate) struct Extras<'a> {
    /// The whole file.
    pub(super) bytes: &'a [u8],
    /// Where its first picture ends.
    pub(super) end: usize,
    /// Its XMP.
    pub(super) xmp: Xmp,
    /// The extended XMP that it points to.
    pub(super) extended: Option<Result<Xmp, String>>,
}

/// Opens a JPEG and the depth in it.
fn open(bytes: &[u8]) -> Result<PhotoFile, Problem> {
    let parts = jpeg_parts::parse(bytes);
    let mut main = raster::jpeg::decode_parts(bytes, &parts)?;
    let mut warnings = Vec::new();
    let extras = Extras::of(bytes, &parts, &mut warnings);
    let depth = formats::depth_in(&mut warnings, |reader| reader.jpeg.and_then(|read| read(&extras)));
    let orientation = main.orientation;
    let mut notes = Vec::new();
    match gdepth::original(&extras) {
        Some(Ok(original)) => {
            notes.push(("photo".to_owned(), "the all-in-focus original (GImage)".to_owned()));
            let (exif, xmp) = (main.exif.take(), main.xmp.take());
            main = Raster { exif: original.exif.or(exif), xmp, orientation, ..original };
        }
        Some(Err(reason)) => warnings.push(format!("the all-in-focus original is left out — {reason}")),
        None => {}
    }
    main.xmp = main.xmp.filter(|xmp| !describes_extras(xmp));
    let mut file = PhotoFile::from_raster(main, TYPE.name)?;
    file.info.notes = notes;
    let carried = carried::find(&extras.xmp, extras.extended.as_ref());
    file.take_carried(carried.or_else(|| carried::find_damaged(parts.xmp()?)));
    if let Some(depth) = depth {
        file.set_depth(depth.oriented(orientation)?);
    }
    warnings.into_iter().for_each(|text| file.warn(text));
    Ok(file)
}

impl<'a> Extras<'a> {
    fn of(bytes: &'a [u8], parts: &JpegParts, warnings: &mut Vec<String>) -> Self {
        let parsed = parts.xmp().map_or_else(|| Ok(Xmp::default()), Xmp::parse);
        let xmp = parsed.map_err(|reason| warnings.push(reason)).unwrap_or_default();
        let guid = xmp.get(XMP_NOTE, "HasExtendedXMP");
        let extended = guid.map(|guid| parts.extended_xmp(guid).and_then(|packet| Xmp::parse(&packet)));
        Self { bytes, end: parts.end.unwrap_or(bytes.len()), xmp, extended }
    }
}

/// An export keeps the XMP, but not one that points to data which is not exported.
fn describes_extras(xmp: &[u8]) -> bool {
    let has = |what: &[u8]| xmp.windows(what.len()).any(|window| window == what);
    // What this program wrote is taken out piece by piece.
    if carried::is_told_of(xmp) {
        return false;
    }
    has(b"HasExtendedXMP") || has(b"/dd/1.0/") || has(b"photos/1.0/depthmap/") || has(b"photos/1.0/container/")
}
