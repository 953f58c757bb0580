//! A photo.

use std::path::PathBuf;
use std::sync::Arc;

use plenoscope::field;
use plenoscope::scene::Subject;
use pyo3::prelude::*;

use crate::arrays;
use crate::errors::{raised, wrong_type};

/// A photo that is open: its pixels, and what is known of its depth.
#[pyclass(frozen, module = "plenoscope")]
pub struct Photo {
    pub(crate) subject: Arc<Subject>,
}

#[pymethods]
impl Photo {
    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.subject.name
    }

    /// The file; None for what was no file.
    #[getter]
    fn path(&self) -> Option<PathBuf> {
        self.subject.path.clone()
    }

    /// Width and height of the upright photo, in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        self.subject.size().into()
    }

    /// Its own pixels, uint8 or uint16 `[y, x, c]`, upright, in its own colours. A window onto memory: to be read only.
    #[getter]
    fn pixels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        match self.subject.photo() {
            Some(photo) => arrays::photo(py, photo),
            None => Ok(py.None().into_bound(py)),
        }
    }

    fn __repr__(&self) -> String {
        let [width, height] = self.subject.size();
        format!("<plenoscope.Photo {:?}, {width}×{height}>", self.subject.name)
    }
}

/// A photo of sRGB pixels, uint8 `[y, x, c]`.
#[pyfunction]
pub fn photo(pixels: &Bound<'_, PyAny>, name: &str) -> PyResult<Photo> {
    Ok(Photo { subject: of_array(pixels, name)? })
}

/// What is open, of an array.
pub fn of_array(pixels: &Bound<'_, PyAny>, name: &str) -> PyResult<Arc<Subject>> {
    let given = arrays::given(pixels, "uint8")?;
    let &[height, width, 3 | 4] = given.shape.as_slice() else {
        return Err(wrong_type("pixels", "an array [y, x, c] of 3 or 4 channels", pixels));
    };
    let photo = field::Photo::from_srgb8([width as u32, height as u32], given.rgba());
    let photo = photo.map_err(|error| raised(pixels.py(), error))?;
    Ok(Arc::new(Subject::from_photo(Arc::new(photo), name)))
}
