//! Several photos through the queue, and one of them bad.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;

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
