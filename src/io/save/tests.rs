//! What is written is read back by other readers: values, profile, EXIF, XMP, and what was asked to go is gone.

use std::path::Path;
use std::sync::{Arc, LazyLock};

use image::ImageDecoder;

use super::*;

const ALL: [(&str, Format); 4] =
    [("a.png", Format::Png), ("a.jpg", Format::Jpeg), ("a.tif", Format::Tiff), ("a.webp", Format::WebP)];

fn gradient(bits: u8) -> Pixels {
    let value = |i: usize| (i * 65535 / (20 * 12 * 3)) as u16;
    let samples = match bits {
        8 => Samples::Eight((0..20 * 12 * 3).map(|i| (value(i) >> 8) as u8).collect()),
        _ => Samples::Sixteen((0..20 * 12 * 3).map(value).collect()),
    };
    Pixels { size: [20, 12], samples }
}

/// Orientation 6 and a position: `II`, two entries.
fn exif_block() -> Vec<u8> {
    let mut b = b"II*\0\x08\0\0\0\x02\0".to_vec();
    b.extend([0x12, 0x01, 3, 0, 1, 0, 0, 0, 6, 0, 0, 0]);
    b.extend([0x25, 0x88, 4, 0, 1, 0, 0, 0, 38, 0, 0, 0]);
    b.extend([0, 0, 0, 0]);
    b.extend([1, 0, 1, 0, 2, 0, 2, 0, 0, 0, b'N', 0, 0, 0, 0, 0, 0, 0]);
    b
}

/// Encoded once, as the time stands in it.
fn display_p3() -> Arc<[u8]> {
    static ICC: LazyLock<Arc<[u8]>> = LazyLock::new(|| moxcms::ColorProfile::new_display_p3().encode().unwrap().into());
    Arc::clone(&ICC)
}

fn options(keep: Keep) -> PictureOptions {
    let icc = display_p3();
    let xmp: Arc<[u8]> = Arc::from(&b"<x tiff:Orientation=\"6\" exif:GPSLatitude=\"1\" a:b=\"kept\"/>"[..]);
    let metadata = Metadata { icc: Some(icc), exif: Some(exif_block().into()), xmp: Some(xmp), orientation: 6 };
    PictureOptions { keep, origin: Origin { metadata, ..Origin::default() }, quality: 100, ..PictureOptions::default() }
}

fn profile(path: &Path) -> Option<Vec<u8>> {
    if Format::of(path) == Some(Format::Tiff) {
        let mut decoder = tiff::decoder::Decoder::new(std::fs::File::open(path).unwrap()).unwrap();
        return Some(decoder.get_tag_u8_vec(tiff::tags::Tag::IccProfile).unwrap());
    }
    image::ImageReader::open(path).unwrap().into_decoder().unwrap().icc_profile().unwrap()
}

#[test]
fn lossless_formats_give_back_every_value_at_8_and_16_bits() {
    let dir = tempfile::tempdir().unwrap();
    for (name, format) in ALL.into_iter().filter(|(_, f)| *f != Format::Jpeg) {
        for bits in [8, 16].into_iter().filter(|&bits| bits == 8 || format.has_16_bits()) {
            let path = dir.path().join(name);
            let picture = gradient(bits);
            pixels(&path, &picture, &PictureOptions::default()).unwrap();
            let read = image::open(&path).unwrap();
            match &picture.samples {
                Samples::Eight(px) => assert_eq!(read.as_rgb8().unwrap().as_raw(), px, "{name}"),
                Samples::Sixteen(px) => assert_eq!(read.as_rgb16().unwrap().as_raw(), px, "{name}"),
            }
        }
    }
}

#[test]
fn a_jpeg_of_best_quality_is_close_and_has_no_subsampled_colour() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.jpg");
    let stripes: Vec<u8> = (0..32 * 16).flat_map(|i| if i % 2 == 0 { [255, 0, 0] } else { [0, 0, 255] }).collect();
    let picture = Pixels { size: [32, 16], samples: Samples::Eight(stripes.clone()) };
    pixels(&path, &picture, &options(Keep::All)).unwrap();
    let read = image::open(&path).unwrap().into_rgb8();
    assert!(read.as_raw().iter().zip(&stripes).all(|(a, b)| a.abs_diff(*b) < 16));
}

#[test]
fn every_format_carries_the_profile_and_an_upright_exif_block() {
    let dir = tempfile::tempdir().unwrap();
    for (name, _) in ALL {
        let path = dir.path().join(name);
        pixels(&path, &gradient(8), &options(Keep::All)).unwrap();
        assert_eq!(profile(&path).as_deref(), Some(&*display_p3()), "{name}");
        let bytes = std::fs::read(&path).unwrap();
        let block = ::exif::Reader::new().read_from_container(&mut std::io::Cursor::new(&bytes)).unwrap();
        let orientation = block.get_field(::exif::Tag::Orientation, ::exif::In::PRIMARY);
        assert!(orientation.is_none_or(|f| f.value.get_uint(0) == Some(1)), "{name}");
        assert!(block.get_field(::exif::Tag::GPSLatitudeRef, ::exif::In::PRIMARY).is_some(), "{name}");
        let has = |text: &[u8]| bytes.windows(text.len()).any(|w| w == text);
        assert!(has(b"tiff:Orientation=\"1\"") && has(b"kept") && has(b"GPSLatitude"), "{name}");
    }
}

#[test]
fn the_position_or_everything_is_left_out_where_asked() {
    let dir = tempfile::tempdir().unwrap();
    for (name, _) in ALL {
        let path = dir.path().join(name);
        let read = |keep| {
            pixels(&path, &gradient(8), &options(keep)).unwrap();
            std::fs::read(&path).unwrap()
        };
        let has = |bytes: &[u8], text: &[u8]| bytes.windows(text.len()).any(|w| w == text);
        let without = read(Keep::WithoutPosition);
        assert!(!has(&without, b"GPSLatitude") && has(&without, b"kept"), "{name}");
        let block = ::exif::Reader::new().read_from_container(&mut std::io::Cursor::new(&without));
        assert!(block.is_ok_and(|b| b.fields().all(|f| f.tag.context() != ::exif::Context::Gps)), "{name}");
        let nothing = read(Keep::Nothing);
        assert!(!has(&nothing, b"kept"), "{name}");
        assert!(profile(&path).is_some(), "{name}");
    }
}

#[test]
fn names_say_formats() {
    assert_eq!(Format::of(Path::new("a/B.JPeG")), Some(Format::Jpeg));
    assert_eq!(Format::of(Path::new("a.tif")), Some(Format::Tiff));
    assert_eq!(Format::of(Path::new("png")), None);
}

#[test]
fn the_source_is_protected_by_any_of_its_names() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("photo.png");
    std::fs::write(&path, b"the photo").unwrap();
    let mut options = PictureOptions::default();
    options.origin.source = Some(dir.path().join(".").join("photo.png"));
    let grey = Picture { size: [1, 1], rgb_linear: vec![0.5; 3] };
    assert!(matches!(picture(&path, &grey, &options), Err(SaveError::IsSource(_))));
    assert_eq!(std::fs::read(&path).unwrap(), b"the photo");
    options.replace_source = true;
    picture(&path, &grey, &options).unwrap();
    assert_ne!(std::fs::read(&path).unwrap(), b"the photo");
}
