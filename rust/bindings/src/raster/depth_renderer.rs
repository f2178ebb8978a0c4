//! `render`: depth images and part images.

use kinmo_geometry::raster::depth_renderer::{self, Pinhole};
use kinmo_geometry::{GeometryError, Result};
use nalgebra::Matrix3x4;
use numpy::ndarray::{ArrayViewD, Axis, array};
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, check_finite, check_shape, values_of, zeros};
use crate::arguments::numbers::{count_of, float, integer};
use crate::batches::map_in_batches;
use crate::errors::value_error;
use crate::mesh::meshes::Meshes;

/// Largest width and height, in pixels.
const MAX_SIDE: usize = 1 << 14;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(render, module)?)
}

/// Depths and parts `[F, height, width]`.
type Images<'py> = (Bound<'py, PyArrayDyn<f32>>, Bound<'py, PyArrayDyn<i32>>);

#[pyfunction]
#[pyo3(signature = (meshes, transforms, size, focal, center, *, near, far))]
#[allow(clippy::too_many_arguments)]
fn render<'py>(
    py: Python<'py>,
    meshes: &Meshes,
    transforms: Array<'py, f64>,
    size: (Bound<'py, PyAny>, Bound<'py, PyAny>),
    focal: Array<'py, f64>,
    center: Array<'py, f64>,
    #[pyo3(from_py_with = float)] near: f64,
    #[pyo3(from_py_with = float)] far: f64,
) -> PyResult<Images<'py>> {
    let side = |of: &Bound<'py, PyAny>| count_of("size", integer(of)?, MAX_SIDE).map_err(value_error);
    let (width, height) = (side(&size.0)?, side(&size.1)?);
    let camera = camera_of(width, height, &focal, &center, near, far).map_err(value_error)?;
    let transforms = transforms.view();
    let frames = transforms.shape().first().copied().unwrap_or(0);
    check_shape("transforms", &transforms, &[frames, meshes.parts.len(), 4, 4]).map_err(value_error)?;
    check_finite("transforms", &transforms).map_err(value_error)?;
    check_last_rows(&transforms).map_err(value_error)?;
    let depths = zeros::<f32>(py, &[frames, height, width])?;
    let parts = zeros::<i32>(py, &[frames, height, width])?;
    {
        let (mut depths, mut parts) = (depths.readwrite(), parts.readwrite());
        let pixels = width * height;
        let images = depths.as_slice_mut()?.chunks_mut(pixels).zip(parts.as_slice_mut()?.chunks_mut(pixels));
        let poses = transforms.axis_iter(Axis(0)).map(|frame| {
            frame.axis_iter(Axis(0)).map(|part| Matrix3x4::from_fn(|i, j| part[[i, j]])).collect::<Vec<_>>()
        });
        map_in_batches(py, images.zip(poses), |((depths, parts), poses)| {
            depth_renderer::render(&meshes.parts, &poses, &camera, depths, parts);
        })?;
    }
    Ok((depths, parts))
}

/// Checks that the last rows are 0, 0, 0, 1, which a transposed affine map does not have.
fn check_last_rows(transforms: &ArrayViewD<'_, f64>) -> Result<()> {
    let last = transforms.index_axis(Axis(2), 3);
    match last.rows().into_iter().find(|row| *row != array![0.0, 0.0, 0.0, 1.0]) {
        Some(row) => Err(GeometryError::new("transforms", format!("a last row is {row}, expected 0, 0, 0, 1"))),
        None => Ok(()),
    }
}

fn camera_of(
    width: usize,
    height: usize,
    focal: &Array<'_, f64>,
    center: &Array<'_, f64>,
    near: f64,
    far: f64,
) -> Result<Pinhole> {
    let focal = values_of("focal", focal.view(), 2)?;
    let center = values_of("center", center.view(), 2)?;
    if focal.iter().any(|&length| length <= 0.0) {
        return Err(GeometryError::new("focal", "expected lengths above zero"));
    }
    if !(near > 0.0 && near < far && far.is_finite()) {
        return Err(GeometryError::new("near", format!("{near} with far {far}, expected 0 < near < far")));
    }
    Ok(Pinhole { width, height, focal: [focal[0], focal[1]], center: [center[0], center[1]], near, far })
}
