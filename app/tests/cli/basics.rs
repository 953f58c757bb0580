//! The real program: exit codes, what it says, what it writes, and what it does with bad input.

use std::fs;

use crate::common::{Scratch, data, plenoscope};
use predicates::prelude::*;
use predicates::str::{contains, starts_with};

#[test]
fn help_names_every_command() {
    plenoscope(&["--help"]).assert().success().stdout(contains("info").and(contains("Exit codes")));
    plenoscope(&["help", "info"]).assert().success().stdout(contains("--json"));
    plenoscope(&["--version"]).assert().success().stdout(starts_with("plenoscope 0."));
}

#[test]
fn wrong_usage_is_exit_code_2() {
    plenoscope(&["info"]).assert().code(2);
    plenoscope(&["info", "--no-such-option", "x"]).assert().code(2);
    plenoscope(&["-q", "-v", "info", "x"]).assert().code(2);
}

#[test]
fn completions_and_man_page_are_made() {
    plenoscope(&["completions", "bash"]).assert().success().stdout(contains("_plenoscope"));
    plenoscope(&["man"]).assert().success().stdout(contains(".TH plenoscope"));
    let dir = Scratch::new();
    plenoscope(&["man", "-o", &dir.arg("man")]).assert().success();
    assert!(dir.path("man/plenoscope-info.1").exists());
    plenoscope(&["icons", "-o", &dir.arg("icons")]).assert().success();
    assert_eq!(image::open(dir.path("icons/48x48/apps/plenoscope.png")).unwrap().height(), 48);
    assert!(fs::read_to_string(dir.path("icons/scalable/apps/plenoscope.svg")).unwrap().starts_with("<svg"));
}

#[test]
fn info_says_what_a_photo_is() {
    let dir = Scratch::new();
    let photo = dir.photo("photo.png", 48, 32);
    let out = plenoscope(&["info", "--json", &photo]).assert().success().stderr("");
    let said: serde_json::Value = serde_json::from_slice(&out.get_output().stdout).unwrap();
    assert_eq!(said["kind"], "photo");
    assert_eq!(said["format"], "PNG");
    assert_eq!(said["size"], serde_json::json!([48, 32]));
    assert_eq!(said["views"], serde_json::Value::Null);
    assert_eq!(said["orientation"], 1);
    assert_eq!(said["bits"], 8);
    assert_eq!(said["embedded_depth"], serde_json::Value::Null);
    assert_eq!(said["disparity_px"], serde_json::Value::Null);
    assert_eq!(said["warnings"], serde_json::json!([]));
    for key in ["profile", "f35_mm"] {
        assert!(said.get(key).is_some(), "{key} is missing");
    }
    plenoscope(&["info", &photo]).assert().success().stdout(contains("48 × 32 px"));
}

#[test]
fn bad_input_is_one_line_and_exit_code_1() {
    let dir = Scratch::new();
    let photo = dir.photo("photo.png", 48, 32);
    let whole = fs::read(&photo).unwrap();
    let bad: [(&str, &[u8]); 4] = [
        ("truncated.png", &whole[..whole.len() / 2]),
        ("empty.jpg", b""),
        ("text.jpg", b"this is not a picture, whatever its name says"),
        ("huge.png", &huge_header()),
    ];
    for (name, bytes) in bad {
        fs::write(dir.path(name), bytes).unwrap();
        fails_in_one_line(&["info", &dir.arg(name)], name);
    }
    fails_in_one_line(&["info", &dir.arg("away.jpg")], "away.jpg");
    fs::create_dir(dir.path("nothing in it")).unwrap();
    fails_in_one_line(&["info", &dir.arg("nothing in it")], "nothing in it");
}

/// A PNG whose header promises 30,000 × 300,000 pixels.
fn huge_header() -> Vec<u8> {
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec();
    png.extend(30_000_u32.to_be_bytes());
    png.extend(300_000_u32.to_be_bytes());
    png.extend([8, 2, 0, 0, 0, 0, 0, 0, 0]);
    png
}

/// Exit code 1, nothing on stdout, and one line of the form `error: what — why — what to do: path`.
fn fails_in_one_line(args: &[&str], names: &str) {
    let one_line = predicate::function(|text: &str| text.trim_end().lines().count() == 1);
    plenoscope(args).assert().code(1).stdout("").stderr(
        starts_with("error: ").and(contains(names)).and(contains(" — ")).and(one_line).and(contains("panicked").not()),
    );
}

#[test]
fn every_photo_of_the_data_folder_is_understood() {
    let Some(data) = data() else { return };
    for entry in fs::read_dir(data.join("photos")).unwrap() {
        let path = entry.unwrap().path();
        let out = plenoscope(&["info", "--json", &path.to_string_lossy()]).assert().success();
        let said: serde_json::Value = serde_json::from_slice(&out.get_output().stdout).unwrap();
        assert_eq!(said["kind"], "photo", "{}", path.display());
    }
}
