//! The two things that we need from EXIF: which way up, and how long the lens.

use exif::{Exif, In, Reader, Tag};

/// Orientation 1 … 8 of an EXIF block (a TIFF structure); 1 where it says nothing sensible.
pub(crate) fn orientation(tiff: &[u8]) -> u8 {
    let read = |exif: Exif| exif.get_field(Tag::Orientation, In::PRIMARY)?.value.get_uint(0);
    match parse(tiff).and_then(read) {
        Some(n @ 1..=8) => n as u8,
        _ => 1,
    }
}

/// Focal length as on 35-mm film, in millimetres.
pub(crate) fn f35_mm(tiff: &[u8]) -> Option<f32> {
    let value = parse(tiff)?.get_field(Tag::FocalLengthIn35mmFilm, In::PRIMARY)?.value.get_uint(0)?;
    (value > 0).then_some(value as f32)
}

fn parse(tiff: &[u8]) -> Option<Exif> {
    Reader::new().continue_on_error(true).read_raw(tiff.to_vec()).or_else(|e| e.distill_partial_result(|_| ())).ok()
}
