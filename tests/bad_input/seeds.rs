//! Small whole files of every format, to be damaged.

use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use image::{DynamicImage, ImageFormat, Rgb, RgbImage};
use jpeg_encoder::{ColorType as JpegColor, Encoder as JpegEncoder};
use plenoscope::field::{DisparityMap, LightField, Picture, RayDepths, View, ViewGrid};
use plenoscope::io::formats::depth_out::{self, Seen};
use plenoscope::io::formats::{FieldToWrite, Writer, by_id, mpo, pfm};
use plenoscope::job::{Cancel, Job};
use tempfile::TempDir;

/// Whole files for one parser.
pub struct Seed {
    pub parser: String,
    pub opened: As,
    pub whole: Vec<Vec<u8>>,
}

/// How a file is opened.
pub enum As {
    /// By itself, under a name.
    File(&'static str),
    /// As a map of depth or disparity.
    Map,
    /// As a file of a folder, of which `open` is opened.
    In { folder: Arc<TempDir>, file: &'static str, open: &'static str },
}

/// The seeds of a line of the table; none where the line is not known here.
pub fn of(line: &str) -> Vec<Seed> {
    use ImageFormat::{Bmp, Gif, Jpeg, Png, Pnm, Tiff, WebP};
    let seed = |parser: &str, opened, whole| Seed { parser: parser.to_owned(), opened, whole };
    let file = |parser, name, whole: Vec<Vec<u8>>| vec![seed(parser, As::File(name), whole)];
    match line {
        "photo: JPEG, PNG, TIFF, WebP" => vec![
            seed("jpeg", As::File("a.jpg"), vec![still(Jpeg), jpeg(&[exif(0)])]),
            seed("png", As::File("a.png"), vec![still(Png)]),
            seed("tiff", As::File("a"), vec![still(Tiff)]),
            seed("webp", As::File("a"), vec![still(WebP)]),
        ],
        "photo: HEIC, AVIF, BMP, PNM, GIF (first frame)" => vec![
            seed("heic", As::File("a.heic"), vec![heic()]),
            seed("avif", As::File("a.avif"), avif().to_vec()),
            seed("bmp", As::File("a"), vec![still(Bmp)]),
            seed("pnm", As::File("a"), vec![still(Pnm)]),
            seed("gif", As::File("a"), vec![still(Gif)]),
        ],
        name if name.starts_with("film: motion-JPEG in AVI") => file("avi", "a.avi", vec![film()]),
        "HCI 4-D benchmark scene" => folder("hci", &["parameters.cfg", "gt_disp_lowres.pfm"]),
        "Stanford archive" => folder("stanford", &["out_01_00_-0.000000_-1.000000.png"]),
        name if name.starts_with("folder of views (`view_V_U.png`") => {
            folder("views", &["lightfield.json", "view_1_0.png", "disparity_0_1.pfm"])
        }
        name if name.starts_with("Middlebury stereo scene") => {
            let dir = Arc::new(tempfile::tempdir().unwrap());
            let calibration = b"cam0=[40.5 0 12; 0 40.5 8; 0 0 1]\ndoffs=1.5\nbaseline=190\n".to_vec();
            let mut map = Vec::new();
            let disparities: Vec<f32> = (0..SIZE[0] * SIZE[1]).map(|n| n as f32 / 9.0).collect();
            pfm::write_pfm(&mut map, SIZE, &disparities).unwrap();
            std::fs::write(dir.path().join("im0.png"), still(Png)).unwrap();
            std::fs::write(dir.path().join("disp0.pfm"), &map).unwrap();
            std::fs::write(dir.path().join("calib.txt"), &calibration).unwrap();
            let of =
                |parser, file, whole| seed(parser, As::In { folder: Arc::clone(&dir), file, open: "" }, vec![whole]);
            vec![of("middlebury", "calib.txt", calibration), of("middlebury-map", "disp0.pfm", map)]
        }
        "folder of views with other names" => {
            let seeds = folder("views", &["view_1_0.png"]);
            if let As::In { folder, .. } = &seeds[0].opened {
                std::fs::remove_file(folder.path().join("lightfield.json")).unwrap();
            }
            seeds.into_iter().map(|seed| Seed { parser: "other-views".to_owned(), ..seed }).collect()
        }
        "Looking Glass quilt" => file("quilt", "q_qs4x2a1.5.png", vec![still(Png)]),
        "ESLF lenslet picture" => file("eslf", "a_eslf.png", vec![written("x.png", |path| write("eslf", path))]),
        "depth map: PFM" => vec![seed("pfm", As::Map, vec![pfm(), b"Pf\n# by hand\n2 1\n2.0\n01234567".to_vec()])],
        "depth map: 16-bit PNG" => vec![seed("depth-map", As::Map, vec![still(Png)])],
        "phone depth: GDepth" => file("gdepth", "a.jpg", vec![gdepth()]),
        "phone depth: Dynamic Depth" => file("dynamic-depth", "a.jpg", vec![dynamic_depth()]),
        // Both are in what the HEIC parser reads too.
        "phone depth: Apple portrait (HEIC, JPEG)" => file("apple", "a.jpg", vec![apple()]),
        "phone depth: spatial photo (HEIC)" => file("spatial", "a.heic", vec![heic()]),
        "phone depth: file beside the photo (`_DEPTH`)" => {
            let folder = tempfile::tempdir().unwrap();
            std::fs::write(folder.path().join("a.jpg"), jpeg(&[])).unwrap();
            let opened = As::In { folder: Arc::new(folder), file: "a_depth.pfm", open: "a.jpg" };
            vec![seed("side-file", opened, vec![pfm()])]
        }
        "processed Lytro file (`-stk.lfp`)" => {
            let pictures = [still(Jpeg), jpeg(&[])];
            file("lfp", "a.lfp", vec![lfp([&pictures[0], &pictures[1]], &lfp_table(), r#""width":2,"height":2"#)])
        }
        "Gaussian splats (PLY)" => {
            // Its picture is too small to be named; without its camera one would be looked for, at a hundred times the work.
            let own = written("a.ply", |path| write("gaussians", path));
            let at = own.windows(6).position(|window| window == b" 12 8 ").unwrap();
            file("splats", "a.ply", vec![[&own[..at], b" 24 16 ", &own[at + 6..]].concat(), splats()])
        }
        "Gaussian splats (SPZ)" => file("packed-splats", "a.spz", vec![packed_splats()]),
        _ => Vec::new(),
    }
}

/// A motion-JPEG film of two pictures.
fn film() -> Vec<u8> {
    let chunk = |name: &[u8], data: &[u8]| {
        let mut bytes = [name, &(data.len() as u32).to_le_bytes(), data].concat();
        bytes.resize(bytes.len().next_multiple_of(2), 0);
        bytes
    };
    let picture = chunk(b"00dc", &jpeg(&[]));
    let movie = chunk(b"LIST", &[b"movi", &picture[..], &picture].concat());
    chunk(b"RIFF", &[b"AVI ", &movie[..]].concat())
}

/// Three packed Gaussians beside each other.
fn packed_splats() -> Vec<u8> {
    let mut bytes = b"NGSP\x02\0\0\0\x03\0\0\0\0\x08\0\0".to_vec();
    for x in [-100i32, 0, 100] {
        bytes.extend([x, 0, -512].iter().flat_map(|value| value.to_le_bytes()[..3].to_vec()));
    }
    bytes.extend([[250; 3], [200, 128, 100], [128; 3]].concat());
    bytes.extend([128; 3]);
    bytes.extend([130; 9]);
    bytes.extend([128; 9]);
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut packed, &bytes).unwrap();
    packed.finish().unwrap()
}

/// A few Gaussians as text, with the camera that SHARP adds.
fn splats() -> Vec<u8> {
    let mut text = "ply\nformat ascii 1.0\nelement vertex 3\n".to_owned();
    let names = "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3";
    names.split(' ').for_each(|name| text += &format!("property float {name}\n"));
    text += "element intrinsic 4\nproperty float intrinsic\nend_header\n";
    (0..3).for_each(|i| text += &format!("{} 0 2 1 0.5 0 3 -2 -2.5 -2 1 0 0.1 0\n", f64::from(i) * 0.4 - 0.4));
    (text + "20\n20\n24\n16\n").into_bytes()
}

/// A folder that the program writes, and a seed for each of these files in it.
fn folder(id: &str, files: &[&'static str]) -> Vec<Seed> {
    let folder = Arc::new(tempfile::tempdir().unwrap());
    write(id, folder.path());
    let seed = |&file: &&'static str| Seed {
        parser: format!("{id}-{file}"),
        whole: vec![std::fs::read(folder.path().join(file)).unwrap()],
        opened: As::In { folder: Arc::clone(&folder), file, open: "" },
    };
    files.iter().map(seed).collect()
}

/// Small views with their ray depths.
pub fn field() -> (LightField, RayDepths) {
    let grid = ViewGrid::new(2, 2).unwrap();
    let view = |n: u8| Arc::new(View::new([12, 8], (0..12 * 8 * 4).map(|i| i as u8 ^ n).collect()).unwrap());
    let depths = RayDepths::new(grid, [12, 8], (0..12 * 8 * 4).map(|n| n as f32 / 100.0).collect()).unwrap();
    (LightField::new(grid, (0..4).map(view).collect()).unwrap(), depths)
}

/// Three frames as GIF and as APNG, and both eyes in one MPO.
pub fn several() -> Vec<Vec<u8>> {
    let mut gif = Vec::new();
    let frames = (0..3).map(|_| image::Frame::new(DynamicImage::ImageRgb8(picture()).into_rgba8()));
    image::codecs::gif::GifEncoder::new(&mut gif).encode_frames(frames).unwrap();
    let mut apng = Vec::new();
    let mut encoder = png::Encoder::new(&mut apng, SIZE[0], SIZE[1]);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_animated(3, 0).unwrap();
    let mut writer = encoder.write_header().unwrap();
    (0..3).for_each(|_| writer.write_image_data(picture().as_raw()).unwrap());
    writer.finish().unwrap();
    let eye = |light: f32| Picture { size: SIZE, rgb_linear: vec![light; (SIZE[0] * SIZE[1] * 3) as usize] };
    vec![gif, apng, written("a.mpo", |path| mpo::write(path, &eye(0.2), &eye(0.4)).unwrap())]
}

/// Writes a small light field in a format of the table.
fn write(id: &str, path: &Path) {
    let (field, depths) = field();
    let source = FieldToWrite { depths: Some(&depths), ..FieldToWrite::new(&field) };
    let Some(Writer::Field(write)) = by_id(id).unwrap().writer else { panic!("{id} holds a light field") };
    write(path, &source, &Job { cancel: &Cancel::default(), sink: &() }).unwrap();
}

pub const SIZE: [u32; 2] = [24, 16];

pub fn picture() -> RgbImage {
    RgbImage::from_fn(SIZE[0], SIZE[1], |x, y| Rgb([x as u8 * 10, y as u8 * 15, 255 - x as u8 * 7]))
}

/// A file of the `image` crate's.
pub fn still(format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    DynamicImage::ImageRgb8(picture()).write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// A file that a writer makes at a path.
fn written(name: &str, write: impl FnOnce(&Path)) -> Vec<u8> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join(name);
    write(&path);
    std::fs::read(path).unwrap()
}

/// A JPEG with GDepth in extended XMP.
pub fn gdepth() -> Vec<u8> {
    let view = View::new(SIZE, [90, 120, 60, 255].repeat((SIZE[0] * SIZE[1]) as usize)).unwrap();
    let map = DisparityMap::new([8, 6], (0..48).map(|n| n as f32 / 10.0).collect()).unwrap();
    written("depth.jpg", |path| depth_out::write_gdepth(path, Seen::View(&view), &map, 90).unwrap())
}

/// A JPEG with segments before the picture.
pub fn jpeg(segments: &[(u8, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = JpegEncoder::new(&mut bytes, 95);
    for (number, data) in segments {
        encoder.add_app_segment(*number, data).unwrap();
    }
    encoder.encode(&picture(), SIZE[0] as u16, SIZE[1] as u16, JpegColor::Rgb).unwrap();
    bytes
}

/// An XMP packet as a segment.
pub fn xmp(packet: &str) -> (u8, Vec<u8>) {
    (1, [b"http://ns.adobe.com/xap/1.0/\0", packet.as_bytes()].concat())
}

/// An EXIF block as a segment: orientation 6, and a further directory at `next`.
pub fn exif(next: u8) -> (u8, Vec<u8>) {
    let mut block = b"Exif\0\0MM\0*\0\0\0\x08\0\x02\x01\x12\0\x03\0\0\0\x01\0\x06\0\0".to_vec();
    block.extend([0x87, 0x69, 0, 4, 0, 0, 0, 1, 0, 0, 0, next, 0, 0, 0, next]);
    (1, block)
}

/// A JPEG with a depth map of Dynamic Depth behind it.
pub fn dynamic_depth() -> Vec<u8> {
    let map = image::GrayImage::from_fn(8, 6, |x, _| image::Luma([x as u8 * 36]));
    let mut payload = Cursor::new(Vec::new());
    DynamicImage::ImageLuma8(map).write_to(&mut payload, ImageFormat::Png).unwrap();
    let payload = payload.into_inner();
    [jpeg(&[xmp(&depth_packet(payload.len()))]), payload].concat()
}

/// The XMP of Dynamic Depth, whose map has this many bytes.
pub fn depth_packet(map_bytes: usize) -> String {
    let ns = |name: &str| format!(r#"xmlns:{name}="http://ns.google.com/photos/dd/1.0/{}/""#, name.to_lowercase());
    format!(
        r#"<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">
        <rdf:Description {} {} {}><DepthMap:Format>RangeInverse</DepthMap:Format><DepthMap:Near>0.5</DepthMap:Near>
        <DepthMap:Far>10</DepthMap:Far><DepthMap:DepthURI>depth</DepthMap:DepthURI><Container:Directory><rdf:Seq>
        <rdf:li><Container:Item Item:Mime="image/jpeg" Item:Length="0" Item:DataURI="primary_image"/></rdf:li>
        <rdf:li><Container:Item Item:Mime="image/png" Item:Length="{}" Item:DataURI="depth"/></rdf:li>
        </rdf:Seq></Container:Directory></rdf:Description></rdf:RDF></x:xmpmeta>"#,
        ns("DepthMap"),
        ns("Container"),
        ns("Item"),
        map_bytes,
    )
}

/// Apple's JPEG: a second picture with a depth map's XMP behind the first.
pub fn apple() -> Vec<u8> {
    let packet = r#"<x:xmpmeta xmlns:x="adobe:ns:meta/"><r xmlns:apdi="http://ns.apple.com/pixeldatainfo/1.0/">
        <apdi:AuxiliaryImageType>disparity</apdi:AuxiliaryImageType><apdi:FloatMinValue>1.0</apdi:FloatMinValue>
        <apdi:FloatMaxValue>3.0</apdi:FloatMaxValue></r></x:xmpmeta>"#;
    [jpeg(&[exif(0)]), jpeg(&[xmp(packet)])].concat()
}

/// A HEIC whose alpha plane is relabelled as a depth map.
pub fn heic() -> Vec<u8> {
    let rgba: Vec<u8> = (0..64 * 48).flat_map(|n| [200, 100, 50, (n % 64 * 4) as u8]).collect();
    let mut bytes = heifer::encode_rgba8(64, 48, &rgba, &heifer::EncodeOptions::default()).unwrap();
    let urn = b"urn:mpeg:hevc:2015:auxid:1";
    let at = bytes.windows(urn.len()).position(|w| w == urn).unwrap();
    bytes[at + urn.len() - 1] = b'2';
    bytes
}

/// AVIF pictures that another program has encoded: a still, one with opacity, one of 10 bits, a grid, one with all extras.
pub fn avif() -> [Vec<u8>; 5] {
    [
        &include_bytes!("../avif/limited_420.avif")[..],
        &include_bytes!("../avif/opacity_premultiplied.avif")[..],
        &include_bytes!("../avif/bt2020_10bit_422.avif")[..],
        &include_bytes!("../avif/grid.avif")[..],
        &include_bytes!("../avif/tagged.avif")[..],
    ]
    .map(<[u8]>::to_vec)
}

/// A section of Lytro's container, with its name.
pub fn lfp_section(kind: u8, body: &[u8]) -> (String, Vec<u8>) {
    let name = format!("sha1-{}", sha1_smol::Sha1::from(body).digest());
    let mut out = [b"\x89LF", &[kind][..], b"\x0d\x0a\x1a\x0a\0\0\0\0", &(body.len() as u32).to_be_bytes()].concat();
    out.extend(name.as_bytes());
    out.extend([0; 35]);
    out.extend(body);
    out.extend(vec![0; 16 - out.len() % 16]);
    (name, out)
}

/// A processed Lytro file of these pictures and this depth table; checksums fit.
pub fn lfp(pictures: [&[u8]; 2], table: &[u8], table_json: &str) -> Vec<u8> {
    let [(a, a_bytes), (b, b_bytes)] = pictures.map(|picture| lfp_section(b'C', picture));
    let (lut, lut_bytes) = lfp_section(b'C', table);
    let json = format!(
        r#"{{"picture":{{"accelerationArray":[{{"vendorContent":{{"depthLut":{{{table_json},"imageRef":"{lut}"}},
        "imageArray":[{{"imageRef":"{a}","lambda":7.5}},{{"imageRef":"{b}","lambda":-0.5}}]}}}}]}}}}"#
    );
    let head = b"\x89LFP\x0d\x0a\x1a\x0a\0\0\0\x01\0\0\0\0".to_vec();
    [head, lfp_section(b'M', json.as_bytes()).1, a_bytes, b_bytes, lut_bytes].concat()
}

/// The depth table of [`lfp`].
pub fn lfp_table() -> Vec<u8> {
    [-5.0f32, 1.0, 2.0, 9.0].iter().flat_map(|l| l.to_le_bytes()).collect()
}

/// A map of 6×4.
pub fn pfm() -> Vec<u8> {
    let mut bytes = Vec::new();
    let values: Vec<f32> = (0..24).map(|n| n as f32 / 5.0 - 2.0).collect();
    plenoscope::io::formats::pfm::write_pfm(&mut bytes, [6, 4], &values).unwrap();
    bytes
}

/// Makes the checksums of a PNG's chunks right again, so that damage reaches what lies behind them.
pub fn mend_png(bytes: &mut [u8]) {
    let mut at = 8;
    while let Some(head) = bytes.get(at..at + 8) {
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let Some(end) = at.checked_add(8).and_then(|n| n.checked_add(length)).filter(|end| end + 4 <= bytes.len())
        else {
            return;
        };
        let mut crc = flate2::Crc::new();
        crc.update(&bytes[at + 4..end]);
        bytes[end..end + 4].copy_from_slice(&crc.sum().to_be_bytes());
        at = end + 4;
    }
}
