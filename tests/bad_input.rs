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
use plenoscope::field::{LightField, RayDepths, View, ViewGrid};
use plenoscope::io::formats::{TABLE, depth_map};
use plenoscope::io::{self, OpenError, Opened};
use plenoscope::job::{Cancel, Job};
use plenoscope::scene::Recipe;
use plenoscope::synth::Manifest;
use plenoscope::synth::tract::{Options, prepare};
use seeds::As;

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
fn every_line_of_the_table_that_is_read() {
    for line in TABLE.iter().filter(|line| line.is_read()) {
        let seeds = seeds::of(line.name);
        assert!(!seeds.is_empty(), "the table reads \"{}\", and no file of it is damaged here", line.name);
        for seed in seeds {
            fuzz_as(&seed.parser, &seed.opened, &seed.whole);
        }
    }
}

fn fuzz_as(parser: &str, opened: &As, whole: &[Vec<u8>]) {
    let dir = tempfile::tempdir().unwrap();
    match opened {
        As::File(name) => fuzz(parser, whole, |bytes| {
            let mut bytes = bytes.to_vec();
            if name.ends_with(".png") {
                seeds::mend_png(&mut bytes);
            }
            io::open_bytes(&bytes, Some(Path::new(name)))
        }),
        As::Map => fuzz(parser, whole, |bytes| {
            std::fs::write(dir.path().join("map"), bytes).unwrap();
            depth_map::read(&dir.path().join("map"))
        }),
        // One file of a folder at a time is damaged.
        As::In { folder, file, open } => {
            let path = folder.path().join(file);
            fuzz(parser, whole, |bytes| {
                std::fs::write(&path, bytes).unwrap();
                open_path(&folder.path().join(open))
            });
            std::fs::write(&path, &whole[0]).unwrap();
        }
    }
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
