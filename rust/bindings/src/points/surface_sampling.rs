//! `sample_surface`: random or evenly spaced points on meshes.

use kinmo_geometry::points::surface_sample::SurfaceSample;
use kinmo_geometry::points::surface_sampling::{sample_surface_evenly, visit_samples};
use kinmo_geometry::{GeometryError, Mesh};
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

use crate::arguments::arrays::zeros;
use crate::arguments::numbers::{count_of, integer, seed};
use crate::batches::map_in_batches;
use crate::errors::value_error;
use crate::mesh::meshes::Meshes;

/// Largest number of points per mesh, of evenly spaced points per mesh, and of points in total.
///
/// Even spacing needs more memory and time per point.
const MAX_POINTS: usize = 10_000_000;
const MAX_EVEN_POINTS: usize = 100_000;
const MAX_IN_ALL: usize = 100_000_000;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(sample_surface, module)?)
}

/// Points, normals and face indices.
type Samples<'py> = (Bound<'py, PyArrayDyn<f32>>, Bound<'py, PyArrayDyn<f32>>, Bound<'py, PyArrayDyn<u32>>);

#[pyfunction]
#[pyo3(signature = (meshes, count, seed=0, *, blue_noise=false))]
fn sample_surface<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    #[pyo3(from_py_with = integer)] count: i64,
    #[pyo3(from_py_with = seed)] seed: u64,
    blue_noise: bool,
) -> PyResult<Samples<'py>> {
    let parts = meshes.parts.len();
    let most = if blue_noise { MAX_EVEN_POINTS } else { MAX_POINTS }.min(MAX_IN_ALL / parts.max(1));
    let count = count_of("count", count, most).map_err(value_error)?;
    for (part, mesh) in meshes.parts.iter().enumerate() {
        refuse_beyond_single_precision(part, mesh).map_err(value_error)?;
    }
    let (points, normals) = (zeros(py, &[parts, count, 3])?, zeros(py, &[parts, count, 3])?);
    let faces = zeros(py, &[parts, count])?;
    {
        let (mut points, mut normals, mut faces) = (points.readwrite(), normals.readwrite(), faces.readwrite());
        let places = points.as_slice_mut()?.chunks_mut(3 * count).zip(normals.as_slice_mut()?.chunks_mut(3 * count));
        let rows = meshes.parts.iter().zip(places.zip(faces.as_slice_mut()?.chunks_mut(count)));
        map_in_batches(py, rows, |(mesh, ((points, normals), faces))| {
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
    }
    Ok((points, normals, faces))
}

fn refuse_beyond_single_precision(part: usize, mesh: &Mesh) -> Result<(), GeometryError> {
    let (low, high) = mesh.bounds();
    if low.coords.amax().max(high.coords.amax()) > f64::from(f32::MAX) {
        return Err(GeometryError::new(format!("meshes[{part}]"), "has coordinates beyond single precision"));
    }
    Ok(())
}
