//! Nearest points on a surface, by parry's bounding volume hierarchy.

use nalgebra::{Point3, Vector3};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
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

/// Distance from `point` to a box; 0 inside.
pub(crate) fn distance_to_box(bounds: &Aabb, point: &Point3<f64>) -> f64 {
    bounds.distance_to_local_point(to_parry(point), true)
}

/// The triangles of a mesh, arranged for projecting points onto them.
pub struct ProjectionTree {
    triangles: Vec<Triangle>,
    tree: Bvh,
}

/// Nearest point of a surface to a query point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestPoint {
    /// Distance to the query point.
    pub distance: f64,
    /// The point on the surface.
    pub point: Point3<f64>,
    /// Unit normal of its triangle, by the order of the corners; zero for a triangle without area.
    pub normal: Vector3<f64>,
}

impl ProjectionTree {
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

    /// Box around the surface.
    pub(crate) fn bounds(&self) -> Aabb {
        self.tree.root_aabb()
    }

    /// Nearest point of the surface to `point`; `None` unless it is nearer than `reach`.
    pub fn nearest_within(&self, point: &Point3<f64>, reach: f64) -> Option<NearestPoint> {
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
        Some(NearestPoint { distance, point: Point3::from(from_parry(place)), normal })
    }
}
