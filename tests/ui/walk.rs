//! Open the sample, get a light field, look round, focus, export; and what must not disturb that.

use egui::{pos2, vec2};
use egui_kittest::kittest::Queryable as _;
use plenoscope::field::ViewPoint;

use crate::common::{Window, button, click, has_device, steps, wait, with_sample};

#[test]
fn the_main_walk() {
    if !has_device() {
        return;
    }
    let mut harness = with_sample([1200.0, 800.0]);

    // Dragging the picture moves the eye, against the hand.
    let from = harness.get_by_label("Picture canvas").rect().center();
    harness.hover_at(from);
    harness.step();
    button(&harness, from, true);
    harness.step();
    for step in 1..=6 {
        harness.hover_at(from + vec2(10.0 * step as f32, 0.0));
        harness.step();
    }
    button(&harness, from + vec2(60.0, 0.0), false);
    harness.step();
    let eye = harness.state().edit().viewpoint.0;
    assert!(eye.du < -0.2 && eye.dv.abs() < 1e-3, "the eye moved to {eye:?}");

    // A click focuses on what is there.
    let before = harness.state().lens().focus.disparity_px;
    let at = pos2(from.x, from.y + 200.0);
    click(&mut harness, at);
    assert_ne!(harness.state().lens().focus.disparity_px, before, "the click focused");

    // Undo takes the edits back once they have settled; Home centres the eye.
    harness.key_press(egui::Key::Home);
    harness.step();
    assert_eq!(harness.state().edit().viewpoint, ViewPoint::default());

    // Export through the dialog.
    let folder = tempfile::tempdir().expect("a folder to export into");
    harness.state_mut().set_export_folder(folder.path());
    harness.get_by_label("Export…").click();
    // A dialog that scrolls takes a few frames to find its size.
    steps(&mut harness, 5);
    harness.get_by_role_and_label(egui::accesskit::Role::Button, "Export").click();
    harness.step();
    wait(&mut harness, "the export", |app| !app.is_busy());
    let files: Vec<_> = std::fs::read_dir(folder.path()).expect("the folder is there").flatten().collect();
    assert_eq!(files.len(), 1, "one file and nothing aside: {files:?}");
    let picture = image::open(files[0].path()).expect("the export is a picture");
    assert_eq!((picture.width(), picture.height()), (1200, 800), "it has the photo's size");
}

#[test]
fn views_depths_and_keys() {
    if !has_device() {
        return;
    }
    let mut harness = with_sample([1200.0, 800.0]);
    harness.get_by_label("Views").click();
    harness.step();
    harness.step();
    assert!(harness.query_all_by_label("View 0, 7").count() >= 1, "all views are shown");
    harness.query_all_by_label("View 0, 7").next().expect("the corner view").click();
    harness.step();
    harness.step();
    let eye = harness.state().edit().viewpoint.0;
    assert_eq!((eye.dv, eye.du), (-4.0, 3.0));
    harness.key_press(egui::Key::ArrowDown);
    harness.step();
    assert_eq!(harness.state().edit().viewpoint.0.dv, -3.0);
    harness.key_press(egui::Key::D);
    harness.step();
    harness.step();
    assert!(harness.query_by_label("Ray depths canvas").is_some(), "D shows the ray depths");
    harness.key_press(egui::Key::F1);
    harness.step();
    harness.step();
    assert!(harness.query_by_label("Shortcuts").is_some(), "F1 shows the sheet");
}

#[test]
fn points_turn_under_the_hand_and_back() {
    if !has_device() {
        return;
    }
    let mut harness = with_sample([1200.0, 800.0]);
    harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Num4);
    steps(&mut harness, 2);
    wait(&mut harness, "the points", |app| app.is_at_rest());
    let canvas = harness.get_by_label("Points canvas").rect();
    let from = canvas.center();
    let shown = |harness: &mut Window| {
        // The pointer is in the picture.
        harness.hover_at(from);
        steps(harness, 4);
        let all = harness.render().expect("the window is drawn");
        // Without the read-out below.
        let [x, y, w, h] =
            [canvas.left(), canvas.top(), canvas.width(), canvas.height() - 60.0].map(|side| side as u32);
        image::imageops::crop_imm(&all, x, y, w, h).to_image().into_raw()
    };
    let before = shown(&mut harness);
    let eye = harness.state().edit().viewpoint;
    button(&harness, from, true);
    harness.step();
    for step in 1..=6 {
        harness.hover_at(from + vec2(20.0 * step as f32, 0.0));
        harness.step();
    }
    button(&harness, from + vec2(120.0, 0.0), false);
    wait(&mut harness, "the points from the side", |app| app.is_at_rest());
    let turned = shown(&mut harness);
    let changed = before.chunks_exact(4).zip(turned.chunks_exact(4)).filter(|(a, b)| a != b).count();
    assert!(changed * 10 > before.len() / 4, "{changed} pixels changed");
    assert_eq!(harness.state().edit().viewpoint, eye, "the eye of the picture stays");
    harness.key_press(egui::Key::Home);
    steps(&mut harness, 2);
    wait(&mut harness, "the points from the front", |app| app.is_at_rest());
    assert!(shown(&mut harness) == before, "Home turns back");
}

/// A file that never ends: whoever waited for it would wait for ever.
#[cfg(unix)]
#[test]
fn a_pipe_is_refused_and_leaves_the_picture() {
    if !has_device() {
        return;
    }
    let mut harness = with_sample([1000.0, 700.0]);
    let folder = tempfile::tempdir().expect("a folder");
    let pipe = folder.path().join("pipe.jpg");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status().expect("mkfifo is there");
    assert!(made.success());
    harness.state_mut().open_file(&pipe);
    wait(&mut harness, "the refusal of a pipe that nobody writes to", |app| !app.is_busy());
    harness.step();
    assert!(harness.state().light_field().is_some(), "what was open stays usable");
    assert!(harness.query_by_label("Details").is_some(), "a toast says what happened");
}

#[test]
fn a_broken_file_leaves_the_picture() {
    if !has_device() {
        return;
    }
    let mut harness = with_sample([1000.0, 700.0]);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("broken.jpg");
    std::fs::write(&path, b"no picture at all").expect("written");
    harness.state_mut().open_file(&path);
    wait(&mut harness, "the refusal", |app| !app.is_busy());
    harness.step();
    assert!(harness.state().light_field().is_some(), "the picture that was there stays");
    assert!(harness.query_by_label("Details").is_some(), "a toast says what happened");
}

#[test]
fn a_narrow_window_folds() {
    if !has_device() {
        return;
    }
    let mut harness = with_sample([800.0, 600.0]);
    assert!(harness.query_by_label("Aperture slider").is_none(), "the inspector is a drawer");
    harness.get_by_label("Inspector").click();
    harness.step();
    harness.step();
    assert!(harness.query_by_label("Aperture slider").is_some(), "and opens");
}
