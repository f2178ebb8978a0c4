//! `nearest_neighbours`.

use kinmo_geometry::neighbours::nearest_neighbours as nearest_of_all;
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

use crate::arrays::{Array, check_finite, stacks_of};
use crate::batches::map_in_batches;
use crate::convert::value_error;
use crate::numbers::{count_of, integer};

/// Most neighbours that may be asked for; there are no more than points.
const MOST_NEIGHBOURS: usize = u32::MAX as usize;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(nearest_neighbours, module)?)
}

#[pyfunction]
fn nearest_neighbours<'py>(
    py: Python<'py>,
    points: Array<'py, f32>,
    #[pyo3(from_py_with = integer)] count: i64,
) -> PyResult<Bound<'py, PyArray3<i64>>> {
    let count = count_of("count", count, MOST_NEIGHBOURS).map_err(value_error)?;
    let points = points.view();
    check_finite("points", &points).map_err(value_error)?;
    let clouds = stacks_of("points", points, 3).map_err(value_error)?;
    let [batch, size, _] = *clouds.shape() else { unreachable!("a stack has three axes") };
    let rows = clouds
        .outer_iter()
        .map(|cloud| cloud.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect::<Vec<_>>());
    let found = map_in_batches(py, rows, |points| nearest_of_all(&points, count))?;
    let numbers = found.into_iter().flatten().map(i64::from);
    PyArray1::from_iter(py, numbers).reshape([batch, size, count.min(size)])
}
