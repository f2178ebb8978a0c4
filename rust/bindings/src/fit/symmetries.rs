//! `fit_symmetric_boxes`, `find_symmetries` and `find_round_pieces`: symmetries of parts.

use kinmo_geometry::GeometryError;
use kinmo_geometry::fit::oriented_box::OrientedBox;
use kinmo_geometry::fit::round_pieces::round_pieces;
use kinmo_geometry::fit::symmetric_box::symmetric_box;
use kinmo_geometry::fit::symmetry_detection::{Symmetry, SymmetryKind, find_symmetries};
use kinmo_geometry::fit::symmetry_test::TestOptions;
use kinmo_geometry::mesh::part_surface::PartSurface;
use numpy::{PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;

use crate::arguments::arrays::array_of_vectors;
use crate::arguments::boxes::to_arrays;
use crate::arguments::groups::groups_of;
use crate::arguments::numbers::{Index, count_of, float, integer, seed};
use crate::batches::map_in_batches;
use crate::errors::value_error;
use crate::mesh::meshes::Meshes;

/// Largest number of samples per part.
const MAX_SAMPLES: usize = 1_000_000;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(fit_symmetric_boxes, module)?)?;
    module.add_function(wrap_pyfunction!(py_find_symmetries, module)?)?;
    module.add_function(wrap_pyfunction!(find_round_pieces, module)?)
}

/// Centers, axes, half extents and numbers of symmetric planes.
type SymmetricBoxes<'py> =
    (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<u8>>);

#[pyfunction]
#[pyo3(signature = (meshes, groups=None, *, seed=0, samples=100, tolerance=1e-4))]
fn fit_symmetric_boxes<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    groups: Option<Vec<Vec<Index>>>,
    #[pyo3(from_py_with = seed)] seed: u64,
    #[pyo3(from_py_with = integer)] samples: i64,
    #[pyo3(from_py_with = float)] tolerance: f64,
) -> PyResult<SymmetricBoxes<'py>> {
    let found = test_each_part(py, meshes, groups, seed, samples, tolerance, symmetric_box)?;
    let (boxes, planes): (Vec<OrientedBox>, Vec<u8>) = found.into_iter().unzip();
    let (centers, axes, half_extents) = to_arrays(py, &boxes)?;
    Ok((centers, axes, half_extents, PyArray1::from_vec(py, planes)))
}

/// Groups, kinds, orders, points, directions and errors.
type Symmetries<'py> = (
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<u8>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
);

#[pyfunction]
#[pyo3(name = "find_symmetries", signature = (meshes, groups=None, *, seed=0, samples=100, tolerance=0.01))]
fn py_find_symmetries<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    groups: Option<Vec<Vec<Index>>>,
    #[pyo3(from_py_with = seed)] seed: u64,
    #[pyo3(from_py_with = integer)] samples: i64,
    #[pyo3(from_py_with = float)] tolerance: f64,
) -> PyResult<Symmetries<'py>> {
    let found = test_each_part(py, meshes, groups, seed, samples, tolerance, find_symmetries)?;
    let rows: Vec<(u32, Symmetry)> =
        (0..).zip(found).flat_map(|(group, list)| list.into_iter().map(move |s| (group, s))).collect();
    let kinds = rows.iter().map(|(_, s)| kind_and_order(s.kind));
    Ok((
        PyArray1::from_iter(py, rows.iter().map(|(group, _)| *group)),
        PyArray1::from_iter(py, kinds.clone().map(|(kind, _)| kind)),
        PyArray1::from_iter(py, kinds.map(|(_, order)| order)),
        array_of_vectors(py, rows.iter().map(|(_, s)| s.point.coords))?,
        array_of_vectors(py, rows.iter().map(|(_, s)| s.direction))?,
        PyArray1::from_iter(py, rows.iter().map(|(_, s)| s.error)),
    ))
}

/// Meshes, middles, directions, radii and half lengths.
type RoundPieces<'py> = (
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
);

#[pyfunction]
#[pyo3(signature = (meshes, *, seed=0, samples=100, tolerance=0.02))]
fn find_round_pieces<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    #[pyo3(from_py_with = seed)] seed: u64,
    #[pyo3(from_py_with = integer)] samples: i64,
    #[pyo3(from_py_with = float)] tolerance: f64,
) -> PyResult<RoundPieces<'py>> {
    let options = options_of(seed, samples, tolerance)?;
    let found = map_in_batches(py, &meshes.parts, |mesh| round_pieces(mesh, &options))?;
    let rows: Vec<_> = (0..).zip(found).flat_map(|(mesh, list)| list.into_iter().map(move |p| (mesh, p))).collect();
    Ok((
        PyArray1::from_iter(py, rows.iter().map(|(mesh, _)| *mesh)),
        array_of_vectors(py, rows.iter().map(|(_, p)| p.middle.coords))?,
        array_of_vectors(py, rows.iter().map(|(_, p)| p.direction))?,
        PyArray1::from_iter(py, rows.iter().map(|(_, p)| p.radius)),
        PyArray1::from_iter(py, rows.iter().map(|(_, p)| p.half_length)),
    ))
}

/// Results of `work` on the surface of every group.
fn test_each_part<T: Send>(
    py: Python<'_>,
    meshes: &Meshes,
    groups: Option<Vec<Vec<Index>>>,
    seed: u64,
    samples: i64,
    tolerance: f64,
    work: impl Fn(&PartSurface<'_>, &TestOptions) -> T + Sync,
) -> PyResult<Vec<T>> {
    let options = options_of(seed, samples, tolerance)?;
    let groups = groups_of(meshes.parts.len(), groups).map_err(value_error)?;
    map_in_batches(py, &groups, |group| {
        let members: Vec<_> = group.iter().map(|&part| &meshes.parts[part]).collect();
        work(&PartSurface::new(&members, group.iter().map(|&part| meshes.tree(part)).collect()), &options)
    })
}

fn options_of(seed: u64, samples: i64, tolerance: f64) -> PyResult<TestOptions> {
    let samples = count_of("samples", samples, MAX_SAMPLES).map_err(value_error)?;
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        let problem = format!("{tolerance}, expected a positive number");
        return Err(value_error(GeometryError::new("tolerance", problem)));
    }
    Ok(TestOptions { samples, tolerance, seed })
}

fn kind_and_order(kind: SymmetryKind) -> (u8, u32) {
    match kind {
        SymmetryKind::Reflection => (0, 2),
        SymmetryKind::Rotation(order) => (1, order),
        SymmetryKind::Revolution => (1, 0),
    }
}
