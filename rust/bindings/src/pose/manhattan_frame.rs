//! `manhattan_frames`: Manhattan frames of scans.

use kinmo_geometry::pose::manhattan_frame::manhattan_frame;
use nalgebra::Point3;
use numpy::ndarray::Axis;
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, check_finite, flags_of, stacks_of};
use crate::batches::map_in_batches;
use crate::errors::value_error;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(manhattan_frames, module)?)
}

#[pyfunction]
fn manhattan_frames<'py>(
    py: Python<'py>,
    points: Array<'py, f32>,
    mask: Array<'py, bool>,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let points = points.view();
    check_finite("points", &points).map_err(value_error)?;
    let scans = stacks_of("points", points, 3).map_err(value_error)?;
    let (frames, count) = (scans.len_of(Axis(0)), scans.len_of(Axis(1)));
    let mask = flags_of("mask", &mask, &[frames, count])?;
    let clouds = (0..frames).map(|frame| {
        let scan = scans.index_axis(Axis(0), frame);
        let counted = scan.rows().into_iter().zip(&mask[frame * count..]).filter(|(_, counts)| **counts);
        counted.map(|(row, _)| Point3::new(row[0], row[1], row[2]).cast::<f64>()).collect::<Vec<_>>()
    });
    let frames = map_in_batches(py, clouds, |points| manhattan_frame(&points))?;
    // nalgebra stores matrices column by column.
    let rows = frames.iter().flat_map(|frame| frame.matrix().transpose().data.0).flatten();
    PyArray1::from_iter(py, rows).reshape([frames.len(), 3, 3])
}
