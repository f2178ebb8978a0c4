use kinmo_geometry::iou::{self, OrientedBox};
use kinmo_geometry::{GeometryError, Result};
use numpy::{PyArray1, PyReadonlyArrayDyn};
use pyo3::prelude::*;

use crate::arrays::{matrices_of, points_of, vectors_of};
use crate::convert::value_error;

type Array<'py> = PyReadonlyArrayDyn<'py, f64>;

/// Boxes between two looks at the signals.
const BATCH: usize = 65536;
/// Largest deviation of the product of the axes with themselves from the identity.
const ORTHONORMAL: f64 = 1e-6;

fn boxes_of(side: &str, centers: &Array<'_>, axes: &Array<'_>, half: &Array<'_>) -> Result<Vec<OrientedBox>> {
    let count = centers.as_array().shape().first().copied().unwrap_or(0);
    let (centers_name, axes_name, half_name) =
        (format!("centers_{side}"), format!("axes_{side}"), format!("half_{side}"));
    let centers = points_of(&centers_name, centers.as_array(), count)?;
    let axes = matrices_of(&axes_name, axes.as_array(), count)?;
    let half = vectors_of(&half_name, half.as_array(), count)?;
    if let Some(row) =
        axes.iter().position(|m| (m * m.transpose() - nalgebra::Matrix3::identity()).amax() > ORTHONORMAL)
    {
        return Err(GeometryError::new(axes_name, format!("row {row} is not orthonormal")));
    }
    if let Some(row) = half.iter().position(|half| half.min() < 0.0) {
        return Err(GeometryError::new(half_name, format!("row {row} has a negative half extent")));
    }
    let boxes = centers.into_iter().zip(axes).zip(half);
    Ok(boxes.map(|((center, axes), half)| OrientedBox { center, axes, half }).collect())
}

#[allow(clippy::too_many_arguments)]
fn measure<'py>(
    py: Python<'py>,
    centers_a: Array<'py>,
    axes_a: Array<'py>,
    half_a: Array<'py>,
    centers_b: Array<'py>,
    axes_b: Array<'py>,
    half_b: Array<'py>,
    measure: fn(&OrientedBox, &OrientedBox) -> f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let a = boxes_of("a", &centers_a, &axes_a, &half_a).map_err(value_error)?;
    let b = boxes_of("b", &centers_b, &axes_b, &half_b).map_err(value_error)?;
    if a.len() != b.len() {
        let problem = format!("{} boxes, but centers_a has {}", b.len(), a.len());
        return Err(value_error(GeometryError::new("centers_b", problem)));
    }
    let mut values = Vec::with_capacity(a.len());
    for (a, b) in a.chunks(BATCH).zip(b.chunks(BATCH)) {
        values.extend(py.detach(|| iou::for_pairs(a, b, measure)));
        py.check_signals()?;
    }
    Ok(PyArray1::from_vec(py, values))
}

#[pyfunction]
fn box_intersection_volume<'py>(
    py: Python<'py>,
    centers_a: Array<'py>,
    axes_a: Array<'py>,
    half_a: Array<'py>,
    centers_b: Array<'py>,
    axes_b: Array<'py>,
    half_b: Array<'py>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    measure(py, centers_a, axes_a, half_a, centers_b, axes_b, half_b, iou::intersection_volume)
}

#[pyfunction]
fn box_iou<'py>(
    py: Python<'py>,
    centers_a: Array<'py>,
    axes_a: Array<'py>,
    half_a: Array<'py>,
    centers_b: Array<'py>,
    axes_b: Array<'py>,
    half_b: Array<'py>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    measure(py, centers_a, axes_a, half_a, centers_b, axes_b, half_b, iou::box_iou)
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(box_intersection_volume, module)?)?;
    module.add_function(wrap_pyfunction!(box_iou, module)?)
}
