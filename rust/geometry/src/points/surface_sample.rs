//! Sample of a surface.

use nalgebra::{Point3, Vector3};

/// A point on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceSample {
    /// Position.
    pub point: Point3<f64>,
    /// Unit normal of the face. On a mesh without area, a unit vector perpendicular to the edge.
    pub normal: Vector3<f64>,
    /// Index of the face.
    pub face: u32,
}
