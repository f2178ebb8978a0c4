//! Checked views of arrays: shape and finiteness, with the argument's name in the error.

use kinmo_geometry::{GeometryError, Result};
use nalgebra::{Matrix3, Point3, Vector3};
use numpy::ndarray::{ArrayView1, ArrayView2, ArrayViewD, Ix1, Ix2};

/// What is wrong with a shape: `expected` is written as in the documentation, such as `[N, 3]`.
fn shape_error<T>(name: &str, array: &ArrayViewD<'_, T>, expected: &str) -> GeometryError {
    GeometryError::new(name, format!("shape {:?}, expected {expected}", array.shape()))
}

/// Refuses an array that does not have exactly the `shape`.
pub fn check_shape<T>(name: &str, array: &ArrayViewD<'_, T>, shape: &[usize]) -> Result<()> {
    if array.shape() == shape { Ok(()) } else { Err(shape_error(name, array, &format!("{shape:?}"))) }
}

/// Refuses NaN and infinities.
pub fn check_finite(name: &str, array: &ArrayViewD<'_, f64>) -> Result<()> {
    if array.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(GeometryError::new(name, "not finite")) }
}

/// A matrix with `columns` columns.
pub fn rows_of<'a, T>(name: &str, array: ArrayViewD<'a, T>, columns: usize) -> Result<ArrayView2<'a, T>> {
    if array.ndim() != 2 || array.shape()[1] != columns {
        return Err(shape_error(name, &array, &format!("[N, {columns}]")));
    }
    array.into_dimensionality::<Ix2>().map_err(|error| GeometryError::new(name, error.to_string()))
}

/// A vector of `len` finite values.
pub fn values_of<'a>(name: &str, array: ArrayViewD<'a, f64>, len: usize) -> Result<ArrayView1<'a, f64>> {
    check_shape(name, &array, &[len])?;
    check_finite(name, &array)?;
    array.into_dimensionality::<Ix1>().map_err(|error| GeometryError::new(name, error.to_string()))
}

/// `len` finite vectors of three.
pub fn vectors_of(name: &str, array: ArrayViewD<'_, f64>, len: usize) -> Result<Vec<Vector3<f64>>> {
    check_shape(name, &array, &[len, 3])?;
    check_finite(name, &array)?;
    Ok(rows_of(name, array, 3)?.rows().into_iter().map(|row| Vector3::new(row[0], row[1], row[2])).collect())
}

/// A finite vector of three.
pub fn vector_of(name: &str, array: ArrayViewD<'_, f64>) -> Result<Vector3<f64>> {
    let values = values_of(name, array, 3)?;
    Ok(Vector3::new(values[0], values[1], values[2]))
}

/// `len` finite points.
pub fn points_of(name: &str, array: ArrayViewD<'_, f64>, len: usize) -> Result<Vec<Point3<f64>>> {
    Ok(vectors_of(name, array, len)?.into_iter().map(Point3::from).collect())
}

/// `len` finite 3 x 3 matrices.
pub fn matrices_of(name: &str, array: ArrayViewD<'_, f64>, len: usize) -> Result<Vec<Matrix3<f64>>> {
    check_shape(name, &array, &[len, 3, 3])?;
    check_finite(name, &array)?;
    let values: Vec<f64> = array.iter().copied().collect();
    Ok(values.chunks_exact(9).map(Matrix3::from_row_slice).collect())
}

/// A finite 3 x 3 matrix.
pub fn matrix_of(name: &str, array: ArrayViewD<'_, f64>) -> Result<Matrix3<f64>> {
    check_shape(name, &array, &[3, 3])?;
    check_finite(name, &array)?;
    Ok(Matrix3::from_row_iterator(array.iter().copied()))
}
