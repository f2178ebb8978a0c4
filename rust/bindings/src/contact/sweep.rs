//! `sweep`: free travel of a part along candidate joints.

use kinmo_geometry::contact::collision_probes::BodyMesh;
use kinmo_geometry::contact::sweep::{CandidateJoint, SweepOptions, SweepScene, Travel};
use kinmo_geometry::{GeometryError, Result};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, array_of_rows, values_of};
use crate::arguments::groups::members_of;
use crate::arguments::joints::joints_of;
use crate::arguments::numbers::{Index, count_of, float, integer};
use crate::batches::map_in_batches;
use crate::errors::value_error;
use crate::mesh::meshes::Meshes;

/// Largest number of probes per body and of steps per direction.
const MAX_PROBES: usize = 100_000;
const MAX_STEPS: usize = 100_000;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(sweep, module)?)
}

/// Free travel downwards `[C]` and upwards `[C]`, and penetration `[C, 2]`.
type Travels<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

#[pyfunction]
#[pyo3(
    signature = (meshes, moving, obstacles, kinds, directions, pivots, lower, upper, *, pitches=None,
                 probes=200, steps=16, tolerance=0.01, ignored_share=0.005)
)]
#[allow(clippy::too_many_arguments)]
fn sweep<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    moving: Vec<Index>,
    obstacles: Vec<Index>,
    kinds: Array<'py, u8>,
    directions: Array<'py, f64>,
    pivots: Array<'py, f64>,
    lower: Array<'py, f64>,
    upper: Array<'py, f64>,
    pitches: Option<Array<'py, f64>>,
    #[pyo3(from_py_with = integer)] probes: i64,
    #[pyo3(from_py_with = integer)] steps: i64,
    #[pyo3(from_py_with = float)] tolerance: f64,
    #[pyo3(from_py_with = float)] ignored_share: f64,
) -> PyResult<Travels<'py>> {
    let (moving, obstacles) = bodies_of(meshes, &moving, &obstacles).map_err(value_error)?;
    let options = options_of(probes, steps, tolerance, ignored_share).map_err(value_error)?;
    let joints = JointArguments { kinds, directions, pivots, lower, upper, pitches };
    let candidates = joints.candidates().map_err(value_error)?;
    meshes.build_trees(py, moving.iter().chain(&obstacles).copied())?;
    let solids = |body: &[usize]| -> Vec<BodyMesh<'_>> {
        body.iter().map(|&mesh| BodyMesh { mesh: &meshes.parts[mesh], tree: meshes.tree(mesh) }).collect()
    };
    let (moving, obstacles) = (solids(&moving), solids(&obstacles));
    let scene = py.detach(|| SweepScene::new(&moving, &obstacles, &candidates, options));
    let travels: Vec<Travel> = map_in_batches(py, &candidates, |candidate| scene.travel(candidate))?;
    Ok((
        PyArray1::from_iter(py, travels.iter().map(|travel| travel.free[0])),
        PyArray1::from_iter(py, travels.iter().map(|travel| travel.free[1])),
        array_of_rows(py, travels.iter().map(|travel| travel.penetration))?,
    ))
}

/// Checked meshes of the two bodies. They must not share a mesh.
fn bodies_of(meshes: &Meshes, moving: &[Index], obstacles: &[Index]) -> Result<(Vec<usize>, Vec<usize>)> {
    let moving = members_of("moving", meshes.parts.len(), moving)?;
    let obstacles = members_of("obstacles", meshes.parts.len(), obstacles)?;
    match moving.iter().find(|mesh| obstacles.contains(mesh)) {
        Some(mesh) => Err(GeometryError::new("obstacles", format!("mesh {mesh} is in moving too"))),
        None => Ok((moving, obstacles)),
    }
}

fn options_of(probes: i64, steps: i64, tolerance: f64, ignored_share: f64) -> Result<SweepOptions> {
    for (name, share) in [("tolerance", tolerance), ("ignored_share", ignored_share)] {
        if !(0.0..1.0).contains(&share) {
            return Err(GeometryError::new(name, format!("{share}, expected at least 0 and below 1")));
        }
    }
    let probes = count_of("probes", probes, MAX_PROBES)?;
    let steps = count_of("steps", steps, MAX_STEPS)?;
    Ok(SweepOptions { probes, steps, tolerance, ignored_share })
}

/// The array arguments that describe candidate joints.
struct JointArguments<'py> {
    kinds: Array<'py, u8>,
    directions: Array<'py, f64>,
    pivots: Array<'py, f64>,
    lower: Array<'py, f64>,
    upper: Array<'py, f64>,
    pitches: Option<Array<'py, f64>>,
}

impl JointArguments<'_> {
    fn candidates(&self) -> Result<Vec<CandidateJoint>> {
        let joints = joints_of(&self.kinds, &self.directions, &self.pivots)?;
        let lower = values_of("lower", self.lower.view(), joints.len())?;
        let upper = values_of("upper", self.upper.view(), joints.len())?;
        let pitches = match &self.pitches {
            Some(pitches) => values_of("pitches", pitches.view(), joints.len())?.to_vec(),
            None => vec![0.0; joints.len()],
        };
        if let Some(row) = lower.iter().position(|&limit| limit > 0.0) {
            return Err(GeometryError::new("lower", format!("row {row} is above 0")));
        }
        if let Some(row) = upper.iter().position(|&limit| limit < 0.0) {
            return Err(GeometryError::new("upper", format!("row {row} is below 0")));
        }
        let rows = joints.into_iter().zip(pitches).zip(lower.iter().zip(&upper));
        let candidate = |((axis, pitch), (&lower, &upper))| CandidateJoint { axis, pitch, limits: [lower, upper] };
        Ok(rows.map(candidate).collect())
    }
}
