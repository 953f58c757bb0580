//! A monkey at the window: whatever is pressed, turned, dropped and broken, no part of the program panics.
//!
//! The ordinary run does two thousand things; `PLENOSCOPE_MONKEY=100000` as many as are asked for, and says how it went.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use egui::{Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, TouchPhase, pos2, vec2};
use plenoscope::crash;
use plenoscope::field::{LightField, View, ViewGrid};
use plenoscope::io::formats::{FieldToWrite, views};
use plenoscope::job::{Cancel, Job};

use crate::common::{Window, drop_files, has_device, sample_file, window};

/// Things that are done where nobody asks for more.
const FEW: usize = 2000;
/// Frames within which everything should have ended: five seconds and more.
const MANY_FRAMES: usize = 500;
/// Things that are done between two frames.
const A_FRAME: usize = 6;

/// A small generator, so that a failure can be repeated.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) % n.max(1) as u64) as usize
    }

    fn place(&mut self, size: [f32; 2]) -> Pos2 {
        pos2(self.below(size[0] as usize) as f32, self.below(size[1] as usize) as f32)
    }
}

/// Photos, a light field, and what is none.
fn files(folder: &Path) -> Vec<PathBuf> {
    let photo = sample_file(folder, "sample.png");
    let small = folder.join("small.jpg");
    image::RgbImage::from_fn(60, 40, |x, y| image::Rgb([(x * 4) as u8, (y * 6) as u8, 90]))
        .save(&small)
        .expect("written");
    let whole = std::fs::read(&photo).expect("it is there");
    let broken = folder.join("broken.png");
    std::fs::write(&broken, &whole[..whole.len() / 3]).expect("written");
    let text = folder.join("text.jpg");
    std::fs::write(&text, "no picture").expect("written");
    let tiny = folder.join("tiny.png");
    image::RgbImage::from_pixel(1, 1, image::Rgb([1, 2, 3])).save(&tiny).expect("written");
    let grid = ViewGrid::new(3, 3).expect("a grid");
    let view =
        |n: u8| Arc::new(View::new([40, 30], (0..40 * 30 * 4).map(|i| (i as u8) ^ n).collect()).expect("a view"));
    let field = LightField::new(grid, (0..9).map(view).collect()).expect("a light field");
    let at = folder.join("field");
    let job = Job { cancel: &Cancel::default(), sink: &() };
    views::write(&at, &FieldToWrite::new(&field), &job).expect("written");
    vec![photo, small, broken, text, tiny, at, folder.join("nothing here")]
}

/// Keys that the window hears; Q would ask the system to close it.
const KEYS: [Key; 34] = [
    Key::ArrowLeft,
    Key::ArrowRight,
    Key::ArrowUp,
    Key::ArrowDown,
    Key::Home,
    Key::Escape,
    Key::Enter,
    Key::Tab,
    Key::Space,
    Key::Plus,
    Key::Minus,
    Key::Num0,
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::A,
    Key::B,
    Key::C,
    Key::D,
    Key::E,
    Key::F,
    Key::G,
    Key::I,
    Key::M,
    Key::P,
    Key::R,
    Key::S,
    Key::T,
    Key::U,
    Key::X,
    Key::Y,
    Key::Z,
    Key::F1,
    Key::Delete,
];

fn act(window: &mut Window, random: &mut Random, files: &[PathBuf], size: &mut [f32; 2]) {
    match random.below(100) {
        0..40 => {
            let all = [Modifiers::NONE, Modifiers::NONE, Modifiers::NONE, Modifiers::SHIFT, Modifiers::COMMAND];
            let modifiers = all[random.below(all.len())];
            window.key_press_modifiers(modifiers, KEYS[random.below(KEYS.len())]);
        }
        40..60 => {
            let pos = random.place(*size);
            let buttons =
                [PointerButton::Primary, PointerButton::Primary, PointerButton::Secondary, PointerButton::Middle];
            let button = buttons[random.below(buttons.len())];
            window.event(Event::PointerMoved(pos));
            for pressed in [true, false] {
                window.event(Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE });
            }
        }
        60..72 => {
            let (from, to, modifiers) = (random.place(*size), random.place(*size), Modifiers::NONE);
            let button = PointerButton::Primary;
            window.event(Event::PointerMoved(from));
            window.event(Event::PointerButton { pos: from, button, pressed: true, modifiers });
            window.step();
            window.event(Event::PointerMoved(to));
            window.step();
            window.event(Event::PointerButton { pos: to, button, pressed: false, modifiers });
        }
        72..84 => {
            let (unit, modifiers, phase) = (MouseWheelUnit::Point, Modifiers::NONE, TouchPhase::Move);
            let delta = vec2(random.below(200) as f32 - 100.0, random.below(400) as f32 - 200.0);
            let source = MouseWheelSource::Wheel;
            window.event(Event::MouseWheel { unit, delta, phase, source, modifiers });
        }
        84..88 => window.event(Event::Text(["7", "-1e9", "nan", "/", "ü", "🦀"][random.below(6)].to_owned())),
        88..92 => window.event(Event::PointerGone),
        92..95 => {
            let sizes = [[640.0, 480.0], [900.0, 600.0], [1200.0, 500.0], [500.0, 900.0], [320.0, 200.0]];
            *size = sizes[random.below(sizes.len())];
            window.set_size(vec2(size[0], size[1]));
        }
        95..99 => {
            let file = &files[random.below(files.len())];
            window.state_mut().open_file(file);
        }
        _ => {
            let file = files[random.below(files.len())].clone();
            drop_files(window, &[file]);
        }
    }
}

/// Memory that this process holds, in MiB; none where the system does not say.
fn held_mib() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: f64 = text.split_whitespace().nth(1)?.parse().ok()?;
    Some(pages * 4096.0 / f64::from(1 << 20))
}

#[test]
fn whatever_is_done_no_part_panics() {
    if !has_device() {
        return;
    }
    let count = std::env::var("PLENOSCOPE_MONKEY").ok().and_then(|text| text.parse().ok()).unwrap_or(FEW);
    let folder = tempfile::tempdir().expect("a folder");
    let files = files(folder.path());
    // A worker's panic is told in the window; here it also leaves a report.
    crash::watch(folder.path().join("crashes"));
    let mut size = [900.0, 600.0];
    let mut harness = window(size);
    harness.state_mut().set_export_folder(folder.path());
    // The program draws a box for what no font has; the harness would panic.
    harness.ctx.set_missing_glyph_policy(egui::MissingGlyphPolicy::Tofu);
    let mut random = Random(0x5eed_600d);
    let mut early = None;
    for n in 0..count {
        act(&mut harness, &mut random, &files, &mut size);
        if n % A_FRAME == 0 {
            harness.step();
        }
        if n == count / 10 {
            early = held_mib();
        }
    }
    // Escape ends what runs, one thing at a time; each takes a moment.
    for frame in 0.. {
        if !harness.state().is_busy() {
            break;
        }
        assert!(frame < MANY_FRAMES, "what runs did not end by Escape");
        harness.key_press(Key::Escape);
        harness.step();
        std::thread::sleep(Duration::from_millis(10));
    }
    let reports: Vec<_> = crash::reports(&folder.path().join("crashes"));
    let told: Vec<String> = reports.iter().filter_map(|path| std::fs::read_to_string(path).ok()).collect();
    // Other tests of this program run beside this one, and none of them panics on purpose.
    assert!(told.is_empty(), "{}", told.join("\n\n"));
    if let (Some(early), Some(late)) = (early, held_mib()) {
        eprintln!("{count} things done: {early:.0} MiB after a tenth of them, {late:.0} MiB at the end");
    }
}
