//! Keyword arguments that were given, each looked up by its name and checked by the library.

use plenoscope::scene::asked::Usage;
use pyo3::conversion::FromPyObjectOwned;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors;

/// The keyword arguments of a call; `None` is as good as not given.
pub struct Options<'a, 'py>(pub &'a Bound<'py, PyDict>);

impl<'py> Options<'_, 'py> {
    /// The value of a name, as it came.
    pub fn any(&self, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        Ok(self.0.get_item(name)?.filter(|value| !value.is_none()))
    }

    /// The value of a name as `T`; `wanted` says in words what that is.
    pub fn get<T: FromPyObjectOwned<'py>>(&self, name: &str, wanted: &str) -> PyResult<Option<T>> {
        let of_type =
            |value: Bound<'py, PyAny>| value.extract::<T>().map_err(|_not_so| errors::wrong_type(name, wanted, &value));
        self.any(name)?.map(of_type).transpose()
    }

    /// The same, brought to what the library takes.
    pub fn checked<T, U>(&self, name: &str, wanted: &str, check: impl Fn(T) -> Result<U, Usage>) -> PyResult<Option<U>>
    where
        T: FromPyObjectOwned<'py>,
    {
        let check = |value| check(value).map_err(|usage| errors::of_argument(self.0.py(), name, usage));
        self.get(name, wanted)?.map(check).transpose()
    }

    /// Whether a switch is on.
    pub fn is_on(&self, name: &str) -> PyResult<bool> {
        Ok(self.get(name, "True or False")?.unwrap_or(false))
    }
}
