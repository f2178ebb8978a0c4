//! `group_points`: sampling and grouping for PointNet++.

use kinmo_geometry::GeometryError;
use kinmo_geometry::points::pointnet_grouping::{ball_query, farthest_point_sampling, nearest_centers};
use numpy::ndarray::Axis;
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, clouds_of, triples_of_cloud, zeros};
use crate::arguments::numbers::{count_of, float, integer};
use crate::batches::map_in_batches;
use crate::errors::value_error;

/// Largest allowed number of centers and of members. The result has no more of them than there are points.
const MAX_COUNT: usize = u32::MAX as usize;
/// Number of nearest centers from which PointNet++ interpolates features.
const INTERPOLATED: usize = 3;

/// Centers, groups, nearest centers and their distances.
type Grouped<'py> = (
    Bound<'py, PyArrayDyn<i64>>,
    Bound<'py, PyArrayDyn<i64>>,
    Bound<'py, PyArrayDyn<i64>>,
    Bound<'py, PyArrayDyn<f32>>,
);

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(group_points, module)?)
}

#[pyfunction]
fn group_points<'py>(
    py: Python<'py>,
    points: Array<'py, f32>,
    #[pyo3(from_py_with = integer)] centers: i64,
    #[pyo3(from_py_with = float)] radius: f64,
    #[pyo3(from_py_with = integer)] members: i64,
) -> PyResult<Grouped<'py>> {
    let centers = count_of("centers", centers, MAX_COUNT).map_err(value_error)?;
    let members = count_of("members", members, MAX_COUNT).map_err(value_error)?;
    if !(0.0..=f64::from(f32::MAX)).contains(&radius) {
        return Err(value_error(GeometryError::new("radius", format!("{radius}, expected 0 to {}", f32::MAX))));
    }
    let radius = radius as f32;
    let clouds = clouds_of("points", points.view()).map_err(value_error)?;
    let (batch, size) = (clouds.len_of(Axis(0)), clouds.len_of(Axis(1)));
    let (centers, members) = (centers.min(size), members.min(size));
    let near = INTERPOLATED.min(centers);
    let chosen = zeros(py, &[batch, centers])?;
    let groups = zeros(py, &[batch, centers, members])?;
    let nearest = zeros(py, &[batch, size, near])?;
    let distances = zeros(py, &[batch, size, near])?;
    if size > 0 {
        let (mut to_chosen, mut to_groups) = (chosen.readwrite(), groups.readwrite());
        let (mut to_nearest, mut to_distances) = (nearest.readwrite(), distances.readwrite());
        let rows = clouds
            .outer_iter()
            .map(triples_of_cloud)
            .zip(to_chosen.as_slice_mut()?.chunks_mut(centers))
            .zip(to_groups.as_slice_mut()?.chunks_mut(centers * members))
            .zip(to_nearest.as_slice_mut()?.chunks_mut(size * near))
            .zip(to_distances.as_slice_mut()?.chunks_mut(size * near));
        map_in_batches(py, rows, |((((points, chosen), groups), nearest), distances)| {
            farthest_point_sampling(&points, chosen);
            let places: Vec<_> = chosen.iter().map(|&number| points[number as usize]).collect();
            ball_query(&points, &places, radius, members, groups);
            nearest_centers(&points, &places, near, nearest, distances);
        })?;
    }
    Ok((chosen, groups, nearest, distances))
}
