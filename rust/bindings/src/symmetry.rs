//! `fit_symmetric_boxes`, `find_symmetries`, `find_round_pieces`.

use kinmo_geometry::GeometryError;
use kinmo_geometry::oriented_box::OrientedBox;
use kinmo_geometry::round_pieces::round_pieces;
use kinmo_geometry::surface::Surface;
use kinmo_geometry::symmetric_box::symmetric_box;
use kinmo_geometry::symmetry::{Symmetry, SymmetryKind, find_symmetries};
use kinmo_geometry::symmetry_test::TestOptions;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

use crate::batches::map_in_batches;
use crate::boxes::to_arrays;
use crate::convert::value_error;
use crate::groups::groups_of;
use crate::meshes::Meshes;
use crate::numbers::{Index, count_of, float, integer, seed};

/// Most samples of a part.
const MOST_SAMPLES: usize = 1_000_000;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(fit_symmetric_boxes, module)?)?;
    module.add_function(wrap_pyfunction!(py_find_symmetries, module)?)?;
    module.add_function(wrap_pyfunction!(find_round_pieces, module)?)
}

/// Centers, axes, half extents, numbers of symmetric planes.
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

/// Groups, kinds, orders, points, directions, errors.
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
    let count = rows.len();
    let kinds = rows.iter().map(|(_, s)| kind_and_order(s.kind));
    Ok((
        PyArray1::from_iter(py, rows.iter().map(|(group, _)| *group)),
        PyArray1::from_iter(py, kinds.clone().map(|(kind, _)| kind)),
        PyArray1::from_iter(py, kinds.map(|(_, order)| order)),
        PyArray1::from_iter(py, rows.iter().flat_map(|(_, s)| s.point.coords.data.0[0])).reshape([count, 3])?,
        PyArray1::from_iter(py, rows.iter().flat_map(|(_, s)| s.direction.data.0[0])).reshape([count, 3])?,
        PyArray1::from_iter(py, rows.iter().map(|(_, s)| s.error)),
    ))
}

/// Meshes, middles, directions, radii, half lengths.
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
    let count = rows.len();
    Ok((
        PyArray1::from_iter(py, rows.iter().map(|(mesh, _)| *mesh)),
        PyArray1::from_iter(py, rows.iter().flat_map(|(_, p)| p.middle.coords.data.0[0])).reshape([count, 3])?,
        PyArray1::from_iter(py, rows.iter().flat_map(|(_, p)| p.direction.data.0[0])).reshape([count, 3])?,
        PyArray1::from_iter(py, rows.iter().map(|(_, p)| p.radius)),
        PyArray1::from_iter(py, rows.iter().map(|(_, p)| p.half_length)),
    ))
}

/// What `work` finds on the surface of every group.
fn test_each_part<T: Send>(
    py: Python<'_>,
    meshes: &Meshes,
    groups: Option<Vec<Vec<Index>>>,
    seed: u64,
    samples: i64,
    tolerance: f64,
    work: impl Fn(&Surface<'_>, &TestOptions) -> T + Sync,
) -> PyResult<Vec<T>> {
    let options = options_of(seed, samples, tolerance)?;
    let groups = groups_of(meshes.parts.len(), groups).map_err(value_error)?;
    map_in_batches(py, &groups, |group| {
        let members: Vec<_> = group.iter().map(|&part| &meshes.parts[part]).collect();
        work(&Surface::new(&members, group.iter().map(|&part| meshes.tree(part)).collect()), &options)
    })
}

fn options_of(seed: u64, samples: i64, tolerance: f64) -> PyResult<TestOptions> {
    let samples = count_of("samples", samples, MOST_SAMPLES).map_err(value_error)?;
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
