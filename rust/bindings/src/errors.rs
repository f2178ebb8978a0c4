//! Conversion of Rust errors to Python exceptions.

use kinmo_geometry::GeometryError;
use pyo3::PyErr;
use pyo3::exceptions::PyValueError;

/// Converts an input error to a `ValueError`. Its message starts with the name of the argument.
pub fn value_error(error: GeometryError) -> PyErr {
    PyValueError::new_err(error.to_string())
}
