//! What strangers send: links, names that lead elsewhere, words that command a terminal.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;

use predicates::prelude::*;
use predicates::str::contains;

use crate::common::{Scratch, plenoscope};

fn names(folder: &Path) -> Vec<String> {
    let mut all: Vec<_> = folder.read_dir().unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    all.sort();
    all
}

#[test]
fn a_recipe_names_no_place_outside_the_folder_of_pictures() {
    let dir = Scratch::new();
    let photo = dir.photo("photo.png", 48, 32);
    fs::create_dir(dir.path("out")).unwrap();
    fs::write(dir.path("edit.json"), r#"{"version": 2, "export": {"format": "png", "name": "../../{name}\u001b[2J"}}"#)
        .unwrap();
    let args =
        ["batch", &photo, "--recipe", &dir.arg("edit.json"), "-o", &dir.arg("out"), "--no-cache", "--long-side", "48"];
    plenoscope(&args).assert().success();
    assert!(names(&dir.path("out")).contains(&"..-..-photo-[2J.png".to_owned()), "{:?}", names(&dir.path("out")));
    assert_eq!(names(&dir.path("")), ["edit.json", "out", "photo.png"]);
}

#[test]
fn a_recipe_that_never_ends_or_is_no_file_is_refused_at_once() {
    let dir = Scratch::new();
    let photo = dir.photo("photo.png", 48, 32);
    symlink("/dev/zero", dir.path("edit.json")).unwrap();
    for recipe in [dir.arg("edit.json"), dir.arg("")] {
        plenoscope(&["refocus", &photo, "-o", &dir.arg("out.png"), "--recipe", &recipe])
            .assert()
            .code(1)
            .stderr(contains("the recipe cannot be read"));
    }
    assert!(!dir.path("out.png").exists());
}

#[test]
fn what_is_written_follows_no_link() {
    let dir = Scratch::new();
    let photo = dir.photo("photo.png", 48, 32);
    fs::write(dir.path("letter"), "dear").unwrap();
    fs::create_dir(dir.path("home")).unwrap();
    symlink(dir.path("letter"), dir.path("out.png")).unwrap();
    symlink(dir.path("home"), dir.path("field")).unwrap();
    let small = ["--no-cache", "--long-side", "48"];
    plenoscope(&[&["refocus", &photo, "-o", &dir.arg("out.png")], &small[..]].concat()).assert().success();
    assert_eq!(fs::read_to_string(dir.path("letter")).unwrap(), "dear");
    assert!(dir.path("out.png").symlink_metadata().unwrap().is_file());
    plenoscope(&[&["synth", &photo, "-o", &dir.arg("field")], &small[..]].concat())
        .assert()
        .code(1)
        .stderr(contains("symbolic link").and(contains("name the folder that it leads to")));
    assert_eq!(names(&dir.path("home")), [""; 0]);
}

#[test]
fn a_light_fields_words_command_no_terminal() {
    let dir = Scratch::new();
    let photo = dir.photo("photo.png", 48, 32);
    let field = dir.arg("field");
    plenoscope(&["synth", &photo, "-o", &field, "--no-cache", "--long-side", "48"]).assert().success();
    let index = r#"{"grid": [8, 8], "name": "\u001b]0;owned\u0007", "scene": "/etc/passwd", "views": ["../../x"]}"#;
    fs::write(dir.path("field/lightfield.json"), index).unwrap();
    plenoscope(&["info", &field]).assert().success().stdout(contains("]0;owned").and(contains("\u{1b}").not()));
}
