//! Numeric arguments. A value out of range is a `ValueError` that names the argument, however large the value is.

use kinmo_geometry::{GeometryError, Result};
use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;

use crate::errors::value_error;

/// A Python integer, clamped to the range of `i64`. All valid ranges lie well inside it.
pub fn integer(object: &Bound<'_, PyAny>) -> PyResult<i64> {
    match object.extract::<i64>() {
        Err(error) if error.is_instance_of::<PyOverflowError>(object.py()) => {
            Ok(if object.lt(0)? { i64::MIN } else { i64::MAX })
        }
        value => value,
    }
}

/// An index in a list, clamped as by [`integer`].
#[derive(Clone, Copy)]
pub struct Index(pub i64);

impl<'py> FromPyObject<'_, 'py> for Index {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        integer(&object).map(Self)
    }
}

/// A Python number. It becomes infinite if it exceeds the range of `f64`.
pub fn float(object: &Bound<'_, PyAny>) -> PyResult<f64> {
    match object.extract::<f64>() {
        Err(error) if error.is_instance_of::<PyOverflowError>(object.py()) => {
            Ok(if object.lt(0)? { f64::NEG_INFINITY } else { f64::INFINITY })
        }
        value => value,
    }
}

/// A seed for random draws.
pub fn seed(object: &Bound<'_, PyAny>) -> PyResult<u64> {
    match object.extract::<u64>() {
        Err(error) if error.is_instance_of::<PyOverflowError>(object.py()) => Err(value_error(GeometryError::new(
            "seed",
            format!("{object}, expected an integer from 0 to {}", u64::MAX),
        ))),
        value => value,
    }
}

/// A checked count from 1 to `most`.
pub fn count_of(argument: &str, count: i64, most: usize) -> Result<usize> {
    let checked = usize::try_from(count).ok().filter(|count| (1..=most).contains(count));
    checked.ok_or_else(|| GeometryError::new(argument, format!("{count}, expected an integer from 1 to {most}")))
}
