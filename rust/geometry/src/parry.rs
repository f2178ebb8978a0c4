//! The seam to parry: the only file that names its types.
//!
//! It says where the nearest place of a surface is and on which triangle, and decomposes symmetric matrices; [`crate::bvh`] tells
//! distances and crossings.

use nalgebra::{Matrix3, Point3, Vector3};
use parry3d_f64::math::{Matrix, SymmetricEigen, Vector};
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::Triangle;

use crate::Mesh;

fn to_parry(point: &Point3<f64>) -> Vector {
    Vector::new(point.x, point.y, point.z)
}

fn from_parry(vector: Vector) -> Vector3<f64> {
    Vector3::new(vector.x, vector.y, vector.z)
}

/// The eigenvalues of a symmetric matrix, the least first, and the unit eigenvector of the least; some unit vector where another is
/// as small.
///
/// In closed form, in less than half of the time that nalgebra takes by steps for any size. Eigenvalues are right to 1e-8
/// of the largest one.
pub(crate) fn least_eigenvector(matrix: &Matrix3<f64>) -> ([f64; 3], Vector3<f64>) {
    let largest = matrix.amax();
    if largest == 0.0 {
        return ([0.0; 3], Vector3::x());
    }
    // It takes what is small, whatever the unit, for nothing.
    let matrix = Matrix::from_cols_array_2d(&(matrix / largest).data.0);
    let values = SymmetricEigen::eigenvalues(matrix);
    let least = SymmetricEigen::eigenvector1(matrix, values.x);
    (values.to_array().map(|value| value * largest), from_parry(least))
}

/// The triangles of a mesh, arranged for projecting points on them.
pub struct Surface {
    triangles: Vec<Triangle>,
    tree: Bvh,
}

/// The place of a surface that is nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// How far away it is.
    pub distance: f64,
    /// The point of the surface.
    pub point: Point3<f64>,
    /// Unit normal of the triangle it lies on, as its corners are ordered; zero for a triangle without area.
    pub normal: Vector3<f64>,
}

impl Surface {
    /// Arranges the triangles of `mesh`.
    pub fn new(mesh: &Mesh) -> Self {
        let triangle = |face| {
            let [a, b, c] = mesh.triangle(face);
            Triangle::new(to_parry(&a), to_parry(&b), to_parry(&c))
        };
        let triangles: Vec<_> = (0..mesh.faces().len()).map(triangle).collect();
        let boxes: Vec<_> = triangles.iter().map(Triangle::local_aabb).collect();
        Self { tree: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes), triangles }
    }

    /// Distance of `point` from the box around the surface; 0 inside.
    pub fn distance_to_bounds(&self, point: &Point3<f64>) -> f64 {
        self.tree.root_aabb().distance_to_local_point(to_parry(point), true)
    }

    /// The place nearest to `point`, if nearer than `reach`.
    pub fn nearest_within(&self, point: &Point3<f64>, reach: f64) -> Option<Nearest> {
        let point = to_parry(point);
        let (face, (distance, place)) = self.tree.find_best(
            reach,
            |node, _| node.aabb().distance_to_local_point(point, true),
            |leaf, _| {
                let place = self.triangles[leaf as usize].project_local_point(point, true).point;
                Some(((place - point).length(), place))
            },
        )?;
        let Triangle { a, b, c } = self.triangles[face as usize];
        let scaled = from_parry((b - a).cross(c - a));
        let normal = scaled.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(Vector3::zeros);
        Some(Nearest { distance, point: Point3::from(from_parry(place)), normal })
    }
}
