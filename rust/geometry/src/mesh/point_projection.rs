//! Nearest points on surfaces, by parry's bounding volume hierarchy.

use nalgebra::{Point3, Vector3};
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

    /// Distance from `point` to the box around the surface; 0 inside.
    pub fn distance_to_bounds(&self, point: &Point3<f64>) -> f64 {
        self.tree.root_aabb().distance_to_local_point(to_parry(point), true)
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

/// Nearest point to `point` on any of `surfaces`; `None` if there are no surfaces.
pub fn nearest_point(surfaces: &[&ProjectionTree], point: &Point3<f64>) -> Option<NearestPoint> {
    // The surface with the nearest box most often has the nearest point. Its distance prunes the others.
    let mut order: Vec<_> = surfaces.iter().map(|surface| (surface.distance_to_bounds(point), *surface)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best: Option<NearestPoint> = None;
    for (at_least, surface) in order {
        let reach = best.map_or(f64::MAX, |found| found.distance);
        if at_least > reach {
            break;
        }
        best = surface.nearest_within(point, reach).or(best);
    }
    best
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::mesh::triangle::point_triangle;
    use crate::test_shapes::triangle_soup;

    proptest! {
        #[test]
        fn no_triangle_is_nearer_than_the_nearest_point(
            meshes in prop::collection::vec(triangle_soup(7), 1..4), point in prop::array::uniform3(-3.0..3.0f64),
        ) {
            let point = Point3::from(point);
            let surfaces: Vec<ProjectionTree> = meshes.iter().map(ProjectionTree::new).collect();
            let found = nearest_point(&surfaces.iter().collect::<Vec<_>>(), &point).expect("there are surfaces");
            let triangles: Vec<_> = meshes.iter().flat_map(|mesh| (0..mesh.faces().len()).map(|face| mesh.triangle(face))).collect();
            let expected = triangles.iter().map(|triangle| point_triangle(&point, triangle)).fold(f64::INFINITY, f64::min);
            prop_assert!((found.distance - expected.sqrt()).abs() < 1e-9);
            prop_assert!(((found.point - point).norm() - found.distance).abs() < 1e-12);
            let holds = |triangle: &[Point3<f64>; 3]| {
                let [u, v] = [triangle[1] - triangle[0], triangle[2] - triangle[0]];
                point_triangle(&found.point, triangle) < 1e-18 && u.dot(&found.normal).abs() + v.dot(&found.normal).abs() < 1e-9
            };
            prop_assert!(triangles.iter().any(holds));
        }
    }
}
