//! The library's sentences as exceptions; the classes stand in `plenoscope/_errors.py`.

use plenoscope::errors::one_line;
use plenoscope::scene::SceneError;
use plenoscope::scene::asked::Usage;
use plenoscope::scene::recipe::RecipeError;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

/// The exception of an error, with the sentence that the command line prints.
pub fn raised(py: Python<'_>, error: impl Into<SceneError>) -> PyErr {
    let error = error.into();
    let class = match &error {
        SceneError::Usage(_) | SceneError::Field(_) => "UsageError",
        SceneError::Recipe(RecipeError::Parse { .. }) => "UsageError",
        SceneError::Open(_) | SceneError::Save(_) | SceneError::Recipe(_) => "FileError",
        _ => "Error",
    };
    let text = one_line(&error);
    let made = py.import("plenoscope._errors").and_then(|module| module.getattr(class)?.call1((text,)));
    made.map_or_else(|broken| broken, PyErr::from_value)
}

/// A value that cannot be, with the name of its argument.
pub fn of_argument(py: Python<'_>, name: &str, Usage(text): Usage) -> PyErr {
    raised(py, Usage(format!("{name}: {text}")))
}

/// A value of the wrong type, with the name of its argument.
pub fn wrong_type(name: &str, wanted: &str, got: &Bound<'_, PyAny>) -> PyErr {
    let got = got.get_type().name().map_or_else(|_nameless| "something else".to_owned(), |name| name.to_string());
    PyTypeError::new_err(format!("{name}: {wanted} is wanted, not {got}"))
}
