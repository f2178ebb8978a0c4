//! Where lines meet a surface.

use nalgebra::{Point3, Vector3};

use super::Bvh;
use crate::triangle::ray_triangle;

/// What is met closer behind each other, in units of the surface's diagonal, is met at one place.
const ONE_PLACE: f64 = 1e-9;

impl Bvh {
    /// Share in [0, 1] of the way from `start` to `end` at which the surface is first met.
    pub fn first_crossing(&self, start: &Point3<f64>, end: &Point3<f64>) -> Option<f64> {
        let mut first = None;
        self.visit_crossings(start, &(end - start), 1.0, |t| {
            first = Some(t);
            t
        });
        first
    }

    /// At how many places the ray from `origin` along the unit vector `direction` meets the surface.
    ///
    /// Triangles that lie on each other, as where files have every face once for either side, are met once.
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

    /// Calls `found` with the parameter of every crossing below a limit, which `found` gives anew.
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
        // Most rays miss the whole mesh: nothing is allocated for them.
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
    use crate::soup::soup;

    proptest! {
        #[test]
        fn a_ray_meets_the_tree_where_it_meets_the_triangles(mesh in soup(40), to in prop::array::uniform3(-2.0..2.0f64)) {
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
        fn faces_that_are_there_twice_are_met_once(mesh in soup(40), to in prop::array::uniform3(-2.0..2.0f64)) {
            let (start, direction) = (Point3::new(-3.0, 0.1, 0.2), Vector3::from(to).normalize());
            let both = mesh.faces().iter().flat_map(|&[a, b, c]| [[a, b, c], [c, b, a]]).collect();
            let doubled = Mesh::new(mesh.vertices().to_vec(), both).expect("finite");
            let count = |mesh: &Mesh| Bvh::new(mesh).count_crossings(&start, &direction);
            prop_assert_eq!(count(&doubled), count(&mesh));
        }

        #[test]
        fn a_ray_in_the_plane_of_a_box_s_side_meets_what_is_there(
            place in prop::array::uniform3(-2i32..3), at in 0i32..4, backward in any::<bool>(), axis in 0usize..3,
        ) {
            // A wall across the axis, from 0 to 2 along the others, and a ray along the axis through any whole place.
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
