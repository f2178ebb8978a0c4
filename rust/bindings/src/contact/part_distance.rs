//! `part_distances`: exact distances between parts.

use kinmo_geometry::GeometryError;
use kinmo_geometry::contact::part_distance::PartBvh;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, array_of_rows, array_of_vectors};
use crate::arguments::groups::{groups_of, pairs_of};
use crate::arguments::numbers::{Index, float};
use crate::batches::{filter_map_in_batches, map_in_batches};
use crate::errors::value_error;
use crate::mesh::meshes::Meshes;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(part_distances, module)?)
}

/// Pairs `[E, 2]`, distances `[E]`, witness points `[E, 3]` on the first parts and on the second parts.
type Distances<'py> =
    (Bound<'py, PyArray2<u32>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

#[pyfunction]
#[pyo3(signature = (meshes, groups=None, pairs=None, *, max_distance=f64::INFINITY))]
fn part_distances<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    groups: Option<Vec<Vec<Index>>>,
    pairs: Option<Array<'py, u32>>,
    #[pyo3(from_py_with = float)] max_distance: f64,
) -> PyResult<Distances<'py>> {
    let groups = groups_of(meshes.parts.len(), groups).map_err(value_error)?;
    let pairs = pairs.map(|pairs| pairs_of(groups.len(), &pairs)).transpose().map_err(value_error)?;
    if max_distance.is_nan() || max_distance < 0.0 {
        return Err(value_error(GeometryError::new("max_distance", format!("{max_distance}, expected at least 0"))));
    }
    let parts =
        map_in_batches(py, &groups, |members| PartBvh::new(members.iter().map(|&part| meshes.tree(part)).collect()))?;
    let measure = |(a, b): (usize, usize)| Some(((a, b), parts[a].distance(&parts[b], max_distance)?));
    let found = match pairs {
        Some(pairs) => filter_map_in_batches(py, pairs, measure)?,
        None => filter_map_in_batches(py, unordered_pairs(parts.len()), measure)?,
    };
    Ok((
        array_of_rows(py, found.iter().map(|((a, b), _)| [*a as u32, *b as u32]))?,
        PyArray1::from_iter(py, found.iter().map(|(_, distance)| distance.distance)),
        array_of_vectors(py, found.iter().map(|(_, distance)| distance.witness_a.coords))?,
        array_of_vectors(py, found.iter().map(|(_, distance)| distance.witness_b.coords))?,
    ))
}

fn unordered_pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |a| (a + 1..count).map(move |b| (a, b)))
}
