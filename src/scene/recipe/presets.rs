//! Presets: lens and export under a name, each a small recipe that can be sent.

use std::path::{Path, PathBuf};

use super::{Recipe, RecipeError};
use crate::scene::Edit;
use crate::within;

/// How the files end.
const ENDING: &str = "json";
/// More are not listed.
const MOST: usize = 500;

/// A folder of presets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Presets {
    folder: PathBuf,
}

impl Presets {
    /// Those of a folder, which may not be there yet.
    pub fn of(folder: PathBuf) -> Self {
        Self { folder }
    }

    /// The person's own; none where the system names no place for them.
    pub fn user() -> Option<Self> {
        Some(Self::of(directories::ProjectDirs::from("", "", "plenoscope")?.config_dir().join("presets")))
    }

    /// Their names, in order.
    pub fn names(&self) -> Vec<String> {
        let files = std::fs::read_dir(&self.folder).into_iter().flatten().flatten().take(MOST);
        let name = |path: &Path| {
            let is_preset = path.extension().is_some_and(|ending| ending == ENDING) && path.is_file();
            path.file_stem().filter(|_| is_preset)?.to_str().map(str::to_owned)
        };
        let mut names: Vec<String> = files.filter_map(|entry| name(&entry.path())).collect();
        names.sort_by_key(|name| name.to_lowercase());
        names
    }

    /// Where one lies.
    ///
    /// # Errors
    /// The name cannot be one of a file.
    pub fn path(&self, name: &str) -> Result<PathBuf, RecipeError> {
        let file = format!("{}.{ENDING}", name.trim());
        let is_good = within::is_plain_name(&file) && !name.trim().is_empty() && !name.trim().starts_with('.');
        let path = self.folder.join(&file);
        let why = || "a preset's name is one of a file, without / and the like".to_owned();
        is_good.then_some(path).ok_or_else(|| RecipeError::Parse { why: why(), path: file.into() })
    }

    /// One of them.
    ///
    /// # Errors
    /// [`RecipeError`]: it is not there, or no recipe.
    pub fn read(&self, name: &str) -> Result<Recipe, RecipeError> {
        Recipe::read(&self.path(name)?)
    }

    /// Keeps lens and export of a recipe under a name, in place of what had it. What belongs to one photo stays out.
    ///
    /// # Errors
    /// [`RecipeError`]; then what was there is as it was.
    pub fn keep(&self, name: &str, recipe: &Recipe) -> Result<(), RecipeError> {
        let path = self.path(name)?;
        let failed = |error: std::io::Error| RecipeError::Read { why: error.to_string(), path: path.clone() };
        std::fs::create_dir_all(&self.folder).map_err(failed)?;
        Recipe::new(recipe.edit(1).for_new_photo(), recipe.export.clone()).write(&path)
    }

    /// Takes one away.
    ///
    /// # Errors
    /// The system's.
    pub fn remove(&self, name: &str) -> Result<(), RecipeError> {
        let path = self.path(name)?;
        std::fs::remove_file(&path).map_err(|error| RecipeError::Read { why: error.to_string(), path })
    }
}

impl Recipe {
    /// A recipe from its file, or from the preset of that name, where there is no file.
    ///
    /// # Errors
    /// [`RecipeError`], of the file.
    pub fn named(path: &Path, presets: Option<&Presets>) -> Result<Self, RecipeError> {
        let preset = || presets?.path(path.to_str()?).ok().filter(|preset| preset.is_file());
        match (path.exists(), preset()) {
            (false, Some(preset)) => Self::read(&preset),
            _ => Self::read(path),
        }
    }

    /// An edit with the lens of a preset: what belongs to its photo stays.
    pub fn lens_over(&self, edit: &Edit) -> Edit {
        let Edit { f_number, shape, highlights, grain, glass, .. } = self.edit(1);
        Edit { f_number, shape, highlights, grain, glass, ..edit.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::FNumber;
    use crate::scene::Focus;
    use crate::scene::recipe::PictureSettings;

    #[test]
    fn a_preset_keeps_lens_and_export_and_nothing_of_its_photo() {
        let dir = tempfile::tempdir().unwrap();
        let presets = Presets::of(dir.path().join("presets"));
        assert!(presets.names().is_empty());
        let edit = Edit { f_number: FNumber(1.8), focus: Focus::At([0.2, 0.3]), pivot: 1e-3, ..Edit::default() };
        let recipe = Recipe::new(edit.clone(), PictureSettings { quality: 70, ..PictureSettings::default() });
        presets.keep("For the web", &recipe).unwrap();
        presets.keep("b", &recipe).unwrap();
        assert_eq!(presets.names(), ["b", "For the web"]);
        let read = Recipe::named(Path::new("For the web"), Some(&presets)).unwrap();
        assert_eq!((read.export.quality, read.edit(1).focus), (70, Focus::Subject));
        let here = Edit { f_number: FNumber(5.6), focus: Focus::At([0.9, 0.9]), ..Edit::default() };
        assert_eq!(read.lens_over(&here), Edit { f_number: FNumber(1.8), ..here });
        presets.remove("b").unwrap();
        assert!(presets.read("b").is_err() && Recipe::named(Path::new("b"), Some(&presets)).is_err());
        for name in ["", "../x", "a/b", ".hidden", "c:d"] {
            assert!(presets.keep(name, &recipe).is_err(), "{name:?}");
        }
        assert_eq!(dir.path().read_dir().unwrap().count(), 1);
    }
}
