//! A light field becomes Gaussians, and their file goes in wherever a photo does.

use crate::common::{Scratch, plenoscope};

/// Mean difference of two pictures, 0 … 255.
fn apart(a: &std::path::Path, b: &std::path::Path) -> f32 {
    let [a, b] = [a, b].map(|path| image::open(path).unwrap().to_rgb8());
    assert_eq!(a.dimensions(), b.dimensions());
    let sum: u32 = a.as_raw().iter().zip(b.as_raw()).map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
    sum as f32 / a.as_raw().len() as f32
}

#[test]
fn gaussians_are_written_and_go_in_wherever_a_photo_does() {
    let dir = Scratch::new();
    let done = |args: &[&str]| plenoscope(args).assert().success().stderr("");
    done(&["sample", "-o", &dir.arg("")]);
    let (photo, map) = (dir.arg("sample.png"), dir.arg("sample.pfm"));
    let known = ["--disparity", &map, "--lambertian", "--long-side", "120"];
    let scene = dir.arg("scene.ply");
    done(&[&["export", &photo, "--as", "gaussians", "-o", &scene], &known[..]].concat());
    let info = done(&["info", "--json", &scene]);
    let said: serde_json::Value = serde_json::from_slice(&info.get_output().stdout).unwrap();
    assert_eq!((&said["kind"], &said["size"]), (&"splats".into(), &serde_json::json!([120, 80])));
    for at in ["0,0", "-3,2"] {
        done(&[&["view", &photo, "--at", at, "-o", &dir.arg("wanted.png")], &known[..]].concat());
        done(&["view", &scene, "--at", at, "-o", &dir.arg("got.png")]);
        let apart = apart(&dir.path("wanted.png"), &dir.path("got.png"));
        assert!(apart < 5.0, "{at}: {apart} of 255");
    }
    done(&["refocus", &scene, "-o", &dir.arg("fast.png"), "--f-number", "1.4"]);
    done(&["refocus", &scene, "-o", &dir.arg("slow.png"), "--f-number", "28"]);
    let blurred = apart(&dir.path("fast.png"), &dir.path("slow.png"));
    assert!(blurred > 2.0, "the lens does something: {blurred} of 255");
    done(&["synth", &scene, "-o", &dir.arg("field"), "--strength", "2"]);
    assert!(dir.path("field/disparity_7_7.pfm").exists());
}

#[test]
fn a_cloud_of_points_is_refused_in_one_sentence() {
    let dir = Scratch::new();
    plenoscope(&["sample", "-o", &dir.arg("")]).assert().success();
    let known = ["--disparity", &dir.arg("sample.pfm"), "--lambertian", "--long-side", "60"];
    let points = dir.arg("points.ply");
    let export = ["export", &dir.arg("sample.png"), "--as", "ply", "-o", &points];
    plenoscope(&[&export[..], &known[..]].concat()).assert().success();
    let refused = plenoscope(&["info", &points]).assert().code(1);
    let said = String::from_utf8(refused.get_output().stderr.clone()).unwrap();
    assert!(said.contains("a cloud of points and no Gaussian splats") && said.lines().count() == 1, "{said}");
}
