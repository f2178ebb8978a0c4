//! Nearest points of several surfaces to given points.

use nalgebra::Point3;

use crate::parry::{Nearest, Surface};

/// The place nearest to `point` on any of `surfaces`; `None` without surfaces.
pub fn nearest(surfaces: &[&Surface], point: &Point3<f64>) -> Option<Nearest> {
    // The surface whose box is nearest most often holds the answer: what it gives prunes the others.
    let mut order: Vec<_> = surfaces.iter().map(|surface| (surface.distance_to_bounds(point), *surface)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best: Option<Nearest> = None;
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
    use crate::soup::soup;
    use crate::triangle::point_triangle;

    proptest! {
        #[test]
        fn no_triangle_is_nearer_than_the_nearest_place(
            meshes in prop::collection::vec(soup(7), 1..4), point in prop::array::uniform3(-3.0..3.0f64),
        ) {
            let point = Point3::from(point);
            let surfaces: Vec<Surface> = meshes.iter().map(Surface::new).collect();
            let found = nearest(&surfaces.iter().collect::<Vec<_>>(), &point).expect("there are surfaces");
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
