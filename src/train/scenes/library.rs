//! The pictures that samples are made of, decoded once and kept small in memory.
//!
//! Folders (see `manifest.jsonl` in each): `flowers/` and `everyday/` with `split` train or val, `photos_depth/` with
//! nearness maps of flower photos, `lightfields/`. What is marked val is read only where validation is asked for, and
//! the two validation light fields never; a flower's nearness map is used only on the flower's own side of the split.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::OnceLock;

use rayon::prelude::*;
use serde::Deserialize;

use super::cutout::Cutout;
use super::fields::{self, Field};
use super::raster::Raster;
use super::{Config, SceneError, Split};
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
    cutout: OnceLock<Option<Cutout>>,
}

impl Picture {
    /// A picture from its parts.
    pub fn new(id: String, rgb: Raster<[u8; 3]>, mask: Option<Raster<u8>>, nearness: Option<Raster<u8>>) -> Self {
        Self { id, rgb, mask, nearness, cutout: OnceLock::new() }
    }

    /// Whether the photo comes from one of the flower folders.
    pub fn is_flower(&self) -> bool {
        !self.id.starts_with("everyday/")
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
}

#[derive(Deserialize)]
struct Entry {
    id: String,
    #[serde(default)]
    split: Option<Split>,
    #[serde(default)]
    gate: Option<String>,
}

impl Entry {
    fn split(&self) -> Split {
        self.split.unwrap_or(Split::Train)
    }
}

/// One line of a manifest, told where its files lie.
struct Item {
    id: String,
    photo: std::path::PathBuf,
    mask: std::path::PathBuf,
    nearness: Option<std::path::PathBuf>,
}

impl Library {
    /// Reads what `config` asks for from `config.data`.
    ///
    /// # Errors
    /// A file that is missing, unreadable or of another size than its photo; a folder without any pictures.
    pub fn load(config: &Config) -> Result<Self, SceneError> {
        let items = items(&config.data, config.split)?;
        let long_side = config.long_side + config.long_side / 5;
        let pictures = items.par_iter().map(|item| read_picture(item, long_side)).collect::<Result<_, _>>()?;
        let wanted = config.mix.real > 0.0 && config.split == Split::Train;
        let fields = if wanted { fields::read(&config.data, config.long_side)? } else { Vec::new() };
        let library = Self { pictures, fields };
        if library.pictures.is_empty() && library.fields.is_empty() {
            return Err(SceneError::Empty { path: config.data.clone() });
        }
        Ok(library)
    }
}

fn manifest(folder: &Path) -> Result<Vec<Entry>, SceneError> {
    let path = folder.join("manifest.jsonl");
    if !path.exists() {
        return Ok(Vec::new());
    }
    let expected = "one JSON object with an id on each line";
    let text = std::fs::read_to_string(&path).map_err(|e| SceneError::read("manifest", &path, e, expected))?;
    text.lines()
        .filter(|line| !line.trim().is_empty())
        .map(|line| serde_json::from_str(line).map_err(|e| SceneError::read("manifest", &path, e, expected)))
        .collect()
}

fn items(data: &Path, split: Split) -> Result<Vec<Item>, SceneError> {
    let [flowers, everyday, depth] = ["flowers", "everyday", "photos_depth"].map(|name| data.join(name));
    let flower_entries = manifest(&flowers)?;
    let depth_entries = manifest(&depth)?;
    let mapped: HashSet<&str> = depth_entries.iter().map(|entry| entry.id.as_str()).collect();
    let side: HashMap<&str, Split> = flower_entries.iter().map(|entry| (entry.id.as_str(), entry.split())).collect();
    let mut items = Vec::new();
    let item = |folder: &Path, name: &str, id: &str, nearness: Option<std::path::PathBuf>| Item {
        id: format!("{name}/{id}"),
        photo: folder.join(format!("{id}.jpg")),
        mask: folder.join(format!("{id}.mask.png")),
        nearness,
    };
    for entry in flower_entries.iter().filter(|entry| entry.split() == split) {
        let map = mapped.contains(entry.id.as_str()).then(|| depth.join(format!("{}.nearness.png", entry.id)));
        items.push(item(&flowers, "flowers", &entry.id, map));
    }
    for entry in manifest(&everyday)?.iter().filter(|entry| entry.split() == split) {
        let doubtful = entry.gate.as_deref() == Some("doubtful");
        let map = (!doubtful).then(|| everyday.join(format!("{}.nearness.png", entry.id)));
        items.push(item(&everyday, "everyday", &entry.id, map));
    }
    if split == Split::Train {
        for entry in depth_entries.iter().filter(|entry| !side.contains_key(entry.id.as_str())) {
            let map = Some(depth.join(format!("{}.nearness.png", entry.id)));
            items.push(item(&depth, "photos_depth", &entry.id, map));
        }
    }
    Ok(items)
}

fn read_picture(item: &Item, long_side: usize) -> Result<Picture, SceneError> {
    let photo = read_rgb("photo", &item.photo)?;
    let native = photo.size;
    let size = fit_long_side(native.map(|side| side as u32), long_side as u32).map(|side| side as usize);
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
    let nearness = item.nearness.as_ref().map(|path| read_gray("nearness map", path)).transpose()?;
    let nearness = nearness.map(|map| stretch(&map.resized(size)));
    Ok(Picture::new(item.id.clone(), to_u8(&photo.resized(size)), mask, nearness))
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

fn read_gray(what: &'static str, path: &Path) -> Result<Raster<[f32; 1]>, SceneError> {
    let picture = decode(what, path)?.into_luma8();
    let size = [picture.width() as usize, picture.height() as usize];
    Ok(Raster { size, px: picture.pixels().map(|p| [f32::from(p.0[0])]).collect() })
}

/// Values 0 … 255 rounded to bytes.
pub fn to_u8<const N: usize>(raster: &Raster<[f32; N]>) -> Raster<[u8; N]> {
    raster.map(|texel| texel.map(|value| (value + 0.5).clamp(0.0, 255.0) as u8))
}

/// A nearness map with its 2nd … 98th percentile brought to 0 … 1, stored as −0.05 … 1.05 over 0 … 255.
fn stretch(map: &Raster<[f32; 1]>) -> Raster<u8> {
    let mut sorted: Vec<f32> = map.px.iter().map(|texel| texel[0]).collect();
    sorted.sort_by(f32::total_cmp);
    let at = |share: f32| sorted[((sorted.len() - 1) as f32 * share) as usize];
    let (lo, hi) = (at(0.02), at(0.98));
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
