//! numpy arrays: windows onto the library's own memory, and pictures that are the caller's.
//!
//! A window is told to numpy by its array interface (address, shape, strides), and keeps its owner alive. It can only be
//! read. Alpha is in the memory and not in the window.

use std::sync::Arc;

use plenoscope::field::{DisparityMap, LightField, Photo, PhotoPixels, Pixels, RayDepths, Samples};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyDict, PyTuple};

/// Channels in memory, red, green, blue and alpha; and those that are shown.
const STORED: usize = 4;
const SHOWN: usize = 3;

/// What owns the memory.
enum Owner {
    Views(Arc<LightField>),
    Depths(Arc<RayDepths>),
    Photo(Arc<Photo>),
}

/// Memory of the library that numpy looks at.
#[pyclass(frozen, module = "plenoscope._native")]
pub struct Memory {
    owner: Owner,
    item_bytes: usize,
    kind: char,
    shape: Vec<usize>,
}

#[pymethods]
impl Memory {
    /// The array interface, version 3.
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let is_read_only = true;
        let interface = PyDict::new(py);
        interface.set_item("version", 3)?;
        interface.set_item("shape", PyTuple::new(py, &self.shape)?)?;
        interface.set_item("strides", PyTuple::new(py, self.strides())?)?;
        interface.set_item("typestr", type_text(self.kind, self.item_bytes))?;
        interface.set_item("data", (self.address(), is_read_only))?;
        Ok(interface)
    }
}

impl Memory {
    fn address(&self) -> usize {
        match &self.owner {
            Owner::Views(field) => field.block().unwrap_or_default().as_ptr().expose_provenance(),
            Owner::Depths(depths) => depths.disparity_px().as_ptr().expose_provenance(),
            Owner::Photo(photo) => match photo.pixels() {
                PhotoPixels::Eight(px) => px.as_ptr().expose_provenance(),
                PhotoPixels::Sixteen(px) => px.as_ptr().expose_provenance(),
            },
        }
    }

    /// Bytes from one element to the next along each axis; pixels have a channel that is not shown.
    fn strides(&self) -> Vec<usize> {
        let mut step = self.item_bytes;
        let mut strides: Vec<usize> = Vec::with_capacity(self.shape.len());
        for (n, side) in self.shape.iter().enumerate().rev() {
            strides.push(step);
            let is_channels = n + 1 == self.shape.len() && !matches!(self.owner, Owner::Depths(_));
            step *= if is_channels { STORED } else { *side };
        }
        strides.reverse();
        strides
    }

    fn array(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        py.import("numpy")?.call_method1("asarray", (Bound::new(py, self)?,))
    }
}

fn type_text(kind: char, item_bytes: usize) -> String {
    let order = if cfg!(target_endian = "big") { '>' } else { '<' };
    format!("{order}{kind}{item_bytes}")
}

fn sides(size: [u32; 2]) -> [usize; 2] {
    [size[1] as usize, size[0] as usize]
}

/// All views, `[v, u, y, x, c]`, sRGB bytes, where they lie. They must lie in one block.
pub fn views<'py>(py: Python<'py>, field: &Arc<LightField>) -> PyResult<Bound<'py, PyAny>> {
    let [y, x] = sides(field.size());
    let shape = vec![field.grid().rows(), field.grid().cols(), y, x, SHOWN];
    Memory { owner: Owner::Views(Arc::clone(field)), item_bytes: 1, kind: 'u', shape }.array(py)
}

/// The disparity of every ray, `[v, u, y, x]`, where it lies.
pub fn depths<'py>(py: Python<'py>, depths: &Arc<RayDepths>) -> PyResult<Bound<'py, PyAny>> {
    let [y, x] = sides(depths.size());
    let shape = vec![depths.grid().rows(), depths.grid().cols(), y, x];
    Memory { owner: Owner::Depths(Arc::clone(depths)), item_bytes: 4, kind: 'f', shape }.array(py)
}

/// The photo's own pixels, `[y, x, c]`, where they lie.
pub fn photo<'py>(py: Python<'py>, photo: &Arc<Photo>) -> PyResult<Bound<'py, PyAny>> {
    let [y, x] = sides(photo.size());
    let item_bytes = usize::from(photo.pixels().bits() / 8);
    Memory { owner: Owner::Photo(Arc::clone(photo)), item_bytes, kind: 'u', shape: vec![y, x, SHOWN] }.array(py)
}

/// A picture as it stands in a file, `[y, x, c]`; the caller's own.
pub fn picture<'py>(py: Python<'py>, pixels: &Pixels) -> PyResult<Bound<'py, PyAny>> {
    let [y, x] = sides(pixels.size);
    let shape = [y, x, SHOWN];
    match &pixels.samples {
        Samples::Eight(px) => own(py, px.as_slice(), 'u', &shape, |v| v.to_ne_bytes()),
        Samples::Sixteen(px) => own(py, px.as_slice(), 'u', &shape, |v| v.to_ne_bytes()),
    }
}

/// A map, `[y, x]`; the caller's own.
pub fn map<'py>(py: Python<'py>, map: &DisparityMap) -> PyResult<Bound<'py, PyAny>> {
    own(py, map.disparity_px(), 'f', &sides(map.size()), |v| v.to_ne_bytes())
}

fn own<'py, T: Copy, const BYTES: usize>(
    py: Python<'py>,
    values: &[T],
    kind: char,
    shape: &[usize],
    bytes_of: impl Fn(T) -> [u8; BYTES],
) -> PyResult<Bound<'py, PyAny>> {
    let bytes = PyByteArray::new_with(py, values.len() * BYTES, |out| {
        out.as_chunks_mut().0.iter_mut().zip(values).for_each(|(out, value)| *out = bytes_of(*value));
        Ok(())
    })?;
    let flat = py.import("numpy")?.call_method1("frombuffer", (bytes, type_text(kind, BYTES)))?;
    flat.call_method1("reshape", (PyTuple::new(py, shape)?,))
}

/// What an array holds: its sides, and its bytes in order.
pub struct Given {
    /// Length of each axis.
    pub shape: Vec<usize>,
    /// The values, last axis first, as the machine stores them.
    pub bytes: Vec<u8>,
}

/// The values of an array-like as a type of numpy's.
pub fn given(array: &Bound<'_, PyAny>, dtype: &str) -> PyResult<Given> {
    let numpy = array.py().import("numpy")?;
    let array = numpy.call_method1("ascontiguousarray", (array, dtype))?;
    Ok(Given { shape: array.getattr("shape")?.extract()?, bytes: array.call_method0("tobytes")?.extract()? })
}

/// Whether something is an array.
pub fn is_array(value: &Bound<'_, PyAny>) -> PyResult<bool> {
    value.hasattr("__array__")
}

impl Given {
    /// The values as numbers.
    pub fn floats(&self) -> Vec<f32> {
        self.bytes.as_chunks().0.iter().map(|four| f32::from_ne_bytes(*four)).collect()
    }

    /// Pixels with alpha, of three or four channels.
    pub fn rgba(self) -> Vec<u8> {
        match self.shape.last() {
            Some(&STORED) => self.bytes,
            _ => self.bytes.chunks_exact(SHOWN).flat_map(|rgb| [rgb[0], rgb[1], rgb[2], u8::MAX]).collect(),
        }
    }
}
