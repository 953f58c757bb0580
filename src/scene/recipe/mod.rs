//! Recipes: every edit of a photo as a small JSON, kept beside it and applied to others.
//!
//! A recipe says its `version` and its `unit`. In version 2 disparities are shares of the picture's width per view step
//! ([`Edit`]); in version 1, which has no `version`, they are pixels of the map that the photo then had (`pixels`).
//! Its `depth` says where the depth came from: `"auto"`, `"network"`, `"phone"`, `"fused"`, or a net by its checksum,
//! `{"net": {"name": "…", "sha256": "…"}}`. Its `repairs` are what was mended of that depth ([`crate::repair`]), its
//! `timeline` is what moves in a film of it. What is unknown here stays in the file.

mod beside;
mod error;
mod pixels;
mod presets;

use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{DepthFrom, Edit, Embed, Focus, OutputSize, Timeline, source};
use crate::field::{Strength, ViewPoint};
use crate::io::save::{Format, Keep, SaveError, atomic};
use crate::repair::Repairs;
use crate::within;

pub use beside::Found;
pub use error::RecipeError;
use pixels::PixelEdit;
pub use presets::Presets;

/// What is appended to a photo's name for its sidecar.
const SIDECAR: &str = ".plenoscope.json";
/// A recipe is small, even with many strokes; what is larger is none.
pub(super) const LARGEST_BYTES: u64 = 16 << 20;
/// The most letters of the name of pictures.
const LONGEST_NAME: usize = 200;
/// The version that is written.
const VERSION: u64 = 2;
/// What its numbers mean, for whoever reads the file.
const UNIT: &str = "disparities are shares of the picture's width per view step; places go from 0 to 1";

/// How the picture is kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PictureSettings {
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
    /// What of the edit goes along.
    pub embed: Embed,
    /// Name of the file without its ending: `{name}` is the photo's, `{f}` the f-number, `{focus}` what is in focus.
    pub name: String,
}

impl Default for PictureSettings {
    fn default() -> Self {
        let name = "{name}-f{f}".to_owned();
        let (size, keep, embed) = (OutputSize::Photo, Keep::All, Embed::default());
        Self { format: Format::Jpeg, bits: 8, quality: 92, size, keep, embed, name }
    }
}

/// One edit, and how its pictures are kept.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recipe {
    body: Body,
    /// How the picture is kept.
    pub export: PictureSettings,
    /// Where its ray depths come from; none where the recipe does not say it.
    pub depth: Option<DepthFrom>,
    /// What was mended of them.
    pub repairs: Repairs,
    /// What moves in a film of it.
    pub timeline: Option<Timeline>,
    /// All that was in the file, so that what is unknown here is not lost.
    whole: Value,
}

#[derive(Clone, Debug, PartialEq)]
enum Body {
    Shares(Edit),
    Pixels(PixelEdit),
}

impl Default for Body {
    fn default() -> Self {
        Self::Shares(Edit::default())
    }
}

/// Version 2, as it stands in the file.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct Stored {
    version: u64,
    unit: String,
    lens: Edit,
    viewpoint: ViewPoint,
    export: PictureSettings,
    #[serde(skip_serializing_if = "Option::is_none")]
    depth: Option<source::Stored>,
    #[serde(skip_serializing_if = "Repairs::is_empty")]
    repairs: Repairs,
    #[serde(skip_serializing_if = "Option::is_none")]
    timeline: Option<Timeline>,
}

impl Recipe {
    /// An edit with the way its pictures are kept.
    pub fn new(edit: Edit, export: PictureSettings) -> Self {
        Self { body: Body::Shares(edit), export, ..Self::default() }
    }

    /// The edit, for a photo whose disparity map is `map_width` pixels wide; only recipes of version 1 depend on that.
    pub fn edit(&self, map_width: u32) -> Edit {
        match &self.body {
            Body::Shares(edit) => edit.clone(),
            Body::Pixels(edit) => edit.at_width(map_width),
        }
    }

    /// How deep the scene is.
    pub fn strength(&self) -> Strength {
        match &self.body {
            Body::Shares(edit) => edit.strength,
            Body::Pixels(_) => Strength::AS_MADE,
        }
    }

    /// The same recipe with another edit.
    #[must_use]
    pub fn with_edit(self, edit: Edit) -> Self {
        Self { body: Body::Shares(edit), ..self }
    }

    /// The same recipe for a scene whose depth is from elsewhere, a map of one's own too; that does not go into its text.
    #[must_use]
    pub fn of_depth(self, source: DepthFrom) -> Self {
        Self { depth: Some(source), ..self }
    }

    /// The same recipe with its depth from elsewhere. A map of one's own does not go into a recipe.
    #[must_use]
    pub fn with_depth(self, source: &DepthFrom) -> Self {
        Self { depth: Some(source.clone()).filter(|source| *source != DepthFrom::Map), ..self }
    }

    /// The same recipe with other repairs.
    #[must_use]
    pub fn with_repairs(self, repairs: Repairs) -> Self {
        Self { repairs, ..self }
    }

    /// From JSON text.
    ///
    /// # Errors
    /// What is wrong: no JSON, a later version, or a number that cannot be.
    pub fn from_json(text: &str) -> Result<Self, String> {
        let whole: Value = serde_json::from_str(text).map_err(|e| e.to_string())?;
        if !whole.is_object() {
            return Err("it is no JSON object".to_owned());
        }
        let version = whole.get("version").map_or(Some(1), Value::as_u64).ok_or("its version is no number")?;
        let (body, export, depth, repairs, timeline) = match version {
            0..VERSION => {
                let stored: pixels::Stored = serde_json::from_value(whole.clone()).map_err(|e| e.to_string())?;
                (Body::Pixels(stored.edit()), stored.export, None, Repairs::default(), None)
            }
            VERSION => {
                let Stored { lens, viewpoint, export, depth, repairs, timeline, .. } =
                    serde_json::from_value(whole.clone()).map_err(|e| e.to_string())?;
                let body = Body::Shares(Edit { viewpoint, ..lens });
                (body, export, depth.map(source::Stored::source), repairs, timeline)
            }
            later => return Err(format!("it is of version {later}, and this program knows {VERSION}; update it")),
        };
        let recipe = Self { body, export, depth, repairs, timeline, whole };
        recipe.check()?;
        Ok(recipe)
    }

    /// Refuses numbers that no window and no command line gives.
    fn check(&self) -> Result<(), String> {
        self.timeline.as_ref().map_or(Ok(()), Timeline::check)?;
        let edit = self.edit(1);
        let is_share = |n: f32| (0.0..=1.0).contains(&n);
        let place_is_inside = match edit.focus {
            Focus::At(place) => place.into_iter().all(is_share),
            // Places that lie outside are not read.
            Focus::Subject | Focus::Disparity(_) | Focus::Through(_) => true,
        };
        let checks = [
            ("f_number", (0.5..=64.0).contains(&edit.f_number.0)),
            ("strength", edit.strength.is_valid()),
            ("distance", edit.distance.is_none_or(|distance| distance.is_valid())),
            ("highlights", is_share(edit.highlights)),
            ("grain", is_share(edit.grain)),
            ("pivot", edit.pivot.abs() < 1.0),
            ("focus", place_is_inside),
            ("quality", (1..=100).contains(&self.export.quality)),
            ("bits", [8, 16].contains(&self.export.bits)),
            ("name", self.export.name.chars().count() <= LONGEST_NAME),
        ];
        match checks.iter().find(|(_, is_good)| !is_good).map(|(name, _)| *name).or(edit.glass.out_of_range()) {
            Some(name) => Err(format!("its {name} is out of range")),
            None => Ok(()),
        }
    }

    /// As JSON text, with all that was unknown when it was read.
    pub fn to_json(&self) -> String {
        format!("{:#}\n", self.value())
    }

    /// The same in one line.
    pub fn to_line(&self) -> String {
        self.value().to_string()
    }

    fn value(&self) -> Value {
        let mut whole = self.whole.clone();
        let known = match &self.body {
            Body::Pixels(edit) => serde_json::to_value(pixels::Stored::new(edit, &self.export)),
            Body::Shares(edit) => {
                pixels::forget(&mut whole);
                let depth = self.depth.as_ref().and_then(source::Stored::of);
                if let (None, Some(keys)) = (&depth, whole.as_object_mut()) {
                    keys.remove("depth");
                }
                let empty = [("repairs", self.repairs.is_empty()), ("timeline", self.timeline.is_none())];
                for (name, _) in empty.into_iter().filter(|(_, is_empty)| *is_empty) {
                    whole.as_object_mut().and_then(|keys| keys.remove(name));
                }
                let (export, viewpoint, unit) = (self.export.clone(), edit.viewpoint, UNIT.to_owned());
                let (lens, repairs, timeline) = (edit.clone(), self.repairs.clone(), self.timeline.clone());
                let version = VERSION;
                serde_json::to_value(Stored { version, unit, lens, viewpoint, export, depth, repairs, timeline })
            }
        };
        merge(&mut whole, known.unwrap_or_default());
        whole
    }

    /// Reads a recipe.
    pub fn read(path: &Path) -> Result<Self, RecipeError> {
        let failed = |why: String| RecipeError::Read { why, path: path.to_owned() };
        let text = within::text(path, LARGEST_BYTES).map_err(|e| failed(e.to_string()))?;
        Self::from_json(&text).map_err(|why| RecipeError::Parse { why, path: path.to_owned() })
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
}

impl PictureSettings {
    /// The picture's file name for a photo's, without its ending.
    pub fn stem(&self, photo: &Path, edit: &Edit) -> String {
        let stem = photo.file_stem().unwrap_or_default().to_string_lossy();
        let f = format!("{:.1}", edit.f_number.0);
        let f = f.strip_suffix(".0").unwrap_or(&f);
        let percent = |place: &[f32; 2]| place.map(|share| format!("{:.0}", share * 100.0)).join("x");
        let focus = match edit.focus {
            Focus::Subject => "subject".to_owned(),
            Focus::At(place) => percent(&place),
            Focus::Through(places) => places.all().iter().map(percent).collect::<Vec<_>>().join("+"),
            // As people read it: in pixels of views of the usual width.
            Focus::Disparity(share) => format!("{:+.2}", share * super::Making::LONG_SIDE as f32),
        };
        let name = self.name.replace("{name}", &stem).replace("{f}", f).replace("{focus}", &focus);
        let name = name.replace(|letter: char| matches!(letter, '/' | '\\') || within::is_odd(letter), "-");
        if name.trim_matches(['.', ' ']).is_empty() { stem.into_owned() } else { name }
    }

    /// The picture's file name for a photo's.
    pub fn file_name(&self, photo: &Path, edit: &Edit) -> String {
        format!("{}.{}", self.stem(photo, edit), self.format.extension())
    }

    /// Bits of a channel in the file.
    pub fn bits_in(&self, format: Format) -> u8 {
        if format.has_16_bits() { self.bits } else { 8 }
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
    use crate::field::{FNumber, LensShape, Opening};
    use crate::scene::real::Distance;

    fn edit() -> Edit {
        let shape = LensShape::Blades { count: 7, rotation_deg: 12.5, roundness: 0.3 };
        Edit { f_number: FNumber(4.7), shape, focus: Focus::At([0.25, 0.75]), highlights: 0.1, ..Edit::default() }
    }

    fn recipe() -> Recipe {
        Recipe::new(edit(), PictureSettings::default())
    }

    #[test]
    fn a_recipe_is_the_same_after_it_was_written_and_read() {
        let dir = tempfile::tempdir().unwrap();
        let photo = dir.path().join("p.jpg");
        assert!(Recipe::of_photo(&photo).unwrap().is_none());
        let through = Focus::Through(vec![[0.1, 0.2], [0.5, 0.75]].try_into().unwrap());
        for focus in [Focus::Subject, Focus::At([0.1, 1.0]), through, Focus::Disparity(-7.41e-4)] {
            let recipe = recipe().with_edit(Edit { focus, ..edit() });
            recipe.write(&Recipe::sidecar(&photo)).unwrap();
            let read = Recipe::of_photo(&photo).unwrap().unwrap();
            assert_eq!(Recipe { whole: Value::Null, ..read }, recipe);
        }
    }

    #[test]
    fn what_is_told_with_one_key_takes_the_place_of_another() {
        let distance = |of| Some(Distance { of, metres: 0.5 });
        let first = Edit { distance: distance(Focus::At([0.5, 0.5])), ..edit() };
        let ring = LensShape::Ring { inner: 0.5 };
        let second =
            Edit { shape: ring, focus: Focus::Disparity(1e-3), distance: distance(Focus::Subject), ..first.clone() };
        let none = Edit { distance: None, focus: Focus::Subject, ..second.clone() };
        let picture = LensShape::Picture(Opening::of_picture([2, 1], &[1.0, 0.5]).unwrap());
        let drawn = Edit { shape: picture, ..none.clone() };
        let mut recipe = Recipe::default();
        for edit in [first, second, none, drawn.clone(), edit(), drawn] {
            recipe = Recipe::from_json(&recipe.with_edit(edit.clone()).to_json()).unwrap();
            assert_eq!(recipe.edit(1), edit);
        }
    }

    #[test]
    fn what_is_unknown_is_kept_at_every_depth_and_what_is_missing_has_its_default() {
        let text =
            r#"{"version": 2, "lens": {"f_number": 2.0, "swirl": 3}, "export": {"watermark": "x"}, "stars": [5]}"#;
        let recipe = Recipe::from_json(text).unwrap();
        assert_eq!(recipe.export.quality, PictureSettings::default().quality);
        let edit = Edit { f_number: FNumber(8.0), ..recipe.edit(540) };
        let out: Value = serde_json::from_str(&recipe.with_edit(edit).to_json()).unwrap();
        assert_eq!((&out["lens"]["swirl"], &out["lens"]["f_number"]), (&3.into(), &8.0.into()));
        assert_eq!((&out["export"]["watermark"], &out["stars"][0]), (&"x".into(), &5.into()));
        assert_eq!((&out["version"], &out["unit"]), (&2.into(), &UNIT.into()));
    }

    #[test]
    fn the_source_of_depth_is_kept_by_checksum_and_older_recipes_say_none() {
        let tag = crate::synth::ModelTag { id: "mine".to_owned(), sha256: "a0".repeat(32) };
        for source in [DepthFrom::Auto, DepthFrom::Phone, DepthFrom::Model("m".to_owned()), DepthFrom::Net(tag)] {
            let text = recipe().with_depth(&source).to_json();
            assert_eq!(Recipe::from_json(&text).unwrap().depth, Some(source));
        }
        let text = r#"{"version": 2, "depth": {"net": {"name": "mine", "sha256": "A0", "stars": 5}}}"#;
        let read = Recipe::from_json(text).unwrap();
        assert!(matches!(&read.depth, Some(DepthFrom::Net(tag)) if tag.sha256 == "a0"));
        let kept: Value = serde_json::from_str(&read.clone().with_edit(edit()).to_json()).unwrap();
        assert_eq!(kept["depth"]["net"]["stars"], 5);
        let map: Value = serde_json::from_str(&read.with_depth(&DepthFrom::Map).to_json()).unwrap();
        assert!(map.get("depth").is_none(), "a map of one's own is not in a recipe");
        assert_eq!(Recipe::from_json(r#"{"version": 2, "lens": {}}"#).unwrap().depth, None);
        assert!(Recipe::from_json(r#"{"version": 2, "depth": "lidar"}"#).unwrap_err().contains("lidar"));
    }

    #[test]
    fn what_is_no_recipe_is_refused_with_the_reason() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("r.json");
        let wrong = [
            ("{\"lens\": 3}", "invalid type"),
            ("[]", "no JSON object"),
            ("{\"version\": 3}", "version 3"),
            ("{\"version\": \"new\"}", "no number"),
            ("{\"version\": 2, \"lens\": {\"f_number\": 1e39}}", "out of range"),
            ("{\"version\": 2, \"lens\": {\"f_number\": -2}}", "f_number"),
            ("{\"version\": 2, \"lens\": {\"focus\": {\"at\": [7, 0]}}}", "focus"),
            ("{\"version\": 2, \"lens\": {\"focus\": {\"through\": [[7, 0]]}}}", "one to three places"),
            ("{\"version\": 2, \"lens\": {\"strength\": 0}}", "strength"),
            ("{\"version\": 2, \"lens\": {\"distance\": {\"of\": \"subject\", \"metres\": 0}}}", "distance"),
            ("{\"version\": 2, \"lens\": {\"glass\": {\"swirl\": 7}}}", "swirl"),
            ("{\"version\": 2, \"lens\": {\"grain\": NaN}}", "expected value"),
            ("{\"export\": {\"quality\": 0}}", "quality"),
        ];
        for (text, why) in wrong {
            std::fs::write(&path, text).unwrap();
            let said = Recipe::read(&path).unwrap_err().to_string();
            assert!(said.contains(why) && said.contains(" — "), "{text}: {said}");
        }
        assert!(matches!(Recipe::read(&dir.path().join("none.json")), Err(RecipeError::Read { .. })));
    }

    #[test]
    fn names_follow_the_template_and_stay_in_their_folder() {
        let named = |name: &str, edit: &Edit| {
            let settings = PictureSettings { name: name.to_owned(), ..PictureSettings::default() };
            settings.file_name(Path::new("/a/rose.heic"), edit)
        };
        assert_eq!(named("{name}-f{f}", &edit()), "rose-f4.7.jpg");
        assert_eq!(named("../{name}", &edit()), "..-rose.jpg");
        assert_eq!(named("..", &edit()), "rose.jpg");
        assert_eq!(named("{focus}", &edit()), "25x75.jpg");
        assert_eq!(named("{focus}", &Edit { focus: Focus::Disparity(1e-3), ..edit() }), "+0.54.jpg");
    }
}
