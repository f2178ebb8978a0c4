//! Rotation nearest to a matrix, and angles between rotations.

use nalgebra::{Matrix3, Matrix4, Quaternion, Rotation3, SymmetricEigen, UnitQuaternion, Vector3, Vector4};

/// Largest number of steps of the eigenvector search, which typically takes a dozen.
const MAX_STEPS: usize = 200;

/// Rotation nearest to a matrix, and the stretches of the matrix in descending order.
///
/// The last stretch is negative if the matrix contains a reflection. The quaternion of the rotation is an eigenvector
/// of a 4 x 4 matrix. Singular values of the squared matrix would lose half of the digits, and with them the rotation
/// of a rod about its length.
///
/// Returns `None` if the eigenvector search does not converge. Source: Horn, Closed-form solution of absolute
/// orientation using unit quaternions, 1987.
pub(crate) fn nearest_rotation(matrix: Matrix3<f64>) -> Option<(Rotation3<f64>, Vector3<f64>)> {
    let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = matrix.data.0;
    let products = Matrix4::from_columns(&[
        Vector4::new(xx + yy + zz, zy - yz, xz - zx, yx - xy),
        Vector4::new(zy - yz, xx - yy - zz, xy + yx, xz + zx),
        Vector4::new(xz - zx, xy + yx, yy - xx - zz, yz + zy),
        Vector4::new(yx - xy, xz + zx, yz + zy, zz - xx - yy),
    ]);
    let eigen = SymmetricEigen::try_new(products, f64::EPSILON, MAX_STEPS)?;
    let mut order = [0, 1, 2, 3];
    order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
    let q = eigen.eigenvectors.column(order[0]);
    let rotation = UnitQuaternion::new_normalize(Quaternion::new(q[0], q[1], q[2], q[3])).to_rotation_matrix();
    let [largest, second, third, last] = order.map(|i| eigen.eigenvalues[i]);
    Some((rotation, Vector3::new(largest + second, largest + third, largest + last) * 0.5))
}

/// Angle between two rotations, in radians; exactly 0 for equal rotations.
pub(crate) fn angle_between(a: &Rotation3<f64>, b: &Rotation3<f64>) -> f64 {
    let chord = (a.matrix() - b.matrix()).norm() / 8f64.sqrt();
    2.0 * chord.min(1.0).asin()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_nearest_rotation_is_the_polar_factor(rows in prop::array::uniform9(-1.0..1.0)) {
            let matrix = Matrix3::from_row_slice(&rows);
            let (rotation, stretches) = nearest_rotation(matrix).expect("finite");
            let stretched = rotation.matrix().transpose() * matrix;
            prop_assert!((stretched - stretched.transpose()).norm() < 1e-12 * (1.0 + 1.0 / (stretches[1] + stretches[2])));
            let singular = nalgebra::DMatrix::from_row_slice(3, 3, &rows).singular_values();
            for (mine, other) in stretches.iter().zip(singular.iter()) {
                prop_assert!((mine.abs() - other).abs() < 1e-12, "{stretches} {singular}");
            }
            prop_assert!(stretches[2] * matrix.determinant() >= -1e-12);
        }
    }
}
