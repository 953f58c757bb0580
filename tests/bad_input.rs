//! Bad input of every format: one sentence, no panic, bounded memory; a photo whose extra depth is broken still opens.
//!
//! Each parser also gets files that are damaged at random, the same ones at every run. `PLENOSCOPE_FUZZ_SECS=600
//! cargo test --test bad_input` goes on for that long with each; `fuzz/` holds targets for a coverage-guided fuzzer.
#![allow(clippy::unwrap_used, reason = "in a test a panic is the failure")]
#![allow(unsafe_code, reason = "an allocator that counts cannot be written without")]

#[path = "bad_input/alloc.rs"]
mod alloc;
#[path = "bad_input/cases.rs"]
mod cases;
#[path = "bad_input/harness.rs"]
mod harness;
#[path = "common/nets.rs"]
mod nets;
#[path = "bad_input/seeds.rs"]
mod seeds;

use std::path::Path;
use std::sync::Arc;

use harness::{Random, fuzz};
use image::ImageFormat;
use plenoscope::field::{LightField, RayDepths, View, ViewGrid};
use plenoscope::io::formats::{FieldToWrite, depth_map, eslf, hci, pfm, views};
use plenoscope::io::{self, OpenError, Opened};
use plenoscope::job::{Cancel, Job};
use plenoscope::recipe::Recipe;
use plenoscope::synth::Manifest;
use plenoscope::synth::tract::{Options, prepare};

#[global_allocator]
static ALLOCATOR: alloc::Counting = alloc::Counting;

fn open(bytes: &[u8]) -> Result<Opened, OpenError> {
    io::open_bytes(bytes, None)
}

fn open_path(path: &Path) -> Result<Opened, OpenError> {
    io::open(path, &Job { cancel: &Cancel::default(), sink: &() })
}

/// Small views with their ray depths.
fn field() -> (LightField, RayDepths) {
    let grid = ViewGrid::new(2, 2).unwrap();
    let view = |n: u8| Arc::new(View::new([12, 8], (0..12 * 8 * 4).map(|i| i as u8 ^ n).collect()).unwrap());
    let depths = RayDepths::new(grid, [12, 8], (0..12 * 8 * 4).map(|n| n as f32 / 100.0).collect()).unwrap();
    (LightField::new(grid, (0..4).map(view).collect()).unwrap(), depths)
}

#[test]
fn jpeg_with_all_that_phones_put_into_it() {
    let seeds = [seeds::gdepth(), seeds::dynamic_depth(), seeds::apple(), seeds::jpeg(&[seeds::exif(0)])];
    fuzz("jpeg", &seeds, open);
}

#[test]
fn png() {
    fuzz("png", &[seeds::still(ImageFormat::Png)], |bytes| {
        let mut bytes = bytes.to_vec();
        seeds::mend_png(&mut bytes);
        open(&bytes)
    });
}

#[test]
fn webp_tiff_bmp_gif_and_pnm() {
    use ImageFormat::{Bmp, Gif, Pnm, Tiff, WebP};
    fuzz("stills", &[WebP, Tiff, Bmp, Gif, Pnm].map(seeds::still), open);
}

#[test]
fn heic() {
    fuzz("heic", &[seeds::heic()], open);
}

#[test]
fn avif() {
    fuzz("avif", &seeds::avif(), open);
}

/// Damage in what the codec reads, in a container that is right.
#[test]
fn avif_picture_data() {
    for whole in seeds::avif() {
        let data = whole.windows(4).position(|w| w == b"mdat").unwrap() + 4;
        for seed in 0..120 {
            let mut bytes = Random::new(seed).damage(&whole[data..]);
            bytes.resize(whole.len() - data, 0);
            let _either = harness::run("avif", || open(&[&whole[..data], &bytes].concat()));
        }
    }
}

#[test]
fn lfp() {
    let whole = seeds::lfp(
        [&seeds::still(ImageFormat::Jpeg), &seeds::jpeg(&[])],
        &seeds::lfp_table(),
        r#""width":2,"height":2"#,
    );
    fuzz("lfp", &[whole], open);
}

/// Damage behind checksums that are right.
#[test]
fn lfp_sections() {
    let seeds = [seeds::lfp_table(), br#""width":2,"height":2"#.to_vec(), seeds::jpeg(&[])];
    for seed in 0..60 {
        let mut random = Random::new(seed);
        let parts: Vec<Vec<u8>> = seeds.iter().map(|part| random.damage(part)).collect();
        let json = String::from_utf8_lossy(&parts[1]).into_owned();
        let _either = harness::run("lfp", || open(&seeds::lfp([&parts[2], &seeds[2]], &parts[0], &json)));
    }
}

#[test]
fn pfm_maps() {
    fuzz("pfm", &[seeds::pfm(), b"Pf\n# by hand\n2 1\n2.0\n01234567".to_vec()], pfm::parse_pfm);
}

#[test]
fn depth_maps() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("map");
    fuzz("depth-map", &[seeds::pfm(), seeds::still(ImageFormat::Png)], |bytes| {
        std::fs::write(&path, bytes).unwrap();
        depth_map::read(&path)
    });
}

#[test]
fn lenslet_pictures_and_quilts() {
    let (field, _) = field();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("x.png");
    eslf::write(&path, &FieldToWrite::new(&field), &Job { cancel: &Cancel::default(), sink: &() }).unwrap();
    let lenslets = std::fs::read(path).unwrap();
    for (parser, name, whole) in
        [("eslf", "a_eslf.png", lenslets), ("quilt", "q_qs4x2a1.5.png", seeds::still(ImageFormat::Png))]
    {
        fuzz(parser, &[whole], |bytes| {
            let mut bytes = bytes.to_vec();
            seeds::mend_png(&mut bytes);
            io::open_bytes(&bytes, Some(Path::new(name)))
        });
    }
}

/// One file of a folder at a time is damaged.
fn fuzz_folder(parser: &str, folder: &Path, files: &[&str]) {
    for name in files {
        let path = folder.join(name);
        let whole = std::fs::read(&path).unwrap();
        fuzz(&format!("{parser}-{name}"), std::slice::from_ref(&whole), |bytes| {
            std::fs::write(&path, bytes).unwrap();
            open_path(folder)
        });
        std::fs::write(&path, whole).unwrap();
    }
}

#[test]
fn folders_of_views() {
    let (field, depths) = field();
    let source = FieldToWrite { depths: Some(&depths), ..FieldToWrite::new(&field) };
    let job = Job { cancel: &Cancel::default(), sink: &() };
    let dir = tempfile::tempdir().unwrap();
    views::write(&dir.path().join("views"), &source, &job).unwrap();
    hci::write(&dir.path().join("hci"), &source, &job).unwrap();
    fuzz_folder("views", &dir.path().join("views"), &["lightfield.json", "view_1_0.png", "disparity_0_1.pfm"]);
    fuzz_folder("hci", &dir.path().join("hci"), &["parameters.cfg", "gt_disp_lowres.pfm"]);
}

#[test]
fn recipes() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("recipe.json");
    let whole = Recipe::default().to_json().into_bytes();
    fuzz("recipe", &[whole], |bytes| {
        std::fs::write(&path, bytes).unwrap();
        Recipe::read(&path)
    });
}

#[test]
fn manifests_and_models() {
    let dir = tempfile::tempdir().unwrap();
    nets::write_patches(dir.path(), "net");
    let manifest = std::fs::read(dir.path().join("net/manifest.toml")).unwrap();
    fuzz("manifest", &[manifest], |bytes| Manifest::parse(&String::from_utf8_lossy(bytes), "manifest.toml"));
    let onnx = std::fs::read(dir.path().join("net/model.onnx")).unwrap();
    // What the engine says of a strange model can be long.
    let told = |_| "the model cannot be used — it is damaged — get it again";
    fuzz("onnx", &[onnx], |bytes| prepare(bytes, &[1, 3, 28, 28], &Options::default()).map_err(told));
}
