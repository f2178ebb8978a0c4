//! Distances between points, segments and triangles, and ray intersection.
//!
//! Every result is a pair of points on the two shapes. Rounding may lose some accuracy on slivers, but never gives a
//! distance that no pair of points has. No tolerance is absolute, so any scale works.

use nalgebra::{Point3, Vector3};

/// Corners of a triangle, which may be degenerate.
pub type Triangle = [Point3<f64>; 3];

/// Two points and their squared distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosestPoints {
    /// Squared distance.
    pub squared: f64,
    /// Point on the first shape.
    pub a: Point3<f64>,
    /// Point on the second shape.
    pub b: Point3<f64>,
}

impl ClosestPoints {
    /// Pair of the points `a` and `b`.
    pub fn new(a: Point3<f64>, b: Point3<f64>) -> Self {
        Self { squared: (b - a).norm_squared(), a, b }
    }

    /// The pair with its shapes swapped.
    pub fn flipped(self) -> Self {
        Self { squared: self.squared, a: self.b, b: self.a }
    }

    fn improve(&mut self, other: Self) {
        if other.squared < self.squared {
            *self = other;
        }
    }
}

/// Squared sine of the angle between nearly parallel segments. Their nearest points are ill-defined, so their ends are
/// compared too.
const NEARLY_PARALLEL: f64 = 1e-6;

/// Squared sine of the largest angle of a sliver, which is treated as its three sides.
const SLIVER: f64 = 1e-12;

/// A segment, which may be a point.
#[derive(Clone, Copy)]
struct Segment {
    start: Point3<f64>,
    along: Vector3<f64>,
    squared: f64,
}

impl Segment {
    fn new(start: Point3<f64>, end: Point3<f64>) -> Self {
        let along = end - start;
        Self { start, along, squared: along.norm_squared() }
    }

    fn at(&self, share: f64) -> Point3<f64> {
        self.start + self.along * share
    }

    /// Share in [0, 1] of the projection of an offset onto the segment. `product` is the dot product of the offset with
    /// `along`.
    fn share(&self, product: f64) -> f64 {
        if self.squared > 0.0 { (product / self.squared).clamp(0.0, 1.0) } else { 0.0 }
    }

    fn nearest(&self, point: &Point3<f64>) -> Point3<f64> {
        self.at(self.share((point - self.start).dot(&self.along)))
    }

    fn closest(&self, other: &Self) -> ClosestPoints {
        let across = other.start - self.start;
        let slope = self.along.dot(&other.along);
        let (own, others) = (self.along.dot(&across), other.along.dot(&across));
        let squares = self.squared * other.squared;
        let sharpness = squares - slope * slope;
        if sharpness <= NEARLY_PARALLEL * squares {
            return self.closest_nearly_parallel(other);
        }
        let first = ((own * other.squared - slope * others) / sharpness).clamp(0.0, 1.0);
        let second = other.share(slope * first - others);
        let first = self.share(own + slope * second);
        ClosestPoints::new(self.at(first), other.at(second))
    }

    fn closest_nearly_parallel(&self, other: &Self) -> ClosestPoints {
        let normal = self.along.cross(&other.along);
        let squared = normal.norm_squared();
        let across = other.start - self.start;
        // The cross product stays accurate for small angles, where a difference of squares does not.
        let first =
            if squared > 0.0 { (across.cross(&other.along).dot(&normal) / squared).clamp(0.0, 1.0) } else { 0.0 };
        let facing = other.nearest(&self.at(first));
        let mut best = ClosestPoints::new(self.nearest(&facing), facing);
        for share in [0.0, 1.0] {
            best.improve(ClosestPoints::new(self.at(share), other.nearest(&self.at(share))));
            best.improve(ClosestPoints::new(self.nearest(&other.at(share)), other.at(share)));
        }
        best
    }
}

/// Squared sine of the smallest angle at the first corner for which the plane of a triangle counts as exact.
const SHARP_NORMAL: f64 = 1e-6;

/// Plane of a triangle, with the vectors that project points into it.
struct TrianglePlane {
    origin: Point3<f64>,
    normal: Vector3<f64>,
    squared: f64,
    /// Value of `squared` if the two sides at the origin were perpendicular.
    largest_square: f64,
    /// Dual vectors: their dot products with an offset are the two barycentric coordinates, times `squared`.
    duals: [Vector3<f64>; 2],
    edges: [Vector3<f64>; 2],
}

impl TrianglePlane {
    /// Plane of a triangle; `None` for a triangle without area.
    fn new(t: &Triangle) -> Option<Self> {
        let (u, v) = (t[1] - t[0], t[2] - t[0]);
        let normal = u.cross(&v);
        let squared = normal.norm_squared();
        (squared > 0.0).then(|| Self {
            origin: t[0],
            normal,
            squared,
            largest_square: u.norm_squared() * v.norm_squared(),
            duals: [v.cross(&normal), normal.cross(&u)],
            edges: [u, v],
        })
    }

    /// Height over the plane, times the length of the normal.
    fn height(&self, point: &Point3<f64>) -> f64 {
        (point - self.origin).dot(&self.normal)
    }

    /// True if the plane alone shows that `other` is at least the square root of `bound` away.
    fn separates_from(&self, other: &Triangle, bound: f64) -> bool {
        let [a, b, c] = [self.height(&other[0]), self.height(&other[1]), self.height(&other[2])];
        let gap = a.min(b).min(c).max(-a.max(b).max(c));
        gap > 0.0 && gap * gap >= bound * self.squared && self.squared > SHARP_NORMAL * self.largest_square
    }

    /// Projection of `point` onto the triangle; `None` if it falls outside.
    fn project(&self, point: &Point3<f64>) -> Option<Point3<f64>> {
        let offset = point - self.origin;
        let s = offset.dot(&self.duals[0]) / self.squared;
        let t = offset.dot(&self.duals[1]) / self.squared;
        (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then(|| self.origin + self.edges[0] * s + self.edges[1] * t)
    }

    /// Improves `best` with the corners of `other` and the points where its edges cross the plane. `a` lies on `other`.
    fn closest(&self, other: &Triangle, best: &mut ClosestPoints) {
        let heights = [self.height(&other[0]), self.height(&other[1]), self.height(&other[2])];
        for corner in other {
            if let Some(below) = self.project(corner) {
                best.improve(ClosestPoints::new(*corner, below));
            }
        }
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            if heights[i] * heights[j] < 0.0 {
                let crossing = other[i] + (other[j] - other[i]) * (heights[i] / (heights[i] - heights[j]));
                if let Some(on_face) = self.project(&crossing) {
                    best.improve(ClosestPoints::new(crossing, on_face));
                }
            }
        }
    }
}

/// Nearest points of two triangles; `None` unless their squared distance is below `bound`.
///
/// For triangles that cross or overlap, the two points differ by rounding only.
pub fn triangle_triangle(p: &Triangle, q: &Triangle, bound: f64) -> Option<ClosestPoints> {
    let (face_p, face_q) = (TrianglePlane::new(p), TrianglePlane::new(q));
    let apart = |face: &Option<TrianglePlane>, other: &Triangle| {
        face.as_ref().is_some_and(|face| face.separates_from(other, bound))
    };
    if apart(&face_q, p) || apart(&face_p, q) {
        return None;
    }
    let sides = |t: &Triangle| [Segment::new(t[0], t[1]), Segment::new(t[1], t[2]), Segment::new(t[2], t[0])];
    let (sides_p, sides_q) = (sides(p), sides(q));
    let mut best = ClosestPoints { squared: f64::INFINITY, a: p[0], b: q[0] };
    for (i, side_p) in sides_p.iter().enumerate() {
        for (j, side_q) in sides_q.iter().enumerate() {
            let found = side_p.closest(side_q);
            if found.squared < best.squared {
                best = found;
                // If the slab between the two points separates the triangles, no other pair is nearer.
                let gap = found.b - found.a;
                if (p[(i + 2) % 3] - found.a).dot(&gap) <= 0.0 && (q[(j + 2) % 3] - found.b).dot(&gap) >= 0.0 {
                    return Some(best).filter(|best| best.squared < bound);
                }
            }
        }
    }
    if let Some(face) = face_q {
        face.closest(p, &mut best);
    }
    if let Some(face) = face_p {
        let mut flipped = best.flipped();
        face.closest(q, &mut flipped);
        best = flipped.flipped();
    }
    Some(best).filter(|best| best.squared < bound)
}

/// Squared distance from a point to a triangle.
pub fn point_triangle(point: &Point3<f64>, triangle: &Triangle) -> f64 {
    let face = TrianglePlane::new(triangle).filter(|face| face.squared > SLIVER * face.largest_square);
    if let Some(below) = face.and_then(|face| face.project(point)) {
        return (point - below).norm_squared();
    }
    let [a, b, c] = *triangle;
    let sides = [Segment::new(a, b), Segment::new(b, c), Segment::new(c, a)];
    sides.iter().map(|side| (point - side.nearest(point)).norm_squared()).fold(f64::INFINITY, f64::min)
}

/// Parameter t >= 0 at which the line `origin + t * direction` meets a triangle; `None` for lines inside its plane.
pub fn ray_triangle(origin: &Point3<f64>, direction: &Vector3<f64>, triangle: &Triangle) -> Option<f64> {
    let (u, v) = (triangle[1] - triangle[0], triangle[2] - triangle[0]);
    let across = direction.cross(&v);
    let determinant = u.dot(&across);
    if determinant == 0.0 {
        return None;
    }
    let offset = origin - triangle[0];
    let s = offset.dot(&across) / determinant;
    let along = offset.cross(&u);
    let t = direction.dot(&along) / determinant;
    let distance = v.dot(&along) / determinant;
    (s >= 0.0 && t >= 0.0 && s + t <= 1.0 && distance >= 0.0).then_some(distance)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn triangle() -> impl Strategy<Value = Triangle> {
        prop::array::uniform9(-1.0..1.0f64).prop_map(|x| [0, 3, 6].map(|i| Point3::new(x[i], x[i + 1], x[i + 2])))
    }

    /// Squared distance by which rounding may move a point off a thin triangle.
    const ROUNDING: f64 = 1e-20;

    fn distance(p: &Triangle, q: &Triangle) -> f64 {
        triangle_triangle(p, q, f64::INFINITY).expect("unbounded").squared.sqrt()
    }

    proptest! {
        #[test]
        fn no_two_points_are_nearer_than_the_distance(p in triangle(), q in triangle(), shares in prop::array::uniform4(0.0..1.0f64)) {
            let point = |t: &Triangle, u: f64, v: f64| {
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                t[0] + (t[1] - t[0]) * u + (t[2] - t[0]) * v
            };
            let apart = (point(&p, shares[0], shares[1]) - point(&q, shares[2], shares[3])).norm();
            prop_assert!(distance(&p, &q) <= apart + 1e-12);
        }

        #[test]
        fn the_nearest_points_lie_on_the_triangles(p in triangle(), q in triangle()) {
            let found = triangle_triangle(&p, &q, f64::INFINITY).expect("unbounded");
            prop_assert!(point_triangle(&found.a, &p) < ROUNDING);
            prop_assert!(point_triangle(&found.b, &q) < ROUNDING);
            prop_assert!(((found.b - found.a).norm_squared() - found.squared).abs() < 1e-15);
        }

        #[test]
        fn distances_scale_with_the_triangles(p in triangle(), q in triangle(), exponent in -40i32..40) {
            let scale = 2f64.powi(exponent);
            let scaled = |t: &Triangle| t.map(|corner| corner * scale);
            prop_assert_eq!(distance(&scaled(&p), &scaled(&q)), distance(&p, &q) * scale);
        }

        #[test]
        fn degenerate_triangles_act_as_segments_and_points(p in triangle(), q in triangle()) {
            let (side, corner) = ([q[0], q[1], q[1]], [q[0]; 3]);
            let middle = [q[0], q[1], nalgebra::center(&q[0], &q[1])];
            prop_assert!((distance(&p, &side) - distance(&p, &middle)).abs() < 1e-12);
            prop_assert!((distance(&p, &corner) - point_triangle(&q[0], &p).sqrt()).abs() < 1e-12);
            prop_assert!(distance(&p, &corner) >= distance(&p, &side) - 1e-12);
        }
    }
}
