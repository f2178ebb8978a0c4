//! `closest_points` and `closest_points_of_groups`: nearest points on the surfaces of parts.

use kinmo_geometry::mesh::point_projection::NearestPoint;
use kinmo_geometry::mesh::surface_group::SurfaceGroup;
use nalgebra::Point3;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, array_of_vectors, points_of, rows_of, shape_error};
use crate::arguments::groups::{groups_of, members_of};
use crate::arguments::numbers::Index;
use crate::batches::map_in_batches;
use crate::errors::value_error;
use crate::mesh::meshes::Meshes;

/// Points per work item.
const CHUNK: usize = 256;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(closest_points, module)?)?;
    module.add_function(wrap_pyfunction!(closest_points_of_groups, module)?)
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

/// Distances `[G, N]`, nearest points `[G, N, 3]` and normals `[G, N, 3]`.
type FoundOfGroups<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>, Bound<'py, PyArray3<f64>>);

#[pyfunction]
fn closest_points_of_groups<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    groups: Vec<Vec<Index>>,
    points: Array<'py, f64>,
) -> PyResult<FoundOfGroups<'py>> {
    let groups = groups_of(meshes.parts.len(), Some(groups)).map_err(value_error)?;
    let view = points.view();
    let &[rows, count, 3] = view.shape() else {
        return Err(value_error(shape_error("points", &view, "[G, N, 3]")));
    };
    if rows != groups.len() {
        return Err(value_error(shape_error("points", &view, &format!("[{}, N, 3], a row per group", groups.len()))));
    }
    let flat = view.to_shape((rows * count, 3)).expect("the shape has as many values");
    let points = points_of("points", flat.view().into_dyn(), rows * count).map_err(value_error)?;
    meshes.build_projection_trees(py, &groups.concat())?;
    let jobs = groups.iter().enumerate();
    let found: Vec<Vec<NearestPoint>> = map_in_batches(py, jobs, |(row, group)| {
        let surfaces = SurfaceGroup::new(group.iter().map(|&part| meshes.projection_tree(part)).collect());
        surfaces.nearest_points(&points[row * count..(row + 1) * count])
    })?;
    let nearest = || found.iter().flatten();
    Ok((
        PyArray1::from_iter(py, nearest().map(|nearest| nearest.distance)).reshape([rows, count])?,
        array_of_vectors(py, nearest().map(|nearest| nearest.point.coords))?.reshape([rows, count, 3])?,
        array_of_vectors(py, nearest().map(|nearest| nearest.normal))?.reshape([rows, count, 3])?,
    ))
}
