//! Nearest points of two surfaces.

use nalgebra::Vector3;

use super::Bvh;
use crate::mesh::aabb::{Aabb, greater, lesser};
use crate::mesh::triangle::{ClosestPoints, Triangle, triangle_triangle};

impl Bvh {
    /// Nearest points of two surfaces; `None` unless their squared distance is below `bound`.
    ///
    /// The search stops at the first pair with a squared distance of at most `touching`.
    pub fn closest(&self, other: &Self, bound: f64, touching: f64) -> Option<ClosestPoints> {
        let mut best = Best { points: None, bound, distance: bound.sqrt(), direction: Vector3::zeros() };
        let mut stack = vec![(0u32, 0u32, self.bounds().squared_distance(other.bounds()))];
        while let Some((a, b, squared)) = stack.pop() {
            if squared >= best.bound {
                continue;
            }
            let (node_a, node_b) = (&self.nodes[a as usize], &other.nodes[b as usize]);
            if node_a.bounds.gap_along(&node_b.bounds, &best.direction) >= best.distance {
                continue;
            }
            if node_a.count > 0 && node_b.count > 0 {
                best.improve(self.leaf(node_a), other.leaf(node_b), &node_b.bounds);
                if best.bound <= touching {
                    break;
                }
                continue;
            }
            let split_a = node_b.count > 0
                || (node_a.count == 0 && node_a.bounds.squared_diagonal() >= node_b.bounds.squared_diagonal());
            let [near, far] = if split_a {
                self.children(node_a)
                    .map(|child| (child, b, self.nodes[child as usize].bounds.squared_distance(&node_b.bounds)))
            } else {
                other
                    .children(node_b)
                    .map(|child| (a, child, node_a.bounds.squared_distance(&other.nodes[child as usize].bounds)))
            };
            let (near, far) = if far.2 < near.2 { (far, near) } else { (near, far) };
            stack.extend([far, near]);
        }
        best.points
    }
}

/// Nearest points found so far, with the direction between them.
///
/// Boxes that are separated along this direction by the best distance are pruned. Near the optimum, this prunes far
/// more than box distances do.
struct Best {
    points: Option<ClosestPoints>,
    /// Upper bound on the squared distance, and on the distance.
    bound: f64,
    distance: f64,
    /// Unit vector from the first surface to the second; zero before the first pair is found.
    direction: Vector3<f64>,
}

impl Best {
    /// Compares two short lists of triangles. The triangles of the second lie inside `bounds_b`.
    fn improve(&mut self, a: &[Triangle], b: &[Triangle], bounds_b: &Aabb) {
        for p in a {
            let bounds_p = Aabb::of(p);
            if bounds_p.squared_distance(bounds_b) >= self.bound {
                continue;
            }
            for q in b {
                if bounds_p.squared_distance(&Aabb::of(q)) >= self.bound || self.separates(p, q) {
                    continue;
                }
                if let Some(found) = triangle_triangle(p, q, self.bound) {
                    let distance = found.squared.sqrt();
                    self.direction = (found.b - found.a) / distance;
                    if !self.direction.iter().all(|x| x.is_finite()) {
                        self.direction = Vector3::zeros();
                    }
                    (self.points, self.bound, self.distance) = (Some(found), found.squared, distance);
                }
            }
        }
    }

    /// True if the direction separates two triangles by at least the best distance.
    fn separates(&self, p: &Triangle, q: &Triangle) -> bool {
        let origin = p[0];
        let [a, b] = [p[1], p[2]].map(|corner| (corner - origin).dot(&self.direction));
        let [c, d, e] = q.map(|corner| (corner - origin).dot(&self.direction));
        lesser(lesser(c, d), e) - greater(greater(a, b), 0.0) >= self.distance
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::Mesh;
    use crate::test_shapes::triangle_soup;

    proptest! {
        #[test]
        fn the_closest_points_agree_with_a_search_of_all_pairs(a in triangle_soup(25), b in triangle_soup(25), shift in 0.0..4.0f64) {
            let moved = b.vertices().iter().map(|p| p + Vector3::x() * shift).collect();
            let b = Mesh::new(moved, b.faces().to_vec()).expect("finite");
            let all = (0..25).flat_map(|i| (0..25).map(move |j| (i, j)));
            let expected = all
                .filter_map(|(i, j)| triangle_triangle(&a.triangle(i), &b.triangle(j), f64::INFINITY))
                .fold(f64::INFINITY, |least, found| least.min(found.squared));
            let (tree_a, tree_b) = (Bvh::new(&a), Bvh::new(&b));
            let found = tree_a.closest(&tree_b, f64::INFINITY, 0.0).expect("unbounded");
            prop_assert!((found.squared.sqrt() - expected.sqrt()).abs() < 1e-12);
            let swapped = tree_b.closest(&tree_a, f64::INFINITY, 0.0).expect("unbounded");
            prop_assert!((found.squared.sqrt() - swapped.squared.sqrt()).abs() < 1e-12);
            if expected > 1e-6 {
                prop_assert!(tree_a.closest(&tree_b, 0.99 * expected, 0.0).is_none());
            }
        }
    }
}
