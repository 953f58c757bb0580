//! Depth nets beside the pair's own, put into the models folder: other people's in two layouts, and a second one of ours.

use std::path::Path;

use plenoscope::field::{Photo, RelativeDepth, ViewGrid};
use plenoscope::job::{Cancel, Job};
use plenoscope::synth::{DepthSource, ModelSource, SynthError, SynthParams, Synthesis, Synthesizer, lift};

use crate::nets;

const SIZE: [u32; 2] = [240, 160];

/// Red grows to the right, blue upwards.
fn photo() -> Photo {
    let [w, h] = SIZE;
    let pixel = |i: u32| [(i % w * 255 / (w - 1)) as u8, 90, (255 - i / w * 255 / (h - 1)) as u8, 255];
    Photo::from_srgb8(SIZE, (0..w * h).flat_map(pixel).collect()).unwrap()
}

/// A folder with both nets and the pair that every folder has.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    nets::write_pair(folder.path(), 1);
    nets::write_patches(folder.path(), "patches");
    nets::write_metres(folder.path(), "metres");
    folder
}

fn synthesize(folder: &Path, model: &str) -> Result<Synthesis, SynthError> {
    let synthesizer = Synthesizer::load(&ModelSource::Folder(folder.to_owned()))?;
    let source = DepthSource::Model(model.to_owned());
    let params = SynthParams { source, occlusion: false, ..SynthParams::default() };
    synthesizer.synthesize(&photo(), &params, &Job { cancel: &Cancel::default(), sink: &() })
}

/// Checks ray depth along a line of the reference view: place and share of the way from far to near.
fn check(made: &Synthesis, along: impl Fn(f32) -> [f32; 2], wanted: &[(f32, f32)]) {
    let map = made.depths.reference_map();
    let [far, near] = RelativeDepth::usual_range_px(SIZE[0]);
    for &(place, want) in wanted {
        let [x, y] = along(place);
        let got = (map.at((x * SIZE[0] as f32) as u32, (y * SIZE[1] as f32) as u32) - far) / (near - far);
        assert!((got - want).abs() < 0.06, "at {place} of the way the depth is {got}, not {want}");
    }
    assert_eq!(*made.depths, lift::ray_depths(&map, ViewGrid::PAPER), "64 ray depths are lifted from it");
}

#[test]
fn both_are_offered_and_no_other() {
    let source = ModelSource::Folder(folder().path().to_owned());
    assert!(source.further_models().is_empty(), "the folder has gone");
    let folder = folder();
    assert_eq!(ModelSource::Folder(folder.path().to_owned()).further_models(), ["metres", "patches"]);
}

#[test]
fn planes_of_patches_with_mean_and_deviation() {
    let made = synthesize(folder().path(), "patches").unwrap();
    assert_eq!(made.models.iter().map(|model| model.id.as_str()).collect::<Vec<_>>(), ["patches"]);
    // Flat up to the middle, then rising: only with the mean taken off lies the bend where red is one half.
    check(&made, |x| [x, 0.5], &[(0.1, 0.0), (0.3, 0.0), (0.45, 0.0), (0.75, 0.5), (0.85, 0.72)]);
}

#[test]
fn interleaved_blue_first_of_a_fixed_size_with_distances() {
    let made = synthesize(folder().path(), "metres").unwrap();
    let nearness = |y: f32| 1.0 / (2.0 + 4.0 * (1.0 - y));
    let want = |y: f32| (y, (nearness(y) - nearness(0.02)) / (nearness(0.98) - nearness(0.02)));
    check(&made, |y| [0.5, y], &[want(0.2), want(0.5), want(0.7), want(0.85)]);
}

#[test]
fn a_second_net_of_our_own_kind_is_chosen_by_its_name() {
    let folder = folder();
    let onnx = nets::onnx(&[nets::Layer::conv2(3, 64)], 9);
    nets::write_model(folder.path(), "second", &onnx, "ray-depth");
    let source = ModelSource::Folder(folder.path().to_owned());
    assert_eq!(source.further_models(), ["metres", "patches", "second"]);
    let second = synthesize(folder.path(), "second").unwrap();
    assert_eq!(second.models.iter().map(|model| model.id.as_str()).collect::<Vec<_>>(), ["second"]);
    nets::write_model(folder.path(), "depth", &onnx, "ray-depth");
    let params = SynthParams { occlusion: false, ..SynthParams::default() };
    let job = Job { cancel: &Cancel::default(), sink: &() };
    let same = Synthesizer::load(&source).unwrap().synthesize(&photo(), &params, &job).unwrap();
    assert_eq!(second.depths, same.depths, "as if it were the pair's own");
}

#[test]
fn a_source_that_cannot_be_used_is_told_in_one_sentence() {
    type Damage = fn(&Path);
    let cases: [(&str, Damage, &[&str]); 5] = [
        ("patched", |_| {}, &["\"patched\"", "metres, patches"]),
        ("occlusion", |_| {}, &["task", "manifest.toml"]),
        ("patches", |f| std::fs::write(f.join("patches/model.onnx"), b"x").unwrap(), &["checksum"]),
        ("other", |f| std::fs::rename(f.join("patches"), f.join("other")).unwrap(), &["its id is \"patches\""]),
        (
            "many",
            |f| nets::write_with_manifest(f, "many", &nets::onnx(&[nets::Layer::conv2(3, 5)], 1), "relative-depth", ""),
            &["one depth map", "[1, 5, 160, 240]"],
        ),
    ];
    for (model, damage, words) in cases {
        let folder = folder();
        damage(folder.path());
        let text = synthesize(folder.path(), model).unwrap_err().to_string();
        assert!(words.iter().all(|word| text.contains(word)) && !text.contains('\n'), "{model}: {text}");
    }
}
