//! What we need from EXIF: which way up, how long the lens, how far the subject, and whether it tells a place.

use exif::{Context, Exif, In, Reader, Tag, Value};

/// Orientation 1 … 8 of an EXIF block (a TIFF structure); 1 where it says nothing sensible.
pub(crate) fn orientation(tiff: &[u8]) -> u8 {
    let read = |exif: Exif| exif.get_field(Tag::Orientation, In::PRIMARY)?.value.get_uint(0);
    match parse(tiff).and_then(read) {
        Some(n @ 1..=8) => n as u8,
        _ => 1,
    }
}

/// Focal length as on 35-mm film, in millimetres.
pub fn f35_mm(tiff: &[u8]) -> Option<f32> {
    let value = parse(tiff)?.get_field(Tag::FocalLengthIn35mmFilm, In::PRIMARY)?.value.get_uint(0)?;
    (value > 0).then_some(value as f32)
}

/// Distance of the subject in metres, where it is written: 0 means unknown, and the greatest number infinity.
pub fn subject_distance_m(tiff: &[u8]) -> Option<f32> {
    let exif = parse(tiff)?;
    match &exif.get_field(Tag::SubjectDistance, In::PRIMARY)?.value {
        Value::Rational(values) => values.first().map(|m| m.to_f32()).filter(|m| m.is_finite() && *m > 0.0),
        _ => None,
    }
}

/// Whether it says where the photo was taken.
pub fn has_position(tiff: &[u8]) -> bool {
    parse(tiff).is_some_and(|exif| exif.fields().any(|field| field.tag.context() == Context::Gps))
}

fn parse(tiff: &[u8]) -> Option<Exif> {
    Reader::new().continue_on_error(true).read_raw(tiff.to_vec()).or_else(|e| e.distill_partial_result(|_| ())).ok()
}
