//! The real window, once, on a virtual display: it comes up, shows something, and closes when asked.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::Scratch;
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{AtomEnum, ClientMessageEvent, ConnectionExt, EventMask, ImageFormat, Window};
use x11rb::rust_connection::RustConnection;

/// How long a software rasteriser on a busy machine may take to show the window.
const PATIENCE: Duration = Duration::from_secs(120);

#[test]
fn the_window_opens_a_photo_and_closes() {
    let Some(display) = Display::start() else {
        eprintln!("SKIPPED: no Xvfb on this machine, so the real window is not tried");
        return;
    };
    let dir = Scratch::new();
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("plenoscope"));
    command.arg(dir.photo("photo.png", 320, 240)).env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY");
    command.env("XDG_CONFIG_HOME", dir.path("config")).env("XDG_CACHE_HOME", dir.path("cache"));
    command.env("XDG_DATA_HOME", dir.path("data")).stderr(Stdio::piped());
    let mut program = Running(command.spawn().unwrap());

    let (x, screen) = RustConnection::connect(Some(&display.name)).unwrap();
    let root = x.setup().roots[screen].root;
    let window = program.until("a window named Plenoscope", || find(&x, root, "Plenoscope"));
    program.until("a picture in it", || (colours(&x, window) > 200).then_some(()));
    close(&x, window);
    let said = program.finish();
    assert!(!said.contains("panicked"), "{said}");
}

#[test]
#[cfg(target_os = "linux")]
fn without_a_display_the_window_is_one_sentence() {
    let dir = Scratch::new();
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("plenoscope"));
    for name in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(name);
    }
    let output =
        command.env("XDG_CONFIG_HOME", dir.path("config")).env("XDG_DATA_HOME", dir.path("data")).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.lines().count() == 1 && said.contains("there is no display"), "{said}");
}

/// A virtual display that goes away with the test.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    fn start() -> Option<Self> {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1440x900x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut number = String::new();
        BufReader::new(server.stdout.take()?).read_line(&mut number).ok()?;
        Some(Self { server, name: format!(":{}", number.trim()) })
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        self.server.kill().ok();
        self.server.wait().ok();
    }
}

/// The program while it runs.
struct Running(Child);

impl Running {
    /// Waits for something; fails with what the program said when it ends or takes too long.
    fn until<T>(&mut self, what: &str, mut look: impl FnMut() -> Option<T>) -> T {
        let started = Instant::now();
        loop {
            if let Some(found) = look() {
                return found;
            }
            let ended = self.0.try_wait().unwrap().is_some();
            assert!(!ended, "the program ended while waiting for {what}: {}", self.said());
            assert!(started.elapsed() < PATIENCE, "no {what} after {PATIENCE:?}");
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    fn ended(&mut self) -> std::process::ExitStatus {
        let started = Instant::now();
        loop {
            if let Some(status) = self.0.try_wait().unwrap() {
                return status;
            }
            assert!(started.elapsed() < PATIENCE, "it does not close");
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    fn said(&mut self) -> String {
        let mut text = String::new();
        if let Some(mut stderr) = self.0.stderr.take() {
            std::io::Read::read_to_string(&mut stderr, &mut text).ok();
        }
        text
    }

    /// Waits for its end, which must be a good one, and returns what it said.
    fn finish(mut self) -> String {
        let status = self.ended();
        let said = self.said();
        assert!(status.success(), "{status}: {said}");
        said
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

/// A window by the beginning of its name.
fn find(x: &RustConnection, below: Window, name: &str) -> Option<Window> {
    for child in x.query_tree(below).ok()?.reply().ok()?.children {
        let title = x.get_property(false, child, AtomEnum::WM_NAME, AtomEnum::ANY, 0, 256).ok()?.reply().ok()?;
        if String::from_utf8_lossy(&title.value).contains(name) {
            return Some(child);
        }
        if let Some(found) = find(x, child, name) {
            return Some(found);
        }
    }
    None
}

/// Different colours among the window's pixels; 0 while it has none.
fn colours(x: &RustConnection, window: Window) -> usize {
    let image = || {
        let size = x.get_geometry(window).ok()?.reply().ok()?;
        x.get_image(ImageFormat::Z_PIXMAP, window, 0, 0, size.width, size.height, !0).ok()?.reply().ok()
    };
    let Some(image) = image() else { return 0 };
    image
        .data
        .chunks_exact(4)
        .map(|pixel| [pixel[0], pixel[1], pixel[2]])
        .collect::<std::collections::BTreeSet<_>>()
        .len()
}

/// Asks a window to close, as its frame's button does.
fn close(x: &RustConnection, window: Window) {
    let atom = |name: &str| x.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom;
    let message = ClientMessageEvent::new(32, window, atom("WM_PROTOCOLS"), [atom("WM_DELETE_WINDOW"), 0, 0, 0, 0]);
    x.send_event(false, window, EventMask::NO_EVENT, message).unwrap();
    x.flush().unwrap();
}
