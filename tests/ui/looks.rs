//! What the window looks like: small pictures, drawn by a software device where they were made. `UPDATE_SNAPSHOTS=1` makes
//! them anew; look at them before you keep them.

use egui::Key;
use egui_kittest::SnapshotOptions;
use egui_kittest::kittest::Queryable as _;

use crate::common::{Window, has_device, steps, wait, window, with_sample};

/// Pixels that rasterisers may draw otherwise: rims of rounded corners and of letters.
const RIMS: usize = 60;

fn is_like(harness: &mut Window, name: &str) {
    harness.snapshot_options(name, &SnapshotOptions::new().max_failed_pixels(RIMS));
}

#[test]
fn empty_and_its_shortcut_sheet() {
    if !has_device() {
        return;
    }
    let mut harness = window([760.0, 560.0]);
    steps(&mut harness, 4);
    is_like(&mut harness, "empty");
    harness.key_press(Key::F1);
    steps(&mut harness, 6);
    is_like(&mut harness, "shortcuts");
}

#[test]
fn a_light_field_and_its_ray_depths() {
    if !has_device() {
        return;
    }
    let mut harness = with_sample([640.0, 480.0]);
    wait(&mut harness, "the picture at rest", |app| app.is_at_rest());
    steps(&mut harness, 8);
    is_like(&mut harness, "picture");
    harness.key_press(Key::D);
    steps(&mut harness, 6);
    is_like(&mut harness, "ray_depths");
    harness.get_by_label("Export…").click();
    steps(&mut harness, 6);
    is_like(&mut harness, "export");
}
