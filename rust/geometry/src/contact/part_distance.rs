//! Exact distance between two parts.

use nalgebra::Point3;

use crate::mesh::aabb::Aabb;
use crate::mesh::bvh::Bvh;
use crate::mesh::triangle::ClosestPoints;

/// Tolerance for contact, in units in the last place of the largest coordinate. Smaller distances are rounding errors.
const TOUCHING_ULPS: f64 = 4.0;

/// Distance between two parts, with the pair of points at which it is attained.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartDistance {
    /// Distance between the surfaces; 0 where they touch or cross.
    pub distance: f64,
    /// Nearest point on the first part.
    pub witness_a: Point3<f64>,
    /// Nearest point on the second part.
    pub witness_b: Point3<f64>,
}

/// The bounding volume hierarchies of a part's meshes, and the box around all of them.
pub struct PartBvh<'a> {
    trees: Vec<&'a Bvh>,
    bounds: Aabb,
}

impl<'a> PartBvh<'a> {
    /// Part that is the union of the meshes of `trees`.
    pub fn new(trees: Vec<&'a Bvh>) -> Self {
        let bounds = trees.iter().fold(Aabb::empty(), |bounds, tree| bounds.merged(tree.bounds()));
        Self { trees, bounds }
    }

    /// Distance between the surfaces of two parts; `None` if it exceeds `max_distance`.
    ///
    /// Surfaces have no inside: the distance to a closed part around this one is the distance to its surface.
    pub fn distance(&self, other: &Self, max_distance: f64) -> Option<PartDistance> {
        let corners = [self.bounds.low, self.bounds.high, other.bounds.low, other.bounds.high];
        let largest = corners.iter().fold(0.0f64, |largest, corner| largest.max(corner.coords.amax()));
        let touching = (TOUCHING_ULPS * f64::EPSILON * largest).powi(2);
        // The next larger number keeps pairs at exactly `max_distance`.
        let mut bound = (max_distance * max_distance).max(touching).next_up();
        if self.bounds.squared_distance(&other.bounds) >= bound {
            return None;
        }
        let mut best: Option<ClosestPoints> = None;
        for (squared, a, b) in self.pairs_by_distance_of_boxes(other) {
            if squared >= bound || bound <= touching {
                break;
            }
            if let Some(found) = a.closest(b, bound, touching) {
                bound = found.squared;
                best = Some(found);
            }
        }
        best.map(|points| PartDistance {
            distance: if points.squared <= touching { 0.0 } else { points.squared.sqrt() },
            witness_a: points.a,
            witness_b: points.b,
        })
    }

    /// Pairs of meshes, ordered by the distance between their boxes. Near pairs come first, so most pairs are pruned.
    fn pairs_by_distance_of_boxes(&self, other: &Self) -> Vec<(f64, &'a Bvh, &'a Bvh)> {
        let pairs = self.trees.iter().flat_map(|&a| other.trees.iter().map(move |&b| (a, b)));
        let mut pairs: Vec<_> = pairs.map(|(a, b)| (a.bounds().squared_distance(b.bounds()), a, b)).collect();
        pairs.sort_by(|x, y| x.0.total_cmp(&y.0));
        pairs
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::Mesh;
    use crate::mesh::triangle::{point_triangle, triangle_triangle};
    use crate::test_shapes::{isometry, mapped, triangle_soup};

    /// Two parts of two meshes each. The second part is shifted along x by up to three lengths.
    fn parts() -> impl Strategy<Value = [Mesh; 4]> {
        let far = |mesh: Mesh, shift: f64| mapped(&mesh, |p| p + nalgebra::Vector3::x() * shift);
        (triangle_soup(6), triangle_soup(9), triangle_soup(5), triangle_soup(8), 0.0..3.0f64)
            .prop_map(move |(a, b, c, d, shift)| [a, b, far(c, shift), far(d, shift)])
    }

    fn distance([a, b, c, d]: &[Mesh; 4], max_distance: f64) -> Option<PartDistance> {
        let trees = [a, b, c, d].map(Bvh::new);
        let [a, b, c, d] = &trees;
        let (first, second) = (PartBvh::new(vec![a, b]), PartBvh::new(vec![c, d]));
        let (forth, back) = (first.distance(&second, max_distance), second.distance(&first, max_distance));
        assert_eq!(forth.is_some(), back.is_some(), "symmetric");
        if let (Some(forth), Some(back)) = (forth, back) {
            let bounds = first.bounds.merged(&second.bounds);
            let size = (bounds.high - bounds.low).norm();
            assert!((forth.distance - back.distance).abs() <= 1e-12 * size, "symmetric");
        }
        forth
    }

    fn triangles(meshes: &[Mesh]) -> Vec<[Point3<f64>; 3]> {
        meshes.iter().flat_map(|mesh| (0..mesh.faces().len()).map(|face| mesh.triangle(face))).collect()
    }

    proptest! {
        #[test]
        fn the_distance_agrees_with_a_search_of_all_pairs(meshes in parts()) {
            let (first, second) = (triangles(&meshes[..2]), triangles(&meshes[2..]));
            let pairs = first.iter().flat_map(|p| second.iter().map(move |q| (p, q)));
            let squares = pairs.filter_map(|(p, q)| triangle_triangle(p, q, f64::INFINITY)).map(|found| found.squared);
            let expected = squares.fold(f64::INFINITY, f64::min).sqrt();
            let found = distance(&meshes, f64::INFINITY).expect("unbounded");
            prop_assert!((found.distance - expected).abs() < 1e-12);
            prop_assert!(((found.witness_b - found.witness_a).norm() - found.distance).abs() < 1e-12);
            for (witness, side) in [(found.witness_a, first), (found.witness_b, second)] {
                prop_assert!(side.iter().any(|triangle| point_triangle(&witness, triangle) < 1e-20));
            }
            prop_assert!(distance(&meshes, expected + 1e-9).is_some());
            prop_assert!(expected < 1e-9 || distance(&meshes, expected - 1e-9).is_none());
        }

        #[test]
        fn the_distance_is_invariant_under_motion_and_scales_with_the_parts(meshes in parts(), motion in isometry(), exponent in -30i32..30) {
            let expected = distance(&meshes, f64::INFINITY).expect("unbounded").distance;
            let moved = meshes.each_ref().map(|mesh| mapped(mesh, |p| motion * p));
            prop_assert!((distance(&moved, f64::INFINITY).expect("unbounded").distance - expected).abs() < 1e-12);
            let scale = 2f64.powi(exponent);
            let scaled = meshes.each_ref().map(|mesh| mapped(mesh, |p| p * scale));
            prop_assert_eq!(distance(&scaled, f64::INFINITY).expect("unbounded").distance, expected * scale);
        }
    }
}
