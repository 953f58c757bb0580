//! The paper's training data: a folder of Lytro ESLF pictures, as batches.
//!
//! A file holds 14 × 14 views, interleaved: view (v, u) at pixel (y, x) is the picture's (14·y + v, 14·x + u). Of
//! these the middle 8 × 8 are used, 3 … 10; the reference view is (4, 4) of them. Crops of 192² are halved to 96².

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use crate::TrainError;
use crate::batch::{Batch, Draw};
use crate::config::Config;
use crate::loss::Maps;
use crate::nets::{SIDE, VIEWS};
use crate::rng::Rng;

/// Views of a file along one axis, and the first that is used.
const FILE_SIDE: usize = 14;
const FIRST: usize = 3;
/// A crop is this many times larger than the sample that it becomes.
const HALVED: usize = 2;
/// Batches in a row that are cut from the same files: decoding 39 million pixels takes longer than a step.
const REUSE: u64 = 8;
/// Range of γ that colours are raised to (the released notebook).
const GAMMA: (f32, f32) = (0.4, 1.0);

/// A decoded file: its 8 × 8 views `[view, y, x, 3]`.
struct Field {
    width: usize,
    height: usize,
    rgb: Vec<u8>,
}

/// Files of a folder, and those decoded last.
struct Folder {
    files: Vec<PathBuf>,
    recent: Mutex<VecDeque<(usize, Arc<Field>)>>,
    keep: usize,
}

/// Batches from the ESLF files in `config.data`, of those named in `config.list` if there is one.
pub fn draw(config: &Config) -> Result<Draw, TrainError> {
    let files = files(&config.data, config.list.as_deref())?;
    let keep = config.batch * (config.loaders + 1);
    let folder = Folder { files, recent: Mutex::new(VecDeque::new()), keep };
    let (batch, seed, crops) = (config.batch, config.seed, config.crop.clone());
    Ok(Arc::new(move |number| {
        let size = crops[(number % crops.len() as u64) as usize];
        folder.batch(number, batch, seed, size)
    }))
}

/// The ESLF files of a folder in order; all, or those that a list names (one a line).
fn files(folder: &Path, list: Option<&Path>) -> Result<Vec<PathBuf>, TrainError> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |source| TrainError::File { action: "read the training files", source, path }
    };
    let mut files: Vec<PathBuf> = match list {
        Some(list) => {
            let text = std::fs::read_to_string(list).map_err(failed(list))?;
            let names = text.lines().map(str::trim).filter(|name| !name.is_empty());
            names.map(|name| folder.join(name)).filter(|path| path.exists()).collect()
        }
        None => {
            let entries = std::fs::read_dir(folder).map_err(failed(folder))?;
            let paths = entries.filter_map(|entry| entry.ok().map(|e| e.path()));
            paths.filter(|path| path.to_string_lossy().ends_with("_eslf.png")).collect()
        }
    };
    files.sort();
    if files.is_empty() {
        let why = format!("no *_eslf.png files to train on; give their folder with --data: {}", folder.display());
        return Err(TrainError::Data { why });
    }
    Ok(files)
}

impl Folder {
    fn batch(
        &self,
        number: u64,
        samples: usize,
        seed: u64,
        (width, height): (usize, usize),
    ) -> Result<Batch, TrainError> {
        let maps = Maps { samples, views: (0..VIEWS).collect(), height, width };
        let mut batch = Batch {
            first_sample: number * samples as u64,
            views: Vec::with_capacity(3 * maps.len()),
            truth: vec![f32::NAN; maps.len()],
            yx: Vec::new(),
            worth: vec![1.0; samples],
            subjects: vec![Vec::new(); samples],
            maps,
        };
        for slot in 0..samples {
            let mut choice = Rng::new(seed, number / REUSE * samples as u64 + slot as u64);
            let field = self.field(choice.below(self.files.len()))?;
            let mut rng = Rng::new(seed ^ 0xe51f, batch.first_sample + slot as u64);
            let yx = field.cut(&mut rng, [width, height], &mut batch.views)?;
            batch.yx.push(yx);
        }
        Ok(batch)
    }

    fn field(&self, index: usize) -> Result<Arc<Field>, TrainError> {
        let locked = || self.recent.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some((_, field)) = locked().iter().find(|(i, _)| *i == index) {
            return Ok(field.clone());
        }
        let field = Arc::new(Field::open(&self.files[index])?);
        let mut recent = locked();
        recent.push_back((index, field.clone()));
        while recent.len() > self.keep {
            recent.pop_front();
        }
        Ok(field)
    }
}

impl Field {
    fn open(path: &Path) -> Result<Self, TrainError> {
        let wrong = |why: String| TrainError::Data { why: format!("{why}: {}", path.display()) };
        let mut reader = image::ImageReader::open(path).map_err(|source| TrainError::File {
            action: "read the light field",
            source,
            path: path.to_owned(),
        })?;
        reader.no_limits();
        let picture = reader.decode().map_err(|e| wrong(format!("not a picture: {e}")))?.to_rgb8();
        let (wide, high) = (picture.width() as usize, picture.height() as usize);
        if !wide.is_multiple_of(FILE_SIDE) || !high.is_multiple_of(FILE_SIDE) {
            return Err(wrong(format!("{wide}×{high} is no ESLF picture; expected multiples of {FILE_SIDE}")));
        }
        let (width, height) = (wide / FILE_SIDE, high / FILE_SIDE);
        let mut rgb = Vec::with_capacity(VIEWS * width * height * 3);
        let raw = picture.as_raw();
        for view in 0..VIEWS {
            let (v, u) = (FIRST + view / SIDE, FIRST + view % SIDE);
            for y in 0..height {
                let row = &raw[(y * FILE_SIDE + v) * wide * 3..][..wide * 3];
                (0..width).for_each(|x| rgb.extend(&row[(x * FILE_SIDE + u) * 3..][..3]));
            }
        }
        Ok(Self { width, height, rgb })
    }

    /// Appends a random crop of all views `[v, 3, y, x]`, halved and raised to a random γ; says where it lay.
    fn cut(&self, rng: &mut Rng, [width, height]: [usize; 2], out: &mut Vec<f32>) -> Result<[f32; 4], TrainError> {
        let (w, h) = (width * HALVED, height * HALVED);
        if w > self.width || h > self.height {
            let why =
                format!("crops of {w}×{h} do not fit light fields of {}×{}; lower --crop", self.width, self.height);
            return Err(TrainError::Data { why });
        }
        let (left, top) = (rng.below(self.width - w + 1), rng.below(self.height - h + 1));
        let gamma = rng.range(GAMMA.0, GAMMA.1);
        let table: Vec<f32> = (0..=255 * 4).map(|i| (i as f32 / 1020.0).powf(gamma)).collect();
        for view in 0..VIEWS {
            let at = |x: usize, y: usize, c: usize| {
                usize::from(self.rgb[((view * self.height + y) * self.width + x) * 3 + c])
            };
            for c in 0..3 {
                for y in (top..top + h).step_by(HALVED) {
                    for x in (left..left + w).step_by(HALVED) {
                        out.push(table[at(x, y, c) + at(x + 1, y, c) + at(x, y + 1, c) + at(x + 1, y + 1, c)]);
                    }
                }
            }
        }
        let along = |at: usize, n: usize| 2.0 * at as f32 / (n - 1) as f32 - 1.0;
        Ok([
            along(top, self.height),
            along(top + h - 1, self.height),
            along(left, self.width),
            along(left + w - 1, self.width),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file whose red says v, green says u, blue says x.
    fn write(folder: &Path) {
        let picture = image::RgbImage::from_fn(14 * 40, 14 * 36, |x, y| {
            image::Rgb([(y % 14 * 10) as u8, (x % 14 * 10) as u8, (x / 14) as u8])
        });
        picture.save(folder.join("IMG_1_eslf.png")).unwrap();
    }

    #[test]
    fn a_batch_has_the_middle_views_in_order() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path());
        let config = Config { data: folder.path().to_owned(), batch: 2, crop: vec![(16, 16)], ..Config::default() };
        let draw = draw(&config).unwrap();
        let batch = draw(3).unwrap();
        assert_eq!(batch.maps.views.len(), 64);
        // The power is the same for all: the order of the views' red and green is that of v and u.
        let level = |view: usize, c: usize| batch.views[(view * 3 + c) * 256];
        assert!(level(36, 0) > level(0, 0) && level(36, 1) > level(0, 1));
        assert!(level(1, 1) > level(0, 1) && level(1, 0) == level(0, 0));
        let again = draw(3).unwrap();
        assert_eq!((again.views, again.yx), (batch.views, batch.yx));
        assert!(again.truth.iter().all(|truth| truth.is_nan()), "no truth is known of a photographed light field");
    }

    #[test]
    fn an_empty_folder_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let config = Config { data: folder.path().to_owned(), ..Config::default() };
        assert!(draw(&config).err().unwrap().to_string().contains("_eslf.png"));
    }
}
