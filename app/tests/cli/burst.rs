//! Several photos of one subject.

use predicates::prelude::*;
use predicates::str::contains;

use crate::common::{Scratch, plenoscope};

#[test]
fn a_burst_becomes_a_folder_that_opens_again_and_says_who_saw_its_rays() {
    let dir = Scratch::new();
    plenoscope(&["sample", "-o", &dir.arg("")]).assert().success();
    let photos = ["0,0", "-3,0", "2,-2"].map(|at| {
        let to = dir.arg(&format!("{at}.png"));
        plenoscope(&["view", &dir.arg("sample.png"), "-o", &to, "--at", at]).assert().success();
        to
    });
    let field = dir.arg("field");
    let args = ["burst", &photos[0], &photos[1], &photos[2], "-o", &field, "--long-side", "240", "--json"];
    let done = plenoscope(&args).assert().success();
    let said: serde_json::Value = serde_json::from_slice(&done.get_output().stdout).unwrap();
    assert_eq!(said["photos"], 3);
    assert!(said["reprojection_px"].as_f64().unwrap() < 0.5, "{said}");
    let index = std::fs::read(dir.path("field/lightfield.json")).unwrap();
    let index: serde_json::Value = serde_json::from_slice(&index).unwrap();
    let [kept, told] = [&index["seen"], &said["seen"]].map(|seen| seen["invented"].as_f64().unwrap());
    assert!((kept - told).abs() < 1e-6 && index["photo"] == "0,0.png", "{index}");
    assert!(dir.path("field/seen_0_0.png").exists());
    plenoscope(&["depth", &field, "-o", &dir.arg("trust.png"), "--as", "trust"]).assert().success();
    plenoscope(&["view", &field, "-o", &dir.arg("left.png"), "--at", "-2,0"]).assert().success();
}

#[test]
fn one_photo_twice_is_one_photo_and_a_photo_that_is_not_there_is_an_error() {
    let dir = Scratch::new();
    plenoscope(&["sample", "-o", &dir.arg("")]).assert().success();
    let (photo, out) = (dir.arg("sample.png"), dir.arg("field"));
    let args = ["burst", &photo, &photo, "-o", &out, "--long-side", "120", "--lambertian"];
    plenoscope(&args).assert().success().stderr(contains("the camera did not move; one photo is used"));
    plenoscope(&["burst", &dir.arg("away.jpg"), &photo, "-o", &out]).assert().code(1).stderr(contains("away.jpg"));
    plenoscope(&["burst", &photo, "--reference", "3", "-o", &out])
        .assert()
        .code(1)
        .stderr(contains("--reference").and(contains("panicked").not()));
}
