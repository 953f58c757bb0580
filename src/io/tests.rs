//! Photos made by the tests themselves: every kind opens as it should, and whatever is broken is told.

use std::io::Cursor;
use std::sync::Arc;

use image::{DynamicImage, ExtendedColorType, ImageEncoder, ImageFormat, Rgb, RgbImage, Rgba};
use jpeg_encoder::{ColorType as JpegColor, Encoder as JpegEncoder, SamplingFactor};
use moxcms::ColorProfile;

use super::*;
use crate::field::{Photo, PhotoPixels};

/// 24×16, every pixel its own colour.
fn picture() -> RgbImage {
    RgbImage::from_fn(24, 16, |x, y| Rgb([x as u8 * 10, y as u8 * 15, 255 - x as u8 * 7]))
}

fn encoded(picture: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn photo(bytes: &[u8]) -> PhotoFile {
    match open_bytes(bytes, None).unwrap() {
        Opened::Photo(file) => *file,
        Opened::LightField(_) => panic!("a photo"),
    }
}

fn pixel(photo: &Photo, x: u32, y: u32) -> [u8; 4] {
    let at = (y * photo.size()[0] + x) as usize * 4;
    photo.srgb8()[at..at + 4].try_into().unwrap()
}

/// A TIFF block that says only which way up.
fn exif(orientation: u8) -> Vec<u8> {
    let mut block = b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0".to_vec();
    block.extend([orientation, 0, 0, 0, 0, 0, 0]);
    block
}

/// 24×16 JPEG; the segments stand before the picture.
fn jpeg(segments: &[(u8, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = JpegEncoder::new(&mut bytes, 98);
    encoder.set_sampling_factor(SamplingFactor::R_4_4_4);
    for (number, data) in segments {
        encoder.add_app_segment(*number, data).unwrap();
    }
    encoder.encode(&picture(), 24, 16, JpegColor::Rgb).unwrap();
    bytes
}

#[test]
fn lossless_formats_give_the_pixels_back() {
    let source = DynamicImage::ImageRgb8(picture());
    for (format, name) in [
        (ImageFormat::Png, "PNG"),
        (ImageFormat::WebP, "WebP"),
        (ImageFormat::Tiff, "TIFF"),
        (ImageFormat::Bmp, "BMP"),
        (ImageFormat::Pnm, "PNM"),
    ] {
        let file = photo(&encoded(&source, format));
        assert_eq!((file.info.format, file.info.size, file.info.bits), (name, [24, 16], 8));
        assert_eq!(pixel(&file.photo, 5, 3), [50, 45, 220, 255], "{name}");
        let PhotoPixels::Eight(own) = file.photo.pixels() else { panic!("8 bits") };
        assert!(Arc::ptr_eq(own, file.photo.srgb8()), "{name}: an sRGB photo is kept once");
    }
    let gif = encoded(&DynamicImage::ImageRgba8(DynamicImage::ImageRgb8(picture()).into_rgba8()), ImageFormat::Gif);
    assert_eq!(photo(&gif).info.size, [24, 16]);
}

#[test]
fn sixteen_bits_grey_and_alpha_are_read() {
    let deep = image::ImageBuffer::<Rgb<u16>, _>::from_fn(4, 4, |x, _| Rgb([x as u16 * 257 + 1, 65_535, 0]));
    let file = photo(&encoded(&DynamicImage::ImageRgb16(deep), ImageFormat::Png));
    let PhotoPixels::Sixteen(own) = file.photo.pixels() else { panic!("16 bits") };
    assert_eq!((own[4], own[5], file.info.bits, pixel(&file.photo, 1, 0)), (258, 65_535, 16, [1, 255, 0, 255]));

    let grey = image::GrayImage::from_fn(4, 4, |x, y| image::Luma([(x * 4 + y) as u8]));
    assert_eq!(pixel(&photo(&encoded(&grey.into(), ImageFormat::Png)).photo, 2, 1), [9, 9, 9, 255]);

    let glass = image::RgbaImage::from_pixel(2, 2, Rgba([255, 0, 0, 128]));
    let seen = pixel(&photo(&encoded(&glass.into(), ImageFormat::Png)).photo, 0, 0);
    assert_eq!(seen, [255, 127, 127, 255], "composited onto white");
}

#[test]
fn a_palette_with_transparency_is_read() {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(vec![10, 20, 30, 40, 50, 60]);
    encoder.set_trns(vec![255, 0]);
    encoder.write_header().unwrap().write_image_data(&[0, 1]).unwrap();
    let file = photo(&bytes);
    assert_eq!((pixel(&file.photo, 0, 0), pixel(&file.photo, 1, 0)), ([10, 20, 30, 255], [255; 4]));
}

#[test]
fn all_eight_orientations_stand_upright() {
    let upright = |orientation: u8, x: u32, y: u32| match orientation {
        1 => [x, y],
        2 => [23 - x, y],
        3 => [23 - x, 15 - y],
        4 => [x, 15 - y],
        5 => [y, x],
        6 => [15 - y, x],
        7 => [15 - y, 23 - x],
        _ => [y, 23 - x],
    };
    for orientation in 1..=8 {
        let file = photo(&jpeg(&[(1, [b"Exif\0\0".to_vec(), exif(orientation)].concat())]));
        assert_eq!(file.info.orientation, orientation);
        assert_eq!(file.info.size, if orientation < 5 { [24, 16] } else { [16, 24] });
        for (x, y) in [(2, 3), (20, 12), (0, 15)] {
            let [sx, sy] = upright(orientation, x, y);
            let (seen, want) = (pixel(&file.photo, sx, sy), picture().get_pixel(x, y).0);
            assert!(seen.iter().zip(want).all(|(a, b)| a.abs_diff(b) < 12), "{orientation}: {seen:?} for {want:?}");
        }
        assert!(file.photo.metadata().exif.is_some());
    }
}

/// A PNG of one colour with a profile.
fn tagged(icc: Vec<u8>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = image::codecs::png::PngEncoder::new(&mut bytes);
    encoder.set_icc_profile(icc).unwrap();
    let px = [100, 200, 100].repeat(4);
    encoder.write_image(&px, 2, 2, ExtendedColorType::Rgb8).unwrap();
    bytes
}

#[test]
fn a_profile_that_unpacks_to_more_than_any_has_is_left_out() {
    let is_kept = |more: usize| {
        let icc = [ColorProfile::new_display_p3().encode().unwrap(), vec![0; more]].concat();
        let bytes = tagged(icc);
        assert!(bytes.len() < 1 << 20, "it is to be packed");
        photo(&bytes).photo.metadata().icc.is_some()
    };
    assert!(is_kept(1 << 20));
    assert!(!is_kept(65 << 20));
}

#[test]
fn a_wide_profile_is_kept_for_export_and_converted_for_work() {
    let icc = ColorProfile::new_display_p3().encode().unwrap();
    let file = photo(&tagged(icc.clone()));
    assert_eq!(file.photo.metadata().icc.as_deref(), Some(&icc[..]));
    let PhotoPixels::Eight(own) = file.photo.pixels() else { panic!() };
    // P3 (100, 200, 100) is sRGB (34, 203, 89): greener than it looks.
    let [r, g, b, _] = pixel(&file.photo, 0, 0);
    assert_eq!(own[..3], [100, 200, 100]);
    assert!(r < 60 && (200..=206).contains(&g) && b < 97, "{r} {g} {b}");
    assert!(file.info.profile.is_some_and(|name| name.contains("P3")));

    let srgb = photo(&tagged(ColorProfile::new_srgb().encode().unwrap()));
    let PhotoPixels::Eight(own) = srgb.photo.pixels() else { panic!() };
    assert!(Arc::ptr_eq(own, srgb.photo.srgb8()));
    let broken = photo(&tagged(b"no profile".to_vec()));
    assert_eq!(pixel(&broken.photo, 0, 0)[0], 100);
}

#[test]
fn cmyk_becomes_rgb() {
    // jpeg-encoder writes inks as Adobe does: inverted.
    let mut bytes = Vec::new();
    let inks = [[0u8, 255, 255, 0]; 64].concat();
    JpegEncoder::new(&mut bytes, 98).encode(&inks, 8, 8, JpegColor::Cmyk).unwrap();
    let [r, g, b, _] = pixel(&photo(&bytes).photo, 3, 3);
    assert!(r > 240 && g < 15 && b < 15, "magenta and yellow ink make red, not {r} {g} {b}");
}

#[test]
fn one_pixel_and_one_column_open() {
    for (w, h) in [(1, 1), (1, 40), (30_000, 1)] {
        let line = RgbImage::from_pixel(w, h, Rgb([1, 2, 3]));
        for format in [ImageFormat::Png, ImageFormat::Tiff, ImageFormat::Bmp] {
            assert_eq!(photo(&encoded(&line.clone().into(), format)).info.size, [w, h]);
        }
    }
}

#[test]
fn what_is_no_picture_is_told_in_one_sentence() {
    assert!(matches!(open_bytes(b"", None), Err(OpenError::File { problem: Problem::Empty, .. })));
    for bytes in [&b"hello"[..], b"%PDF-1.7", &[0; 64]] {
        assert!(matches!(open_bytes(bytes, None), Err(OpenError::File { problem: Problem::Unknown, .. })));
    }
    let error = open_bytes(b"hello", Some(std::path::Path::new("a/b.txt"))).unwrap_err().to_string();
    assert!(error.ends_with(": a/b.txt") && error.matches(" — ").count() == 2 && !error.contains('\n'), "{error}");
}

#[test]
fn files_cut_off_at_twenty_places_are_refused() {
    let noisy = RgbImage::from_fn(64, 64, |x, y| Rgb([(x * y) as u8, (x * 31 + y * 17) as u8, (x ^ y) as u8]));
    let source = DynamicImage::ImageRgb8(noisy);
    let formats = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP, ImageFormat::Tiff, ImageFormat::Bmp];
    for format in formats {
        let whole = encoded(&source, format);
        for n in 0..20 {
            let end = whole.len() * n / 21;
            assert!(open_bytes(&whole[..end], None).is_err(), "{format:?} cut at {end} of {}", whole.len());
        }
    }
}

/// A picture large enough for many rows of blocks; progressive or not, with restart markers or not.
fn long_jpeg(progressive: bool, restart: u16, color: JpegColor) -> Vec<u8> {
    let noisy = RgbImage::from_fn(160, 128, |x, y| Rgb([(x * y) as u8, (x * 31 + y * 17) as u8, (x ^ y) as u8]));
    let mut bytes = Vec::new();
    let mut encoder = JpegEncoder::new(&mut bytes, 80);
    encoder.set_progressive(progressive);
    if restart > 0 {
        encoder.set_restart_interval(restart);
    }
    let gray = DynamicImage::ImageRgb8(noisy.clone()).into_luma8();
    let pixels = if color == JpegColor::Luma { gray.as_raw() } else { noisy.as_raw() };
    encoder.encode(pixels, 160, 128, color).unwrap();
    bytes
}

#[test]
fn a_jpeg_whose_data_end_early_opens_with_a_warning_and_a_whole_one_without() {
    for color in [JpegColor::Rgb, JpegColor::Luma] {
        for (progressive, restart) in [(false, 0), (false, 3), (true, 0)] {
            let what = format!("{color:?}, progressive {progressive}, restart {restart}");
            let whole = long_jpeg(progressive, restart, color);
            let start = whole.windows(2).position(|w| w == [0xff, 0xda]).unwrap() + 16;
            assert!(photo(&whole).warnings.is_empty(), "{what}: {:?}", photo(&whole).warnings);
            for share in [1, 3, 6] {
                // Cut, and then an end marker: a file that a camera could not finish.
                let mut short = whole[..start + (whole.len() - start) * share / 8].to_vec();
                if short.last() == Some(&0xff) {
                    short.pop();
                }
                short.extend([0xff, 0xd9]);
                let file = photo(&short);
                assert!(file.warnings.len() == 1 && file.warnings[0].contains("early"), "{what}: {:?}", file.warnings);
            }
        }
    }
    // A header that says more rows than there are; in passes that is seen where it says very many more.
    for (progressive, frame, high_byte) in [(false, 0xc0, 1), (true, 0xc2, 40)] {
        let mut taller = long_jpeg(progressive, 0, JpegColor::Rgb);
        let at = taller.windows(2).position(|w| w == [0xff, frame]).unwrap();
        taller[at + 5] = high_byte;
        let file = photo(&taller);
        assert_eq!((file.info.size, file.warnings.len()), ([160, u32::from(high_byte) * 256 + 128], 1));
    }
}

#[test]
fn a_progressive_jpeg_holds_as_many_numbers_as_its_sampling_says() {
    let held = |progressive: bool, sampling| {
        let mut bytes = Vec::new();
        let mut encoder = JpegEncoder::new(&mut bytes, 80);
        encoder.set_progressive(progressive);
        encoder.set_sampling_factor(sampling);
        encoder.encode(&[9; 3 * 160 * 130], 160, 130, JpegColor::Rgb).unwrap();
        jpeg_parts::parse(&bytes).held_numbers()
    };
    // 130 rows are 17 of blocks, or 9 of units of two.
    assert_eq!(
        [held(true, SamplingFactor::F_1_1), held(true, SamplingFactor::F_2_2)],
        [Some(3 * 160 * 136), Some(160 * 144 * 3 / 2)]
    );
    assert_eq!(held(false, SamplingFactor::F_2_2), None);
}

#[test]
fn headers_that_lie_about_their_size_are_refused_at_once() {
    // A PNG whose header says 30,000 × 30,000, with the right checksum, and whose data begin.
    let mut header = Vec::new();
    let mut writer = png::Encoder::new(&mut header, 30_000, 30_000).write_header().unwrap();
    writer.write_chunk(png::chunk::IDAT, &[0x78, 0x9c, 0, 0]).unwrap();
    drop(writer);
    let refused = open_bytes(&header, None);
    assert!(matches!(refused, Err(OpenError::File { problem: Problem::TooLarge { .. }, .. })), "{refused:?}");
    let mut bmp = encoded(&DynamicImage::ImageRgb8(picture()), ImageFormat::Bmp);
    bmp[18..26].copy_from_slice(&[0x30, 0x75, 0, 0, 0x30, 0x75, 0, 0]);
    assert!(open_bytes(&bmp, None).is_err());
    let mut frame = jpeg(&[]);
    let start = frame.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
    frame[start + 5..start + 9].copy_from_slice(&[0xff, 0xff, 0xff, 0xff]);
    assert!(matches!(open_bytes(&frame, None), Err(OpenError::File { problem: Problem::TooLarge { .. }, .. })));
}

#[test]
fn xmp_that_is_no_xml_is_a_warning() {
    let packet = [b"http://ns.adobe.com/xap/1.0/\0".to_vec(), b"<x:xmpmeta><rdf:RDF GDepth=".to_vec()].concat();
    let file = photo(&jpeg(&[(1, packet)]));
    assert!(file.warnings.len() == 1 && file.warnings == file.info.warnings, "{:?}", file.warnings);
    assert!(file.warnings[0].contains("XML"));
}

/// A small generator, so that a failure can be repeated.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % n
    }
}

/// Files with flipped, cut, doubled and overwritten bytes: an error or a picture, never a panic.
#[test]
fn damaged_files_never_panic() {
    let source = DynamicImage::ImageRgb8(picture());
    let mut files: Vec<Vec<u8>> = [ImageFormat::Png, ImageFormat::WebP, ImageFormat::Tiff, ImageFormat::Bmp]
        .map(|format| encoded(&source, format))
        .into();
    files.push(jpeg(&[(1, [b"Exif\0\0".to_vec(), exif(6)].concat())]));
    files.push(heifer::encode_rgb8(24, 16, &picture(), &heifer::EncodeOptions::default()).unwrap());
    let dir = tempfile::tempdir().unwrap();
    let view = crate::field::View::new([24, 16], [90, 120, 60, 255].repeat(24 * 16)).unwrap();
    let map = DisparityMap::constant([8, 6], 1.0);
    formats::depth_out::write_gdepth(&dir.path().join("d.jpg"), formats::depth_out::Seen::View(&view), &map, 90)
        .unwrap();
    files.push(std::fs::read(dir.path().join("d.jpg")).unwrap());
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for whole in &files {
        for _ in 0..150 {
            let mut bytes = whole.clone();
            for _ in 0..1 + random.below(6) {
                let at = random.below(bytes.len());
                match random.below(4) {
                    0 => bytes[at] ^= 1 << random.below(8),
                    1 => bytes[at] = [0, 0xff, 0x7f, 0x80][random.below(4)],
                    2 if at > 8 => bytes.truncate(at),
                    _ => {
                        let from = random.below(bytes.len());
                        let piece = bytes[from..(from + 16).min(bytes.len())].to_vec();
                        bytes.splice(at..at, piece);
                    }
                }
            }
            let _either = open_bytes(&bytes, None);
        }
    }
}

/// A HEIC whose alpha plane has been relabelled as a depth map: larger to the right.
fn heic_with_depth() -> Vec<u8> {
    let rgba: Vec<u8> = (0..64 * 48).flat_map(|n| [200, 100, 50, (n % 64 * 4) as u8]).collect();
    let mut bytes = heifer::encode_rgba8(64, 48, &rgba, &heifer::EncodeOptions::default()).unwrap();
    let urn = b"urn:mpeg:hevc:2015:auxid:1";
    let at = bytes.windows(urn.len()).position(|w| w == urn).unwrap();
    bytes[at + urn.len() - 1] = b'2';
    bytes
}

#[test]
fn a_heic_opens_with_its_depth_map() {
    let file = photo(&heic_with_depth());
    assert_eq!((file.info.format, file.info.size), ("HEIC", [64, 48]));
    let [r, g, b, a] = pixel(&file.photo, 30, 20);
    assert!(r.abs_diff(200) < 8 && g.abs_diff(100) < 8 && b.abs_diff(50) < 8 && a == 255, "{r} {g} {b} {a}");
    let depth = file.depth.unwrap();
    assert_eq!((depth.kind, depth.map.size()), (DepthKind::ApplePortrait, [64, 48]));
    let row = &depth.map.nearness()[20 * 64..21 * 64];
    assert!(row[4] < 0.2 && row[60] > 0.8, "{} {}", row[4], row[60]);
}

/// Item and property boxes that count or point wrongly.
#[test]
fn damaged_heic_containers_never_panic() {
    let whole = heic_with_depth();
    let mdat = whole.windows(4).position(|w| w == b"mdat").unwrap();
    let mut random = Random(7);
    for _ in 0..400 {
        let mut bytes = whole.clone();
        for _ in 0..1 + random.below(3) {
            let at = random.below(mdat.min(bytes.len()));
            bytes[at] = [0, 1, 0x7f, 0xff][random.below(4)];
        }
        let _either = open_bytes(&bytes, None);
    }
    for n in 0..20 {
        let cut = open_bytes(&whole[..whole.len() * n / 21], None);
        let told = cut.as_ref().is_ok_and(|opened| !opened.info().warnings.is_empty());
        assert!(cut.is_err() || told, "cut at {n}/21");
    }
}

/// A JPEG with a depth map behind it, as Android's cameras write them.
fn dynamic_depth(length: usize) -> Vec<u8> {
    let map = image::GrayImage::from_fn(8, 6, |x, _| image::Luma([x as u8 * 36]));
    let payload = encoded(&map.into(), ImageFormat::Png);
    let length = if length == 0 { payload.len() } else { length };
    let ns = |name: &str| format!(r#"xmlns:{name}="http://ns.google.com/photos/dd/1.0/{}/""#, name.to_lowercase());
    let packet = format!(
        r#"<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">
        <rdf:Description {} {} {} {}><DepthMap:Format>RangeInverse</DepthMap:Format><DepthMap:Near>0.5</DepthMap:Near>
        <DepthMap:Far>10</DepthMap:Far><DepthMap:Units>Meters</DepthMap:Units><DepthMap:DepthURI>android/depthmap</DepthMap:DepthURI>
        <Container:Directory><rdf:Seq>
        <rdf:li><Container:Item Item:Mime="image/jpeg" Item:Length="0" Item:DataURI="primary_image"/></rdf:li>
        <rdf:li><Container:Item Item:Mime="image/jpeg" Item:Length="11" Item:DataURI="other"/></rdf:li>
        <rdf:li><Container:Item Item:Mime="image/png" Item:Length="{length}" Item:DataURI="android/depthmap"/></rdf:li>
        </rdf:Seq></Container:Directory></rdf:Description></rdf:RDF></x:xmpmeta>"#,
        ns("DepthMap"),
        ns("Container"),
        ns("Item"),
        ns("Device"),
    );
    let mut bytes = jpeg(&[(1, [b"http://ns.adobe.com/xap/1.0/\0".to_vec(), packet.into_bytes()].concat())]);
    bytes.extend(b"a gain map.");
    bytes.extend(payload);
    bytes
}

#[test]
fn dynamic_depth_is_read_in_metres_with_near_first() {
    let file = photo(&dynamic_depth(0));
    assert!(file.warnings.is_empty(), "{:?}", file.warnings);
    let depth = file.depth.unwrap();
    assert_eq!((depth.kind, depth.map.size(), depth.metric), (DepthKind::DynamicDepth, [8, 6], true));
    // Value 0 is the near end, 0.5 m; the range goes on linearly in 1/m.
    assert!((depth.map.nearness()[0] - 2.0).abs() < 1e-4);
    let n = 252.0 / 255.0;
    assert!((depth.map.nearness()[7] - (2.0 - n * 1.9)).abs() < 1e-4, "{}", depth.map.nearness()[7]);
    let [near, far] = file.info.embedded_depth.unwrap().range_m.unwrap();
    assert!((near - 0.5).abs() < 1e-3 && far > 5.0 && far <= 10.0);
}

#[test]
fn item_lengths_that_lie_cost_the_depth_not_the_photo() {
    for length in [5, 1_000_000, usize::MAX] {
        let file = photo(&dynamic_depth(length));
        assert!(file.depth.is_none() && file.warnings.len() == 1, "{length}: {:?}", file.warnings);
    }
}

#[test]
fn apples_second_picture_is_turned_with_the_photo() {
    let xmp = r#"<x:xmpmeta xmlns:x="adobe:ns:meta/"><r xmlns:apdi="http://ns.apple.com/pixeldatainfo/1.0/">
        <apdi:AuxiliaryImageType>disparity</apdi:AuxiliaryImageType><apdi:FloatMinValue>1.0</apdi:FloatMinValue>
        <apdi:FloatMaxValue>3.0</apdi:FloatMaxValue></r></x:xmpmeta>"#;
    let mut second = Vec::new();
    let mut encoder = JpegEncoder::new(&mut second, 98);
    encoder.add_app_segment(1, &[b"http://ns.adobe.com/xap/1.0/\0", xmp.as_bytes()].concat()).unwrap();
    // White at the top of the stored map.
    let map: Vec<u8> = (0..24 * 16).map(|n| if n / 24 < 8 { 255 } else { 0 }).collect();
    encoder.encode(&map, 24, 16, JpegColor::Luma).unwrap();
    let first = jpeg(&[(1, [b"Exif\0\0".to_vec(), exif(6)].concat())]);
    let file = photo(&[first, vec![0; 20], second].concat());
    let depth = file.depth.unwrap();
    assert_eq!((depth.kind, depth.map.size(), file.info.size), (DepthKind::ApplePortrait, [16, 24], [16, 24]));
    // Orientation 6 turns the stored top to the right.
    let row = &depth.map.nearness()[12 * 16..13 * 16];
    assert!((row[14] - 3.0).abs() < 0.05 && (row[1] - 1.0).abs() < 0.05, "{row:?}");
}

/// An even surface of many megapixels is a small file, and no lie.
#[test]
fn large_even_pictures_open() {
    let even = image::GrayImage::from_pixel(9000, 8000, image::Luma([128]));
    let bytes = encoded(&DynamicImage::ImageLuma8(even), ImageFormat::Png);
    assert!(bytes.len() * 100 < 9000 * 8000, "{}", bytes.len());
    let raster = crate::io::raster::decode(&bytes).unwrap();
    assert_eq!(raster.size, [9000, 8000]);
    assert!(crate::io::raster::check_size(16_000, 16_000, 4, 2000).is_err());
}
