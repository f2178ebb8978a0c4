//! NumPy arguments, checked for type, shape and range.
//!
//! An error names the argument, the shape it has and the shape that is expected.

use std::borrow::Cow;

use kinmo_geometry::mesh::triangle_mesh::MAX_COORDINATE;
use kinmo_geometry::{GeometryError, Result};
use nalgebra::{Matrix3, Point3, Vector3};
use numpy::ndarray::{ArrayView1, ArrayView2, ArrayView3, ArrayViewD, Ix1, Ix2, Ix3};
use numpy::{
    Element, PyArray1, PyArray2, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray,
    PyUntypedArrayMethods, dtype,
};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::errors::value_error;

/// Largest number of axes of a rust-numpy view. NumPy arrays may have more.
const MAX_AXES: usize = 32;

/// An array of `T` in any memory layout.
pub struct Array<'py, T: Element> {
    values: PyReadonlyArrayDyn<'py, T>,
    /// Shape of an array with too many axes for a view. Its values are stored flat.
    shape: Option<Vec<usize>>,
}

impl<T: Element> Array<'_, T> {
    /// View of the values, with the shape of the Python array.
    pub fn view(&self) -> ArrayViewD<'_, T> {
        let values = self.values.as_array();
        match &self.shape {
            Some(shape) => values.into_shape_with_order(&shape[..]).expect("the shape has as many values"),
            None => values,
        }
    }
}

impl<'py, T: Element> FromPyObject<'_, 'py> for Array<'py, T> {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let expected = dtype::<T>(object.py());
        let Ok(untyped) = object.cast::<PyUntypedArray>() else {
            let found = object.get_type().name()?;
            return Err(PyTypeError::new_err(format!("expected an array of {expected}, not {found}")));
        };
        let found = untyped.dtype();
        if !found.is_equiv_to(&expected) {
            return Err(PyTypeError::new_err(format!("expected an array of {expected}, not of {found}")));
        }
        let array = object.cast::<PyArrayDyn<T>>()?;
        let copied = |method| PyResult::Ok(array.call_method0(method)?.cast_into::<PyArrayDyn<T>>()?.try_readonly()?);
        if array.ndim() > MAX_AXES {
            return Ok(Self { values: copied("flatten")?, shape: Some(array.shape().to_vec()) });
        }
        let values = if is_addressable(&array) { array.try_readonly()? } else { copied("copy")? };
        Ok(Self { values, shape: None })
    }
}

/// True if a Rust view can address every value: strides are whole multiples of the size of `T`, and the data is
/// aligned.
///
/// Fields of NumPy record arrays need not be.
fn is_addressable<T: Element>(array: &Bound<'_, PyArrayDyn<T>>) -> bool {
    let size = size_of::<T>() as isize;
    array.data().is_aligned() && array.strides().iter().all(|stride| stride % size == 0)
}

/// An array of zeros, allocated by NumPy, so that a `MemoryError` states the requested size.
pub fn zeros<'py, T: Element>(py: Python<'py>, shape: &[usize]) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let array = py.import("numpy")?.call_method1("zeros", (shape, dtype::<T>(py)))?;
    Ok(array.cast_into()?)
}

/// A new array `[len, N]` of rows.
pub fn array_of_rows<'py, T: Element, const N: usize>(
    py: Python<'py>,
    rows: impl IntoIterator<Item = [T; N]>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let values: Vec<T> = rows.into_iter().flatten().collect();
    let count = values.len() / N;
    PyArray1::from_vec(py, values).reshape([count, N])
}

/// A new array `[len, 3]` of vectors.
pub fn array_of_vectors<'py>(
    py: Python<'py>,
    vectors: impl IntoIterator<Item = Vector3<f64>>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    array_of_rows(py, vectors.into_iter().map(<[f64; 3]>::from))
}

/// Error for a wrong shape. `expected` is written as in the documentation, such as `[N, 3]`.
pub fn shape_error<T>(name: &str, array: &ArrayViewD<'_, T>, expected: &str) -> GeometryError {
    GeometryError::new(name, format!("shape {:?}, expected {expected}", array.shape()))
}

/// Checks that an array has exactly the given shape.
pub fn check_shape<T>(name: &str, array: &ArrayViewD<'_, T>, shape: &[usize]) -> Result<()> {
    if array.shape() == shape { Ok(()) } else { Err(shape_error(name, array, &format!("{shape:?}"))) }
}

/// Checks that all values are finite and small enough to be squared and multiplied.
pub fn check_finite<T: Copy + Into<f64>>(name: &str, array: &ArrayViewD<'_, T>) -> Result<()> {
    let fits = |x: &T| (*x).into().abs() <= MAX_COORDINATE;
    // A loop without an early exit lets the compiler compare several contiguous values at a time.
    let all_fit = match array.as_slice_memory_order() {
        Some(values) => values.iter().fold(true, |so_far, x| so_far & fits(x)),
        None => array.iter().all(fits),
    };
    if all_fit {
        return Ok(());
    }
    Err(GeometryError::new(name, format!("not finite, or beyond {MAX_COORDINATE:e}")))
}

/// Checked view of a matrix with `columns` columns.
pub fn rows_of<'a, T>(name: &str, array: ArrayViewD<'a, T>, columns: usize) -> Result<ArrayView2<'a, T>> {
    if array.ndim() != 2 || array.shape()[1] != columns {
        return Err(shape_error(name, &array, &format!("[N, {columns}]")));
    }
    array.into_dimensionality::<Ix2>().map_err(|error| GeometryError::new(name, error.to_string()))
}

/// Checked view of point clouds `[F, N, 3]` with finite coordinates.
pub fn clouds_of<'a>(name: &str, array: ArrayViewD<'a, f32>) -> Result<ArrayView3<'a, f32>> {
    if array.ndim() != 3 || array.shape()[2] != 3 {
        return Err(shape_error(name, &array, "[F, N, 3]"));
    }
    check_finite(name, &array)?;
    array.into_dimensionality::<Ix3>().map_err(|error| GeometryError::new(name, error.to_string()))
}

/// Rows of a point cloud `[N, 3]`.
pub fn triples_of_cloud(cloud: ArrayView2<'_, f32>) -> Vec<[f32; 3]> {
    cloud.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect()
}

/// Checked view of a vector of `len` finite values.
pub fn values_of<'a>(name: &str, array: ArrayViewD<'a, f64>, len: usize) -> Result<ArrayView1<'a, f64>> {
    check_shape(name, &array, &[len])?;
    check_finite(name, &array)?;
    array.into_dimensionality::<Ix1>().map_err(|error| GeometryError::new(name, error.to_string()))
}

/// Flags of an array with the given shape, flattened in C order.
///
/// The bytes are read as `u8`: memory written by other code may hold values that are invalid for a Rust `bool`.
pub fn flags_of(name: &str, array: &Array<'_, bool>, shape: &[usize]) -> PyResult<Vec<bool>> {
    check_shape(name, &array.view(), shape).map_err(value_error)?;
    let bytes = array.values.call_method1("view", (dtype::<u8>(array.values.py()),))?.extract::<Array<'_, u8>>()?;
    Ok(bytes.view().iter().map(|byte| *byte != 0).collect())
}

/// Checked list of `len` finite 3D vectors.
pub fn vectors_of(name: &str, array: ArrayViewD<'_, f64>, len: usize) -> Result<Vec<Vector3<f64>>> {
    Ok(triples_of(name, &array, len)?.iter().copied().map(Vector3::from).collect())
}

/// Checked rows of three finite values. They are borrowed if the array is contiguous, and copied otherwise.
pub fn triples_of<'a>(name: &str, array: &'a ArrayViewD<'_, f64>, len: usize) -> Result<Cow<'a, [[f64; 3]]>> {
    check_shape(name, array, &[len, 3])?;
    check_finite(name, array)?;
    Ok(match array.as_slice() {
        Some(values) => Cow::Borrowed(values.as_chunks().0),
        None => rows_of(name, array.view(), 3)?.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect(),
    })
}

/// Checked list of `len` finite 3D points.
pub fn points_of(name: &str, array: ArrayViewD<'_, f64>, len: usize) -> Result<Vec<Point3<f64>>> {
    Ok(vectors_of(name, array, len)?.into_iter().map(Point3::from).collect())
}

/// Checked list of `len` finite 3 x 3 matrices.
pub fn matrices_of(name: &str, array: ArrayViewD<'_, f64>, len: usize) -> Result<Vec<Matrix3<f64>>> {
    check_shape(name, &array, &[len, 3, 3])?;
    check_finite(name, &array)?;
    let values: Vec<f64> = array.iter().copied().collect();
    Ok(values.chunks_exact(9).map(Matrix3::from_row_slice).collect())
}

/// A checked, finite 3 x 3 matrix.
pub fn matrix_of(name: &str, array: ArrayViewD<'_, f64>) -> Result<Matrix3<f64>> {
    check_shape(name, &array, &[3, 3])?;
    check_finite(name, &array)?;
    Ok(Matrix3::from_row_iterator(array.iter().copied()))
}
