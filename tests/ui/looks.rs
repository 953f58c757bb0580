//! What the window looks like: small pictures of it, half its size. `UPDATE_SNAPSHOTS=1` makes them anew; look at them
//! before you keep them.

use egui::Key;
use egui_kittest::kittest::Queryable as _;
use egui_kittest::{SnapshotOptions, image_snapshot_options};
use plenoscope::field::FNumber;
use plenoscope::scene::{Edit, Recipe};

use crate::common::{Window, has_device, steps, wait, window, with_large_sample, with_sample};

/// Pixels that rasterisers may draw otherwise: rims of rounded corners and of letters.
const RIMS: usize = 60;

/// Height of the status line, which names the device that draws.
const STATUS: u32 = 26;

fn is_like(harness: &mut Window, name: &str) {
    let mut shown = harness.render().expect("the window is drawn");
    shown.pixels_mut().for_each(on_surround);
    let (width, height) = (shown.width(), shown.height() - STATUS);
    let shown = image::imageops::crop_imm(&shown, 0, 0, width, height).to_image();
    let small = image::imageops::resize(&shown, width / 2, height / 2, image::imageops::FilterType::Triangle);
    image_snapshot_options(&small, name, &SnapshotOptions::new().max_failed_pixels(RIMS));
}

/// The window is cleared with this before anything is painted; without a window it is not.
const SURROUND: u8 = 0x14;

/// Colours are premultiplied.
fn on_surround(pixel: &mut image::Rgba<u8>) {
    let [r, g, b, alpha] = pixel.0;
    let rest = (u32::from(SURROUND) * u32::from(255 - alpha) / 255) as u8;
    pixel.0 = [r.saturating_add(rest), g.saturating_add(rest), b.saturating_add(rest), 255];
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
    harness.state_mut().set_export_folder(std::path::Path::new("/exports"));
    steps(&mut harness, 8);
    is_like(&mut harness, "picture");
    harness.key_press(Key::D);
    steps(&mut harness, 6);
    is_like(&mut harness, "ray_depths");
    harness.get_by_label("Export…").click();
    steps(&mut harness, 6);
    is_like(&mut harness, "export");
}

/// Draws the window for README into the folder that `PLENOSCOPE_PICTURES` names: see `scripts/pictures.sh`.
#[test]
fn picture_of_readme() {
    let Some(folder) = std::env::var_os("PLENOSCOPE_PICTURES") else {
        eprintln!("SKIPPED: PLENOSCOPE_PICTURES names no folder for the picture");
        return;
    };
    assert!(has_device(), "the window is drawn on a device");
    let mut harness = with_large_sample([1280.0, 800.0]);
    let edit = Edit { f_number: FNumber(1.4), ..harness.state().edit().clone() };
    harness.event(egui::Event::Paste(Recipe::default().with_edit(edit).to_json()));
    steps(&mut harness, 4);
    wait(&mut harness, "the picture at rest", |app| app.is_at_rest());
    harness.get_by_label("Close").click();
    steps(&mut harness, 4);
    while harness.query_by_label("Got it").is_some() {
        harness.get_by_label("Got it").click();
        steps(&mut harness, 4);
    }
    let mut shown = harness.render().expect("the window is drawn");
    shown.pixels_mut().for_each(on_surround);
    let path = std::path::Path::new(&folder).join("window.jpg");
    image::DynamicImage::ImageRgba8(shown).to_rgb8().save(path).expect("written");
}
