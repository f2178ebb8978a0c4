use kinmo_geometry::GeometryError;
use kinmo_geometry::probes::Solid;
use kinmo_geometry::sweep::{self, Candidate, SweepOptions, Travel};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArrayDyn};
use pyo3::prelude::*;

use crate::arrays::values_of;
use crate::convert::value_error;
use crate::groups::members_of;
use crate::joints::joints_of;
use crate::meshes::Meshes;

type Travels<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

#[pyfunction]
#[pyo3(
    name = "sweep",
    signature = (meshes, moving, obstacles, kinds, directions, pivots, lower, upper, *, pitches=None,
                 probes=200, steps=16, tolerance=0.01, ignored_share=0.005)
)]
#[allow(clippy::too_many_arguments)]
fn sweep_joints<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    moving: Vec<i64>,
    obstacles: Vec<i64>,
    kinds: PyReadonlyArrayDyn<'py, u8>,
    directions: PyReadonlyArrayDyn<'py, f64>,
    pivots: PyReadonlyArrayDyn<'py, f64>,
    lower: PyReadonlyArrayDyn<'py, f64>,
    upper: PyReadonlyArrayDyn<'py, f64>,
    pitches: Option<PyReadonlyArrayDyn<'py, f64>>,
    probes: usize,
    steps: usize,
    tolerance: f64,
    ignored_share: f64,
) -> PyResult<Travels<'py>> {
    let moving = members_of("moving", meshes.parts.len(), &moving).map_err(value_error)?;
    let obstacles = members_of("obstacles", meshes.parts.len(), &obstacles).map_err(value_error)?;
    if let Some(mesh) = moving.iter().find(|mesh| obstacles.contains(mesh)) {
        return Err(value_error(GeometryError::new("obstacles", format!("mesh {mesh} is in moving too"))));
    }
    for (name, positive) in [("probes", probes > 0), ("steps", steps > 0)] {
        if !positive {
            return Err(value_error(GeometryError::new(name, "0, expected at least 1")));
        }
    }
    for (name, share) in [("tolerance", tolerance), ("ignored_share", ignored_share)] {
        if !(0.0..1.0).contains(&share) {
            return Err(value_error(GeometryError::new(name, format!("{share}, expected at least 0 and below 1"))));
        }
    }
    let joints = joints_of(&kinds, &directions, &pivots).map_err(value_error)?;
    let lower = values_of("lower", lower.as_array(), joints.len()).map_err(value_error)?;
    let upper = values_of("upper", upper.as_array(), joints.len()).map_err(value_error)?;
    let pitches = match &pitches {
        Some(pitches) => values_of("pitches", pitches.as_array(), joints.len()).map_err(value_error)?.to_vec(),
        None => vec![0.0; joints.len()],
    };
    if let Some(row) = lower.iter().position(|&limit| limit > 0.0) {
        return Err(value_error(GeometryError::new("lower", format!("row {row} is above 0"))));
    }
    if let Some(row) = upper.iter().position(|&limit| limit < 0.0) {
        return Err(value_error(GeometryError::new("upper", format!("row {row} is below 0"))));
    }
    let candidates: Vec<Candidate> = joints
        .into_iter()
        .zip(pitches)
        .zip(lower.iter().zip(&upper))
        .map(|((axis, pitch), (&lower, &upper))| Candidate { axis, pitch, limits: [lower, upper] })
        .collect();
    let options = SweepOptions { probes, steps, tolerance, ignored_share };
    let travels: Vec<Travel> = py.detach(|| {
        let solids = |members: &[usize]| -> Vec<Solid<'_>> {
            members.iter().map(|&mesh| Solid { mesh: &meshes.parts[mesh], tree: meshes.tree(mesh) }).collect()
        };
        sweep::sweep(&solids(&moving), &solids(&obstacles), &candidates, &options)
    });
    py.check_signals()?;
    let penetration = Array2::from_shape_fn((travels.len(), 2), |(row, side)| travels[row].penetration[side]);
    Ok((
        PyArray1::from_iter(py, travels.iter().map(|travel| travel.free[0])),
        PyArray1::from_iter(py, travels.iter().map(|travel| travel.free[1])),
        penetration.into_pyarray(py),
    ))
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(sweep_joints, module)?)
}
