//! `fit_boxes`, `fit_aligned_boxes`, `fit_upright_boxes`.

use kinmo_geometry::GeometryError;
use kinmo_geometry::obb::{OrientedBox, aligned_box, minimum_volume_box, upright_box};
use nalgebra::{Matrix3, Vector3};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::convert::value_error;
use crate::groups::Groups;
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
    let groups = Groups::new(groups, meshes.parts.len())?;
    to_arrays(py, &groups.map_vertices(py, &meshes.parts, minimum_volume_box)?)
}

#[pyfunction]
#[pyo3(signature = (meshes, frame, groups=None))]
fn fit_aligned_boxes<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    frame: PyReadonlyArray2<'py, f64>,
    groups: Option<Vec<Vec<i64>>>,
) -> PyResult<Boxes<'py>> {
    let axes = orthonormal_rows(&frame).map_err(value_error)?;
    let groups = Groups::new(groups, meshes.parts.len())?;
    to_arrays(py, &groups.map_vertices(py, &meshes.parts, |points| aligned_box(points, axes))?)
}

#[pyfunction]
#[pyo3(signature = (meshes, up, groups=None))]
fn fit_upright_boxes<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    up: PyReadonlyArray1<'py, f64>,
    groups: Option<Vec<Vec<i64>>>,
) -> PyResult<Boxes<'py>> {
    let up = unit("up", &up).map_err(value_error)?;
    let groups = Groups::new(groups, meshes.parts.len())?;
    to_arrays(py, &groups.map_vertices(py, &meshes.parts, |points| upright_box(points, up))?)
}

fn orthonormal_rows(frame: &PyReadonlyArray2<'_, f64>) -> Result<[Vector3<f64>; 3], GeometryError> {
    if frame.shape() != [3, 3] {
        return Err(GeometryError::new("frame", format!("shape {:?}, expected [3, 3]", frame.shape())));
    }
    let rows = frame.as_array();
    let axes = [0, 1, 2].map(|i| Vector3::new(rows[[i, 0]], rows[[i, 1]], rows[[i, 2]]));
    let matrix = Matrix3::from_columns(&axes);
    let deviation = (matrix.transpose() * matrix - Matrix3::identity()).amax();
    if deviation <= ORTHONORMAL && matrix.determinant() > 0.0 {
        Ok(axes)
    } else {
        Err(GeometryError::new("frame", "rows are not orthonormal and right-handed"))
    }
}

fn unit(argument: &str, direction: &PyReadonlyArray1<'_, f64>) -> Result<Vector3<f64>, GeometryError> {
    if direction.len() != 3 {
        return Err(GeometryError::new(argument, format!("{} elements, expected 3", direction.len())));
    }
    let view = direction.as_array();
    let vector = Vector3::new(view[0], view[1], view[2]);
    let finite = vector.iter().all(|x| x.is_finite());
    let unit = vector.try_normalize(0.0).filter(|_| finite);
    unit.ok_or_else(|| GeometryError::new(argument, "expected a finite direction that is not zero"))
}
