//! Recipes: every edit of a photo as a small JSON, kept beside it and applied to others.
//!
//! What a newer version wrote and this one does not know stays in the file.

use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::field::{Lens, ViewPoint, fit_long_side};
use crate::io::save::{Format, Keep, Origin, PictureOptions, Pixels, SaveError, atomic};
use crate::job::Job;
use crate::render::lens::{LensError, Scene, render_pixels};

/// What is appended to a photo's name for its sidecar.
const SIDECAR: &str = ".plenoscope.json";
/// A recipe is small; what is larger is none.
const LARGEST_BYTES: u64 = 1 << 20;

/// Why a recipe could not be read or kept.
#[derive(Debug, thiserror::Error)]
pub enum RecipeError {
    /// The file could not be read.
    #[error("the recipe cannot be read — {why}: {}", .path.display())]
    Read {
        /// What the system says.
        why: String,
        /// The file.
        path: PathBuf,
    },
    /// It is not a recipe.
    #[error("this is not a recipe — {why} — make one with \"Copy edit\" or write the sidecar of a photo anew: {}", .path.display())]
    Parse {
        /// What is wrong, and where.
        why: String,
        /// The file.
        path: PathBuf,
    },
    /// The sidecar could not be written.
    #[error(transparent)]
    Save(#[from] SaveError),
}

/// How large the picture becomes; never larger than the photo.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutputSize {
    /// As the photo.
    #[default]
    Photo,
    /// At most so many pixels on the longer side.
    LongSide(u32),
    /// As large as fits into this width and height.
    Within([u32; 2]),
}

impl OutputSize {
    /// The picture's size for a photo's.
    pub fn of(self, photo: [u32; 2]) -> [u32; 2] {
        match self {
            Self::Photo => photo,
            Self::LongSide(side) => fit_long_side(photo, side.max(1)),
            Self::Within([width, height]) => {
                let shrink = |axis: usize, side: u32| f64::from(side.max(1)) / f64::from(photo[axis]);
                let scale = shrink(0, width).min(shrink(1, height)).min(1.0);
                photo.map(|side| ((f64::from(side) * scale).round() as u32).max(1))
            }
        }
    }
}

/// How the picture is kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ExportSettings {
    /// The format.
    pub format: Format,
    /// 8, or 16 where the format has that.
    pub bits: u8,
    /// Of JPEG, 1 … 100.
    pub quality: u8,
    /// How large.
    pub size: OutputSize,
    /// Which metadata goes along.
    pub keep: Keep,
    /// Name of the file without its ending: `{name}` is the photo's, `{f}` the f-number, `{focus}` the disparity in focus.
    pub name: String,
}

impl Default for ExportSettings {
    fn default() -> Self {
        let name = "{name}-f{f}".to_owned();
        Self { format: Format::Jpeg, bits: 8, quality: 92, size: OutputSize::Photo, keep: Keep::All, name }
    }
}

/// One edit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Recipe {
    /// The lens; disparities are in pixels per view step of the scene's map.
    pub lens: Lens,
    /// A place of the photo that is to be sharp, x and y from 0 to 1; it takes the place of the lens's disparity.
    pub focus_at: Option<[f32; 2]>,
    /// Where the lens stands, in steps from the reference view.
    pub viewpoint: ViewPoint,
    /// How the picture is kept.
    pub export: ExportSettings,
    /// All that was in the file, so that what is unknown here is not lost.
    #[serde(skip)]
    whole: Value,
}

impl Recipe {
    /// From JSON text.
    pub fn from_json(text: &str) -> Result<Self, serde_json::Error> {
        let whole: Value = serde_json::from_str(text)?;
        let mut recipe: Self = serde_json::from_value(whole.clone())?;
        recipe.whole = whole;
        Ok(recipe)
    }

    /// As JSON text, with all that was unknown when it was read.
    pub fn to_json(&self) -> String {
        let known = serde_json::to_value(self).unwrap_or_default();
        let mut whole = self.whole.clone();
        merge(&mut whole, known);
        format!("{whole:#}\n")
    }

    /// Reads a recipe.
    pub fn read(path: &Path) -> Result<Self, RecipeError> {
        let failed = |why: String| RecipeError::Read { why, path: path.to_owned() };
        let bytes = std::fs::metadata(path).map_err(|e| failed(e.to_string()))?.len();
        if bytes > LARGEST_BYTES {
            return Err(failed("it is too large for one; give the recipe's file".to_owned()));
        }
        let text = std::fs::read_to_string(path).map_err(|e| failed(e.to_string()))?;
        Self::from_json(&text).map_err(|e| RecipeError::Parse { why: e.to_string(), path: path.to_owned() })
    }

    /// Writes it, whole or not at all.
    pub fn write(&self, path: &Path) -> Result<(), RecipeError> {
        let text = self.to_json();
        let write =
            |file: &mut std::fs::File| file.write_all(text.as_bytes()).map_err(|e| SaveError::from_io(&e, path));
        Ok(atomic(path, write)?)
    }

    /// The sidecar of a photo: `photo.jpg.plenoscope.json` beside it.
    pub fn sidecar(photo: &Path) -> PathBuf {
        let mut name = photo.as_os_str().to_owned();
        name.push(SIDECAR);
        name.into()
    }

    /// The photo's own recipe, if it has one.
    pub fn of_photo(photo: &Path) -> Result<Option<Self>, RecipeError> {
        let path = Self::sidecar(photo);
        if path.exists() { Self::read(&path).map(Some) } else { Ok(None) }
    }

    /// The lens for a scene: where a place is to be sharp, its disparity becomes the focal plane's.
    pub fn lens_for(&self, scene: &Scene) -> Lens {
        let mut lens = self.lens;
        if let Some([x, y]) = self.focus_at {
            let map = scene.disparity();
            let cell = |at: f32, side: u32| ((at.clamp(0.0, 1.0) * side as f32) as u32).min(side - 1);
            let here = map.at(cell(x, map.size()[0]), cell(y, map.size()[1]));
            lens.focus.disparity_px += here - lens.focus.at(x, y);
        }
        lens
    }

    /// Makes the picture of a scene.
    pub fn apply(&self, scene: &Scene, job: &Job) -> Result<Pixels, LensError> {
        let size = self.export.size.of(scene.photo().size());
        let bits = if self.export.format.has_16_bits() { self.export.bits } else { 8 };
        render_pixels(&scene.seen_from(self.viewpoint, size, job)?, &self.lens_for(scene), size, bits, job)
    }

    /// How that picture is written.
    pub fn options(&self, scene: &Scene) -> PictureOptions {
        let ExportSettings { format, bits, quality, keep, .. } = self.export;
        let origin = Origin::in_own_space(scene.photo());
        PictureOptions { format: Some(format), bits, quality, keep, origin, replace_source: false }
    }

    /// The picture's file name for a photo's, without its ending.
    pub fn stem(&self, photo: &Path) -> String {
        let stem = photo.file_stem().unwrap_or_default().to_string_lossy();
        let f = format!("{:.1}", self.lens.f_number.0);
        let f = f.strip_suffix(".0").unwrap_or(&f);
        let focus = format!("{:+.2}", self.lens.focus.disparity_px);
        let name = self.export.name.replace("{name}", &stem).replace("{f}", f).replace("{focus}", &focus);
        let name = name.replace(['/', '\\', '\0'], "-");
        if name.trim_matches(['.', ' ']).is_empty() { stem.into_owned() } else { name }
    }

    /// The picture's file name for a photo's.
    pub fn file_name(&self, photo: &Path) -> String {
        format!("{}.{}", self.stem(photo), self.export.format.extension())
    }
}

/// Puts `new` over `old`: objects key by key, all else as a whole.
fn merge(old: &mut Value, new: Value) {
    match (old, new) {
        (Value::Object(old), Value::Object(new)) => {
            for (key, value) in new {
                merge(old.entry(key).or_insert(Value::Null), value);
            }
        }
        (old, new) => *old = new,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{DisparityMap, FNumber, LensShape, Photo};

    fn edit() -> Recipe {
        let shape = LensShape::Blades { count: 7, rotation_deg: 12.5, roundness: 0.3 };
        let lens = Lens { f_number: FNumber(4.7), shape, highlights: 0.1, ..Lens::default() };
        Recipe { lens, focus_at: Some([0.25, 0.75]), ..Recipe::default() }
    }

    #[test]
    fn a_recipe_is_the_same_after_it_was_written_and_read() {
        let dir = tempfile::tempdir().unwrap();
        let photo = dir.path().join("p.jpg");
        assert!(Recipe::of_photo(&photo).unwrap().is_none());
        edit().write(&Recipe::sidecar(&photo)).unwrap();
        let read = Recipe::of_photo(&photo).unwrap().unwrap();
        assert_eq!(Recipe { whole: Value::Null, ..read }, edit());
    }

    #[test]
    fn what_is_unknown_is_kept_at_every_depth_and_what_is_missing_has_its_default() {
        let text = r#"{"lens": {"f_number": 2.0, "swirl": 3}, "export": {"watermark": "x"}, "stars": [5]}"#;
        let mut recipe = Recipe::from_json(text).unwrap();
        assert_eq!(recipe.export.quality, ExportSettings::default().quality);
        recipe.lens.f_number = FNumber(8.0);
        let out: Value = serde_json::from_str(&recipe.to_json()).unwrap();
        assert_eq!((&out["lens"]["swirl"], &out["lens"]["f_number"]), (&3.into(), &8.0.into()));
        assert_eq!((&out["export"]["watermark"], &out["stars"][0]), (&"x".into(), &5.into()));
    }

    #[test]
    fn what_is_no_recipe_is_refused_with_the_place() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("r.json");
        std::fs::write(&path, "{\"lens\": 3}").unwrap();
        assert!(matches!(Recipe::read(&path), Err(RecipeError::Parse { .. })));
        assert!(matches!(Recipe::read(&dir.path().join("none.json")), Err(RecipeError::Read { .. })));
    }

    #[test]
    fn sizes_keep_the_shape_and_never_grow() {
        assert_eq!(OutputSize::LongSide(2048).of([4000, 3000]), [2048, 1536]);
        assert_eq!(OutputSize::Within([1000, 1000]).of([4000, 3000]), [1000, 750]);
        assert_eq!(OutputSize::Within([9000, 9000]).of([4000, 3000]), [4000, 3000]);
    }

    #[test]
    fn names_follow_the_template_and_stay_in_their_folder() {
        let mut recipe = edit();
        assert_eq!(recipe.file_name(Path::new("/a/rose.heic")), "rose-f4.7.jpg");
        recipe.export.name = "../{name}".to_owned();
        assert_eq!(recipe.file_name(Path::new("/a/rose.heic")), "..-rose.jpg");
        recipe.export.name = "..".to_owned();
        assert_eq!(recipe.file_name(Path::new("/a/rose.heic")), "rose.jpg");
    }

    #[test]
    fn the_place_in_focus_gets_its_disparity() {
        let photo = Photo::from_srgb8([4, 2], vec![128; 32]).unwrap();
        let map = DisparityMap::new([4, 2], vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]).unwrap();
        let scene = Scene::new(photo.into(), map).unwrap();
        assert_eq!(edit().lens_for(&scene).focus.at(0.25, 0.75), 5.0);
    }
}
