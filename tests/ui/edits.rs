//! Edits are undone, kept beside the photo, and found again.

use std::path::Path;

use egui::{Key, Modifiers, vec2};
use egui_kittest::kittest::Queryable as _;
use plenoscope::recipe::Recipe;

use crate::common::{Window, click, has_device, is_made, sample_file, steps, wait, window};

/// Frames after which an edit counts as done: they are a quarter of a second each.
const SETTLED: usize = 12;

/// A window with the light field of a photo.
fn with_photo(photo: &Path) -> Window {
    let mut harness = window([1000.0, 700.0]);
    harness.state_mut().open_file(photo);
    wait(&mut harness, "the light field", is_made);
    harness
}

#[test]
fn an_edit_is_undone_kept_beside_the_photo_and_found_again() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let photo = sample_file(folder.path(), "sample.png");
    let mut harness = with_photo(&photo);
    steps(&mut harness, SETTLED);
    assert!(!Recipe::sidecar(&photo).exists(), "looking is no edit");
    let untouched = *harness.state().edit();

    let center = harness.get_by_label("Picture canvas").rect().center();
    click(&mut harness, center + vec2(-120.0, 120.0));
    steps(&mut harness, SETTLED);
    let focused = *harness.state().edit();
    assert!(focused.focus_at.is_some());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    steps(&mut harness, 2);
    assert_eq!(*harness.state().edit(), untouched, "undone");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    steps(&mut harness, SETTLED);
    assert_eq!(*harness.state().edit(), focused, "done again");
    wait(&mut harness, "the sidecar", |_| {
        Recipe::of_photo(&photo).is_ok_and(|recipe| recipe.is_some_and(|recipe| recipe.focus_at == focused.focus_at))
    });

    let harness = with_photo(&photo);
    let again = *harness.state().edit();
    assert_eq!((again.lens, again.focus_at), (focused.lens, focused.focus_at));
}

#[test]
fn an_edit_goes_through_the_clipboard_to_another_photo() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let photo = sample_file(folder.path(), "sample.png");
    let mut harness = with_photo(&photo);
    let mut recipe = Recipe::default();
    recipe.lens.f_number = plenoscope::field::FNumber(7.0);
    recipe.focus_at = Some([0.5, 0.5]);
    harness.event(egui::Event::Paste(recipe.to_json()));
    steps(&mut harness, 2);
    let edit = harness.state().edit();
    assert_eq!((edit.lens.f_number.0, edit.focus_at), (7.0, Some([0.5, 0.5])));
    let depths = harness.state().focus_depth_px([0.5, 0.5]).expect("there are ray depths");
    assert!((edit.lens.focus.disparity_px - depths).abs() < 1e-6, "its place is in focus here");
}
