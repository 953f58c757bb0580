//! The paper's training data: a folder of light fields, as batches.
//!
//! Lytro's ESLF pictures hold 14 × 14 views, interleaved: view (v, u) at pixel (y, x) is the picture's (14·y + v, 14·x + u). Of
//! these the middle 8 × 8 are used, 3 … 10; the reference view is (4, 4) of them. Of any other format that the library
//! opens, the 8 × 8 views around the reference view. Crops of 192² are halved to 96².

pub mod packed;
pub mod stats;

use std::collections::{BTreeSet, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use plenoscope::io::formats::eslf;

use crate::TrainError;
use crate::batch::{Batch, Draw};
use crate::config::Config;
use crate::field::TrueField;
use crate::loss::Maps;
use crate::nets::{REFERENCE, SIDE, VIEWS};
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

/// Ends of the names of files that hold a light field; folders may hold one, too.
pub const ENDINGS: [&str; 3] = ["_eslf.png", ".lfp", packed::ENDING];

/// A decoded light field: its 8 × 8 views `[view, y, x, 3]`.
struct Field {
    width: usize,
    height: usize,
    rgb: Vec<u8>,
    /// As the sensor saw it, without a display's curve.
    raw: bool,
}

/// Told of each light field that cannot be read and is passed over.
pub type Note = Arc<dyn Fn(&str) + Send + Sync>;

/// Notes that go to the terminal.
pub fn told() -> Note {
    Arc::new(|text| eprintln!("{text}"))
}

/// Light fields of a folder, those decoded last, and those that cannot be read.
struct Folder {
    files: Vec<PathBuf>,
    recent: Mutex<VecDeque<(usize, Arc<Field>)>>,
    broken: Mutex<BTreeSet<usize>>,
    keep: usize,
    note: Note,
}

/// Batches from the light fields in `config.data`, of those named in `config.list` if there is one.
pub fn draw(config: &Config, note: Note) -> Result<Draw, TrainError> {
    let files = match &config.list {
        Some(list) => named(&config.data, list)?,
        None => found(&config.data)?,
    };
    of_files(files, config, note)
}

/// Batches from these light fields.
pub fn of_files(files: Vec<PathBuf>, config: &Config, note: Note) -> Result<Draw, TrainError> {
    if files.is_empty() {
        return Err(none_in(&config.data));
    }
    let keep = config.batch * (config.loaders + 1);
    let folder = Folder { files, recent: Mutex::default(), broken: Mutex::default(), keep, note };
    let (batch, seed, crops) = (config.batch, config.seed, config.crop.clone());
    Ok(Arc::new(move |number| {
        let size = crops[(number % crops.len() as u64) as usize];
        folder.batch(number, batch, seed, size)
    }))
}

fn none_in(folder: &Path) -> TrainError {
    let why = "no light fields (*_eslf.png, *.lfp, folders of views) to train on; give their folder with --data";
    TrainError::Data { why: format!("{why}: {}", folder.display()) }
}

fn failed(path: &Path) -> impl FnOnce(std::io::Error) -> TrainError {
    let path = path.to_owned();
    move |source| TrainError::File { action: "read the training files", source, path }
}

/// What may be light fields in a folder, in order: whether they are is seen when they are opened.
pub fn found(folder: &Path) -> Result<Vec<PathBuf>, TrainError> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed(folder))? {
        let path = entry.map_err(failed(folder))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        if !name.starts_with('.') && (path.is_dir() || ENDINGS.iter().any(|ending| name.ends_with(ending))) {
            files.push(path);
        }
    }
    files.sort();
    if files.is_empty() { Err(none_in(folder)) } else { Ok(files) }
}

/// The light fields of a folder that a list names, one a line, and that are there.
pub fn named(folder: &Path, list: &Path) -> Result<Vec<PathBuf>, TrainError> {
    let text = std::fs::read_to_string(list).map_err(failed(list))?;
    let names = text.lines().map(str::trim).filter(|name| !name.is_empty());
    let mut files: Vec<PathBuf> = names.map(|name| folder.join(name)).filter(|path| path.exists()).collect();
    files.sort();
    if files.is_empty() { Err(none_in(folder)) } else { Ok(files) }
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

    /// The light field of a number; where it cannot be read, the next that can.
    fn field(&self, index: usize) -> Result<Arc<Field>, TrainError> {
        let mut why = None;
        for index in (0..self.files.len()).map(|i| (index + i) % self.files.len()) {
            if self.broken.lock().unwrap_or_else(PoisonError::into_inner).contains(&index) {
                continue;
            }
            match self.decoded(index) {
                Ok(field) => return Ok(field),
                Err(error) => {
                    if self.broken.lock().unwrap_or_else(PoisonError::into_inner).insert(index) {
                        (self.note)(&format!("passed over: {error}"));
                    }
                    why = Some(error);
                }
            }
        }
        let none = || TrainError::Data { why: "none of the light fields can be read".into() };
        Err(why.unwrap_or_else(none))
    }

    fn decoded(&self, index: usize) -> Result<Arc<Field>, TrainError> {
        let locked = || self.recent.lock().unwrap_or_else(PoisonError::into_inner);
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
        match path.to_string_lossy() {
            name if name.ends_with(ENDINGS[0]) => Self::of_eslf(path),
            name if name.ends_with(packed::ENDING) => packed::open(path),
            _ => Self::of_views(path),
        }
    }

    /// Of any format that the library opens.
    fn of_views(path: &Path) -> Result<Self, TrainError> {
        let field = TrueField::open(path).map_err(|e| TrainError::Data { why: e.to_string() })?;
        let [width, height] = field.size;
        let byte = |c: &f32| (c * 255.0 + 0.5) as u8;
        let rgb = field.views.iter().flat_map(|view| view.px.as_flattened()).map(byte).collect();
        Ok(Self { width, height, rgb, raw: false })
    }

    fn of_eslf(path: &Path) -> Result<Self, TrainError> {
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
        Ok(Self::of_lenslets(width, height, rgb))
    }

    /// Views of a lenslet picture. It has the sensor's colours, or those of a display: the library's rule says which.
    fn of_lenslets(width: usize, height: usize, rgb: Vec<u8>) -> Self {
        let reference = &rgb[REFERENCE * width * height * 3..][..width * height * 3];
        let raw = eslf::is_raw(reference.chunks_exact(3).map(|px| px[1]));
        Self { width, height, rgb, raw }
    }

    /// Appends a random crop of all views `[v, 3, y, x]`, halved where the views are large enough, raw ones raised to a
    /// random γ; says where it lay.
    fn cut(&self, rng: &mut Rng, [width, height]: [usize; 2], out: &mut Vec<f32>) -> Result<[f32; 4], TrainError> {
        let fits = |part: usize| width * part <= self.width && height * part <= self.height;
        let Some(part) = [HALVED, 1].into_iter().find(|part| fits(*part)) else {
            let size = format!("{width}×{height} do not fit light fields of {}×{}", self.width, self.height);
            return Err(TrainError::Data { why: format!("crops of {size}; lower --crop") });
        };
        let (w, h) = (width * part, height * part);
        let (left, top) = (rng.below(self.width - w + 1), rng.below(self.height - h + 1));
        let gamma = if self.raw { rng.range(GAMMA.0, GAMMA.1) } else { 1.0 };
        let table: Vec<f32> = (0..=255 * 4).map(|i| (i as f32 / 1020.0).powf(gamma)).collect();
        for view in 0..VIEWS {
            let at = |x: usize, y: usize, c: usize| {
                usize::from(self.rgb[((view * self.height + y) * self.width + x) * 3 + c])
            };
            for c in 0..3 {
                for y in (top..top + h).step_by(part) {
                    for x in (left..left + w).step_by(part) {
                        let (right, below) = (x + part - 1, y + part - 1);
                        out.push(table[at(x, y, c) + at(right, y, c) + at(x, below, c) + at(right, below, c)]);
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
pub(crate) mod tests {
    use super::*;
    use crate::field::light_field;
    use crate::scenes::raster::Raster;
    use crate::scenes::steps;

    /// Writes the views of a textured plane of one disparity as a folder.
    pub(crate) fn write_plane(folder: &Path, disparity_px: f32) {
        let texture = |x: f32, y: f32| [0.5 + 0.3 * (0.9 * x).sin(), 0.5 + 0.3 * (0.7 * y + 0.4 * x).cos(), 0.3];
        let view = |layer| {
            let (du, dv) = steps(layer);
            let texel = |x, y| texture(x as f32 + du * disparity_px, y as f32 + dv * disparity_px);
            Raster::from_fn([48, 36], texel)
        };
        let field = light_field(&(0..VIEWS).map(view).collect::<Vec<_>>()).unwrap();
        let cancel = plenoscope::job::Cancel::default();
        let job = plenoscope::job::Job { cancel: &cancel, sink: &() };
        plenoscope::io::formats::views::write(folder, &plenoscope::io::formats::FieldToWrite::new(&field), &job)
            .unwrap();
    }

    /// A file as dark as a sensor's, whose red says v, green says u, blue says x.
    pub(crate) fn write_eslf(folder: &Path) {
        write_eslf_of(folder, 8);
    }

    /// The same, each view so much brighter than the one before.
    fn write_eslf_of(folder: &Path, step: u32) {
        let picture = image::RgbImage::from_fn(14 * 40, 14 * 36, |x, y| {
            image::Rgb([(y % 14 * step) as u8, (x % 14 * step) as u8, (x / 14) as u8])
        });
        picture.save(folder.join("IMG_1_eslf.png")).unwrap();
    }

    #[test]
    fn a_batch_has_the_middle_views_in_order() {
        let folder = tempfile::tempdir().unwrap();
        write_eslf(folder.path());
        let config = Config { data: folder.path().to_owned(), batch: 2, crop: vec![(16, 16)], ..Config::default() };
        let draw = draw(&config, Arc::new(|_| ())).unwrap();
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
    fn only_colours_of_a_sensor_are_raised() {
        for (step, raised) in [(8, true), (18, false)] {
            let folder = tempfile::tempdir().unwrap();
            write_eslf_of(folder.path(), step);
            let config = Config { data: folder.path().to_owned(), batch: 1, crop: vec![(16, 16)], ..Config::default() };
            let batch = draw(&config, Arc::new(|_| ())).unwrap()(0).unwrap();
            let red = (FIRST as u32 * step) as f32 / 255.0;
            assert_eq!((batch.views[0] - red).abs() > 1e-6, raised, "{} for {red}", batch.views[0]);
        }
    }

    #[test]
    fn a_light_field_that_cannot_be_read_is_told_once_and_passed_over() {
        let folder = tempfile::tempdir().unwrap();
        write_eslf(folder.path());
        std::fs::write(folder.path().join("IMG_0_eslf.png"), b"no picture").unwrap();
        std::fs::create_dir(folder.path().join("notes")).unwrap();
        let config = Config { data: folder.path().to_owned(), batch: 2, crop: vec![(16, 16)], ..Config::default() };
        let told = Arc::new(Mutex::new(Vec::new()));
        let notes = told.clone();
        let draw = draw(&config, Arc::new(move |text| notes.lock().unwrap().push(text.to_owned()))).unwrap();
        for number in 0..40 {
            assert_eq!(draw(number).unwrap().maps.samples, 2);
        }
        let told = told.lock().unwrap();
        assert_eq!(told.len(), 2, "{told:?}");
        assert!(told.iter().all(|text| text.starts_with("passed over") && !text.contains('\n')), "{told:?}");
    }

    #[test]
    fn crops_that_only_fit_whole_are_not_halved() {
        let folder = tempfile::tempdir().unwrap();
        write_eslf(folder.path());
        let config = Config { data: folder.path().to_owned(), batch: 1, crop: vec![(36, 32)], ..Config::default() };
        let batch = draw(&config, Arc::new(|_| ())).unwrap()(0).unwrap();
        assert!(batch.views[0] == batch.views[35] && batch.views[72 * 32] < batch.views[72 * 32 + 35]);
        let config = Config { crop: vec![(64, 64)], ..config };
        let text = draw(&config, Arc::new(|_| ())).unwrap()(0).unwrap_err().to_string();
        assert!(text.contains("--crop"), "{text}");
    }

    #[test]
    fn an_empty_folder_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let config = Config { data: folder.path().to_owned(), ..Config::default() };
        assert!(draw(&config, Arc::new(|_| ())).err().unwrap().to_string().contains("_eslf.png"));
    }
}
