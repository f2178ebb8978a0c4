//! Crossings of rays and segments with a surface.

use nalgebra::{Point3, Vector3};

use super::Bvh;
use crate::mesh::triangle::ray_triangle;

/// Largest distance between crossings that count as one, as a share of the surface's diagonal.
const ONE_PLACE: f64 = 1e-9;

impl Bvh {
    /// First crossing of the segment from `start` to `end`, as a share of its length in [0, 1]; `None` if there is
    /// none.
    pub fn first_crossing(&self, start: &Point3<f64>, end: &Point3<f64>) -> Option<f64> {
        let mut first = None;
        self.visit_crossings(start, &(end - start), 1.0, |t| {
            first = Some(t);
            t
        });
        first
    }

    /// Number of places where the ray from `origin` along the unit vector `direction` crosses the surface.
    ///
    /// Coincident triangles count once. Some files store every face twice, once per side.
    pub fn count_crossings(&self, origin: &Point3<f64>, direction: &Vector3<f64>) -> usize {
        let mut met = Vec::new();
        self.visit_crossings(origin, direction, f64::INFINITY, |t| {
            met.push(t);
            f64::INFINITY
        });
        met.sort_unstable_by(f64::total_cmp);
        let apart = ONE_PLACE * self.bounds().squared_diagonal().sqrt();
        met.dedup_by(|next, last| *next - *last <= apart);
        met.len()
    }

    /// Calls `found` with the ray parameter of every crossing up to a limit. Its return value is the new limit.
    fn visit_crossings(
        &self,
        origin: &Point3<f64>,
        direction: &Vector3<f64>,
        limit: f64,
        mut found: impl FnMut(f64) -> f64,
    ) {
        let mut limit = limit;
        let inverse = direction.map(|x| if x == 0.0 { f64::INFINITY } else { x.recip() });
        let meets = |index: u32, limit: f64| self.nodes[index as usize].bounds.meets_ray(origin, &inverse, limit);
        // Most rays miss the mesh. They need no allocation.
        if !meets(0, limit) {
            return;
        }
        let mut stack = vec![0u32];
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index as usize];
            if node.count == 0 {
                stack.extend(self.children(node).into_iter().filter(|&child| meets(child, limit)));
                continue;
            }
            for triangle in self.leaf(node) {
                if let Some(t) = ray_triangle(origin, direction, triangle).filter(|&t| t <= limit) {
                    limit = found(t);
                }
            }
        }
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
        fn crossings_agree_with_a_search_of_all_triangles(mesh in triangle_soup(40), to in prop::array::uniform3(-2.0..2.0f64)) {
            let (start, end) = (Point3::new(-3.0, 0.1, 0.2), Point3::from(to));
            let expected = (0..40)
                .filter_map(|face| ray_triangle(&start, &(end - start), &mesh.triangle(face)))
                .filter(|&share| share <= 1.0)
                .min_by(f64::total_cmp);
            let tree = Bvh::new(&mesh);
            prop_assert_eq!(tree.first_crossing(&start, &end), expected);
            let direction = (end - start).normalize();
            let rays = (0..40).filter_map(|face| ray_triangle(&start, &direction, &mesh.triangle(face)));
            prop_assert_eq!(tree.count_crossings(&start, &direction), rays.count());
        }

        #[test]
        fn duplicate_faces_count_once(mesh in triangle_soup(40), to in prop::array::uniform3(-2.0..2.0f64)) {
            let (start, direction) = (Point3::new(-3.0, 0.1, 0.2), Vector3::from(to).normalize());
            let both = mesh.faces().iter().flat_map(|&[a, b, c]| [[a, b, c], [c, b, a]]).collect();
            let doubled = Mesh::new(mesh.vertices().to_vec(), both).expect("finite");
            let count = |mesh: &Mesh| Bvh::new(mesh).count_crossings(&start, &direction);
            prop_assert_eq!(count(&doubled), count(&mesh));
        }

        #[test]
        fn rays_in_the_plane_of_a_box_side_are_handled(
            place in prop::array::uniform3(-2i32..3), at in 0i32..4, backward in any::<bool>(), axis in 0usize..3,
        ) {
            // A wall perpendicular to the axis, from 0 to 2 in the other coordinates, and a ray along the axis through
            // an integer point.
            let corner = |u: f64, v: f64| {
                let mut corner = Point3::new(u, u, u);
                (corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (f64::from(at), u, v);
                corner
            };
            let corners = vec![corner(0.0, 0.0), corner(2.0, 0.0), corner(2.0, 2.0), corner(0.0, 2.0)];
            let wall = Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).expect("finite");
            let mut start = Point3::from(place.map(f64::from));
            start[axis] = if backward { 9.0 } else { -9.0 };
            let mut end = start;
            end[axis] = -start[axis];
            let is_met = [1, 2].iter().all(|other| (0..=2).contains(&place[(axis + other) % 3]));
            let tree = Bvh::new(&wall);
            prop_assert_eq!(tree.first_crossing(&start, &end).is_some(), is_met);
            for zero in [0.0, -0.0] {
                let mut direction = Vector3::repeat(zero);
                direction[axis] = if backward { -1.0 } else { 1.0 };
                prop_assert_eq!(tree.count_crossings(&start, &direction), usize::from(is_met));
            }
        }
    }
}
