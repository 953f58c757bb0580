//! The nets that ship, run by the real program; and what it says when they are away or not what their manifests say.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{Scratch, plenoscope};
use crate::small_nets;
use predicates::prelude::*;
use predicates::str::{contains, starts_with};

fn models() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../models")
}

/// Whether the repository holds models at all; says so where it does not.
fn have_models() -> bool {
    let there = models().join("models.toml").exists();
    if !there {
        eprintln!("SKIPPED: the repository has no models yet");
    }
    there
}

#[test]
fn a_photo_becomes_a_light_field_with_the_nets_in_the_program() {
    if !have_models() {
        return;
    }
    let dir = Scratch::new();
    let photo = dir.photo("photo.jpg", 160, 120);
    plenoscope(&["synth", &photo, "--long-side", "96", "-o", &dir.arg("field")]).assert().success().stdout("");
    let index: serde_json::Value =
        serde_json::from_slice(&fs::read(dir.path("field/lightfield.json")).unwrap()).unwrap();
    assert_eq!(index["size_xy"], serde_json::json!([96, 72]));
    assert!(!index["models"].as_array().unwrap().is_empty(), "{index}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_net_that_fills_memory_while_it_is_read_is_one_line() {
    let dir = Scratch::new();
    fs::write(dir.path("greedy.onnx"), small_nets::with_a_constant_of(1 << 40)).unwrap();
    let said = starts_with("error: the net was not added").and(contains("more memory")).and(contains("panicked").not());
    plenoscope(&["models", "add", &dir.arg("greedy.onnx")]).assert().code(1).stderr(said);
    fs::write(dir.path("modest.onnx"), small_nets::with_a_constant_of(1 << 10)).unwrap();
    let said = starts_with("error: the net was not added").and(contains("correlation"));
    plenoscope(&["models", "add", &dir.arg("modest.onnx")]).assert().code(1).stderr(said);
}

#[test]
fn a_folder_without_models_is_one_line() {
    let dir = Scratch::new();
    let photo = dir.photo("photo.png", 64, 48);
    let said = starts_with("error: ").and(contains("models.toml")).and(contains("panicked").not());
    plenoscope(&["synth", &photo, "--models", &dir.arg("none"), "-o", &dir.arg("field")]).assert().code(1).stderr(said);
    assert!(!dir.path("field").exists());
}

#[test]
fn a_model_that_was_tampered_with_is_refused() {
    if !have_models() {
        return;
    }
    let dir = Scratch::new();
    let photo = dir.photo("photo.png", 64, 48);
    let copy = dir.path("models");
    copy_folder(&models(), &copy);
    let nets: Vec<PathBuf> =
        all_files(&copy).into_iter().filter(|path| path.extension().is_some_and(|e| e == "onnx")).collect();
    assert!(!nets.is_empty());
    for path in nets {
        let mut bytes = fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(&path, bytes).unwrap();
    }
    let said = starts_with("error: ").and(contains("checksum")).and(contains("panicked").not());
    plenoscope(&["synth", &photo, "--models", &dir.arg("models"), "-o", &dir.arg("field")])
        .assert()
        .code(1)
        .stderr(said);
    assert!(!dir.path("field").exists());
}

#[test]
fn a_depth_net_of_ones_own_is_one_more_source() {
    if !have_models() {
        return;
    }
    let dir = Scratch::new();
    let photo = dir.photo("photo.png", 64, 48);
    // The folder holds nothing else: the nets in the program do the rest.
    small_nets::write_metres(&dir.path("mine"), "metres");
    let with = |source: &str, out: &str| {
        let args = ["synth", &photo, "--models", &dir.arg("mine"), "--source", source, "-o", &dir.arg(out)];
        plenoscope(&args).assert()
    };
    with("metres", "field").success();
    let index: serde_json::Value =
        serde_json::from_slice(&fs::read(dir.path("field/lightfield.json")).unwrap()).unwrap();
    assert_eq!(index["models"][0]["id"], "metres");
    assert!(dir.path("field/disparity_7_7.pfm").exists());
    let said = starts_with("error: ").and(contains("meters")).and(contains("network, phone, fused, metres"));
    with("meters", "none").code(1).stderr(said);
    assert!(!dir.path("none").exists());
}

#[test]
fn a_recipe_names_its_net_by_checksum_and_goes_on_without_it() {
    if !have_models() {
        return;
    }
    let dir = Scratch::new();
    let photo = dir.photo("photo.png", 96, 64);
    let shelf = dir.path("data/plenoscope/models");
    small_nets::write_metres(&shelf, "metres");
    let manifest = fs::read_to_string(shelf.join("metres/manifest.toml")).unwrap();
    let sha256 = manifest.split("sha256 = \"").nth(1).unwrap().split('"').next().unwrap();
    let recipe = format!(r#"{{"version": 2, "depth": {{"net": {{"name": "metres", "sha256": "{sha256}"}}}}}}"#);
    fs::write(dir.path("r.json"), recipe).unwrap();
    let run = |args: &[&str]| plenoscope(args).env("XDG_DATA_HOME", dir.path("data")).assert().success();
    let refocus = |more: &[&str], out: &str| {
        let fixed = ["refocus", &photo, "--recipe", &dir.arg("r.json"), "--no-cache", "-o", &dir.arg(out)];
        let said = run(&[&fixed[..], more].concat());
        (fs::read(dir.path(out)).unwrap(), String::from_utf8_lossy(&said.get_output().stderr).into_owned())
    };
    let (by_name, _) = refocus(&["--source", "metres"], "name.png");
    let (own, _) = refocus(&["--source", "network"], "own.png");
    assert_ne!(by_name, own);
    assert_eq!(refocus(&[], "recipe.png"), (by_name.clone(), String::new()));

    fs::remove_dir_all(shelf.join("metres")).unwrap();
    small_nets::write_metres(&shelf, "renamed");
    assert_eq!(refocus(&[], "renamed.png"), (by_name.clone(), String::new()));
    let batch = ["batch", &photo, "--recipe", &dir.arg("r.json"), "--no-cache", "-o", &dir.arg("out")];
    run(&batch);
    let mut batched = all_files(&dir.path("out"));
    batched.retain(|file| file.extension().is_some_and(|extension| extension == "jpg"));
    run(&["refocus", &photo, "--recipe", &dir.arg("r.json"), "--no-cache", "-o", &dir.arg("one.jpg")]);
    assert_eq!(batched.len(), 1, "one photo, one picture");
    assert_eq!(fs::read(&batched[0]).unwrap(), fs::read(dir.path("one.jpg")).unwrap());

    fs::remove_dir_all(shelf.join("renamed")).unwrap();
    let (without, said) = refocus(&[], "without.png");
    assert_eq!(without, own);
    assert!(said.contains("\"metres\"") && said.contains("automatic") && said.lines().count() == 1, "{said}");
}

fn all_files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { all_files(&path) } else { vec![path] }).collect()
}

fn copy_folder(from: &Path, to: &Path) {
    for file in all_files(from) {
        let target = to.join(file.strip_prefix(from).unwrap());
        fs::create_dir_all(target.parent().unwrap()).unwrap();
        fs::copy(&file, target).unwrap();
    }
}
