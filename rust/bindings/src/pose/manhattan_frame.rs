//! `manhattan_frames`: Manhattan frames of scans.

use kinmo_geometry::pose::manhattan_frame::manhattan_frame;
use nalgebra::Point3;
use numpy::ndarray::Axis;
use numpy::{PyArray3, PyArrayMethods};
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, array_of_rows, clouds_of, flags_of, triples_of_cloud};
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
    let scans = clouds_of("points", points.view()).map_err(value_error)?;
    let (frames, count) = (scans.len_of(Axis(0)), scans.len_of(Axis(1)));
    let mask = flags_of("mask", &mask, &[frames, count])?;
    let clouds = scans.outer_iter().enumerate().map(|(frame, scan)| {
        let counted = triples_of_cloud(scan).into_iter().zip(&mask[frame * count..]).filter(|(_, counts)| **counts);
        counted.map(|(point, _)| Point3::from(point).cast::<f64>()).collect::<Vec<_>>()
    });
    let frames = map_in_batches(py, clouds, |points| manhattan_frame(&points))?;
    // nalgebra stores matrices column by column.
    let rows = frames.iter().flat_map(|frame| frame.matrix().transpose().data.0);
    array_of_rows(py, rows)?.reshape([frames.len(), 3, 3])
}
