use kinmo_geometry::GeometryError;
use kinmo_geometry::motion::{self, RigidMotion};
use numpy::ndarray::Axis;
use numpy::{PyArray4, PyArrayMethods, PyReadonlyArrayDyn};
use pyo3::prelude::*;

use crate::arrays::{check_finite, check_shape, rows_of};
use crate::convert::value_error;
use crate::joints::joints_of;

/// Motions between two looks at the signals.
const BATCH: usize = 1024;

#[pyfunction]
#[pyo3(signature = (points, kinds, directions, pivots, angles, shifts, *, out=None))]
#[allow(clippy::too_many_arguments)]
fn move_points<'py>(
    py: Python<'py>,
    points: PyReadonlyArrayDyn<'py, f32>,
    kinds: PyReadonlyArrayDyn<'py, u8>,
    directions: PyReadonlyArrayDyn<'py, f64>,
    pivots: PyReadonlyArrayDyn<'py, f64>,
    angles: PyReadonlyArrayDyn<'py, f64>,
    shifts: PyReadonlyArrayDyn<'py, f64>,
    out: Option<Bound<'py, PyArray4<f32>>>,
) -> PyResult<Bound<'py, PyArray4<f32>>> {
    let rows = rows_of("points", points.as_array(), 3).map_err(value_error)?;
    let points: Vec<[f32; 3]> = rows.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect();
    if !points.iter().flatten().all(|x| x.is_finite()) {
        return Err(value_error(GeometryError::new("points", "not finite")));
    }
    let joints = joints_of(&kinds, &directions, &pivots).map_err(value_error)?;
    let (angles, shifts) = (angles.as_array(), shifts.as_array());
    let displacements = angles.shape().get(1).copied().unwrap_or(0);
    for (name, array) in [("angles", &angles), ("shifts", &shifts)] {
        check_shape(name, array, &[joints.len(), displacements]).map_err(value_error)?;
        check_finite(name, array).map_err(value_error)?;
    }
    let mut motions: Vec<RigidMotion> = Vec::with_capacity(joints.len() * displacements);
    for (candidate, joint) in joints.iter().enumerate() {
        let (angles, shifts) = (angles.index_axis(Axis(0), candidate), shifts.index_axis(Axis(0), candidate));
        motions.extend(angles.iter().zip(&shifts).map(|(&angle, &shift)| joint.displacement(angle, shift)));
    }

    let shape = [joints.len(), displacements, points.len(), 3];
    let out = match out {
        Some(out) => out,
        None => PyArray4::zeros(py, shape, false),
    };
    let mut writable = out.try_readwrite().map_err(|_| value_error(GeometryError::new("out", "not writable")))?;
    if writable.as_array().shape() != shape {
        let problem = format!("shape {:?}, expected {shape:?}", writable.as_array().shape());
        return Err(value_error(GeometryError::new("out", problem)));
    }
    let moved = writable.as_slice_mut().map_err(|_| value_error(GeometryError::new("out", "not contiguous")))?;
    let batches = moved.chunks_mut((BATCH * points.len() * 3).max(1));
    for (moved, motions) in batches.zip(motions.chunks(BATCH)) {
        py.detach(|| motion::move_points(&points, motions, moved));
        py.check_signals()?;
    }
    drop(writable);
    Ok(out)
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(move_points, module)?)
}
