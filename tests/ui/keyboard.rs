//! A whole session without a mouse: open, look, focus, aperture, timeline, export; and what is said meanwhile.

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT as _, Queryable as _};

use crate::common::{Window, has_device, is_made, steps, wait, window};

/// What has the keyboard.
fn focused(harness: &Window) -> Option<(Role, String)> {
    let mut all = harness.root().children_recursive();
    let node = all.find(|node| node.accesskit_node().is_focused())?;
    Some((node.accesskit_node().role(), node.accesskit_node().label().unwrap_or_default()))
}

/// Presses Tab until a control has the keyboard.
fn tab_to(harness: &mut Window, role: Role, label: &str) {
    let mut passed = Vec::new();
    for _ in 0..200 {
        harness.key_press(Key::Tab);
        steps(harness, 2);
        let now = focused(harness);
        if now.as_ref().is_some_and(|(is, name)| (*is, name.as_str()) == (role, label)) {
            return;
        }
        passed.extend(now);
    }
    panic!("Tab does not lead to {label}, but to {passed:?}");
}

/// What screen readers are told of the lens.
fn said(harness: &Window) -> String {
    let mut all = harness.root().children_recursive();
    let is_said = |text: &String| text.starts_with("layer ");
    all.find_map(|node| node.accesskit_node().label().filter(is_said)).unwrap_or_default()
}

/// What the window says aloud of itself.
fn alert(harness: &Window) -> Option<String> {
    let mut all = harness.root().children_recursive();
    all.find(|node| node.accesskit_node().role() == Role::Alert)?.accesskit_node().label()
}

#[test]
fn a_session_by_keys_alone() {
    if !has_device() {
        return;
    }
    let mut harness = window([1300.0, 860.0]);
    steps(&mut harness, 3);
    tab_to(&mut harness, Role::Button, "Try the sample");
    harness.key_press(Key::Enter);
    wait(&mut harness, "the sample's light field", is_made);
    steps(&mut harness, 10);

    // Look: arrows move the eye, and it is said.
    harness.key_press(Key::ArrowRight);
    steps(&mut harness, 2);
    assert_eq!(harness.state().edit().viewpoint.0.du, 1.0);
    assert!(said(&harness).ends_with(", 1.0 right"), "{}", said(&harness));
    harness.key_press(Key::Home);

    // Focus: layer by layer.
    for _ in 0..9 {
        harness.key_press(Key::PageUp);
        steps(&mut harness, 2);
    }
    let near = harness.state().lens().focus.disparity_px;
    let nearest = said(&harness);
    assert!(nearest.starts_with("layer 1 of ") && nearest.ends_with(", f/3.5"), "{nearest}");
    harness.key_press(Key::PageDown);
    steps(&mut harness, 2);
    assert!(said(&harness).starts_with("layer 2 of "), "{}", said(&harness));
    assert!(harness.state().lens().focus.disparity_px < near, "the next layer is farther");

    // Aperture: Tab leads to its slider, whose arrows are its own.
    tab_to(&mut harness, Role::Slider, "Aperture slider");
    let (f, eye) = (harness.state().edit().f_number.0, harness.state().edit().viewpoint);
    for _ in 0..4 {
        harness.key_press(Key::ArrowRight);
        steps(&mut harness, 2);
    }
    let wide = harness.state().edit().f_number.0;
    assert!(wide < f && harness.state().edit().viewpoint == eye, "f/{f} became f/{wide}");
    assert!(
        said(&harness).contains(&format!("f/{}", format!("{wide:.1}").trim_end_matches(".0"))),
        "{}",
        said(&harness)
    );

    // A key of a film, and the next.
    harness.key_press_modifiers(Modifiers::SHIFT, Key::K);
    steps(&mut harness, 2);
    for _ in 0..20 {
        harness.key_press(Key::Period);
        steps(&mut harness, 1);
    }
    harness.key_press(Key::PageUp);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::K);
    steps(&mut harness, 3);
    assert!(harness.query_by_label("Key 2 at 3.0 s: focus, aperture, eye").is_some(), "two keys are there");
    tab_to(&mut harness, Role::Slider, "Playhead, seconds");
    for _ in 0..3 {
        harness.key_press(Key::ArrowLeft);
        steps(&mut harness, 2);
    }
    assert_eq!(focused(&harness), Some((Role::Slider, "Playhead, seconds".to_owned())), "arrows do not lead away");
    assert_eq!(harness.state().edit().viewpoint, eye, "arrows are the playhead's");
    harness.key_press(Key::F);
    steps(&mut harness, 2);

    // Export.
    let folder = tempfile::tempdir().expect("a folder to export into");
    harness.state_mut().set_export_folder(folder.path());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    steps(&mut harness, 6);
    tab_to(&mut harness, Role::Button, "Export");
    harness.key_press(Key::Enter);
    harness.step();
    wait(&mut harness, "the export", |app| !app.is_busy());
    steps(&mut harness, 2);
    let files: Vec<_> = std::fs::read_dir(folder.path()).expect("the folder is there").flatten().collect();
    assert_eq!(files.len(), 1, "one file: {files:?}");
    let told = files[0].file_name().to_string_lossy().into_owned();
    assert_eq!(alert(&harness), Some(format!("Saved {told}")), "it is said");

    // The next time Enter alone is enough: the button stands out.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    steps(&mut harness, 6);
    harness.key_press(Key::Enter);
    steps(&mut harness, 2);
    wait(&mut harness, "the other export", |app| !app.is_busy());
    assert_eq!(std::fs::read_dir(folder.path()).expect("the folder is there").count(), 2);
}

#[test]
fn escape_closes_a_menu_first() {
    if !has_device() {
        return;
    }
    let mut harness = window([900.0, 600.0]);
    steps(&mut harness, 3);
    harness.get_by_role_and_label(Role::Button, "Plenoscope").click();
    steps(&mut harness, 3);
    assert!(harness.query_by_label_contains("Settings…").is_some());
    harness.key_press(Key::Escape);
    steps(&mut harness, 3);
    assert!(harness.query_by_label_contains("Settings…").is_none());
}
