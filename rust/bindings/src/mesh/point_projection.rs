//! `closest_points`: nearest points on the surface of a part.

use kinmo_geometry::mesh::point_projection::NearestPoint;
use kinmo_geometry::mesh::surface_group::SurfaceGroup;
use nalgebra::Point3;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, array_of_vectors, points_of, rows_of};
use crate::arguments::groups::members_of;
use crate::arguments::numbers::Index;
use crate::batches::map_in_batches;
use crate::errors::value_error;
use crate::mesh::meshes::Meshes;

/// Points per work item.
const CHUNK: usize = 256;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(closest_points, module)?)
}

/// Distances `[N]`, nearest points `[N, 3]` and normals `[N, 3]`.
type Found<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

#[pyfunction]
fn closest_points<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    group: Vec<Index>,
    points: Array<'py, f64>,
) -> PyResult<Found<'py>> {
    let group = members_of("group", meshes.parts.len(), &group).map_err(value_error)?;
    let count = rows_of("points", points.view(), 3).map_err(value_error)?.nrows();
    let points = points_of("points", points.view(), count).map_err(value_error)?;
    meshes.build_projection_trees(py, &group)?;
    let surfaces = SurfaceGroup::new(group.iter().map(|&part| meshes.projection_tree(part)).collect());
    let chunks = map_in_batches(py, points.chunks(CHUNK), |chunk: &[Point3<f64>]| surfaces.nearest_points(chunk))?;
    let found: Vec<NearestPoint> = chunks.concat();
    Ok((
        PyArray1::from_iter(py, found.iter().map(|nearest| nearest.distance)),
        array_of_vectors(py, found.iter().map(|nearest| nearest.point.coords))?,
        array_of_vectors(py, found.iter().map(|nearest| nearest.normal))?,
    ))
}
