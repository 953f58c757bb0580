//! Edits are undone, kept beside the photo, and found again.

use std::path::Path;
use std::sync::Arc;

use egui::{Key, Modifiers, vec2};
use egui_kittest::kittest::Queryable as _;
use plenoscope::field::{FNumber, Strength};
use plenoscope::job::{Cancel, Job};
use plenoscope::scene::export::{self, Settings};
use plenoscope::scene::recipe::PictureSettings;
use plenoscope::scene::{Edit, Embed, Focus, Maker, Making, Need, Recipe, Subject};

use crate::common::{Window, button, click, has_device, opened, sample_file, shift_click, steps, wait, window};

/// Frames after which an edit counts as done: they are a quarter of a second each.
const SETTLED: usize = 12;

/// A window with the light field of a photo.
fn with_photo(photo: &Path) -> Window {
    opened(window([1000.0, 700.0]), photo)
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
    let untouched = harness.state().edit().clone();

    let center = harness.get_by_label("Picture canvas").rect().center();
    click(&mut harness, center + vec2(-120.0, 120.0));
    steps(&mut harness, SETTLED);
    let focused = harness.state().edit().clone();
    assert!(matches!(focused.focus, Focus::At(_)));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    steps(&mut harness, 2);
    assert_eq!(*harness.state().edit(), untouched, "undone");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    steps(&mut harness, SETTLED);
    assert_eq!(*harness.state().edit(), focused, "done again");
    wait(&mut harness, "the sidecar", |_| {
        Recipe::of_photo(&photo).is_ok_and(|recipe| recipe.is_some_and(|recipe| recipe.edit(1) == focused))
    });

    let harness = with_photo(&photo);
    assert_eq!(*harness.state().edit(), focused);
}

#[test]
fn a_picture_leads_back_to_its_photo_with_its_edit() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let photo = sample_file(folder.path(), "sample.png");
    let job = Job { cancel: &Cancel::default(), sink: &() };
    let subject = Arc::new(Subject::open(&photo, &job).expect("opened"));
    let small = Making { long_side: 120, ..Making::default() };
    let scene = Maker::default().scene(&subject, &small, Need::Map, &job).expect("made");
    let edit = Edit { f_number: FNumber(1.8), focus: Focus::At([0.4, 0.4]), ..Edit::default() };
    let embed = Embed { recipe: true, ..Embed::default() };
    let settings = Settings { picture: PictureSettings { embed, ..PictureSettings::default() }, ..Settings::default() };
    let picture = folder.path().join("made.jpg");
    export::write(&scene, &edit, &settings, &picture, &job).expect("written");

    let mut harness = with_photo(&picture);
    assert!(harness.query_by_label("sample.png").is_some(), "the photo is open");
    assert_eq!(*harness.state().edit(), edit);
    wait(&mut harness, "the edit beside the photo", |_| {
        Recipe::of_photo(&photo).is_ok_and(|recipe| recipe.is_some_and(|recipe| recipe.edit(1) == edit))
    });
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    steps(&mut harness, 2);
    assert_ne!(*harness.state().edit(), edit, "what was there before comes back");
}

#[test]
fn an_edit_goes_through_the_clipboard_to_another_photo() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let photo = sample_file(folder.path(), "sample.png");
    let mut harness = with_photo(&photo);
    let edit = Edit { f_number: FNumber(7.0), focus: Focus::At([0.5, 0.5]), ..Edit::default() };
    harness.event(egui::Event::Paste(Recipe::default().with_edit(edit.clone()).to_json()));
    steps(&mut harness, 2);
    assert_eq!(*harness.state().edit(), edit);
    let depth = harness.state().focus_depth_px([0.5, 0.5]).expect("there are ray depths");
    assert!((harness.state().lens().focus.disparity_px - depth).abs() < 1e-6, "its place is in focus here");
}

#[test]
fn an_edit_that_cannot_be_read_is_told_and_never_written_over() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let photo = sample_file(folder.path(), "sample.png");
    let later = "{\"version\": 99, \"lens\": {}}";
    std::fs::write(Recipe::sidecar(&photo), later).expect("written");
    let mut harness = with_photo(&photo);
    let center = harness.get_by_label("Picture canvas").rect().center();
    // Where no toast lies.
    click(&mut harness, center + vec2(120.0, -120.0));
    steps(&mut harness, SETTLED);
    assert!(matches!(harness.state().edit().focus, Focus::At(_)), "it can be edited");
    drop(harness);
    assert_eq!(std::fs::read_to_string(Recipe::sidecar(&photo)).expect("it is there"), later);
}

#[test]
fn a_recipe_of_version_1_opens_as_it_looked() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let photo = sample_file(folder.path(), "sample.png");
    let old = r#"{"lens": {"f_number": 2.0, "focus": {"disparity_px": 0.25}}, "viewpoint": {"du": 1.0, "dv": 0.0}}"#;
    std::fs::write(Recipe::sidecar(&photo), old).expect("written");
    let harness = with_photo(&photo);
    let lens = harness.state().lens();
    assert_eq!((lens.f_number.0, harness.state().edit().viewpoint.0.du), (2.0, 1.0));
    assert!((lens.focus.disparity_px - 0.25).abs() < 1e-6, "its pixels are those of the views");
}

#[test]
fn strength_is_shown_everywhere_and_undone_as_one() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let photo = sample_file(folder.path(), "sample.png");
    let mut harness = with_photo(&photo);
    steps(&mut harness, SETTLED);
    let plain = Arc::clone(harness.state().light_field().expect("it is made"));
    let center = [0.5, 0.5];
    let depth = harness.state().focus_depth_px(center).expect("there are ray depths");
    let before = harness.state().edit().clone();
    let deep = Edit { strength: Strength(2.0), ..before.clone() };
    harness.event(egui::Event::Paste(Recipe::default().with_edit(deep).to_json()));
    steps(&mut harness, SETTLED);
    wait(&mut harness, "the deeper light field", |app| app.is_at_rest());
    let now = harness.state().focus_depth_px(center).expect("there are ray depths");
    assert!((now - 2.0 * depth).abs() < 1e-4, "{depth} became {now}");
    let shown = Arc::clone(harness.state().light_field().expect("it is made"));
    assert!(!Arc::ptr_eq(&shown, &plain) && shown.reference() == plain.reference());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    steps(&mut harness, SETTLED);
    wait(&mut harness, "what was made", |app| app.is_at_rest());
    assert_eq!(*harness.state().edit(), before);
    assert!(Arc::ptr_eq(harness.state().light_field().expect("it is made"), &plain));
}

#[test]
fn rings_are_set_moved_and_taken_away() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let photo = sample_file(folder.path(), "sample.png");
    let mut harness = with_photo(&photo);
    steps(&mut harness, SETTLED);
    let center = harness.get_by_label("Picture canvas").rect().center();
    let [first, second, third] = [vec2(-120.0, 60.0), vec2(110.0, -40.0), vec2(20.0, 90.0)].map(|by| center + by);
    let places = |harness: &Window| match harness.state().edit().focus {
        Focus::Through(places) => places.all().to_vec(),
        _ => Vec::new(),
    };
    click(&mut harness, first);
    shift_click(&mut harness, second);
    let two = places(&harness);
    assert_eq!(two.len(), 2, "the click before is the first");
    let lens = harness.state().lens();
    for place in &two {
        let depth = harness.state().focus_depth_px(*place).expect("there are ray depths");
        assert!(lens.defocus_px(depth, place[0], place[1]).abs() < 0.02, "{place:?} is sharp");
    }
    shift_click(&mut harness, third);
    assert_eq!(places(&harness).len(), 3);
    steps(&mut harness, SETTLED);
    // The hand takes a ring and not the picture.
    let viewpoint = harness.state().edit().viewpoint;
    harness.hover_at(third);
    harness.step();
    button(&harness, third, true);
    harness.step();
    for part in 1..=4 {
        harness.hover_at(third + vec2(10.0, 5.0) * part as f32);
        harness.step();
    }
    button(&harness, third + vec2(40.0, 20.0), false);
    harness.step();
    let moved = places(&harness);
    assert!(moved[..2] == two[..] && moved[2][0] > 0.5, "{moved:?}");
    assert_eq!(harness.state().edit().viewpoint, viewpoint);
    steps(&mut harness, SETTLED);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    steps(&mut harness, SETTLED);
    assert_ne!(places(&harness)[2], moved[2], "undone as one");
    shift_click(&mut harness, first);
    assert_eq!(places(&harness), [places(&harness)[0], places(&harness)[1]], "a click on a ring takes it away");
    click(&mut harness, second);
    assert!(matches!(harness.state().edit().focus, Focus::At(_)));
}
