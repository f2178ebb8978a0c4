//! `neighbour_argmax`: feature-wise maximum over neighbours.

use kinmo_geometry::GeometryError;
use kinmo_geometry::points::neighbour_maximum::neighbour_argmax as largest_of_rows;
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, shape_error, zeros};
use crate::batches::map_in_batches;
use crate::errors::value_error;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(neighbour_argmax, module)?)
}

#[pyfunction]
fn neighbour_argmax<'py>(
    py: Python<'py>,
    features: Array<'py, f32>,
    index: Array<'py, i64>,
) -> PyResult<Bound<'py, PyArrayDyn<i64>>> {
    let (features, index) = (features.view(), index.view());
    let [batch, size, width] = *features.shape() else {
        return Err(value_error(shape_error("features", &features, "[B, N, C]")));
    };
    if !matches!(*index.shape(), [clouds, _, count] if clouds == batch && count > 0) {
        return Err(value_error(shape_error("index", &index, &format!("[{batch}, M, K] with K > 0"))));
    }
    let [rows, count] = [1, 2].map(|axis| index.shape()[axis]);
    if !index.iter().all(|number| (0..size as i64).contains(number)) {
        return Err(value_error(GeometryError::new("index", format!("expected integers from 0, below {size}"))));
    }
    let (features, index) = (features.as_standard_layout(), index.as_standard_layout());
    let (Some(values), Some(numbers)) = (features.as_slice(), index.as_slice()) else {
        unreachable!("the standard layout has no gaps")
    };
    let largest = zeros(py, &[batch, rows, width])?;
    {
        let mut found = largest.readwrite();
        let clouds = values
            .chunks((size * width).max(1))
            .zip(numbers.chunks((rows * count).max(1)))
            .zip(found.as_slice_mut()?.chunks_mut((rows * width).max(1)));
        map_in_batches(py, clouds, |((features, index), found)| {
            let index: Vec<u32> = index.iter().map(|&number| number as u32).collect();
            largest_of_rows(features, width, &index, count, found);
        })?;
    }
    Ok(largest)
}
