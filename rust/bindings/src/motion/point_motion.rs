//! `move_points`: points moved along candidate joints.

use kinmo_geometry::GeometryError;
use kinmo_geometry::motion::joint_axis::RigidMotion;
use kinmo_geometry::motion::point_motion::PointBlocks;
use numpy::ndarray::Axis;
use numpy::{BorrowError, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, check_finite, check_shape, rows_of, triples_of_cloud, zeros};
use crate::arguments::joints::joints_of;
use crate::batches::map_in_batches;
use crate::errors::value_error;

/// Largest coordinate and translation. The sum of four of them still fits single precision.
const MAX_COORDINATE: f64 = f32::MAX as f64 / 4.0;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(move_points, module)?)
}

#[pyfunction]
#[pyo3(signature = (points, kinds, directions, pivots, angles, shifts, *, out=None))]
#[allow(clippy::too_many_arguments)]
fn move_points<'py>(
    py: Python<'py>,
    points: Array<'py, f32>,
    kinds: Array<'py, u8>,
    directions: Array<'py, f64>,
    pivots: Array<'py, f64>,
    angles: Array<'py, f64>,
    shifts: Array<'py, f64>,
    out: Option<Bound<'py, PyArrayDyn<f32>>>,
) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
    check_finite("points", &points.view()).map_err(value_error)?;
    let rows = rows_of("points", points.view(), 3).map_err(value_error)?;
    let points = triples_of_cloud(rows);
    if points.iter().flatten().any(|x| f64::from(x.abs()) > MAX_COORDINATE) {
        return Err(value_error(GeometryError::new("points", format!("beyond {MAX_COORDINATE:e}"))));
    }
    let joints = joints_of(&kinds, &directions, &pivots).map_err(value_error)?;
    let (angles, shifts) = (angles.view(), shifts.view());
    let &[_, displacements] = angles.shape() else {
        let problem = format!("shape {:?}, expected [{}, D]", angles.shape(), joints.len());
        return Err(value_error(GeometryError::new("angles", problem)));
    };
    for (name, array) in [("angles", &angles), ("shifts", &shifts)] {
        check_shape(name, array, &[joints.len(), displacements]).map_err(value_error)?;
        check_finite(name, array).map_err(value_error)?;
    }
    let mut motions: Vec<RigidMotion> = Vec::with_capacity(joints.len() * displacements);
    for (candidate, joint) in joints.iter().enumerate() {
        let (angles, shifts) = (angles.index_axis(Axis(0), candidate), shifts.index_axis(Axis(0), candidate));
        motions.extend(angles.iter().zip(&shifts).map(|(&angle, &shift)| joint.displacement(angle, shift)));
    }
    if let Some(at) = motions.iter().position(|motion| motion.translation.vector.amax() > MAX_COORDINATE) {
        let problem = format!("row {}: pivot and shift move points beyond {MAX_COORDINATE:e}", at / displacements);
        return Err(value_error(GeometryError::new("pivots", problem)));
    }

    let shape = [joints.len(), displacements, points.len(), 3];
    let out = match out {
        Some(out) => out,
        None => zeros(py, &shape)?,
    };
    if out.shape() != shape {
        let problem = format!("shape {:?}, expected {shape:?}", out.shape());
        return Err(value_error(GeometryError::new("out", problem)));
    }
    let refused = |problem: &str| value_error(GeometryError::new("out", problem));
    // An array in Fortran order is contiguous too, but rows are written in C order.
    if !out.is_c_contiguous() {
        return Err(refused("not contiguous in the order of C"));
    }
    let mut writable = out.try_readwrite().map_err(|error| match error {
        BorrowError::AlreadyBorrowed => refused("overlaps an input, or is in use"),
        _ => refused("not writable"),
    })?;
    let moved = writable.as_slice_mut().map_err(|_| refused("not aligned"))?;
    let blocks = PointBlocks::new(&points);
    let rows = moved.chunks_mut((points.len() * 3).max(1)).zip(&motions);
    map_in_batches(py, rows, |(moved, motion)| blocks.moved_into(motion, moved))?;
    drop(writable);
    Ok(out)
}
