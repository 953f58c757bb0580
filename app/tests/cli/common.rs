//! Shared by the tests of the program: the program itself, a scratch folder, small photos, other people's data.

use std::fs::File;
use std::path::PathBuf;

use assert_cmd::Command;
use plenoscope::io::formats::pfm::write_pfm;

/// The program with arguments, away from the settings and caches of whoever runs the tests.
pub fn plenoscope(args: &[&str]) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("plenoscope"));
    let aside = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    command.env("XDG_CACHE_HOME", aside.join("cache")).env("XDG_CONFIG_HOME", aside.join("config"));
    command.env_remove("RUST_LOG").args(args);
    command
}

/// A folder that goes away with the test.
pub struct Scratch(tempfile::TempDir);

impl Scratch {
    /// A new, empty one.
    pub fn new() -> Self {
        Self(tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap())
    }

    /// The path of a file in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The same as an argument.
    pub fn arg(&self, name: &str) -> String {
        self.path(name).to_string_lossy().into_owned()
    }

    /// Writes a small photo with a gradient and a bright square, and says where it is.
    pub fn photo(&self, name: &str, width: u32, height: u32) -> String {
        let picture = image::RgbImage::from_fn(width, height, |x, y| {
            let bright = x > width / 3 && x < width / 2 && y > height / 3 && y < height / 2;
            let ramp = |at: u32, end: u32| (at * 200 / end.max(1)) as u8;
            image::Rgb(if bright { [250, 240, 60] } else { [ramp(x, width), ramp(y, height), 90] })
        });
        picture.save(self.path(name)).unwrap();
        self.arg(name)
    }

    /// Writes a map that is the same in all rows, and says where it is.
    pub fn map(&self, name: &str, [width, height]: [u32; 2], of: impl Fn(u32) -> f32) -> String {
        let values: Vec<f32> = (0..width * height).map(|at| of(at % width)).collect();
        write_pfm(&mut File::create(self.path(name)).unwrap(), [width, height], &values).unwrap();
        self.arg(name)
    }
}

/// The folder of photos and light fields that are not ours to publish; says so and is `None` where there is none.
pub fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("PLENOSCOPE_DATA").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("SKIPPED: PLENOSCOPE_DATA does not name the data folder");
    }
    folder
}
