//! Errors and arrays across the border.

use kinmo_geometry::GeometryError;
use pyo3::PyErr;
use pyo3::exceptions::PyValueError;

/// A refused input becomes a `ValueError` whose message starts with the argument's name.
pub fn value_error(error: GeometryError) -> PyErr {
    PyValueError::new_err(error.to_string())
}
