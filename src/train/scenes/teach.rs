//! `plenoscope-train teach`: nearness maps of photos as our own nets see them, for the next net to learn from.
//!
//! A net that knows more than the teacher of its maps takes the teacher's place (self-training). A map is the mean over
//! nets, and over the photo and its mirror image, with edges brought to the photo's; how far these agree is its gate.
//! Measured depth and good maps of rooms stay what they are.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context as _, Result, bail, ensure};
use clap::{ArgMatches, Command, arg, value_parser};
use plenoscope::field::{Filter, Photo, fit_long_side, resample};
use plenoscope::job::{Cancel, Job};
use plenoscope::synth::{ModelSource, SynthParams, Synthesizer};
use serde_json::json;

use super::library::{byte_from_nearness, read_gray, read_rgb};
use super::manifest::{self, Entry};
use super::raster::{Raster, Rgb};
use super::{SceneError, Split};
use crate::config::parse_part;
use crate::eval::metrics::spearman;
use crate::eval::sheet::usual_range;
use crate::files;

/// Long side of a map, pixels: more than any net works at here.
const LONG_SIDE: u32 = 192;
/// Least rank correlation of any one map with their mean, of a map that is good and of one that is fair.
const GOOD: f32 = 0.9;
const FAIR: f32 = 0.8;
/// Photos after which it is said how far it is.
const TOLD: usize = 250;

/// What the command line understands.
pub fn command() -> Command {
    Command::new("teach")
        .about("Write nearness maps of photos as nets see them, for `train --maps`")
        .arg(
            arg!(--data <DIR> "Folder of flowers/, everyday/, everyday10k/ …")
                .value_parser(value_parser!(PathBuf))
                .required(true),
        )
        .arg(
            arg!(--out <DIR> "Folder for the maps; what lies there is kept")
                .value_parser(value_parser!(PathBuf))
                .required(true),
        )
        .arg(
            arg!(--models <DIR> ... "Folders laid out like models/; the maps are the mean over their depth nets")
                .value_parser(value_parser!(PathBuf))
                .required(true),
        )
        .arg(
            arg!(--share <PART> "How much of a map is theirs; the rest is that of the teacher, where there is one")
                .default_value("1")
                .value_parser(parse_part),
        )
        .arg(arg!(--threads <N> "Threads; 0 means all").default_value("0").value_parser(value_parser!(usize)))
}

/// Writes the maps; gives what is to be printed.
///
/// # Errors
/// No photos, no nets, or a disk that cannot be written.
pub fn run(matches: &ArgMatches, stop: &AtomicBool, told: &dyn Fn(&str)) -> Result<String> {
    let path = |name: &str| matches.get_one::<PathBuf>(name).cloned().unwrap_or_default();
    let folders = matches.get_many::<PathBuf>("models").into_iter().flatten();
    let nets = folders.map(|folder| Synthesizer::load(&ModelSource::Folder(folder.clone())));
    let teachers = Teachers {
        nets: nets.collect::<Result<_, _>>()?,
        share: matches.get_one("share").copied().unwrap_or(1.0),
        threads: matches.get_one("threads").copied().unwrap_or(0),
    };
    let mut counts = [0; 3];
    for folder in TAUGHT {
        let (pupils, notes) = pupils(&path("data").join(folder));
        notes.iter().for_each(|note| told(note));
        let taught = teachers.folder(&pupils, &path("out").join(folder), stop, told)?;
        counts = [0, 1, 2].map(|i| counts[i] + taught[i]);
    }
    ensure!(counts.iter().sum::<usize>() > 0, "no photos that lack maps: {}", path("data").display());
    let [good, fair, doubtful] = counts;
    Ok(format!("{good} good, {fair} fair, {doubtful} doubtful maps in {}\n", path("out").display()))
}

struct Teachers {
    nets: Vec<Synthesizer>,
    share: f32,
    threads: usize,
}

impl Teachers {
    /// Maps of a folder's photos with its manifest; how many are good, fair and doubtful.
    fn folder(&self, pupils: &[Pupil], out: &Path, stop: &AtomicBool, told: &dyn Fn(&str)) -> Result<[usize; 3]> {
        std::fs::create_dir_all(out).with_context(|| format!("cannot make the folder of maps: {}", out.display()))?;
        let path = out.join("manifest.jsonl");
        let mut lines = std::fs::read_to_string(&path).unwrap_or_default();
        let before: HashSet<String> = manifest::read(out, &mut Vec::new()).into_iter().map(|entry| entry.id).collect();
        let mut counts = [0; 3];
        for (i, pupil) in pupils.iter().enumerate().filter(|(_, pupil)| !before.contains(&pupil.entry.id)) {
            if stop.load(Ordering::Relaxed) {
                files::write(&path, lines.as_bytes(), "write the manifest of the maps")?;
                bail!("stopped; what was made is kept, and the same command goes on: {}", out.display());
            }
            let (map, agreement) = match self.map(pupil) {
                Ok(made) => made,
                Err(error) => {
                    told(&format!("left out: {error:#}"));
                    continue;
                }
            };
            let gate = if agreement >= GOOD { 0 } else { usize::from(agreement < FAIR) + 1 };
            counts[gate] += 1;
            let file = out.join(format!("{}.nearness.png", pupil.entry.id));
            files::write(&file, &png(&map)?, "write a map")?;
            let gate = ["self", "soft", "doubtful"][gate];
            lines +=
                &format!("{}\n", json!({"id": pupil.entry.id, "label": "own", "gate": gate, "agreement": agreement}));
            if i % TOLD == TOLD - 1 {
                files::write(&path, lines.as_bytes(), "write the manifest of the maps")?;
                told(&format!("{} of {} maps in {}", i + 1, pupils.len(), out.display()));
            }
        }
        files::write(&path, lines.as_bytes(), "write the manifest of the maps")?;
        Ok(counts)
    }

    /// The map of a photo in the photo's shape, and the least agreement of one of those that it is the mean of.
    fn map(&self, pupil: &Pupil) -> Result<(Raster<f32>, f32)> {
        let (photo, shape) = pupil.photo()?;
        let mut all = Vec::new();
        for net in &self.nets {
            for is_mirrored in [false, true] {
                let seen = if is_mirrored { mirrored(&photo) } else { photo.clone() };
                let map = self.seen(net, &seen)?;
                all.push(unit(if is_mirrored { mirrored(&map) } else { map }));
            }
        }
        let mut mean = average(&all);
        let agreement = all.iter().map(|map| spearman(&map.px, &mean.px)).fold(1.0, f32::min);
        if let Some(teacher) = pupil.nearness(photo.size)? {
            let (own, other) = (unit(mean), unit(teacher));
            let px = own.px.iter().zip(&other.px).map(|(own, other)| other + (own - other) * self.share).collect();
            mean = Raster { size: own.size, px };
        }
        let (from, to) = (photo.size.map(|side| side as u32), shape.map(|side| side as u32));
        Ok((Raster { size: shape, px: resample::<1>(&unit(mean).px, from, to, Filter::Linear) }, agreement))
    }

    /// Disparity as a net sees it, which nearness is linear in.
    fn seen(&self, net: &Synthesizer, photo: &Rgb) -> Result<Raster<f32>> {
        let size = photo.size.map(|side| side as u32);
        let params = SynthParams { long_side: u32::MAX, threads: self.threads, ..SynthParams::default() };
        let cancel = Cancel::default();
        let photo = Photo::from_srgb8(size, photo.rgba8())?;
        let (map, _) = net.depth_map(&photo, &params, None, &Job { cancel: &cancel, sink: &() })?;
        Ok(Raster { size: map.size().map(|side| side as usize), px: map.disparity_px().to_vec() })
    }
}

/// Folders whose maps another net made, so that one of ours may take its place, and flowers, most of which have none.
const TAUGHT: [&str; 3] = ["everyday", "everyday10k", "flowers"];

/// A photo to train on whose map a net of ours may make.
struct Pupil {
    /// Name in its folder.
    entry: Entry,
    folder: PathBuf,
}

impl Pupil {
    fn file(&self, ending: &str) -> PathBuf {
        self.folder.join(format!("{}.{ending}", self.entry.id))
    }

    /// The photo without the stretch that it was stored with, in 0 … 1; and the size of a map in its file's shape.
    fn photo(&self) -> Result<(Rgb, [usize; 2]), SceneError> {
        let photo = read_rgb("photo", &self.file("jpg"))?;
        let fitted =
            |shape: [usize; 2]| fit_long_side(shape.map(|side| side as u32), LONG_SIDE).map(|side| side as usize);
        let seen = photo.resized(fitted(self.entry.unsqueezed(photo.size)));
        Ok((seen.map(|rgb| rgb.map(|value| value / 255.0)), fitted(photo.size)))
    }

    /// The map beside it, at this size; none where that is doubtful.
    fn nearness(&self, size: [usize; 2]) -> Result<Option<Raster<f32>>, SceneError> {
        let path = self.entry.has_map().then(|| self.file("nearness.png")).filter(|path| path.exists());
        let map = path.map(|path| read_gray("nearness map", &path)).transpose()?;
        Ok(map.map(|map| map.resized(size).map(|texel| texel[0])))
    }
}

/// The photos of a folder to train on whose maps neither were measured nor are better than ours; and a sentence for each
/// line that is none.
fn pupils(folder: &Path) -> (Vec<Pupil>, Vec<String>) {
    let mut notes = Vec::new();
    let is_pupil = |entry: &Entry| {
        entry.split() == Split::Train && !entry.is_measured() && entry.label.as_deref() != Some("teacher-rooms")
    };
    let entries = manifest::read(folder, &mut notes).into_iter().filter(is_pupil);
    (entries.map(|entry| Pupil { entry, folder: folder.to_owned() }).collect(), notes)
}

fn average(maps: &[Raster<f32>]) -> Raster<f32> {
    let n = maps.len() as f32;
    let px = (0..maps[0].px.len()).map(|i| maps.iter().map(|map| map.px[i]).sum::<f32>() / n).collect();
    Raster { size: maps[0].size, px }
}

/// The usual range brought to 0 … 1.
fn unit(map: Raster<f32>) -> Raster<f32> {
    let [lo, hi] = usual_range(&map.px);
    Raster { size: map.size, px: map.px.iter().map(|value| (value - lo) / (hi - lo).max(1e-6)).collect() }
}

fn mirrored<T: Copy + Send + Sync>(map: &Raster<T>) -> Raster<T> {
    let [w, h] = map.size;
    Raster { size: map.size, px: (0..w * h).map(|i| map.px[i / w * w + w - 1 - i % w]).collect() }
}

fn png(map: &Raster<f32>) -> Result<Vec<u8>> {
    let [w, h] = map.size.map(|side| side as u32);
    let bytes = map.px.iter().map(|value| byte_from_nearness(*value)).collect();
    let picture = image::GrayImage::from_raw(w, h, bytes).context("a map has the length of its size")?;
    let mut png = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut png, image::ImageFormat::Png)?;
    Ok(png.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::{Config, Library};

    /// Photos of slopes with a map that is nearer to the right, of which one was measured and one is doubtful.
    fn data() -> tempfile::TempDir {
        let data = tempfile::tempdir().unwrap();
        let folder = data.path().join("everyday");
        std::fs::create_dir_all(&folder).unwrap();
        let lines = [
            r#"{"id":"wide","label":"teacher","gate":"soft","split":"train","squeezed":true}"#,
            r#"{"id":"doubt","label":"teacher","gate":"doubtful","split":"train"}"#,
            r#"{"id":"sensed","label":"sensor","split":"train"}"#,
            r#"{"id":"inside","label":"teacher-rooms","gate":"self","split":"train"}"#,
            r#"{"id":"hidden","label":"teacher","gate":"self","split":"val"}"#,
        ];
        std::fs::write(folder.join("manifest.jsonl"), lines.join("\n")).unwrap();
        for id in ["wide", "doubt", "sensed", "inside", "hidden"] {
            let photo = image::RgbImage::from_fn(48, 40, |x, y| image::Rgb([4 * x as u8, 5 * y as u8, 90]));
            photo.save(folder.join(format!("{id}.jpg"))).unwrap();
            let map = image::GrayImage::from_fn(48, 40, |x, _| image::Luma([4 * x as u8 + 30]));
            map.save(folder.join(format!("{id}.nearness.png"))).unwrap();
        }
        data
    }

    fn taught(data: &Path, share: &str) -> Result<String> {
        let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
        let (data, out, models) = (data.to_string_lossy(), data.join("maps"), models.to_string_lossy());
        let line =
            ["teach", "--data", &*data, "--out", &*out.to_string_lossy(), "--models", &*models, "--share", share];
        run(&command().get_matches_from(line), &AtomicBool::new(false), &|_| ())
    }

    fn library(data: &Path) -> Library {
        let maps = Some(data.join("maps"));
        Library::load(&Config { data: data.to_owned(), maps, long_side: 40, ..Config::default() }).unwrap()
    }

    #[test]
    fn maps_take_the_place_of_those_that_were_not_measured() {
        let data = data();
        let text = taught(data.path(), "1").unwrap();
        let names: Vec<String> = std::fs::read_dir(data.path().join("maps/everyday"))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        assert_eq!(names.len(), 3, "{names:?}: two maps and the manifest; {text}");
        let (before, after) =
            (Config { data: data.path().to_owned(), long_side: 40, ..Config::default() }, library(data.path()));
        let before = Library::load(&before).unwrap();
        let map = |library: &Library, id: &str| {
            library.pictures.iter().find(|p| p.id.ends_with(id)).unwrap().nearness.clone()
        };
        for id in ["sensed", "inside"] {
            assert_eq!(map(&before, id), map(&after, id), "{id}");
        }
        assert_ne!(map(&before, "wide"), map(&after, "wide"));
        // What is there is kept, and nothing is left to do.
        assert!(taught(data.path(), "1").unwrap_err().to_string().contains("no photos that lack maps"));
    }

    #[test]
    fn flowers_that_have_no_map_get_one() {
        let data = tempfile::tempdir().unwrap();
        let folder = data.path().join("flowers");
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("manifest.jsonl"), r#"{"id":"rose","split":"train"}"#).unwrap();
        // As its own mirror image, of whose map no net has doubts.
        let photo = image::RgbImage::from_fn(48, 40, |_, y| image::Rgb([60 + 3 * y as u8, 130, 250 - 6 * y as u8]));
        photo.save(folder.join("rose.jpg")).unwrap();
        let before = Config { data: data.path().to_owned(), long_side: 40, ..Config::default() };
        assert!(Library::load(&before).unwrap().pictures[0].nearness.is_none());
        // There is no teacher whose map a part of it could be.
        taught(data.path(), "0.5").unwrap();
        let rose = &library(data.path()).pictures[0];
        assert!(rose.taught && rose.is_flower() && rose.nearness.is_some());
    }

    #[test]
    fn the_share_of_nobody_is_the_map_of_the_teacher() {
        let data = data();
        taught(data.path(), "0").unwrap();
        let file = data.path().join("maps/everyday/wide.nearness.png");
        let map = image::open(file).unwrap().into_luma8();
        assert_eq!(map.dimensions(), (48, 40));
        let off = |x: u32| f32::from(map.get_pixel(x, 20)[0]) / 255.0 - ((x as f32 / 47.0 - 0.02) / 0.96 + 0.05) / 1.1;
        assert!((4..44).all(|x| off(x).abs() < 0.03), "{:?}", (4..44).map(off).collect::<Vec<_>>());
    }

    #[test]
    fn a_folder_without_maps_is_refused() {
        let data = data();
        let config = Config { data: data.path().to_owned(), maps: Some(data.path().join("none")), ..Config::default() };
        let error = Library::load(&config).err().unwrap().to_string();
        assert!(error.contains("teach") && error.ends_with("none"), "{error}");
    }
}
