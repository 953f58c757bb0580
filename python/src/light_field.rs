//! Light fields: made, opened, given as arrays, and written.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use plenoscope::field::{self, RayDepths, ViewGrid};
use plenoscope::io::formats::layout::Layout;
use plenoscope::scene::asked::{self, How};
use plenoscope::scene::export::{self, Settings};
use plenoscope::scene::{Content, Edit, Need, Recorded, Scene, Subject};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{of_argument, raised, wrong_type};
use crate::input::{Input, progress};
use crate::options::Options;
use crate::photo::Photo;
use crate::run::run;
use crate::{arrays, making};

/// A light field: views, and the disparity of every ray.
#[pyclass(frozen, module = "plenoscope")]
pub struct LightField {
    subject: Arc<Subject>,
    /// Made at the first need where the light field was recorded.
    scene: OnceLock<Scene>,
}

impl LightField {
    fn of_scene(scene: Scene) -> Self {
        let scene = scene.in_one_block();
        Self { subject: Arc::clone(scene.subject()), scene: scene.into() }
    }

    /// Of what was recorded; its ray depths are measured when they are asked for, where it has none.
    fn of_subject(subject: Subject) -> Self {
        Self { subject: Arc::new(subject.in_one_block()), scene: OnceLock::new() }
    }

    /// Its views with the disparity of every ray.
    pub fn scene(&self, py: Python<'_>, progress: Option<&Py<PyAny>>) -> PyResult<&Scene> {
        if let Some(scene) = self.scene.get() {
            return Ok(scene);
        }
        let how = How::new(making::usual(), None, None);
        let maker = making::maker(&Options(&PyDict::new(py)))?;
        let scene = run(py, progress, |job| how.scene(&self.subject, maker, Need::Views, job))?;
        Ok(self.scene.get_or_init(|| scene.in_one_block()))
    }

    /// Its views, which need no depths.
    fn field(&self) -> Option<&Arc<field::LightField>> {
        let made = self.scene.get().and_then(Scene::views).map(|views| &views.field);
        made.or_else(|| self.subject.recorded().map(|recorded| &recorded.shown))
    }

    fn grid_of_views(&self) -> ViewGrid {
        self.field().map_or(ViewGrid::PAPER, |field| field.grid())
    }
}

#[pymethods]
impl LightField {
    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.subject.name
    }

    /// The file or folder that it, or its photo, came from; None where there is none.
    #[getter]
    fn path(&self) -> Option<PathBuf> {
        self.subject.path.clone()
    }

    /// Rows and columns of views.
    #[getter]
    fn grid(&self) -> (usize, usize) {
        (self.grid_of_views().rows(), self.grid_of_views().cols())
    }

    /// Width and height of a view, in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        self.field().map_or(self.subject.size(), |field| field.size()).into()
    }

    /// Row and column of the view that was the photo, or of the middle one.
    #[getter]
    fn reference(&self) -> (u8, u8) {
        let at = self.grid_of_views().reference();
        (at.v, at.u)
    }

    /// Who made it.
    #[getter]
    fn made_by(&self) -> Option<String> {
        self.scene.get().map(Scene::made_by)
    }

    /// Whether its depths are known already, so that looking at them takes no time.
    #[getter]
    fn has_depths(&self) -> bool {
        let is_recorded = |recorded: &Recorded| recorded.depths.is_some() || recorded.reference.is_some();
        self.scene.get().is_some() || self.subject.recorded().is_some_and(is_recorded)
    }

    /// All views, uint8 `[v, u, y, x, c]`, sRGB. A window onto memory: to be read only.
    #[getter]
    fn views<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        match self.field() {
            Some(field) => arrays::views(py, field),
            None => Ok(py.None().into_bound(py)),
        }
    }

    /// The disparity of every ray, float32 `[v, u, y, x]`, in pixels per view step. A window onto memory: to be read
    /// only. Where a recorded light field has none, they are measured at the first look.
    #[getter]
    fn depths<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let made = self.scene(py, None)?.made_views();
        arrays::depths(py, &made.map_err(|error| raised(py, error))?.depths)
    }

    fn __repr__(&self) -> String {
        let ((rows, columns), (width, height)) = (self.grid(), self.size());
        format!("<plenoscope.LightField {:?}, {rows}×{columns} views of {width}×{height}>", self.subject.name)
    }
}

/// Opens a photo or a recorded light field.
#[pyfunction]
pub fn open(py: Python<'_>, path: PathBuf, options: &Bound<'_, PyDict>) -> PyResult<Py<PyAny>> {
    let options = Options(options);
    let subject = run(py, progress(&options)?.as_ref(), |job| Subject::open(&path, job))?;
    Ok(match subject.photo() {
        Some(_) => Py::new(py, Photo { subject: Arc::new(subject) })?.into_any(),
        None => Py::new(py, LightField::of_subject(subject))?.into_any(),
    })
}

/// The built-in sample.
#[pyfunction]
pub fn sample(py: Python<'_>) -> PyResult<Photo> {
    Ok(Photo { subject: Arc::new(run(py, None, |_| Subject::sample())?) })
}

/// Makes a light field of a photo.
#[pyfunction]
pub fn synthesize(py: Python<'_>, input: &Bound<'_, PyAny>, options: &Bound<'_, PyDict>) -> PyResult<LightField> {
    let options = Options(options);
    let (how, maker) = (making::how(py, &options)?, making::maker(&options)?);
    let input = Input::of(input, &options)?;
    let scene = run(py, progress(&options)?.as_ref(), |job| {
        let subject = input.subject(&how, job)?;
        asked::check_is_photo(&subject)?;
        how.scene(&subject, maker, Need::Views, job)
    })?;
    Ok(LightField::of_scene(scene))
}

/// A light field of sRGB views, uint8 `[v, u, y, x, c]`, with the disparity of every ray, `[v, u, y, x]`, or None.
#[pyfunction]
pub fn light_field(views: &Bound<'_, PyAny>, depths: Option<&Bound<'_, PyAny>>, name: &str) -> PyResult<LightField> {
    let py = views.py();
    let odd = |error| raised(py, plenoscope::scene::SceneError::Field(error));
    let given = arrays::given(views, "uint8")?;
    let &[rows, columns, height, width, 3 | 4] = given.shape.as_slice() else {
        return Err(wrong_type("views", "an array [v, u, y, x, c] of 3 or 4 channels", views));
    };
    let (grid, size) = (ViewGrid::new(rows, columns).map_err(odd)?, [width as u32, height as u32]);
    let shown = Arc::new(field::LightField::from_block(grid, size, given.rgba()).map_err(odd)?);
    let depths = depths.map(|depths| {
        let given = arrays::given(depths, "float32")?;
        match given.shape == [rows, columns, height, width] {
            true => Ok(Arc::new(RayDepths::new(grid, size, given.floats()).map_err(odd)?)),
            false => Err(wrong_type("depths", "an array [v, u, y, x] of the views' sides", depths)),
        }
    });
    let recorded = Recorded {
        shown,
        stored: None,
        depths: depths.transpose()?,
        reference: None,
        provenance: None,
        layout: Layout::default(),
    };
    let content = Content::Views(recorded);
    Ok(LightField::of_subject(Subject { name: name.to_owned(), path: None, file: None, info: None, content }))
}

/// Writes a light field, and says where.
#[pyfunction]
pub fn write_light_field(
    py: Python<'_>,
    input: &Bound<'_, PyAny>,
    output: PathBuf,
    options: &Bound<'_, PyDict>,
) -> PyResult<PathBuf> {
    let options = Options(options);
    let (how, maker) = (making::how(py, &options)?, making::maker(&options)?);
    let format: String = options.get("format", "a name")?.unwrap_or_else(|| "views".to_owned());
    let kind = asked::field_format(&format).map_err(|usage| of_argument(py, "format", usage))?;
    let force = options.is_on("force")?;
    let input = Input::of(input, &options)?;
    run(py, progress(&options)?.as_ref(), |job| {
        let settings = Settings { kind, replaces_source: force, ..Settings::default() };
        let subject = input.subject(&how, job)?;
        let target = asked::field_target(&output, &settings, &subject.name);
        input.output(&target, force).check_written(kind)?;
        let scene = match &input {
            Input::Made(scene) => how.made(scene, job)?,
            _ => how.scene(&subject, maker, Need::Views, job)?,
        };
        asked::make_folder(&target)?;
        export::write(&scene, &Edit::default(), &settings, &target, job)?;
        Ok(target)
    })
}
