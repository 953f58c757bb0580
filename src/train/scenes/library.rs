//! The pictures that samples are made of, decoded once and kept small in memory.
//!
//! Folders (see `manifest.jsonl` in each): `flowers/`, `everyday/` and `everyday10k/` with `split` train or val,
//! `photos_depth/` with nearness maps of flower photos, `lightfields/`. What is marked val is read only where validation
//! is asked for, and the two validation light fields never; a flower's nearness map is used only on the flower's own side
//! of the split. Of photos with measured depth, whole places are kept for validation (`manifest.rs`). A file that
//! cannot be used is told in [`Library::notes`], and the rest goes on.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::OnceLock;

use rayon::prelude::*;

use super::cutout::Cutout;
use super::fields::{self, Field};
use super::manifest::{self, Entry};
use super::raster::{Raster, push_pull};
use super::{Config, SceneError, Split};
use crate::eval::metrics::percentiles;
use plenoscope::field::fit_long_side;

/// One photo, with what is known about it.
pub struct Picture {
    /// Folder and name, `flowers/image_0001`.
    pub id: String,
    /// sRGB.
    pub rgb: Raster<[u8; 3]>,
    /// Subject, 255 inside.
    pub mask: Option<Raster<u8>>,
    /// Nearness, stretched so that 0 … 255 is −0.05 … 1.05 between far and near; none where it is doubtful.
    pub nearness: Option<Raster<u8>>,
    /// Where the map knows nothing, 255 there.
    pub holes: Option<Raster<u8>>,
    /// Whether the map was measured, by a sensor or by stereo.
    pub measured: bool,
    /// Whether a net of ours made the map (`teach`).
    pub taught: bool,
    /// What the map is worth, 0 … 1.
    pub worth: f32,
    /// People, room, street …
    pub kind: String,
    cutout: OnceLock<Option<Cutout>>,
}

impl Picture {
    /// A picture from its parts.
    pub fn new(id: String, rgb: Raster<[u8; 3]>, mask: Option<Raster<u8>>, nearness: Option<Raster<u8>>) -> Self {
        let (holes, kind) = (None, String::new());
        Self {
            id,
            rgb,
            mask,
            nearness,
            holes,
            measured: false,
            taught: false,
            worth: 1.0,
            kind,
            cutout: OnceLock::new(),
        }
    }

    /// Whether the photo comes from one of the flower folders.
    pub fn is_flower(&self) -> bool {
        self.id.starts_with("flowers/") || self.id.starts_with("photos_depth/")
    }

    /// The subject and what is behind it, made at its first use; none without a mask.
    pub fn cutout(&self) -> Option<&Cutout> {
        self.cutout.get_or_init(|| self.mask.as_ref().map(|mask| Cutout::new(self, mask))).as_ref()
    }
}

/// Everything that samples are made of.
#[derive(Default)]
pub struct Library {
    /// All photos.
    pub pictures: Vec<Picture>,
    /// Real light fields.
    pub fields: Vec<Field>,
    /// A sentence for each file that was left out.
    pub notes: Vec<String>,
}

/// One line of a manifest, told where its files lie.
struct Item<'a> {
    id: String,
    entry: &'a Entry,
    photo: std::path::PathBuf,
    mask: std::path::PathBuf,
    nearness: Option<std::path::PathBuf>,
}

impl Library {
    /// Reads what `config` asks for from `config.data`.
    ///
    /// # Errors
    /// A folder without any pictures; a light field that is none.
    pub fn load(config: &Config) -> Result<Self, SceneError> {
        let mut notes = Vec::new();
        let mut manifests = FOLDERS.map(|name| manifest::read(&config.data.join(name), &mut notes));
        if let Some(maps) = &config.maps {
            let taught = FOLDERS
                .iter()
                .zip(&mut manifests)
                .map(|(name, entries)| manifest::take_maps(entries, &maps.join(name), &mut notes));
            if taught.sum::<usize>() == 0 {
                return Err(SceneError::NoMaps { path: maps.clone() });
            }
        }
        let items = items(&config.data, &manifests, config.split);
        let long_side = config.long_side + config.long_side / 5;
        let read: Vec<_> = items.par_iter().map(|item| read_picture(item, long_side)).collect();
        let mut pictures = Vec::with_capacity(read.len());
        for picture in read {
            picture.map_or_else(|note| notes.push(note.to_string()), |picture| pictures.push(picture));
        }
        let wanted = config.mix.real > 0.0 && config.split == Split::Train;
        let fields = if wanted { fields::read(&config.data, config.long_side)? } else { Vec::new() };
        let library = Self { pictures, fields, notes };
        if library.pictures.is_empty() && library.fields.is_empty() {
            return Err(SceneError::Empty { path: config.data.clone() });
        }
        Ok(library)
    }
}

/// Photos of a folder whose depth was measured and that no net is trained on; all of a folder that tells no labels. And
/// a sentence for each file that was left out.
///
/// # Errors
/// A folder without such photos.
pub fn measured(folder: &Path, long_side: usize) -> Result<(Vec<Picture>, Vec<String>), SceneError> {
    let mut notes = Vec::new();
    let entries = manifest::read(folder, &mut notes);
    let labelled = entries.iter().any(|entry| entry.label.is_some());
    let wanted = |entry: &&Entry| !labelled || (entry.is_measured() && entry.split() == Split::Val);
    let file = |entry: &Entry, ending: &str| folder.join(format!("{}.{ending}", entry.id));
    let items: Vec<Item> = entries
        .iter()
        .filter(wanted)
        .map(|entry| Item {
            id: entry.id.clone(),
            entry,
            photo: file(entry, "jpg"),
            mask: file(entry, "mask.png"),
            nearness: Some(file(entry, "nearness.png")),
        })
        .collect();
    let read: Vec<_> = items.par_iter().map(|item| read_picture(item, long_side)).collect();
    let mut pictures = Vec::with_capacity(read.len());
    for picture in read {
        picture.map_or_else(|note| notes.push(note.to_string()), |picture| pictures.push(picture));
    }
    if pictures.is_empty() {
        return Err(SceneError::NoDepth { path: folder.to_owned() });
    }
    Ok((pictures, notes))
}

/// Folders with a manifest.
const FOLDERS: [&str; 4] = ["flowers", "everyday", "everyday10k", "photos_depth"];

fn items<'a>(data: &Path, [flowers, everyday, more, depth]: &'a [Vec<Entry>; 4], split: Split) -> Vec<Item<'a>> {
    let mapped: HashSet<&str> = depth.iter().map(|entry| entry.id.as_str()).collect();
    let side: HashMap<&str, Split> = flowers.iter().map(|entry| (entry.id.as_str(), entry.split())).collect();
    let item = |name: &str, entry: &'a Entry, nearness: Option<&str>| Item {
        id: format!("{name}/{}", entry.id),
        photo: data.join(name).join(format!("{}.jpg", entry.id)),
        mask: data.join(name).join(format!("{}.mask.png", entry.id)),
        nearness: nearness.map(|folder| {
            entry.maps.clone().unwrap_or_else(|| data.join(folder)).join(format!("{}.nearness.png", entry.id))
        }),
        entry,
    };
    let mut items = Vec::new();
    for entry in flowers.iter().filter(|entry| entry.split() == split) {
        let is_mapped = if entry.is_taught() { entry.has_map() } else { mapped.contains(entry.id.as_str()) };
        items.push(item("flowers", entry, is_mapped.then_some("photos_depth")));
    }
    for (name, entries) in [("everyday", everyday), ("everyday10k", more)] {
        for entry in entries.iter().filter(|entry| entry.split() == split) {
            items.push(item(name, entry, entry.has_map().then_some(name)));
        }
    }
    if split == Split::Train {
        for entry in depth.iter().filter(|entry| !side.contains_key(entry.id.as_str())) {
            items.push(item("photos_depth", entry, Some("photos_depth")));
        }
    }
    items
}

fn read_picture(item: &Item, long_side: usize) -> Result<Picture, SceneError> {
    let photo = read_rgb("photo", &item.photo)?;
    let native = photo.size;
    let shape = item.entry.unsqueezed(native).map(|side| side as u32);
    let size = fit_long_side(shape, long_side as u32).map(|side| side as usize);
    let mask = if item.mask.exists() {
        let mask = read_gray("mask", &item.mask)?;
        if mask.size != native {
            let path = item.mask.clone();
            return Err(SceneError::Size { what: "mask", got: mask.size, want: native, beside: "its photo", path });
        }
        Some(to_u8(&mask.resized(size)).map(|texel| texel[0]))
    } else {
        None
    };
    let mut picture = Picture::new(item.id.clone(), to_u8(&photo.resized(size)), mask, None);
    if let Some(path) = &item.nearness {
        let map = read_gray("nearness map", path)?;
        if !same_shape(map.size, native) {
            let (path, beside) = (path.clone(), "its photo, or fewer in its shape");
            return Err(SceneError::Size { what: "nearness map", got: map.size, want: native, beside, path });
        }
        let known: Vec<f32> =
            map.px.iter().map(|texel| f32::from(!item.entry.invalid_zero || texel[0] > 0.0)).collect();
        if known.iter().sum::<f32>() < 0.05 * known.len() as f32 {
            return Err(SceneError::read("nearness map", path, "nearly all of it is unknown", "some depth"));
        }
        let range = usual_range(&map, &known);
        if known.contains(&0.0) {
            let holes = Raster { size: map.size, px: known.iter().map(|k| [255.0 * (1.0 - k)]).collect() };
            picture.holes = Some(to_u8(&holes.resized(size)).map(|texel| texel[0]));
        }
        picture.nearness = Some(stretch(&push_pull(&map, &known).resized(size), range));
    }
    picture.worth = if picture.nearness.is_some() { item.entry.worth() } else { 1.0 };
    picture.measured = item.entry.is_measured();
    picture.taught = item.entry.is_taught();
    picture.kind = item.entry.kind.clone().unwrap_or_default();
    Ok(picture)
}

/// Whether two pictures have the same shape, but for a few rounded pixels.
fn same_shape([w, h]: [usize; 2], [other_w, other_h]: [usize; 2]) -> bool {
    let ratio = (w * other_h) as f32 / (h * other_w).max(1) as f32;
    (ratio - 1.0).abs() < 0.06
}

fn decode(what: &'static str, path: &Path) -> Result<image::DynamicImage, SceneError> {
    let expected = format!("an 8-bit picture, {what}");
    let reader = image::ImageReader::open(path).and_then(image::ImageReader::with_guessed_format);
    let reader = reader.map_err(|e| SceneError::read(what, path, e, expected.as_str()))?;
    reader.decode().map_err(|e| SceneError::read(what, path, e, expected))
}

/// An sRGB picture of a file, values 0 … 255.
pub fn read_rgb(what: &'static str, path: &Path) -> Result<Raster<[f32; 3]>, SceneError> {
    let picture = decode(what, path)?.into_rgb8();
    let size = [picture.width() as usize, picture.height() as usize];
    Ok(Raster { size, px: picture.pixels().map(|p| p.0.map(f32::from)).collect() })
}

pub(super) fn read_gray(what: &'static str, path: &Path) -> Result<Raster<[f32; 1]>, SceneError> {
    let picture = decode(what, path)?.into_luma8();
    let size = [picture.width() as usize, picture.height() as usize];
    Ok(Raster { size, px: picture.pixels().map(|p| [f32::from(p.0[0])]).collect() })
}

/// Values 0 … 255 rounded to bytes.
pub fn to_u8<const N: usize>(raster: &Raster<[f32; N]>) -> Raster<[u8; N]> {
    raster.map(|texel| texel.map(|value| (value + 0.5).clamp(0.0, 255.0) as u8))
}

/// 2nd and 98th percentile of what a map knows.
fn usual_range(map: &Raster<[f32; 1]>, known: &[f32]) -> [f32; 2] {
    let there = map.px.iter().zip(known).filter(|(_, k)| **k > 0.0);
    percentiles(&mut there.map(|(texel, _)| texel[0]).collect::<Vec<f32>>(), [0.02, 0.98])
}

/// A nearness map with its usual range brought to 0 … 1, stored as −0.05 … 1.05 over 0 … 255.
fn stretch(map: &Raster<[f32; 1]>, [lo, hi]: [f32; 2]) -> Raster<u8> {
    map.map(|texel| byte_from_nearness((texel[0] - lo) / (hi - lo).max(1e-3)))
}

/// How a nearness is stored.
pub fn byte_from_nearness(nearness: f32) -> u8 {
    ((nearness + 0.05) / 1.1 * 255.0 + 0.5).clamp(0.0, 255.0) as u8
}

/// The nearness that an (interpolated) byte stands for.
pub fn nearness_from_byte(byte: f32) -> f32 {
    byte * (1.1 / 255.0) - 0.05
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder with photos, maps and a manifest of these lines; photos are 40 × 40 px.
    fn folder(data: &Path, lines: &[&str]) {
        let folder = data.join("everyday10k");
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("manifest.jsonl"), lines.join("\n")).unwrap();
        for line in lines {
            let Ok(entry) = serde_json::from_str::<Entry>(line) else { continue };
            if entry.id.contains("missing") {
                continue;
            }
            image::RgbImage::new(40, 40).save(folder.join(format!("{}.jpg", entry.id))).unwrap();
            // Nothing is known in the left quarter; the rest is nearer to the right.
            let near = |x: u32, _| image::Luma([if x < 5 { 0 } else { 40 + 10 * x.min(20) as u8 }]);
            let map = image::GrayImage::from_fn(if entry.id.contains("wrong") { 40 } else { 20 }, 20, near);
            let unknown = || image::GrayImage::new(20, 20);
            let map = if entry.id.contains("unknown") { unknown() } else { map };
            map.save(folder.join(format!("{}.nearness.png", entry.id))).unwrap();
        }
    }

    const LINES: [&str; 10] = [
        r#"{"id":"tsdfk_1","label":"sensor","invalid_zero":true,"kind":"room","split":"train"}"#,
        r#"{"id":"repl_1","label":"sensor","invalid_zero":true,"kind":"room","split":"train"}"#,
        r#"{"id":"wide_1","label":"teacher","gate":"self","squeezed":true,"split":"train"}"#,
        r#"{"id":"inside_1","label":"teacher-rooms","gate":"self","kind":"room","split":"train"}"#,
        r#"{"id":"doubt_1","label":"teacher","gate":"doubtful","split":"train"}"#,
        r#"{"id":"soft_1","label":"teacher","gate":"soft","split":"train"}"#,
        r#"{"id":"missing_1","label":"teacher","gate":"self","split":"train"}"#,
        r#"{"id":"wrong_1","label":"teacher","gate":"self","split":"train"}"#,
        r#"{"id":"unknown_1","label":"sensor","invalid_zero":true,"split":"train"}"#,
        "{no line",
    ];

    fn load(split: Split) -> Library {
        let data = tempfile::tempdir().unwrap();
        folder(data.path(), &LINES);
        Library::load(&Config { data: data.path().to_owned(), long_side: 50, split, ..Config::default() }).unwrap()
    }

    #[test]
    fn labels_are_weighed_and_what_is_missing_is_told() {
        let library = load(Split::Train);
        let picture = |id: &str| library.pictures.iter().find(|p| p.id.ends_with(id)).unwrap();
        assert_eq!(library.pictures.len(), 5);
        let worths = ["tsdfk_1", "inside_1", "wide_1", "soft_1"].map(|id| picture(id).worth);
        assert!(worths.is_sorted_by(|more, less| more > less), "{worths:?}");
        assert!(picture("doubt_1").nearness.is_none());
        let [w, h] = picture("wide_1").rgb.size;
        assert_eq!((w, h), (53, 40));
        assert_eq!(library.notes.len(), 4);
        for file in ["missing_1.jpg", "wrong_1.nearness.png", "unknown_1.nearness.png", "manifest.jsonl"] {
            assert_eq!(library.notes.iter().filter(|note| note.contains(file)).count(), 1, "{:?}", library.notes);
        }
    }

    #[test]
    fn what_a_sensor_does_not_know_is_a_hole_and_does_not_bend_the_range() {
        let library = load(Split::Train);
        let measured = library.pictures.iter().find(|p| p.measured).unwrap();
        let (holes, map) = (measured.holes.as_ref().unwrap(), measured.nearness.as_ref().unwrap());
        assert_eq!((holes.at(2, 20), holes.at(30, 20)), (255, 0));
        // The least that is known is 0, the most 1.
        assert!(nearness_from_byte(f32::from(map.at(12, 20))).abs() < 0.15);
        assert!((nearness_from_byte(f32::from(map.at(38, 20))) - 1.0).abs() < 0.1);
    }

    #[test]
    fn whole_places_are_kept_for_validation() {
        let kept = load(Split::Val);
        assert_eq!(kept.pictures.iter().map(|p| p.id.as_str()).collect::<Vec<_>>(), ["everyday10k/repl_1"]);
        let data = tempfile::tempdir().unwrap();
        folder(data.path(), &LINES);
        let (pictures, notes) = measured(&data.path().join("everyday10k"), 100).unwrap();
        assert_eq!((pictures.len(), notes.len()), (1, 1));
        let error = measured(data.path(), 100).err().unwrap().to_string();
        assert!(error.contains("measured depth"), "{error}");
    }
}
