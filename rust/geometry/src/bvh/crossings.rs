//! Where lines meet a surface.

use nalgebra::{Point3, Vector3};

use super::Bvh;
use crate::triangle::ray_triangle;

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

    /// How often the ray from `origin` along `direction` meets the surface.
    pub fn count_crossings(&self, origin: &Point3<f64>, direction: &Vector3<f64>) -> usize {
        let mut count = 0;
        self.visit_crossings(origin, direction, f64::INFINITY, |_| {
            count += 1;
            f64::INFINITY
        });
        count
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
        let inverse = direction.map(f64::recip);
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
            let rays = (0..40).filter_map(|face| ray_triangle(&start, &(end - start), &mesh.triangle(face)));
            prop_assert_eq!(tree.count_crossings(&start, &(end - start)), rays.count());
        }
    }
}
