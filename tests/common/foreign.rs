//! Depth nets of other people, exported by `tests/foreign_nets/export.py`.
#![allow(clippy::unwrap_used, reason = "in a test a panic is the failure")]

use std::path::{Path, PathBuf};

use plenoscope::synth::tract::{OnnxFile, Options, Runnable, prepare_file};

/// An exported net.
pub struct Net {
    pub path: PathBuf,
    /// The shape of the input, as the script says.
    pub shape: Vec<usize>,
}

/// All in the folder that `PLENOSCOPE_NETS` names.
pub fn exported() -> Option<Vec<Net>> {
    std::env::var_os("PLENOSCOPE_NETS").map(|folder| Net::all(Path::new(&folder)))
}

impl Net {
    /// All of a folder, from the lists `NAME.shape` beside the nets.
    fn all(folder: &Path) -> Vec<Self> {
        let mut nets: Vec<Self> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.extension().is_some_and(|end| end == "onnx"))
            .map(|path| {
                let text = std::fs::read_to_string(path.with_extension("shape")).unwrap();
                Self { path, shape: text.split_whitespace().map(|n| n.parse().unwrap()).collect() }
            })
            .collect();
        nets.sort_by(|a, b| a.path.cmp(&b.path));
        nets
    }

    /// Its file's name without the ending.
    pub fn name(&self) -> String {
        self.path.file_stem().unwrap().to_string_lossy().into_owned()
    }

    /// The program's engine, made ready for it.
    pub fn runnable(&self) -> Runnable {
        let file = OnnxFile::on_disk(&self.path);
        prepare_file(&file, &self.shape, &Options::default()).unwrap_or_else(|e| panic!("{}: {e}", self.name()))
    }

    /// A smooth picture with edges, −1 … 1, in the order of its shape.
    pub fn picture(&self) -> Vec<f32> {
        let (h, w) = (self.shape[self.shape.len() - 2], self.shape[self.shape.len() - 1]);
        let at = |i: usize| {
            let (x, y, c) = ((i % w) as f32, (i / w % h) as f32, (i / (w * h)) as f32);
            let step = if (x - 0.4 * w as f32).hypot(y - 0.6 * h as f32) < 0.2 * h as f32 { 0.5 } else { -0.1 };
            step + 0.3 * (x * 0.11 + c).sin() + 0.2 * (y * 0.07 - x * 0.013).cos()
        };
        (0..self.shape.iter().product()).map(at).collect()
    }
}
