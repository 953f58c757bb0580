//! Pictures and maps of photos and light fields.

use std::path::PathBuf;

use plenoscope::field::{Pixels, Transfer, ViewOffset};
use plenoscope::io::save::{self, PictureOptions};
use plenoscope::scene::asked::{
    self, Asked, EPI_SCALE, EPI_SCALES, FocusAsked, LensAsked, Line, QUALITIES, Refocus, within,
};
use plenoscope::scene::{OutputSize, export};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{of_argument, raised, wrong_type};
use crate::input::{Input, progress};
use crate::options::Options;
use crate::run::run;
use crate::{arrays, making};

/// The picture that another lens would have taken; with `output` it is written too.
#[pyfunction]
pub fn refocus<'py>(
    py: Python<'py>,
    input: &Bound<'py, PyAny>,
    options: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    let options = Options(options);
    let (asked, how, maker) = (refocused(py, &options)?, making::how(py, &options)?, making::maker(&options)?);
    let output: Option<PathBuf> = options.get("output", "a file")?;
    let input = Input::of(input, &options)?;
    let pixels = run(py, progress(&options)?.as_ref(), |job| {
        if let Some(file) = &output {
            input.output(file, asked.replaces_source).check()?;
            save::check(file, &PictureOptions::default())?;
        }
        let Asked { scene, edit, settings } = match &input {
            Input::Made(scene) => asked.of_made(scene, &how, job)?,
            _ => asked.of(&input.subject(&how, job)?, &how, maker, job)?,
        };
        match &output {
            Some(file) => export::write_picture(&scene, &edit, &settings, file, job),
            None => scene.picture(&edit, settings.size(), settings.picture.bits, job),
        }
    })?;
    arrays::picture(py, &pixels)
}

/// What is asked for of a refocused picture.
fn refocused(py: Python<'_>, options: &Options) -> PyResult<Refocus> {
    let at = options.get::<(f32, f32)>("at", "a pair (u, v)")?;
    Ok(Refocus {
        embed: None,
        lens: lens(py, options)?,
        at: at.map(|(du, dv)| ViewOffset { dv, du }),
        size: size(py, options)?,
        quality: options.checked("quality", "a whole number", |n| within(n, &QUALITIES))?,
        bits: options.checked("bits", "a whole number", asked::bits)?,
        strip_metadata: options.is_on("strip_metadata")?,
        replaces_source: options.is_on("force")?,
    })
}

/// What is asked for of the lens.
fn lens(py: Python<'_>, options: &Options) -> PyResult<LensAsked> {
    let pair = |name: &str| {
        let both = |(a, b): (f32, f32)| Ok([asked::number(a)?, asked::number(b)?]);
        options.checked(name, "a pair of numbers", both)
    };
    let lens = LensAsked {
        f_number: options.checked("f_number", "a number", asked::f_number)?,
        focus: focus(options)?,
        focus_disparity_px: options.checked("focus_disparity", "a number", asked::number)?,
        shape: options.checked("lens", "a name", |name: String| asked::lens_shape(&name))?,
        keep_sharp_px: pair("keep_sharp")?.map(|[a, b]| [a.min(b), a.max(b)]),
        tilt_px: pair("tilt")?,
        highlights: options.checked("highlights", "a number", asked::share)?,
        grain: options.checked("grain", "a number", asked::share)?,
    };
    if lens.focus.is_some() && lens.focus_disparity_px.is_some() {
        let text = "focus cannot be used with focus_disparity — leave one of them out";
        return Err(raised(py, asked::Usage(text.to_owned())));
    }
    Ok(lens)
}

/// `"subject"`, or a pixel.
fn focus(options: &Options) -> PyResult<Option<FocusAsked>> {
    let is_subject = |value: Bound<'_, PyAny>| value.extract::<String>().is_ok_and(|text| text == "subject");
    if options.any("focus")?.is_some_and(is_subject) {
        return Ok(Some(FocusAsked::Subject));
    }
    let at = |(x, y): (f32, f32)| Ok(FocusAsked::At([asked::number(x)?, asked::number(y)?]));
    options.checked("focus", "a pair of numbers or \"subject\"", at)
}

/// `"photo"`, `"light-field"`, or a width and a height.
fn size(py: Python<'_>, options: &Options) -> PyResult<Option<OutputSize>> {
    let Some(value) = options.any("size")? else { return Ok(None) };
    let sides = value.extract::<(i64, i64)>().map(|(width, height)| format!("{width}x{height}"));
    let wanted = "\"photo\", \"light-field\" or (width, height)";
    let text = sides.or_else(|_no_pair| value.extract()).map_err(|_no_text| wrong_type("size", wanted, &value))?;
    asked::picture_size(&text).map(Some).map_err(|usage| of_argument(py, "size", usage))
}

/// The view from a place of the lens.
#[pyfunction]
pub fn view<'py>(
    py: Python<'py>,
    input: &Bound<'py, PyAny>,
    options: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    let options = Options(options);
    let (how, maker) = (making::how(py, &options)?, making::maker(&options)?);
    let (du, dv) = options.get("at", "a pair (u, v)")?.unwrap_or_default();
    let input = Input::of(input, &options)?;
    let picture = run(py, progress(&options)?.as_ref(), |job| {
        let at = ViewOffset { dv, du };
        asked::view(&input.scene(&how, maker, asked::view_need(at), job)?, at, job)
    })?;
    arrays::picture(py, &stored(&picture))
}

/// An epipolar slice.
#[pyfunction]
pub fn epi<'py>(
    py: Python<'py>,
    input: &Bound<'py, PyAny>,
    options: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    let options = Options(options);
    let (how, maker) = (making::how(py, &options)?, making::maker(&options)?);
    let (row, column) = (options.get("row", "a whole number")?, options.get("column", "a whole number")?);
    let line = Line::one_of(row, column).map_err(|usage| raised(py, usage))?;
    let scale = options.checked("scale", "a whole number", |n| within(n, &EPI_SCALES))?.unwrap_or(EPI_SCALE);
    let input = Input::of(input, &options)?;
    let picture = run(py, progress(&options)?.as_ref(), |job| {
        asked::epi(&input.scene(&how, maker, asked::epi_need(line), job)?, line, scale)
    })?;
    arrays::picture(py, &stored(&picture))
}

/// Linear light as sRGB bytes.
fn stored(picture: &plenoscope::field::Picture) -> Pixels {
    Pixels::from_linear(picture.size, &picture.rgb_linear, 8, &Transfer::srgb())
}

/// The map of a view.
#[pyfunction]
pub fn depth<'py>(
    py: Python<'py>,
    input: &Bound<'py, PyAny>,
    options: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    let options = Options(options);
    let (how, maker) = (making::how(py, &options)?, making::maker(&options)?);
    let view = options.get::<(f32, f32)>("view", "a pair (v, u)")?.map(|(v, u)| [v, u]);
    let input = Input::of(input, &options)?;
    let map = run(py, progress(&options)?.as_ref(), |job| {
        asked::depth(&input.scene(&how, maker, asked::depth_need(view), job)?, view)
    })?;
    arrays::map(py, &map)
}
