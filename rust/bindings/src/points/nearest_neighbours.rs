//! `nearest_neighbours`: nearest neighbours of every point of small clouds.

use kinmo_geometry::points::nearest_neighbours::nearest_neighbours as nearest_of_rows;
use numpy::ndarray::Axis;
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, clouds_of, triples_of_cloud, zeros};
use crate::arguments::numbers::{count_of, integer};
use crate::batches::map_in_batches;
use crate::errors::value_error;

/// Largest allowed number of neighbours. The result has no more of them than there are points.
const MAX_NEIGHBOURS: usize = u32::MAX as usize;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(nearest_neighbours, module)?)
}

#[pyfunction]
fn nearest_neighbours<'py>(
    py: Python<'py>,
    points: Array<'py, f32>,
    #[pyo3(from_py_with = integer)] count: i64,
) -> PyResult<Bound<'py, PyArrayDyn<i64>>> {
    let count = count_of("count", count, MAX_NEIGHBOURS).map_err(value_error)?;
    let clouds = clouds_of("points", points.view()).map_err(value_error)?;
    let (batch, size) = (clouds.len_of(Axis(0)), clouds.len_of(Axis(1)));
    let nearest = zeros(py, &[batch, size, count.min(size)])?;
    {
        let mut found = nearest.readwrite();
        let rows = clouds
            .outer_iter()
            .map(triples_of_cloud)
            .zip(found.as_slice_mut()?.chunks_mut((size * count.min(size)).max(1)));
        map_in_batches(py, rows, |(points, found)| nearest_of_rows(&points, count, found))?;
    }
    Ok(nearest)
}
