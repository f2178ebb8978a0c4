//! Vectors perpendicular to a given direction.

use nalgebra::Vector3;

/// Two unit vectors that complete `direction` to a right-handed frame (first, second, direction).
///
/// The first is as near as possible to a coordinate axis.
pub fn perpendicular_basis(direction: Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let nearest = Vector3::ith(direction.iamin(), 1.0);
    let first = (nearest - direction * direction.dot(&nearest)).normalize();
    (first, direction.cross(&first))
}

/// A unit vector perpendicular to `direction`, which may be zero.
pub fn any_perpendicular(direction: Vector3<f64>) -> Vector3<f64> {
    let nearest = Vector3::ith(direction.iamin(), 1.0);
    direction.cross(&nearest).try_normalize(0.0).unwrap_or(Vector3::z())
}
