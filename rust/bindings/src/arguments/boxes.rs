//! Oriented boxes as arrays: centers `[B, 3]`, axes `[B, 3, 3]` with unit axes as rows, half extents `[B, 3]`.

use kinmo_geometry::fit::oriented_box::OrientedBox;
use kinmo_geometry::{GeometryError, Result};
use nalgebra::Matrix3;
use numpy::{PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, array_of_vectors, matrices_of, points_of, vectors_of};

/// Largest deviation of `axes * axes^T` from the identity.
const ORTHONORMAL: f64 = 1e-6;

/// Centers `[B, 3]`, axes `[B, 3, 3]` and half extents `[B, 3]`.
pub type Boxes<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>, Bound<'py, PyArray2<f64>>);

/// Converts boxes to arrays.
pub fn to_arrays<'py>(py: Python<'py>, boxes: &[OrientedBox]) -> PyResult<Boxes<'py>> {
    let centers = array_of_vectors(py, boxes.iter().map(|b| b.center.coords))?;
    let axes = array_of_vectors(py, boxes.iter().flat_map(|b| b.axes))?;
    let half_extents = array_of_vectors(py, boxes.iter().map(|b| b.half_extents))?;
    Ok((centers, axes.reshape([boxes.len(), 3, 3])?, half_extents))
}

/// Checked boxes from three arrays. The argument names are `centers`, `axes` and `half`, each followed by `ending`.
///
/// The axes may be left-handed.
pub fn boxes_of(
    ending: &str,
    centers: &Array<'_, f64>,
    axes: &Array<'_, f64>,
    half: &Array<'_, f64>,
) -> Result<Vec<OrientedBox>> {
    let count = centers.view().shape().first().copied().unwrap_or(0);
    let name = |of: &str| format!("{of}{ending}");
    let centers = points_of(&name("centers"), centers.view(), count)?;
    let axes = matrices_of(&name("axes"), axes.view(), count)?;
    let half = vectors_of(&name("half"), half.view(), count)?;
    if let Some(row) = axes.iter().position(|axes| !is_orthonormal(axes)) {
        return Err(GeometryError::new(name("axes"), format!("row {row} is not orthonormal")));
    }
    if let Some(row) = half.iter().position(|half| half.min() < 0.0) {
        return Err(GeometryError::new(name("half"), format!("row {row} has a negative half extent")));
    }
    let rows = |axes: Matrix3<f64>| [0, 1, 2].map(|axis| axes.row(axis).transpose());
    let boxes = centers.into_iter().zip(axes).zip(half);
    Ok(boxes.map(|((center, axes), half_extents)| OrientedBox { center, axes: rows(axes), half_extents }).collect())
}

/// True if the rows are orthonormal.
fn is_orthonormal(axes: &Matrix3<f64>) -> bool {
    (axes * axes.transpose() - Matrix3::identity()).amax() <= ORTHONORMAL
}

/// True if the rows are orthonormal and right-handed.
pub fn is_rotation(axes: &Matrix3<f64>) -> bool {
    is_orthonormal(axes) && axes.determinant() >= 0.0
}
