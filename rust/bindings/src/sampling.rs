//! `sample_surface`.

use kinmo_geometry::sampling::{SurfaceSample, sample_surface, sample_surface_evenly};
use kinmo_geometry::{GeometryError, Mesh};
use nalgebra::Point3;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

use crate::batches::map_in_batches;
use crate::convert::value_error;
use crate::meshes::Meshes;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(py_sample_surface, module)?)
}

type Samples<'py> = (Bound<'py, PyArray3<f32>>, Bound<'py, PyArray3<f32>>, Bound<'py, PyArray2<u32>>);

#[pyfunction]
#[pyo3(name = "sample_surface", signature = (meshes, count, seed=0, *, blue_noise=false))]
fn py_sample_surface<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    count: i64,
    seed: u64,
    blue_noise: bool,
) -> PyResult<Samples<'py>> {
    let count = usize::try_from(count).ok().filter(|&count| count > 0);
    let count = count.ok_or_else(|| value_error(GeometryError::new("count", "expected at least 1")))?;
    for (part, mesh) in meshes.parts.iter().enumerate() {
        refuse_beyond_single_precision(part, mesh).map_err(value_error)?;
    }
    let sample = if blue_noise { sample_surface_evenly } else { sample_surface };
    let drawn = map_in_batches(py, &meshes.parts, |mesh| single_precision(&sample(mesh, count, seed)))?;
    let parts = drawn.len();
    let (mut points, mut normals, mut faces) = (Vec::new(), Vec::new(), Vec::new());
    for part in drawn {
        points.extend(part.0);
        normals.extend(part.1);
        faces.extend(part.2);
    }
    Ok((
        PyArray1::from_vec(py, points).reshape([parts, count, 3])?,
        PyArray1::from_vec(py, normals).reshape([parts, count, 3])?,
        PyArray1::from_vec(py, faces).reshape([parts, count])?,
    ))
}

fn refuse_beyond_single_precision(part: usize, mesh: &Mesh) -> Result<(), GeometryError> {
    let too_large = |vertex: &Point3<f64>| vertex.coords.amax() > f64::from(f32::MAX);
    match mesh.vertices().iter().any(too_large) {
        true => Err(GeometryError::new(format!("meshes[{part}]"), "has coordinates beyond single precision")),
        false => Ok(()),
    }
}

/// Coordinates of points and normals, and the faces.
fn single_precision(samples: &[SurfaceSample]) -> (Vec<f32>, Vec<f32>, Vec<u32>) {
    let points = samples.iter().flat_map(|s| [s.point.x as f32, s.point.y as f32, s.point.z as f32]).collect();
    let normals = samples.iter().flat_map(|s| [s.normal.x as f32, s.normal.y as f32, s.normal.z as f32]).collect();
    (points, normals, samples.iter().map(|s| s.face).collect())
}
