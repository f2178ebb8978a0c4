//! The seam to parry: the only file that names its types.

use nalgebra::Point3;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::Triangle;

/// Height over longest side of the thinnest triangle that is not taken for a segment.
const THINNEST: f64 = 1e-12;

fn vector(point: Point3<f64>) -> Vector {
    Vector::new(point.x, point.y, point.z)
}

/// A triangle in which parry can find the nearest point: one too thin to have a normal becomes its longest side.
fn triangle([a, b, c]: [Vector; 3]) -> Triangle {
    let sides = [[a, b], [b, c], [c, a]];
    let longest = sides.into_iter().fold([a, a], |long, side| if length(side) > length(long) { side } else { long });
    if (b - a).cross(c - a).length() > THINNEST * length(longest) * length(longest) {
        return Triangle::new(a, b, c);
    }
    Triangle::new(longest[0], longest[1], longest[1])
}

fn length([from, to]: [Vector; 2]) -> f64 {
    (to - from).length()
}

/// The triangles of a mesh, arranged for distances from points.
pub struct Surface {
    triangles: Vec<Triangle>,
    tree: Bvh,
}

impl Surface {
    /// Arranges the triangles `[a, b, c]`.
    pub fn new(triangles: impl Iterator<Item = [Point3<f64>; 3]>) -> Self {
        let triangles: Vec<_> = triangles.map(|corners| triangle(corners.map(vector))).collect();
        let boxes: Vec<_> = triangles.iter().map(Triangle::local_aabb).collect();
        Self { tree: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes), triangles }
    }

    /// Distance from `point` to the surface, if less than `reach`.
    pub fn distance_within(&self, point: Point3<f64>, reach: f64) -> Option<f64> {
        let point = vector(point);
        let found = self.tree.find_best(
            reach,
            |node, _| node.aabb().distance_to_local_point(point, true),
            |leaf, _| Some(self.triangles[leaf as usize].distance_to_local_point(point, true)),
        );
        found.map(|(_, distance)| distance)
    }
}
