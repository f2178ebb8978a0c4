use kinmo_geometry::GeometryError;
use kinmo_geometry::adjacency::{self, PartDistance};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArrayDyn};
use pyo3::prelude::*;

use crate::convert::value_error;
use crate::groups::{groups_of, pairs_of};
use crate::meshes::Meshes;

/// Pairs between two looks at the signals.
const BATCH: usize = 4096;

type Distances<'py> =
    (Bound<'py, PyArray2<u32>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

#[pyfunction]
#[pyo3(signature = (meshes, groups=None, pairs=None, *, max_distance=f64::INFINITY))]
fn part_distances<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    groups: Option<Vec<Vec<i64>>>,
    pairs: Option<PyReadonlyArrayDyn<'py, u32>>,
    max_distance: f64,
) -> PyResult<Distances<'py>> {
    let groups = groups_of(meshes.parts.len(), groups).map_err(value_error)?;
    let pairs = match pairs {
        Some(pairs) => pairs_of(groups.len(), &pairs).map_err(value_error)?,
        None => (0..groups.len()).flat_map(|a| (a + 1..groups.len()).map(move |b| (a, b))).collect(),
    };
    if max_distance.is_nan() || max_distance < 0.0 {
        return Err(value_error(GeometryError::new("max_distance", format!("{max_distance}, expected at least 0"))));
    }
    let parts = py.detach(|| meshes.trees_of(&groups));
    let mut found: Vec<((usize, usize), PartDistance)> = Vec::new();
    for batch in pairs.chunks(BATCH) {
        let distances = py.detach(|| adjacency::part_distances(&parts, batch, max_distance));
        found.extend(batch.iter().zip(distances).filter_map(|(&pair, distance)| Some((pair, distance?))));
        py.check_signals()?;
    }
    let rows = found.len();
    let pairs = Array2::from_shape_fn((rows, 2), |(row, side)| {
        let (a, b) = found[row].0;
        (if side == 0 { a } else { b }) as u32
    });
    let witness_a = Array2::from_shape_fn((rows, 3), |(row, axis)| found[row].1.witness_a[axis]);
    let witness_b = Array2::from_shape_fn((rows, 3), |(row, axis)| found[row].1.witness_b[axis]);
    Ok((
        pairs.into_pyarray(py),
        PyArray1::from_iter(py, found.iter().map(|(_, distance)| distance.distance)),
        witness_a.into_pyarray(py),
        witness_b.into_pyarray(py),
    ))
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(part_distances, module)?)
}
