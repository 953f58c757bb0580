//! Sources of depth: compared by one key, kept beside the photo, and what is said of files that are no nets.

use std::path::Path;

use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use plenoscope::scene::{DepthFrom, Recipe};
use plenoscope::synth::adopt::Shelf;

use crate::common::{Window, drop_files, has_device, is_made, opened, sample_file, steps, wait, window_with_shelf};
use crate::nets;

/// Frames in which a light field that was made before is there.
const AT_ONCE: usize = 3;

fn open(photo: &Path, shelf: &Path) -> Window {
    let mut harness = opened(window_with_shelf([1000.0, 700.0], Some(Shelf::new(shelf))), photo);
    steps(&mut harness, AT_ONCE);
    harness
}

fn depth_px(harness: &Window) -> f32 {
    harness.state().focus_depth_px([0.3, 0.6]).expect("there are ray depths")
}

#[test]
fn one_key_compares_sources_and_what_was_made_comes_back_at_once() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let shelf = folder.path().join("shelf");
    nets::write_metres(&shelf, "metres");
    let photo = sample_file(folder.path(), "sample.png");
    let mut harness = open(&photo, &shelf);
    let (edit, chosen) = (harness.state().edit().clone(), depth_px(&harness));
    assert_eq!(harness.state().source(), DepthFrom::Network);

    while harness.state().source().net_name() != Some("metres") {
        harness.key_press(Key::S);
        harness.step();
    }
    wait(&mut harness, "the other source", is_made);
    harness.step();
    let other = depth_px(&harness);
    assert!((other - chosen).abs() > 0.02, "{other} is not {chosen}");
    harness.key_press(Key::Escape);
    steps(&mut harness, AT_ONCE);
    assert!(!harness.state().is_busy(), "it was kept");
    assert_eq!((harness.state().source(), depth_px(&harness)), (DepthFrom::Network, chosen));
    while harness.state().source().net_name() != Some("metres") {
        harness.key_press(Key::S);
        harness.step();
    }
    steps(&mut harness, AT_ONCE);
    assert_eq!((harness.state().is_busy(), depth_px(&harness)), (false, other));
    assert_eq!(*harness.state().edit(), edit, "comparing is no edit");
    steps(&mut harness, 12);
    assert!(!Recipe::sidecar(&photo).exists(), "and keeps nothing");
}

#[test]
fn a_comparison_that_takes_its_time_is_stopped_by_esc() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let photo = sample_file(folder.path(), "sample.png");
    let mut harness = open(&photo, &folder.path().join("shelf"));
    let chosen = depth_px(&harness);
    harness.key_press(Key::S);
    harness.step();
    assert_ne!(harness.state().source(), DepthFrom::Network);
    assert!(harness.state().is_busy(), "another net of ours is asked");
    harness.key_press(Key::Escape);
    steps(&mut harness, AT_ONCE);
    assert!(!harness.state().is_busy());
    assert_eq!((harness.state().source(), depth_px(&harness)), (DepthFrom::Network, chosen));
}

#[test]
fn the_chosen_source_is_kept_by_its_checksum_and_its_loss_is_told() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let shelf = folder.path().join("shelf");
    nets::write_metres(&shelf, "metres");
    let photo = sample_file(folder.path(), "sample.png");
    let mut harness = open(&photo, &shelf);
    while harness.state().source().net_name() != Some("metres") {
        harness.key_press(Key::S);
        harness.step();
    }
    wait(&mut harness, "the other source", is_made);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::S);
    wait(&mut harness, "the sidecar", |_| {
        Recipe::of_photo(&photo).is_ok_and(|recipe| recipe.is_some_and(|recipe| recipe.depth.is_some()))
    });
    let kept = Recipe::of_photo(&photo).expect("read").expect("there").depth;
    assert!(matches!(&kept, Some(DepthFrom::Net(tag)) if tag.id == "metres" && tag.sha256.len() == 64), "{kept:?}");
    let depth = depth_px(&harness);
    drop(harness);

    std::fs::remove_dir_all(&shelf).expect("removed");
    nets::write_metres(&shelf, "another name");
    let harness = open(&photo, &shelf);
    assert_eq!(harness.state().source().net_name(), Some("another name"));
    assert!((depth_px(&harness) - depth).abs() < 1e-6, "the same net");
    drop(harness);

    std::fs::remove_dir_all(&shelf).expect("removed");
    let mut harness = window_with_shelf([1000.0, 700.0], Some(Shelf::new(&shelf)));
    harness.state_mut().open_file(&photo);
    // What is told goes by itself after a while, so it is looked for before the light field is waited for.
    let is_told = |harness: &mut Window| {
        harness.step();
        harness.query_all_by_label_contains("\"metres\"").count() == 1
    };
    let patience = std::time::Instant::now() + std::time::Duration::from_secs(120);
    while !is_told(&mut harness) {
        assert!(std::time::Instant::now() < patience, "one sentence tells");
    }
    wait(&mut harness, "the light field", is_made);
    assert_eq!(harness.state().source(), DepthFrom::Network);
    assert!((depth_px(&harness) - depth).abs() > 0.02, "the program's own net");
}

#[test]
fn what_is_dropped_and_is_no_depth_net_is_refused_in_a_sentence() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let shelf = folder.path().join("shelf");
    let mut harness = window_with_shelf([1000.0, 700.0], Some(Shelf::new(&shelf)));
    let bad = folder.path().join("notes.onnx");
    std::fs::write(&bad, b"Dear diary").expect("written");
    drop_files(&mut harness, &[bad]);
    assert!(harness.state().is_busy());
    wait(&mut harness, "the refusal", |app| !app.is_busy());
    steps(&mut harness, 2);
    assert!(harness.query_by_label("Details").is_some(), "a toast says why");
    assert!(Shelf::new(&shelf).nets().is_empty());
}

#[test]
fn a_net_that_was_added_shows_its_depth_of_the_sample() {
    let file = std::env::var_os("PLENOSCOPE_DATA").map(|data| Path::new(&data).join("depth_models/tiefenrausch.onnx"));
    let Some(file) = file.filter(|file| file.exists() && has_device()) else {
        eprintln!("SKIPPED: PLENOSCOPE_DATA does not name a folder with a public depth net");
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let shelf = Shelf::new(&folder.path().join("shelf"));
    let mut harness = window_with_shelf([1000.0, 700.0], Some(shelf.clone()));
    drop_files(&mut harness, &[file]);
    wait(&mut harness, "the trial", |app| !app.is_busy());
    steps(&mut harness, 4);
    assert!(harness.query_by_label("Added tiefenrausch").is_some());
    assert!(harness.query_all_by_label("Its depth by this net").next().is_some());
    harness.get_by_label("Use for all photos").click();
    wait(&mut harness, "the preference", |_| shelf.preferred().as_deref() == Some("tiefenrausch"));
    // The file is there before the frame that hears of it.
    steps(&mut harness, 4);
    assert!(harness.query_by_label("Added tiefenrausch").is_none(), "the card is closed");
}
