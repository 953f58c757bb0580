//! Files that another program has encoded (`tests/avif/README.md`): their pixels are those that were drawn.

use super::*;
use crate::io::{OpenError, Opened, PhotoFile, open_bytes};

macro_rules! file {
    ($name:literal) => {
        include_bytes!(concat!("../../../../tests/avif/", $name, ".avif")).as_slice()
    };
}

/// The ramp that was drawn.
fn truth([width, height]: [u32; 2], x: u32, y: u32) -> [u32; 3] {
    [x * 240 / (width - 1), y * 240 / (height - 1), 255 - x * 160 / (width - 1)]
}

/// Pixels in 16 bits, row by row.
fn sixteen(raster: &Raster) -> Vec<[u32; 4]> {
    match &raster.samples {
        Samples::Eight(pixels) => pixels.iter().map(|px| px.map(|value| u32::from(value) * 257)).collect(),
        Samples::Sixteen(pixels) => pixels.iter().map(|px| px.map(u32::from)).collect(),
    }
}

/// The largest difference of a colour to the ramp, in steps of 8 bits.
fn worst(raster: &Raster, truth: impl Fn(u32, u32) -> [u32; 3]) -> f64 {
    worst_inside(raster, 0, truth)
}

/// The same without a margin.
fn worst_inside(raster: &Raster, margin: u32, truth: impl Fn(u32, u32) -> [u32; 3]) -> f64 {
    let [width, height] = raster.size;
    let pixels = sixteen(raster);
    assert_eq!(pixels.len() as u32, width * height);
    let inside =
        |n: u32| (margin..width - margin).contains(&(n % width)) && (margin..height - margin).contains(&(n / width));
    let differences = pixels.iter().zip(0..).filter(|&(_, n)| inside(n)).flat_map(|(px, n)| {
        let wanted = truth(n % width, n / width);
        (0..3).map(move |c| f64::from(px[c].abs_diff(wanted[c] * 257)) / 257.0)
    });
    differences.fold(0.0, f64::max)
}

fn photo(bytes: &[u8]) -> PhotoFile {
    match open_bytes(bytes, None).unwrap() {
        Opened::Photo(file) => *file,
        Opened::LightField(_) => panic!("a photo"),
    }
}

/// Writes other bytes over the only place that has these.
fn patched(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let places: Vec<usize> = (0..bytes.len() - from.len()).filter(|&at| bytes[at..].starts_with(from)).collect();
    assert_eq!(places.len(), 1, "{from:?}");
    bytes[places[0]..][..to.len()].copy_from_slice(to);
    bytes
}

#[test]
fn every_coding_gives_the_ramp_back() {
    // Inside, and at the border: halved colours go on level there, and the ramp changes by 15 steps a pixel.
    for (name, bytes, bits, inside, border) in [
        ("lossless", file!("lossless"), 8, 0.0, 0.0),
        ("limited_420", file!("limited_420"), 8, 3.0, 9.0),
        ("bt2020_10bit_422", file!("bt2020_10bit_422"), 16, 3.0, 9.0),
        ("bt601_12bit_444", file!("bt601_12bit_444"), 16, 2.0, 2.0),
        ("ycgco", file!("ycgco"), 8, 3.0, 3.0),
        ("tagged", file!("tagged"), 8, 3.0, 3.0),
    ] {
        let raster = decode(bytes).unwrap();
        assert_eq!((raster.size, raster.has_alpha), ([25, 17], false), "{name}");
        assert_eq!(matches!(raster.samples, Samples::Eight(_)), bits == 8, "{name}");
        let truth = |x, y| truth([25, 17], x, y);
        let found = [worst_inside(&raster, 2, truth), worst(&raster, truth)];
        assert!(found[0] <= inside && found[1] <= border, "{name}: {found:?}");
        assert_eq!(header_size(bytes).unwrap(), [25, 17]);
    }
}

#[test]
fn grey_is_grey() {
    let raster = decode(file!("grey_10bit_limited")).unwrap();
    assert!(worst(&raster, |x, _| [x * 10; 3]) <= 1.5);
    assert!(sixteen(&raster).iter().all(|px| px[0] == px[1] && px[1] == px[2] && px[3] == 65_535));
}

#[test]
fn opacity_is_read_and_taken_out_of_multiplied_colours() {
    for (name, bytes) in [("plain", file!("opacity")), ("multiplied", file!("opacity_premultiplied"))] {
        let raster = decode(bytes).unwrap();
        assert!(raster.has_alpha, "{name}");
        for (px, n) in sixteen(&raster).iter().zip(0u32..) {
            let (x, y) = (n % 25, n / 25);
            assert_eq!(px[3], (255 - 15 * y) * 257, "{name} at {x} {y}");
            // Few steps are left of what is multiplied with little.
            let tolerance = if name == "plain" { 3 } else { 3 + 600 / (255 - 15 * y).max(1) };
            let wanted = truth([25, 17], x, y);
            let near = (0..3).all(|c| px[c].abs_diff(wanted[c] * 257) <= tolerance * 257);
            assert!(near || y == 17 - 1, "{name} at {x} {y}: {px:?} for {wanted:?}");
        }
        let [r, g, b, a] = photo(bytes).photo.srgb8()[16 * 25 * 4..].first_chunk().copied().unwrap();
        assert!(r >= 238 && g >= 238 && b >= 238 && a == 255, "{name}: nearly clear on white is {r} {g} {b}");
    }
}

#[test]
fn a_grid_is_put_together_and_cut() {
    let whole = decode(file!("grid")).unwrap();
    assert_eq!(whole.size, [128, 128]);
    let worst_of_whole = worst(&whole, |x, y| truth([128, 128], x, y));
    assert!(worst_of_whole <= 6.0, "{worst_of_whole}");
    // The grid's own box: version, flags, rows − 1, columns − 1, width, height.
    let cut = decode(&patched(file!("grid"), &[0, 0, 1, 1, 0, 128, 0, 128], &[0, 0, 1, 1, 0, 101, 0, 77])).unwrap();
    assert_eq!(cut.size, [101, 77]);
    assert!(worst(&cut, |x, y| truth([128, 128], x, y)) <= 6.0);
    for lie in [[0, 0, 1, 1, 0, 64, 0, 128], [0, 0, 1, 1, 0, 129, 0, 128], [0, 0, 1, 2, 0, 128, 0, 128]] {
        let refused = decode(&patched(file!("grid"), &[0, 0, 1, 1, 0, 128, 0, 128], &lie));
        assert!(matches!(&refused, Err(Problem::Damaged { reason, .. }) if reason.contains("grid")), "{refused:?}");
    }
}

#[test]
fn turns_are_those_of_the_container() {
    // A quarter anticlockwise: the upper right corner comes to the upper left.
    let turned = photo(file!("turned"));
    assert_eq!((turned.info.size, turned.info.orientation), ([17, 25], 8));
    let at = |file: &PhotoFile, x: u32, y: u32| {
        let at = (y * file.info.size[0] + x) as usize * 4;
        let px = &file.photo.srgb8()[at..at + 3];
        [u32::from(px[0]), u32::from(px[1]), u32::from(px[2])]
    };
    let size = [25, 17];
    assert_eq!([at(&turned, 0, 0), at(&turned, 16, 0)], [truth(size, 24, 0), truth(size, 24, 16)]);
    assert_eq!(at(&turned, 3, 20), truth(size, 4, 3));
    // Then left and right exchanged.
    let mirrored = photo(file!("turned_mirrored"));
    assert_eq!([at(&mirrored, 16, 0), at(&mirrored, 0, 0)], [truth(size, 24, 0), truth(size, 24, 16)]);
    let cropped = decode(file!("cropped")).unwrap();
    assert_eq!(cropped.size, [16, 10]);
    assert_eq!(worst(&cropped, |x, y| truth(size, x + 4, y + 2)), 0.0);
}

#[test]
fn profile_and_descriptions_are_kept() {
    let raster = decode(file!("tagged")).unwrap();
    assert!(raster.icc.is_some_and(|icc| super::super::profile_name(&icc).is_some_and(|name| name.contains("sRGB"))));
    assert!(raster.exif.is_some_and(|exif| exif.starts_with(b"MM\0*")), "without the container's offset");
    assert!(raster.xmp.is_some_and(|xmp| xmp.starts_with(b"<x:xmpmeta")));
    // EXIF and the container both say a quarter clockwise: it is turned once.
    assert_eq!((raster.orientation, photo(file!("tagged")).info.size), (6, [17, 25]));
    let wide = decode(file!("bt2020_10bit_422")).unwrap();
    assert!(wide.icc.is_some_and(|icc| super::super::profile_name(&icc).is_some_and(|name| name.contains("2020"))));
    assert!(decode(file!("limited_420")).unwrap().icc.is_none());
}

#[test]
fn pictures_for_hdr_screens_open_with_a_warning() {
    let file = photo(file!("pq"));
    assert!(file.warnings.len() == 1 && file.warnings[0].contains("HDR"), "{:?}", file.warnings);
    assert_eq!(file.info.bits, 16);
}

/// The grain of the first test vector makes flat grey restless and leaves its mean.
#[test]
fn film_grain_is_applied() {
    let values: Vec<f64> =
        sixteen(&decode(file!("film_grain")).unwrap()).iter().map(|px| f64::from(px[1]) / 257.0).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt();
    assert!((mean - 128.0).abs() < 3.0 && deviation > 1.0, "{mean} ± {deviation}");
}

#[test]
fn sizes_that_lie_are_refused() {
    let size = [0, 0, 0, 25, 0, 0, 0, 17];
    let told = |to: [u32; 2]| {
        let to = [to[0].to_be_bytes(), to[1].to_be_bytes()].concat();
        decode(&patched(file!("lossless"), &size, &to)).unwrap_err().to_string()
    };
    assert!(told([26, 17]).contains("25×17 pixels, where 26×17"), "{}", told([26, 17]));
    assert!(told([20, 17]).contains("do not fit"), "{}", told([20, 17]));
    assert!(told([60_000, 60_000]).contains("60000×60000"));
    assert!(told([9001, 9000]).contains("only"));
    assert!(told([0, 17]).contains("0 pixels"));
}

#[test]
fn what_is_no_still_is_told() {
    let told = |bytes: &[u8]| match open_bytes(bytes, None) {
        Err(OpenError::File { problem, .. }) => problem.to_string(),
        other => panic!("{other:?}"),
    };
    let derived = patched(file!("grid"), b"infe\x02\0\0\0\0\x01\0\0grid", b"infe\x02\0\0\0\0\x01\0\0iovl");
    assert!(told(&derived).contains("'iovl'"), "{}", told(&derived));
    let film = [b"\0\0\0\x14ftypavis\0\0\0\0avis".as_slice(), b"\0\0\0\x08moov"].concat();
    assert!(told(&film).contains("film"), "{}", told(&film));
    let matrix = patched(file!("ycgco"), b"nclx\0\x01\0\x0d\0\x08", b"nclx\0\x01\0\x0d\0\x0e");
    assert!(told(&matrix).contains("matrix 14"), "{}", told(&matrix));
}
