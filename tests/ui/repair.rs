//! Depth is mended by hand in the window: chosen, painted, dragged; undone singly, and kept beside the photo.

use egui::{Event, Key, Modifiers, Pos2, Role, vec2};
use egui_kittest::kittest::Queryable as _;
use plenoscope::repair::{Brush, Operation, Region, Repair};
use plenoscope::scene::Recipe;
use plenoscope::ui::App;

use crate::common::{Window, button, click, has_device, opened, sample_file, steps, wait, window};

/// Frames after which an edit counts as done.
const SETTLED: usize = 12;

fn with_photo(photo: &std::path::Path) -> Window {
    opened(window([1200.0, 800.0]), photo)
}

/// Presses, goes along, lets go.
fn drag(harness: &mut Window, path: &[Pos2]) {
    harness.hover_at(path[0]);
    harness.step();
    button(harness, path[0], true);
    harness.step();
    for at in path {
        harness.hover_at(*at);
        harness.step();
    }
    button(harness, path[path.len() - 1], false);
    harness.step();
}

fn depth(app: &App) -> f32 {
    app.focus_depth_px([0.5, 0.5]).expect("there are ray depths")
}

/// What was done, one after the other.
fn done(app: &App) -> Vec<Repair> {
    app.repairs().usable().cloned().collect()
}

fn mended(harness: &mut Window, count: usize) {
    wait(harness, "the mended light field", move |app| app.repairs().entries().len() == count && app.is_mended());
    steps(harness, 4);
}

#[test]
fn a_thing_is_chosen_moved_undone_and_found_again_with_the_photo() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let photo = sample_file(folder.path(), "sample.png");
    let mut harness = with_photo(&photo);
    steps(&mut harness, SETTLED);
    let before = depth(harness.state());
    harness.key_press(Key::M);
    steps(&mut harness, 3);
    let center = harness.get_by_label("Repair canvas").rect().center();
    click(&mut harness, center);
    steps(&mut harness, 3);
    harness.get_by_role_and_label(Role::Button, "Nearer").click();
    mended(&mut harness, 1);
    let nearer = depth(harness.state());
    // 0.25 px at 540, of views that are 120 px wide.
    assert!((nearer - before - 0.25 * 120.0 / 540.0).abs() < 0.02, "{before} became {nearer}");
    harness.get_by_role_and_label(Role::Button, "Flatten").click();
    mended(&mut harness, 2);
    steps(&mut harness, SETTLED);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    mended(&mut harness, 1);
    assert!((depth(harness.state()) - nearer).abs() < 1e-6, "one repair was undone, and no more");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    mended(&mut harness, 0);
    assert_eq!(depth(harness.state()), before);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    mended(&mut harness, 1);
    steps(&mut harness, SETTLED);
    let kept = done(harness.state());
    wait(&mut harness, "the sidecar", |_| {
        Recipe::of_photo(&photo).is_ok_and(|recipe| {
            recipe.is_some_and(|recipe| recipe.repairs.usable().cloned().collect::<Vec<_>>() == kept)
        })
    });
    drop(harness);
    let mut harness = with_photo(&photo);
    mended(&mut harness, 1);
    assert!((depth(harness.state()) - nearer).abs() < 1e-6, "opened again it is mended");
}

#[test]
fn a_brush_paints_a_wheel_grows_it_and_one_repair_is_taken_from_the_list() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = with_photo(&sample_file(folder.path(), "sample.png"));
    let before = depth(harness.state());
    harness.key_press(Key::M);
    steps(&mut harness, 3);
    harness.get_by_role_and_label(Role::RadioButton, "Farther").click();
    steps(&mut harness, 2);
    let center = harness.get_by_label("Repair canvas").rect().center();
    drag(&mut harness, &[center - vec2(60.0, 0.0), center, center + vec2(60.0, 0.0)]);
    mended(&mut harness, 1);
    assert!(depth(harness.state()) < before - 0.05, "{} where {before} was", depth(harness.state()));
    let size = |harness: &Window| match &done(harness.state())[..] {
        [.., Repair::Stroke(stroke)] => (stroke.size, stroke.brush),
        other => panic!("{other:?}"),
    };
    let first = size(&harness);
    assert_eq!(first.1, Brush::Farther);
    harness.hover_at(center);
    harness.step();
    let (unit, delta) = (egui::MouseWheelUnit::Point, vec2(0.0, 240.0));
    let (phase, modifiers) = (egui::TouchPhase::Move, Modifiers::NONE);
    let source = egui::MouseWheelSource::Unknown;
    harness.event(Event::MouseWheel { unit, delta, phase, source, modifiers });
    steps(&mut harness, 12);
    drag(&mut harness, &[center, center + vec2(0.0, 40.0)]);
    mended(&mut harness, 2);
    assert!(size(&harness).0 > 1.5 * first.0, "{:?} after {first:?}", size(&harness));
    harness.get_by_label("Remove repair 1").click();
    mended(&mut harness, 1);
    assert_eq!(size(&harness).1, Brush::Farther, "the second is left");
    harness.key_press(Key::Escape);
    steps(&mut harness, 3);
    assert!(harness.query_by_label("Repair canvas").is_none(), "the tool is put away");
}

#[test]
fn a_lasso_chooses_and_a_line_of_an_epipolar_image_is_dragged_to_another_slope() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = with_photo(&sample_file(folder.path(), "sample.png"));
    harness.key_press(Key::M);
    steps(&mut harness, 3);
    harness.get_by_role_and_label(Role::RadioButton, "Lasso").click();
    steps(&mut harness, 2);
    let center = harness.get_by_label("Repair canvas").rect().center();
    let ring = [(-80.0, -60.0), (80.0, -60.0), (80.0, 60.0), (-80.0, 60.0)].map(|(x, y)| center + vec2(x, y));
    drag(&mut harness, &ring);
    steps(&mut harness, 3);
    harness.get_by_role_and_label(Role::Button, "Flatten").click();
    mended(&mut harness, 1);
    let [Repair::Region { of: Region::Lasso { outline, .. }, what: Operation::Flatten }] = &done(harness.state())[..]
    else {
        panic!("{:?}", done(harness.state()))
    };
    assert!(outline.len() >= 4);
    harness.key_press(Key::Escape);
    harness.key_press(Key::Escape);
    steps(&mut harness, 3);
    // The line through the middle, from the strip's lowest view to another place.
    harness.hover_at(center);
    steps(&mut harness, 2);
    let strip = harness.get_by_label("Slope of the row").rect();
    let low = Pos2::new(center.x, strip.bottom() - 2.0);
    drag(&mut harness, &[low, low - vec2(30.0, 0.0)]);
    mended(&mut harness, 2);
    let [_, Repair::Region { of: Region::Click { at, .. }, what: Operation::To(to) }] = &done(harness.state())[..]
    else {
        panic!("{:?}", done(harness.state()))
    };
    assert!(at.iter().all(|at| (at - 0.5).abs() < 0.03), "{at:?}");
    // To the left below the view that is looked at: nearer than the focal plane.
    assert!(*to > 0.0, "{to}");
    let depth = depth(harness.state());
    assert!((depth - to * 120.0).abs() < 0.05, "{depth} px where {} was asked for", to * 120.0);
}
