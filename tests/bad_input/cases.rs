//! Bad files that somebody thought out.

use std::path::Path;

use image::ImageFormat;
use plenoscope::io::formats::{FieldToWrite, TABLE, views};
use plenoscope::io::{self, Opened, several};
use plenoscope::job::{Cancel, Job};

use crate::harness::{run, run_within};
use crate::seeds::As;
use crate::seeds::field;
use crate::{open, open_path, seeds};

fn refused(what: &str, bytes: &[u8]) -> String {
    run(what, || open(bytes)).err().unwrap_or_else(|| panic!("{what} is opened"))
}

/// Opens a photo that is sound but for its depth; what is said.
fn warned(what: &str, bytes: &[u8]) -> String {
    let opened = run(what, || open(bytes)).unwrap_or_else(|text| panic!("{what}: {text}"));
    assert!(opened.info().embedded_depth.is_none() && opened.info().warnings.len() == 1, "{what}: {:?}", opened.info());
    opened.info().warnings[0].clone()
}

/// Writes numbers over those behind a marker.
fn patched(mut bytes: Vec<u8>, marker: &[u8], skip: usize, numbers: &[u8]) -> Vec<u8> {
    let at = bytes.windows(marker.len()).position(|w| w == marker).unwrap() + marker.len() + skip;
    bytes[at..at + numbers.len()].copy_from_slice(numbers);
    bytes
}

#[test]
fn twenty_cuts_of_every_file() {
    let seeds = TABLE.iter().flat_map(|line| seeds::of(line.name)).filter(|seed| matches!(seed.opened, As::File(_)));
    for (name, whole) in seeds.flat_map(|seed| seed.whole.into_iter().map(move |whole| (seed.parser.clone(), whole))) {
        let last = whole.iter().rposition(|byte| *byte != 0).unwrap();
        for n in 0..20 {
            let what = format!("{name} cut at {n}/20");
            let Ok(opened) = run(&what, || open(&whole[..last * n / 20])) else { continue };
            let depth_is_behind = matches!(name.as_str(), "dynamic-depth" | "apple" | "heic" | "spatial");
            let warned = !opened.info().warnings.is_empty();
            let told = warned || depth_is_behind && opened.info().embedded_depth.is_none();
            assert!(told && (depth_is_behind || name == "avi"), "{what}: {:?}", opened.info());
        }
    }
}

#[test]
fn headers_that_claim_millions_of_pixels() {
    let side = 16_000u32;
    let (le, be) = (side.to_le_bytes(), side.to_be_bytes());
    let jpeg_size = [be[2], be[3], be[2], be[3]];
    let png = |mut bytes: Vec<u8>| {
        seeds::mend_png(&mut bytes);
        bytes
    };
    let cases = [
        ("JPEG", patched(seeds::jpeg(&[]), &[0xff, 0xc0], 3, &jpeg_size)),
        ("PNG", png(patched(seeds::still(ImageFormat::Png), b"IHDR", 0, &[be, be].concat()))),
        ("BMP", patched(seeds::still(ImageFormat::Bmp), b"BM", 16, &[le, le].concat())),
        ("PNM", [b"P6\n16000 16000\n255\n".to_vec(), vec![0; 900]].concat()),
        ("GIF", patched(seeds::still(ImageFormat::Gif), b"GIF89a", 0, &[le[0], le[1], le[0], le[1]])),
        ("WebP", solid_webp(side)),
        ("AVIF", patched(seeds::avif()[0].clone(), b"ispe", 4, &[be, be].concat())),
    ];
    // Its strips do not have the lengths that the size asks for.
    let tiff = patched(seeds::still(ImageFormat::Tiff), &[0, 1, 4, 0, 1, 0, 0, 0], 0, &le);
    refused("TIFF", &patched(tiff, &[1, 1, 4, 0, 1, 0, 0, 0], 0, &le));
    for (name, bytes) in cases {
        let text = refused(name, &bytes);
        assert!(text.contains("16000×16000"), "{name}: {text}");
    }
    let text = run("PFM", || plenoscope::io::formats::pfm::parse_pfm(b"Pf\n16000 16000\n-1\n0000")).unwrap_err();
    assert!(text.contains("16000×16000"), "{text}");
    let billion = png(patched(seeds::still(ImageFormat::Png), b"IHDR", 0, &[0, 0, 0x82, 0x35, 0, 0, 0x82, 0x35]));
    assert!(refused("a billion pixels", &billion).contains("more than fit"));
}

#[test]
fn animations_that_claim_millions_of_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let (le, be) = (60_000u16.to_le_bytes(), 60_000u32.to_be_bytes());
    let [gif, mut apng, _] = seeds::several().try_into().unwrap();
    // The first frame fills the canvas.
    apng = patched(patched(apng, b"IHDR", 0, &[be, be].concat()), b"fcTL", 4, &[be, be].concat());
    seeds::mend_png(&mut apng);
    for (name, bytes) in [("a.gif", patched(gif, b"GIF89a", 0, &[le, le].concat())), ("a.png", apng)] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let job = Job { cancel: &Cancel::default(), sink: &() };
        let text = run(name, || several::photos(&path, &job)).map(|photos| photos.len()).unwrap_err();
        assert!(text.contains("60000×60000"), "{name}: {text}");
    }
}

/// A whole picture of one colour in a few bytes.
fn solid_webp(side: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let small = image::RgbImage::from_pixel(16, 16, image::Rgb([9, 9, 9]));
    let encoder = image::codecs::webp::WebPEncoder::new_lossless(&mut bytes);
    small.write_with_encoder(encoder).unwrap();
    // VP8L: signature, then 14 bits of width − 1 and of height − 1.
    let at = bytes.windows(4).position(|w| w == b"VP8L").unwrap() + 9;
    let head = u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) & !0x0fff_ffff;
    bytes[at..at + 4].copy_from_slice(&(head | (side - 1) | (side - 1) << 14).to_le_bytes());
    bytes
}

#[test]
fn xmp_that_is_not_xml_or_never_ends() {
    let packet = |text: &str| seeds::jpeg(&[seeds::xmp(text)]);
    assert!(warned("broken", &packet("<x:xmpmeta><rdf:RDF GDepth=")).contains("XML"));
    assert!(warned("deep", &packet(&"<a>".repeat(5000))).contains("deep"));
    let laughs = (1..12).map(|n| format!("<!ENTITY a{n} \"{}\">", format!("&a{};", n - 1).repeat(10)));
    let laughs = format!("<!DOCTYPE x [<!ENTITY a0 \"ha\">{}]><x y=\"&a11;\">&a11;</x>", laughs.collect::<String>());
    let _either = run("entities", || open(&packet(&laughs)));
    // One long namespace and very many short properties.
    let many = format!("<x xmlns:a=\"{}\">{}</x>", "n".repeat(9000), "<y a:b=\"\"/>".repeat(4900));
    let _either = run("namespaces", || open(&packet(&many)));
}

#[test]
fn a_depth_map_that_is_broken_costs_the_depth_not_the_photo() {
    let whole = seeds::gdepth();
    let with =
        |from: &str, to: &str| patched(whole.clone(), &from.as_bytes()[..from.len() - to.len()], 0, to.as_bytes());
    assert!(warned("far before near", &with("GDepth:Near=\"1.0", "99.")).contains("99"));
    assert!(warned("no number", &with("GDepth:Far=\"10.0", "xx.x")).contains("Far"));
    assert!(warned("another checksum", &with("HasExtendedXMP=\"0000", "0000")).contains("XMP"));
    let mut base64 = whole.clone();
    let at = base64.windows(13).position(|w| w == b"GDepth:Data=\"").unwrap() + 13;
    base64[at..at + 8].copy_from_slice(b"????????");
    assert!(warned("no base64", &base64).contains("base64"));
}

#[test]
fn directories_that_lead_back_to_themselves() {
    // The EXIF directory is the main one again, and follows itself.
    let opened = run("exif", || open(&seeds::jpeg(&[seeds::exif(8)]))).unwrap();
    assert_eq!(opened.info().orientation, 6);
    for (name, parts) in [("itself", vec![1; 4]), ("itself very often", vec![1; 60_000])] {
        let text = refused(name, &heic_grid(&parts));
        assert!(text.contains("HEIC"), "{text}");
    }
}

/// A HEIC whose picture 1 is a grid of the pictures `parts`.
fn heic_grid(parts: &[u16]) -> Vec<u8> {
    let plain =
        |kind: &[u8; 4], content: &[u8]| [&(content.len() as u32 + 8).to_be_bytes(), &kind[..], content].concat();
    let full = |kind: &[u8; 4], version: u8, content: &[u8]| plain(kind, &[&[version, 0, 0, 0], content].concat());
    let handler = full(b"hdlr", 0, &[b"\0\0\0\0pict".as_slice(), &[0; 13]].concat());
    let primary = full(b"pitm", 0, &[0, 1]);
    let entry = full(b"infe", 2, b"\0\x01\0\0grid\0");
    let entries = full(b"iinf", 0, &[&[0, 1], &entry[..]].concat());
    let count = (parts.len() as u16).to_be_bytes();
    let to: Vec<u8> = parts.iter().flat_map(|part| part.to_be_bytes()).collect();
    let references = full(b"iref", 0, &plain(b"dimg", &[&[0, 1], &count[..], &to].concat()));
    let size = full(b"ispe", 0, &[0, 0, 0, 64, 0, 0, 0, 64]);
    let ties = full(b"ipma", 0, &[0, 0, 0, 1, 0, 1, 1, 1]);
    let properties = plain(b"iprp", &[plain(b"ipco", &size), ties].concat());
    // Version 1, offsets and lengths of 4 bytes, the item in `idat`.
    let place = full(b"iloc", 1, &[0x44, 0, 0, 1, 0, 1, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 8]);
    let grid = plain(b"idat", &[0, 0, 1, 1, 0, 64, 0, 64]);
    let meta = full(b"meta", 0, &[handler, primary, entries, references, properties, place, grid].concat());
    [plain(b"ftyp", b"heic\0\0\0\0mif1heic"), meta].concat()
}

#[test]
fn a_wrong_checksum_in_a_lytro_file() {
    let table = seeds::lfp_table();
    let whole = seeds::lfp([&seeds::jpeg(&[]), &seeds::jpeg(&[])], &table, r#""width":2,"height":2"#);
    let text = refused("sha1", &patched(whole, b"\"lambda\":", 0, b"8"));
    assert!(text.contains("checksum"), "{text}");
    let large = seeds::lfp([&seeds::jpeg(&[]), &seeds::jpeg(&[])], &table, r#""width":4000,"height":4000"#);
    assert!(warned("a depth table that is too short", &large).contains("cut off"));
}

#[test]
fn views_that_do_not_belong_together() {
    let (field, depths) = field();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("lf");
    let source = FieldToWrite { depths: Some(&depths), ..FieldToWrite::new(&field) };
    let write = || views::write(&path, &source, &Job { cancel: &Cancel::default(), sink: &() }).unwrap();
    let put = |name: &str, bytes: &[u8]| std::fs::write(path.join(name), bytes).unwrap();
    let told = |what: &str| run(what, || open_path(&path)).err().unwrap_or_else(|| panic!("{what} is opened"));
    write();
    std::fs::remove_file(path.join("view_1_0.png")).unwrap();
    assert!(told("missing").contains("(v 1, u 0)"));
    write();
    put("view_1_0.png", &seeds::still(ImageFormat::Png));
    let text = told("another size");
    assert!(text.contains("24×16") && text.contains("12×8") && text.ends_with("view_1_0.png"), "{text}");
    write();
    put("view_1_0.png", b"no picture");
    assert!(told("text").ends_with("view_1_0.png"));
    write();
    put("disparity_1_1.pfm", &seeds::pfm());
    let Opened::LightField(file) = run("a map of another shape", || open_path(&path)).unwrap() else { panic!() };
    assert!(file.depths.is_none() && file.warnings[0].contains("6×4 values"), "{:?}", file.warnings);
    put("lightfield.json", br#"{"grid":[1000000000,8]}"#);
    assert!(told("a grid of millions").contains("1 to 17"));
}

#[test]
fn a_depth_map_beside_the_photo_of_another_shape() {
    let dir = tempfile::tempdir().unwrap();
    let photo = dir.path().join("photo.jpg");
    std::fs::write(&photo, seeds::jpeg(&[])).unwrap();
    std::fs::write(dir.path().join("photo_depth.pfm"), b"Pf\n4 4\n-1\n").unwrap();
    for (bytes, word) in [(&b"Pf\n4 4\n-1\n"[..], "cut off"), (&[b"Pf\n1 4\n-1\n", &[0; 16][..]].concat(), "shape")] {
        std::fs::write(dir.path().join("photo_depth.pfm"), bytes).unwrap();
        let opened = run("beside", || open_path(&photo)).unwrap();
        assert!(opened.info().warnings[0].contains(word), "{:?}", opened.info().warnings);
    }
}

#[test]
fn files_that_are_no_pictures_are_not_read_whole() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("disk.img");
    // 8 GiB of nothing.
    std::fs::File::create(&path).unwrap().set_len(8 << 30).unwrap();
    let text = run_within(1 << 26, "a disk image", || open_path(&path)).unwrap_err();
    assert!(text.contains("no picture"), "{text}");
    assert!(io::open_bytes(b"", Some(Path::new("a"))).is_err());
}
