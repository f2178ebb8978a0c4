//! `fit_boxes` and `fit_aligned_boxes`: oriented bounding boxes of parts.

use kinmo_geometry::GeometryError;
use kinmo_geometry::fit::minimum_volume_box::{aligned_box, minimum_volume_box};
use kinmo_geometry::fit::oriented_box::OrientedBox;
use nalgebra::{Point3, Vector3};
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, matrix_of};
use crate::arguments::boxes::{Boxes, is_rotation, to_arrays};
use crate::arguments::groups::groups_of;
use crate::arguments::numbers::Index;
use crate::batches::map_in_batches;
use crate::errors::value_error;
use crate::mesh::meshes::Meshes;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(fit_boxes, module)?)?;
    module.add_function(wrap_pyfunction!(fit_aligned_boxes, module)?)
}

#[pyfunction]
#[pyo3(signature = (meshes, groups=None))]
fn fit_boxes<'py>(py: Python<'py>, meshes: &Meshes, groups: Option<Vec<Vec<Index>>>) -> PyResult<Boxes<'py>> {
    fit_each(py, meshes, groups, minimum_volume_box)
}

#[pyfunction]
#[pyo3(signature = (meshes, frame, groups=None))]
fn fit_aligned_boxes<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    frame: Array<'py, f64>,
    groups: Option<Vec<Vec<Index>>>,
) -> PyResult<Boxes<'py>> {
    let axes = right_handed_rows(&frame).map_err(value_error)?;
    fit_each(py, meshes, groups, |points| aligned_box(points, axes))
}

fn fit_each<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    groups: Option<Vec<Vec<Index>>>,
    fit: impl Fn(&[Point3<f64>]) -> OrientedBox + Sync,
) -> PyResult<Boxes<'py>> {
    let groups = groups_of(meshes.parts.len(), groups).map_err(value_error)?;
    let boxes = map_in_batches(py, &groups, |group| match group[..] {
        [only] => fit(meshes.parts[only].vertices()),
        _ => fit(&group.iter().flat_map(|&part| meshes.parts[part].vertices()).copied().collect::<Vec<_>>()),
    })?;
    to_arrays(py, &boxes)
}

fn right_handed_rows(frame: &Array<'_, f64>) -> Result<[Vector3<f64>; 3], GeometryError> {
    let rows = matrix_of("frame", frame.view())?;
    if !is_rotation(&rows) {
        return Err(GeometryError::new("frame", "rows are not orthonormal and right-handed"));
    }
    Ok([0, 1, 2].map(|axis| rows.row(axis).transpose()))
}
