//! `surface_patches`: faces joined across edges without a concave crease.

use kinmo_geometry::GeometryError;
use kinmo_geometry::mesh::surface_patches as patches;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::errors::value_error;
use crate::mesh::meshes::Meshes;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(surface_patches, module)?)
}

#[pyfunction]
#[pyo3(signature = (meshes, mesh, *, tolerance, crease))]
fn surface_patches<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    mesh: usize,
    tolerance: f64,
    crease: f64,
) -> PyResult<Bound<'py, PyArray1<u32>>> {
    let count = meshes.parts.len();
    let part = meshes
        .parts
        .get(mesh)
        .ok_or_else(|| value_error(GeometryError::new("mesh", format!("is {mesh}, but there are {count} meshes"))))?;
    if !(tolerance >= 0.0 && tolerance.is_finite()) {
        return Err(value_error(GeometryError::new("tolerance", format!("expected a length, got {tolerance}"))));
    }
    let found = py.detach(|| patches::surface_patches(part, tolerance, crease));
    Ok(PyArray1::from_vec(py, found))
}
