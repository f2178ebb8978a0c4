//! `fit_boxes`, `fit_aligned_boxes`, `fit_upright_boxes`.

use kinmo_geometry::GeometryError;
use kinmo_geometry::obb::{OrientedBox, aligned_box, minimum_volume_box, upright_box};
use nalgebra::{Matrix3, Point3, Vector3};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArrayDyn};
use pyo3::prelude::*;

use crate::arrays::{matrix_of, vector_of};
use crate::batches::map_in_batches;
use crate::convert::value_error;
use crate::groups::groups_of;
use crate::meshes::Meshes;

/// How far the rows of a frame may be from orthonormal.
const ORTHONORMAL: f64 = 1e-6;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(fit_boxes, module)?)?;
    module.add_function(wrap_pyfunction!(fit_aligned_boxes, module)?)?;
    module.add_function(wrap_pyfunction!(fit_upright_boxes, module)?)
}

/// Centers [G, 3], axes [G, 3, 3] as rows, half extents [G, 3].
pub type Boxes<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>, Bound<'py, PyArray2<f64>>);

pub fn to_arrays<'py>(py: Python<'py>, boxes: &[OrientedBox]) -> PyResult<Boxes<'py>> {
    let count = boxes.len();
    let centers = PyArray1::from_iter(py, boxes.iter().flat_map(|b| b.center.coords.data.0[0]));
    let axes = PyArray1::from_iter(py, boxes.iter().flat_map(|b| b.axes).flat_map(|axis| axis.data.0[0]));
    let half_extents = PyArray1::from_iter(py, boxes.iter().flat_map(|b| b.half_extents.data.0[0]));
    Ok((centers.reshape([count, 3])?, axes.reshape([count, 3, 3])?, half_extents.reshape([count, 3])?))
}

#[pyfunction]
#[pyo3(signature = (meshes, groups=None))]
fn fit_boxes<'py>(py: Python<'py>, meshes: &Meshes, groups: Option<Vec<Vec<i64>>>) -> PyResult<Boxes<'py>> {
    fit_each(py, meshes, groups, minimum_volume_box)
}

#[pyfunction]
#[pyo3(signature = (meshes, frame, groups=None))]
fn fit_aligned_boxes<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    frame: PyReadonlyArrayDyn<'py, f64>,
    groups: Option<Vec<Vec<i64>>>,
) -> PyResult<Boxes<'py>> {
    let axes = orthonormal_rows(&frame).map_err(value_error)?;
    fit_each(py, meshes, groups, |points| aligned_box(points, axes))
}

#[pyfunction]
#[pyo3(signature = (meshes, up, groups=None))]
fn fit_upright_boxes<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    up: PyReadonlyArrayDyn<'py, f64>,
    groups: Option<Vec<Vec<i64>>>,
) -> PyResult<Boxes<'py>> {
    let up = unit("up", &up).map_err(value_error)?;
    fit_each(py, meshes, groups, |points| upright_box(points, up))
}

fn fit_each<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    groups: Option<Vec<Vec<i64>>>,
    fit: impl Fn(&[Point3<f64>]) -> OrientedBox + Sync,
) -> PyResult<Boxes<'py>> {
    let groups = groups_of(meshes.parts.len(), groups).map_err(value_error)?;
    let boxes = map_in_batches(py, &groups, |group| match group[..] {
        [only] => fit(meshes.parts[only].vertices()),
        _ => fit(&group.iter().flat_map(|&part| meshes.parts[part].vertices()).copied().collect::<Vec<_>>()),
    })?;
    to_arrays(py, &boxes)
}

fn orthonormal_rows(frame: &PyReadonlyArrayDyn<'_, f64>) -> Result<[Vector3<f64>; 3], GeometryError> {
    let columns = matrix_of("frame", frame.as_array())?.transpose();
    let deviation = (columns.transpose() * columns - Matrix3::identity()).amax();
    if deviation > ORTHONORMAL || columns.determinant() < 0.0 {
        return Err(GeometryError::new("frame", "rows are not orthonormal and right-handed"));
    }
    Ok([0, 1, 2].map(|axis| columns.column(axis).into_owned()))
}

fn unit(argument: &str, direction: &PyReadonlyArrayDyn<'_, f64>) -> Result<Vector3<f64>, GeometryError> {
    let vector = vector_of(argument, direction.as_array())?;
    // Scaled first: the square of a very long or short vector is out of range.
    let scaled = vector / vector.amax();
    scaled.try_normalize(0.0).filter(|unit| unit.x.is_finite()).ok_or_else(|| GeometryError::new(argument, "is zero"))
}
