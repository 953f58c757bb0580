//! Recipes: edits as small JSON files.

use std::path::PathBuf;

use plenoscope::scene::asked::Usage;
use plenoscope::scene::{self};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{raised, wrong_type};
use crate::options::Options;

/// An edit, and how its pictures are kept: the small JSON that the window keeps beside a photo.
#[pyclass(frozen, module = "plenoscope")]
pub struct Recipe {
    pub(crate) recipe: scene::Recipe,
}

#[pymethods]
impl Recipe {
    /// Recipe(settings): of a dictionary that is laid out as the file is.
    #[new]
    fn new(settings: &Bound<'_, PyDict>) -> PyResult<Self> {
        let py = settings.py();
        let text: String = py.import("json")?.call_method1("dumps", (settings,))?.extract()?;
        Self::from_json(py, &text)
    }

    /// Reads a file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        scene::Recipe::read(&path).map(|recipe| Self { recipe }).map_err(|error| raised(py, error))
    }

    /// The recipe that the window keeps beside a photo, `photo.jpg.plenoscope.json`; None where there is none.
    #[staticmethod]
    fn of_photo(py: Python<'_>, path: PathBuf) -> PyResult<Option<Self>> {
        let found = scene::Recipe::of_photo(&path).map_err(|error| raised(py, error))?;
        Ok(found.map(|recipe| Self { recipe }))
    }

    /// Of JSON text.
    #[staticmethod]
    fn from_json(py: Python<'_>, text: &str) -> PyResult<Self> {
        let recipe = scene::Recipe::from_json(text);
        recipe
            .map(|recipe| Self { recipe })
            .map_err(|why| raised(py, Usage(format!("this recipe cannot be used — {why}"))))
    }

    /// As JSON text.
    fn to_json(&self) -> String {
        self.recipe.to_json()
    }

    /// As a dictionary.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.call_method1("loads", (self.to_json(),))
    }

    /// Writes a file, whole or not at all.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        self.recipe.write(&path).map_err(|error| raised(py, error))
    }

    /// Refocuses by this recipe: plenoscope.refocus(input, recipe=self, ...).
    #[pyo3(signature = (input, /, **options))]
    fn apply<'py>(
        slf: &Bound<'py, Self>,
        input: &Bound<'py, PyAny>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        let all = options.map_or_else(|| Ok(PyDict::new(py)), |options| options.copy())?;
        all.set_item("recipe", slf)?;
        py.import("plenoscope")?.getattr("refocus")?.call((input,), Some(&all))
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| other.get().to_json() == self.to_json())
    }

    /// Processes and machines hand recipes to each other as JSON.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((slf.get_type().getattr("from_json")?, (slf.get().to_json(),)))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("plenoscope.Recipe({})", self.as_dict(py)?.repr()?))
    }
}

/// The recipe that was asked for: one, or a file.
pub fn asked(py: Python<'_>, options: &Options) -> PyResult<Option<scene::Recipe>> {
    let Some(value) = options.any("recipe")? else { return Ok(None) };
    if let Ok(recipe) = value.cast::<Recipe>() {
        return Ok(Some(recipe.get().recipe.clone()));
    }
    let path: PathBuf = value.extract().map_err(|_no_path| wrong_type("recipe", "a Recipe or a file", &value))?;
    scene::Recipe::read(&path).map(Some).map_err(|error| raised(py, error))
}
