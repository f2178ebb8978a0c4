//! A tetrahedron of a Delaunay diagram, with its circumsphere.

use nalgebra::{Point3, Vector3};

/// Index that means "no tetrahedron".
pub const NONE: u32 = u32::MAX;
/// Corners of the face opposite to each corner, counter-clockwise seen from outside.
pub const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// A positively oriented tetrahedron.
#[derive(Debug, Clone, Copy)]
pub struct Tetrahedron {
    /// Indices of the corners.
    pub corners: [u32; 4],
    /// The tetrahedron beyond the face opposite to each corner.
    pub neighbours: [u32; 4],
    /// Circumsphere: an offset `y` from the first corner lies inside if `linear . y + quadratic * |y|^2 < 0`.
    linear: Vector3<f64>,
    quadratic: f64,
}

impl Tetrahedron {
    /// Tetrahedron of four points; `None` unless it is positively oriented.
    #[inline]
    pub fn new(points: &[Point3<f64>], corners: [u32; 4]) -> Option<Self> {
        let [o, a, b, c] = corners.map(|corner| points[corner as usize]);
        let (a, b, c) = (a - o, b - o, c - o);
        let (bc, ca, ab) = (b.cross(&c), c.cross(&a), a.cross(&b));
        let volume = a.dot(&bc);
        // Cramer's rule for the sphere through the four corners, multiplied by the volume.
        let linear = bc * a.norm_squared() + ca * b.norm_squared() + ab * c.norm_squared();
        (volume > 0.0).then_some(Self { corners, neighbours: [NONE; 4], linear: -linear, quadratic: volume })
    }

    /// True if the point at `offset` from the first corner lies inside the circumsphere.
    #[inline]
    pub fn sphere_holds(&self, offset: &Vector3<f64>) -> bool {
        self.linear.dot(offset) + self.quadratic * offset.norm_squared() < 0.0
    }

    /// Center of the circumsphere, relative to the first corner.
    pub fn circumcenter(&self) -> Vector3<f64> {
        self.linear / (-2.0 * self.quadratic)
    }
}
