//! Convex hulls of points that may span a solid, a plane, a line or nothing.

use nalgebra::{Point3, Vector3};

use crate::quickhull::{Quickhull, side};

/// Convex hull of a set of points, of the dimension that they span.
#[derive(Debug, Clone, PartialEq)]
pub enum Hull {
    /// All points coincide.
    Point,
    /// All points lie on a line with this unit direction.
    Segment(Vector3<f64>),
    /// All points lie in a plane with this unit normal.
    Planar(Vector3<f64>),
    /// A polyhedron.
    Solid(Polyhedron),
}

/// A closed convex triangle mesh. Coplanar neighbouring triangles are not merged.
#[derive(Debug, Clone, PartialEq)]
pub struct Polyhedron {
    /// Corners.
    pub vertices: Vec<Point3<f64>>,
    /// Corners of the facets, counter-clockwise seen from outside.
    pub facets: Vec<[u32; 3]>,
    /// Edges: two corners and the two facets that meet there.
    pub edges: Vec<Edge>,
}

/// An edge of a [`Polyhedron`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// Its ends.
    pub vertices: [u32; 2],
    /// The facets on its two sides.
    pub facets: [u32; 2],
}

impl Hull {
    /// Hull of `points`, whose coordinates should be of the order of one; thinner than `flatness` counts as flat.
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
        if distance <= flatness || side(points, [a, b, c], d) == 0.0 {
            return Hull::Planar(normal);
        }
        Hull::Solid(Quickhull::new(points, [a, b, c, d]).run())
    }
}

impl Polyhedron {
    /// Area vector of a facet: its outward unit normal times its area.
    pub fn area_vector(&self, facet: u32) -> Vector3<f64> {
        let [a, b, c] = self.facets[facet as usize].map(|v| self.vertices[v as usize]);
        0.5 * (b - a).cross(&(c - a))
    }
}

fn farthest(points: &[Point3<f64>], distance: impl Fn(&Point3<f64>) -> f64) -> (usize, f64) {
    points.iter().map(distance).enumerate().fold((0, -1.0), |best, next| if next.1 > best.1 { next } else { best })
}

/// The two most distant of the points that are extreme along an axis.
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

    /// Closed, convex, and around all the points.
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
            // The plane of a sliver is known no better than its height allows: what is bounded is a volume, not a distance.
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
        fn is_closed_convex_and_around_all_points(
            coordinates in prop::collection::vec((-3i32..4, -3i32..4, -3i32..4, -1i32..2), 4..80)
        ) {
            // A small grid gives many coplanar, collinear and repeated points; the noise makes some of them nearly so.
            let at = |i: i32, noise: i32| 0.1 * i as f64 + 1e-13 * noise as f64;
            let points: Vec<_> = coordinates.iter().map(|&(x, y, z, e)| Point3::new(at(x, e), at(y, -e), at(z, e))).collect();
            if let Hull::Solid(hull) = Hull::of(&points, 1e-9) {
                check(&points, &hull);
            }
        }

        #[test]
        fn of_points_on_a_sphere_has_them_all_as_corners(seed in 0u64..1000) {
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
    fn knows_the_dimension_that_the_points_span() {
        let at = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
        assert_eq!(Hull::of(&[at(1.0, 1.0, 1.0); 5], 1e-9), Hull::Point);
        assert!(matches!(Hull::of(&[at(0.0, 0.0, 0.0), at(1.0, 1.0, 1.0), at(0.3, 0.3, 0.3)], 1e-9), Hull::Segment(_)));
        let square = [at(0.0, 0.0, 0.0), at(1.0, 0.0, 1.0), at(1.0, 1.0, 1.0), at(0.0, 1.0, 0.0)];
        assert!(matches!(Hull::of(&square, 1e-9), Hull::Planar(_)));
    }
}
