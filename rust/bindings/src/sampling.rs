//! `sample_surface`.

use kinmo_geometry::sampling::{SurfaceSample, sample_surface_evenly, visit_samples};
use kinmo_geometry::{GeometryError, Mesh};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

use crate::batches::for_each_in_batches;
use crate::convert::value_error;
use crate::meshes::Meshes;

/// Most points on a mesh in one call.
const MOST_POINTS: usize = 10_000_000;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(sample_surface, module)?)
}

type Samples<'py> = (Bound<'py, PyArray3<f32>>, Bound<'py, PyArray3<f32>>, Bound<'py, PyArray2<u32>>);

#[pyfunction]
#[pyo3(signature = (meshes, count, seed=0, *, blue_noise=false))]
fn sample_surface<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    count: i64,
    seed: u64,
    blue_noise: bool,
) -> PyResult<Samples<'py>> {
    let count = usize::try_from(count).ok().filter(|count| (1..=MOST_POINTS).contains(count));
    let count = count.ok_or_else(|| {
        value_error(GeometryError::new("count", format!("expected an integer from 1 to {MOST_POINTS}")))
    })?;
    for (part, mesh) in meshes.parts.iter().enumerate() {
        refuse_beyond_single_precision(part, mesh).map_err(value_error)?;
    }
    let parts = meshes.parts.len();
    let mut points = vec![0.0; parts * count * 3];
    let mut normals = vec![0.0; parts * count * 3];
    let mut faces = vec![0; parts * count];
    let rows = points.chunks_mut(3 * count).zip(normals.chunks_mut(3 * count)).zip(faces.chunks_mut(count));
    let mut slots: Vec<_> = meshes.parts.iter().zip(rows).collect();
    for_each_in_batches(py, &mut slots, |(mesh, ((points, normals), faces))| {
        let mut rows = points.chunks_exact_mut(3).zip(normals.chunks_exact_mut(3)).zip(faces.iter_mut());
        let write = |sample: SurfaceSample| {
            if let Some(((point, normal), face)) = rows.next() {
                point.copy_from_slice(&sample.point.coords.map(|x| x as f32).data.0[0]);
                normal.copy_from_slice(&sample.normal.map(|x| x as f32).data.0[0]);
                *face = sample.face;
            }
        };
        match blue_noise {
            true => sample_surface_evenly(mesh, count, seed).into_iter().for_each(write),
            false => visit_samples(mesh, count, seed, write),
        }
    })?;
    Ok((
        PyArray1::from_vec(py, points).reshape([parts, count, 3])?,
        PyArray1::from_vec(py, normals).reshape([parts, count, 3])?,
        PyArray1::from_vec(py, faces).reshape([parts, count])?,
    ))
}

fn refuse_beyond_single_precision(part: usize, mesh: &Mesh) -> Result<(), GeometryError> {
    let (low, high) = mesh.bounds();
    if low.coords.amax().max(high.coords.amax()) > f64::from(f32::MAX) {
        return Err(GeometryError::new(format!("meshes[{part}]"), "has coordinates beyond single precision"));
    }
    Ok(())
}
