//! Several photos through the queue, and one of them bad.

use std::sync::Arc;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use plenoscope::field::ViewIndex;
use plenoscope::job::{Cancel, Job};
use plenoscope::scene::{Maker, Making, Need, Subject};

use crate::common::{drop_files, has_device, sample_file, steps, wait, window};

#[test]
fn photos_that_are_dropped_together_are_exported_and_a_bad_one_stops_nothing() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let first = sample_file(folder.path(), "a1.png");
    let last = folder.path().join("a10.png");
    std::fs::copy(&first, &last).expect("copied");
    let bad = folder.path().join("a2.png");
    std::fs::write(&bad, b"no picture").expect("written");
    let out = folder.path().join("out");
    std::fs::create_dir(&out).expect("made");

    let mut harness = window([1000.0, 700.0]);
    harness.state_mut().set_export_folder(&out);
    drop_files(&mut harness, &[last, bad, first]);
    steps(&mut harness, 2);
    harness.get_by_label("Export all…").click();
    // A dialog that scrolls takes a few frames to find its size.
    steps(&mut harness, 5);
    harness.get_by_role_and_label(Role::Button, "Export").click();
    steps(&mut harness, 2);
    assert!(harness.state().is_busy());
    wait(&mut harness, "the queue", |app| !app.is_busy());
    let mut names: Vec<_> = std::fs::read_dir(&out)
        .expect("the folder is there")
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(names, ["a1-f3.5.jpg", "a10-f3.5.jpg"], "whole files alone");
    steps(&mut harness, 2);
    assert!(harness.query_all_by_label("Show in folder").count() >= 2, "the queue tells");
}

#[test]
fn photos_of_one_subject_that_are_dropped_together_are_one_light_field() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let job = Job { cancel: &Cancel::default(), sink: &() };
    let making = Making { long_side: 300, occlusion: false, ..Making::default() };
    let sample = Arc::new(Subject::sample().expect("the sample"));
    let scene = Maker::default().scene(&sample, &making, Need::Views, &job).expect("its views");
    let photos = [(4, 4), (4, 1), (2, 6)].map(|(v, u)| {
        let view = scene.views().expect("views").field.view(ViewIndex { v, u });
        let path = folder.path().join(format!("p{v}{u}.png"));
        let [w, h] = view.size();
        image::save_buffer(&path, view.rgba(), w, h, image::ColorType::Rgba8).expect("written");
        path
    });
    let mut harness = window([1000.0, 700.0]);
    drop_files(&mut harness, &photos);
    steps(&mut harness, 2);
    harness.get_by_label("One subject").click();
    steps(&mut harness, 2);
    assert!(harness.state().is_busy());
    wait(&mut harness, "the light field", |app| !app.is_busy());
    steps(&mut harness, 2);
    assert!(harness.query_by_label("3 photos").is_some(), "the source of depth");
    // A folder of photos asks the same.
    drop_files(&mut harness, &[folder.path().to_owned()]);
    steps(&mut harness, 1);
    wait(&mut harness, "the question", |app| !app.is_busy());
    steps(&mut harness, 2);
    assert!(harness.query_by_label("3 files").is_some() && harness.query_by_label("One subject").is_some());
    assert!(harness.query_by_label("3 photos").is_some(), "what was open stays");
    // What was chosen the last time stands out: Enter takes it.
    harness.key_press(egui::Key::Enter);
    steps(&mut harness, 2);
    assert!(harness.state().is_busy() && harness.query_by_label("One subject").is_none());
}
