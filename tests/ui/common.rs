//! What the window's tests share: a window without a display, waiting, the hand.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use egui::{Event, Modifiers, PointerButton, Pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use plenoscope::synth::ModelSource;
use plenoscope::synth::adopt::Shelf;
use plenoscope::ui::{App, Options};

/// Frames after which a job must have ended; each waits a little, so this is minutes on a slow machine.
const MANY_FRAMES: usize = 20_000;

/// A window without a display.
pub type Window = Harness<'static, App>;

/// Whether there is a device; says so where there is none.
pub fn has_device() -> bool {
    let adapter = pollster::block_on(wgpu::Instance::default().request_adapter(&Default::default()));
    if adapter.is_err() {
        assert!(std::env::var_os("PLENOSCOPE_NEED_GPU").is_none(), "no device, and PLENOSCOPE_NEED_GPU is set");
        eprintln!("SKIPPED: no device here; install a Vulkan driver (mesa-vulkan-drivers) to test the window");
    }
    adapter.is_ok()
}

/// An empty window, whose views will be small.
pub fn window(size: [f32; 2]) -> Window {
    window_of(size, 120, None, None)
}

/// The same after faults whose reports lie in a folder.
pub fn window_after_faults(size: [f32; 2], crashes: &Path) -> Window {
    window_of(size, 120, None, Some(crashes.to_owned()))
}

/// The same with nets that a person added.
pub fn window_with_shelf(size: [f32; 2], shelf: Option<Shelf>) -> Window {
    window_of(size, 120, shelf, None)
}

/// The same with a program that trains.
#[cfg(unix)]
pub fn window_with_trainer(size: [f32; 2], shelf: Shelf, trainer: &Path) -> Window {
    with_options(size, Options { shelf: Some(shelf), trainer: Some(trainer.to_owned()), ..usual() })
}

/// An empty window, whose views will have this long side.
fn window_of(size: [f32; 2], long_side: u32, shelf: Option<Shelf>, crashes: Option<PathBuf>) -> Window {
    with_options(size, Options { long_side: Some(long_side), shelf, crashes, ..usual() })
}

/// An empty window that speaks German.
pub fn german_window(size: [f32; 2]) -> Window {
    with_options(size, Options { language: Some("de".to_owned()), ..usual() })
}

/// How windows of tests are started: in English, whatever the system speaks.
fn usual() -> Options {
    Options {
        files: Vec::new(),
        models: ModelSource::Embedded,
        shelf: None,
        trainer: None,
        crashes: None,
        long_side: Some(120),
        threads: 1,
        restores_last: false,
        language: Some("en".to_owned()),
    }
}

fn with_options(size: [f32; 2], options: Options) -> Window {
    Harness::builder()
        .with_size(vec2(size[0], size[1]))
        .with_max_steps(16)
        .wgpu()
        .build_eframe(move |creation| App::new(options, &creation.egui_ctx, creation.wgpu_render_state.as_ref(), None))
}

/// Steps until something holds; returns the frames that went by.
pub fn wait(harness: &mut Window, what: &str, holds: impl Fn(&App) -> bool) -> usize {
    for frame in 0..MANY_FRAMES {
        harness.step();
        if holds(harness.state()) {
            return frame;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("{what}: not within {MANY_FRAMES} frames");
}

/// A window once the light field of a photo is there.
pub fn opened(mut harness: Window, photo: &Path) -> Window {
    harness.state_mut().open_file(photo);
    wait(&mut harness, "the light field", is_made);
    harness
}

/// Some frames.
pub fn steps(harness: &mut Window, count: usize) {
    (0..count).for_each(|_| harness.step());
}

/// Presses or lets go.
pub fn button(harness: &Window, pos: Pos2, pressed: bool) {
    let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
    harness.event(Event::PointerButton { pos, button, pressed, modifiers });
}

/// A click at a place.
pub fn click(harness: &mut Window, at: Pos2) {
    harness.hover_at(at);
    harness.step();
    button(harness, at, true);
    harness.step();
    button(harness, at, false);
    harness.step();
}

/// The same with Shift held.
pub fn shift_click(harness: &mut Window, at: Pos2) {
    harness.hover_at(at);
    harness.step();
    harness.event(Event::ModifiersChanged(Modifiers::SHIFT));
    harness.step();
    let (button, modifiers) = (PointerButton::Primary, Modifiers::SHIFT);
    for pressed in [true, false] {
        harness.event(Event::PointerButton { pos: at, button, pressed, modifiers });
        harness.step();
    }
    harness.event(Event::ModifiersChanged(Modifiers::NONE));
    harness.step();
}

/// A window with the sample's light field, all of it on the device.
pub fn with_sample(size: [f32; 2]) -> Window {
    try_sample(window(size))
}

/// The same with views as large as people have them.
pub fn with_large_sample(size: [f32; 2]) -> Window {
    try_sample(window_of(size, 540, None, None))
}

fn try_sample(mut harness: Window) -> Window {
    harness.step();
    harness.get_by_label("Try the sample").click();
    wait(&mut harness, "the sample's light field", is_made);
    steps(&mut harness, 80);
    harness
}

/// Whether a light field is there and nothing runs.
pub fn is_made(app: &App) -> bool {
    app.light_field().is_some() && !app.is_busy()
}

/// The sample as a file.
pub fn sample_file(folder: &Path, name: &str) -> PathBuf {
    let sample = plenoscope::io::sample::sample().expect("the sample is drawn");
    let [w, h] = sample.photo.size();
    let rgb: Vec<u8> = sample.photo.srgb8().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    let path = folder.join(name);
    image::save_buffer(&path, &rgb, w, h, image::ExtendedColorType::Rgb8).expect("written");
    path
}

#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }
    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

/// Drops files on the window.
pub fn drop_files(harness: &mut Window, paths: &[PathBuf]) {
    harness.input_mut().dropped_files = paths.iter().map(|path| Arc::new(Dropped(path.clone())) as _).collect();
    harness.step();
}
