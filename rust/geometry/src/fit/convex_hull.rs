//! Convex hulls of points that span a solid, a plane, a line or a single point.

use nalgebra::{Point3, Vector3};

use crate::fit::polyhedron::Polyhedron;
use crate::fit::quickhull::{Quickhull, side_of_facet};

/// Convex hull of points, by the dimension that they span.
#[derive(Debug, Clone, PartialEq)]
pub enum Hull {
    /// All points coincide.
    Point,
    /// All points lie on a line with this unit direction.
    Segment(Vector3<f64>),
    /// All points lie in a plane with this unit normal.
    Planar(Vector3<f64>),
    /// The points span a polyhedron.
    Solid(Polyhedron),
}

impl Hull {
    /// Hull of `points`. Their coordinates should be of the order of one. Extents of at most `flatness` count as zero.
    pub fn of(points: &[Point3<f64>], flatness: f64) -> Self {
        let Some([a, b]) = distant_pair(points).filter(|[a, b]| (points[*b] - points[*a]).norm() > flatness) else {
            return Hull::Point;
        };
        let direction = (points[b] - points[a]).normalize();
        let (c, distance) = farthest(points, |p| (p - points[a]).cross(&direction).norm());
        if distance <= flatness {
            return Hull::Segment(direction);
        }
        let normal = direction.cross(&(points[c] - points[a])).normalize();
        let (d, distance) = farthest(points, |p| (p - points[a]).dot(&normal).abs());
        if distance <= flatness || side_of_facet(points, [a, b, c], d) == 0.0 {
            return Hull::Planar(normal);
        }
        Hull::Solid(Quickhull::new(points, [a, b, c, d]).run())
    }
}

fn farthest(points: &[Point3<f64>], distance: impl Fn(&Point3<f64>) -> f64) -> (usize, f64) {
    points.iter().map(distance).enumerate().fold((0, -1.0), |best, next| if next.1 > best.1 { next } else { best })
}

/// The most distant pair among the points that are extreme along a coordinate axis.
fn distant_pair(points: &[Point3<f64>]) -> Option<[usize; 2]> {
    let extremes: Vec<usize> = (0..3)
        .flat_map(|axis| {
            let by = |sign: f64| farthest_along(points, axis, sign);
            [by(1.0), by(-1.0)]
        })
        .collect();
    let pairs = extremes.iter().flat_map(|&a| extremes.iter().map(move |&b| [a, b]));
    pairs.max_by(|[a, b], [c, d]| (points[*a] - points[*b]).norm().total_cmp(&(points[*c] - points[*d]).norm()))
}

fn farthest_along(points: &[Point3<f64>], axis: usize, sign: f64) -> usize {
    (1..points.len()).fold(0, |best, i| if sign * points[i][axis] > sign * points[best][axis] { i } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Checks that a hull is closed and convex, and contains all points.
    fn check(points: &[Point3<f64>], hull: &Polyhedron) {
        assert_eq!(hull.vertices.len() + hull.facets.len(), hull.edges.len() + 2, "Euler's formula");
        for edge in &hull.edges {
            for facet in edge.facets {
                let corners = hull.facets[facet as usize];
                assert!(edge.vertices.iter().all(|v| corners.contains(v)));
            }
        }
        for facet in 0..hull.facets.len() {
            let vector = hull.area_vector(facet as u32);
            let anchor = hull.vertices[hull.facets[facet][0] as usize];
            // The plane of a sliver is only as accurate as its height allows. The bound is therefore on a volume, not
            // on a distance.
            let worst = points.iter().map(|p| vector.dot(&(p - anchor))).fold(f64::MIN, f64::max);
            assert!(worst <= 1e-9 * (1e-6 + vector.norm()), "facet {facet}: {worst}");
        }
    }

    fn solid(points: &[Point3<f64>]) -> Polyhedron {
        match Hull::of(points, 1e-9) {
            Hull::Solid(hull) => hull,
            flat => panic!("expected a solid, got {flat:?}"),
        }
    }

    proptest! {
        #[test]
        fn hulls_are_closed_and_convex_and_contain_all_points(
            coordinates in prop::collection::vec((-3i32..4, -3i32..4, -3i32..4, -1i32..2), 4..80)
        ) {
            // A small grid gives many coplanar, collinear and repeated points. The noise makes some of them nearly so.
            let at = |i: i32, noise: i32| 0.1 * i as f64 + 1e-13 * noise as f64;
            let points: Vec<_> = coordinates.iter().map(|&(x, y, z, e)| Point3::new(at(x, e), at(y, -e), at(z, e))).collect();
            if let Hull::Solid(hull) = Hull::of(&points, 1e-9) {
                check(&points, &hull);
            }
        }

        #[test]
        fn all_points_on_a_sphere_are_corners_of_their_hull(seed in 0u64..1000) {
            use rand::{RngExt, SeedableRng};
            let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
            let mut coordinate = || rng.random::<f64>() - 0.5;
            let points: Vec<_> = (0..60)
                .map(|_| Point3::from(Vector3::new(coordinate(), coordinate(), coordinate()).normalize()))
                .collect();
            let hull = solid(&points);
            check(&points, &hull);
            prop_assert_eq!(hull.vertices.len(), points.len());
        }
    }

    #[test]
    fn hulls_have_the_dimension_that_the_points_span() {
        let at = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
        assert_eq!(Hull::of(&[at(1.0, 1.0, 1.0); 5], 1e-9), Hull::Point);
        assert!(matches!(Hull::of(&[at(0.0, 0.0, 0.0), at(1.0, 1.0, 1.0), at(0.3, 0.3, 0.3)], 1e-9), Hull::Segment(_)));
        let square = [at(0.0, 0.0, 0.0), at(1.0, 0.0, 1.0), at(1.0, 1.0, 1.0), at(0.0, 1.0, 0.0)];
        assert!(matches!(Hull::of(&square, 1e-9), Hull::Planar(_)));
    }
}
