//! Smallest eigenvector of a symmetric 3 x 3 matrix, by parry's closed form.

use nalgebra::{Matrix3, Vector3};
use parry3d_f64::math::{Matrix, SymmetricEigen};

/// Eigenvalues of a symmetric matrix in ascending order, and a unit eigenvector of the smallest.
///
/// The closed form takes less than half the time of nalgebra's iteration. Eigenvalues are accurate to 1e-8 of the
/// largest one. If the smallest eigenvalue is repeated, the vector is one of its eigenvectors.
pub(crate) fn smallest_eigenvector(matrix: &Matrix3<f64>) -> ([f64; 3], Vector3<f64>) {
    let largest = matrix.amax();
    if largest == 0.0 {
        return ([0.0; 3], Vector3::x());
    }
    // The solver treats small values as zero, so the matrix is scaled first.
    let matrix = Matrix::from_cols_array_2d(&(matrix / largest).data.0);
    let values = SymmetricEigen::eigenvalues(matrix);
    let least = SymmetricEigen::eigenvector1(matrix, values.x);
    (values.to_array().map(|value| value * largest), Vector3::new(least.x, least.y, least.z))
}
