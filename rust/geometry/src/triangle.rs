//! Distance between triangles.
//!
//! Every candidate is a pair of points of the two triangles, so that rounding can lose a little sharpness on slivers but
//! never report a distance that no pair of points has. No tolerance is absolute: any scale works.

use nalgebra::{Point3, Vector3};

/// Corners of a triangle, degenerate ones included.
pub type Triangle = [Point3<f64>; 3];

/// Two points and the square of how far they are apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosestPoints {
    /// Squared distance.
    pub squared: f64,
    /// The point on the first shape.
    pub a: Point3<f64>,
    /// The point on the second shape.
    pub b: Point3<f64>,
}

impl ClosestPoints {
    /// The pair of `a` and `b`.
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

/// Segments whose directions differ by less than the square root of this are also compared by their ends.
const NEARLY_PARALLEL: f64 = 1e-10;

/// Parameter in [0, 1] of the point of `origin + t * along` nearest to `point`.
fn project_on_segment(point: &Point3<f64>, origin: &Point3<f64>, along: &Vector3<f64>) -> f64 {
    let squared = along.norm_squared();
    if squared > 0.0 { ((point - origin).dot(along) / squared).clamp(0.0, 1.0) } else { 0.0 }
}

fn ends_against_segment(ends: [Point3<f64>; 2], origin: &Point3<f64>, along: &Vector3<f64>) -> ClosestPoints {
    let [first, second] =
        ends.map(|end| ClosestPoints::new(end, origin + along * project_on_segment(&end, origin, along)));
    if second.squared < first.squared { second } else { first }
}

/// Nearest points of the segments `p0 p1` and `q0 q1`, each of which may be a point.
pub fn segment_segment(p0: &Point3<f64>, p1: &Point3<f64>, q0: &Point3<f64>, q1: &Point3<f64>) -> ClosestPoints {
    let (u, v, w) = (p1 - p0, q1 - q0, q0 - p0);
    let normal = u.cross(&v);
    let (uu, vv, nn) = (u.norm_squared(), v.norm_squared(), normal.norm_squared());
    // The cross product keeps its relative accuracy for small angles, where `uu * vv - (u . v)^2` has none left.
    let s = if nn > 0.0 { (w.cross(&v).dot(&normal) / nn).clamp(0.0, 1.0) } else { 0.0 };
    let t = project_on_segment(&(p0 + u * s), q0, &v);
    let s = project_on_segment(&(q0 + v * t), p0, &u);
    let mut best = ClosestPoints::new(p0 + u * s, q0 + v * t);
    if nn <= NEARLY_PARALLEL * uu * vv {
        best.improve(ends_against_segment([*p0, *p1], q0, &v));
        best.improve(ends_against_segment([*q0, *q1], p0, &u).flipped());
    }
    best
}

/// The plane of a triangle with what is needed to tell whether a point projects into it.
struct Face {
    origin: Point3<f64>,
    normal: Vector3<f64>,
    squared: f64,
    /// Dot products with these give the two barycentric coordinates, times `squared`.
    duals: [Vector3<f64>; 2],
    edges: [Vector3<f64>; 2],
}

impl Face {
    /// `None` for a triangle without area.
    fn new(t: &Triangle) -> Option<Self> {
        let (u, v) = (t[1] - t[0], t[2] - t[0]);
        let normal = u.cross(&v);
        let squared = normal.norm_squared();
        (squared > 0.0).then(|| Self {
            origin: t[0],
            normal,
            squared,
            duals: [v.cross(&normal), normal.cross(&u)],
            edges: [u, v],
        })
    }

    /// Height over the plane, times the length of the normal.
    fn height(&self, point: &Point3<f64>) -> f64 {
        (point - self.origin).dot(&self.normal)
    }

    /// The point of the triangle below `point`, if `point` projects into it.
    fn project(&self, point: &Point3<f64>) -> Option<Point3<f64>> {
        let offset = point - self.origin;
        let s = offset.dot(&self.duals[0]) / self.squared;
        let t = offset.dot(&self.duals[1]) / self.squared;
        (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then(|| self.origin + self.edges[0] * s + self.edges[1] * t)
    }

    /// Nearest candidate of the corners of `other` and of the edges that cross the plane; `a` lies on `other`.
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

/// The point of a triangle nearest to `point`.
pub fn nearest_on_triangle(point: &Point3<f64>, triangle: &Triangle) -> Point3<f64> {
    if let Some(below) = Face::new(triangle).and_then(|face| face.project(point)) {
        return below;
    }
    let on_edge = |i: usize| {
        let along = triangle[(i + 1) % 3] - triangle[i];
        triangle[i] + along * project_on_segment(point, &triangle[i], &along)
    };
    let squared = |place: &Point3<f64>| (place - point).norm_squared();
    let [first, second, third] = [on_edge(0), on_edge(1), on_edge(2)];
    let nearer = if squared(&second) < squared(&first) { second } else { first };
    if squared(&third) < squared(&nearer) { third } else { nearer }
}

/// Nearest points of two triangles; triangles that cross or overlap are as far apart as rounding puts the common point.
pub fn triangle_triangle(p: &Triangle, q: &Triangle) -> ClosestPoints {
    let mut best = ClosestPoints::new(p[0], q[0]);
    for i in 0..3 {
        for j in 0..3 {
            let (p0, p1, p2) = (&p[i], &p[(i + 1) % 3], &p[(i + 2) % 3]);
            let (q0, q1, q2) = (&q[j], &q[(j + 1) % 3], &q[(j + 2) % 3]);
            let edge = segment_segment(p0, p1, q0, q1);
            if edge.squared <= best.squared {
                best = edge;
                // The slab between the two points parts the triangles: nothing can be nearer.
                let gap = edge.b - edge.a;
                if (p2 - edge.a).dot(&gap) <= 0.0 && (q2 - edge.b).dot(&gap) >= 0.0 {
                    return best;
                }
            }
        }
    }
    if let Some(face) = Face::new(q) {
        face.closest(p, &mut best);
    }
    if let Some(face) = Face::new(p) {
        let mut flipped = best.flipped();
        face.closest(q, &mut flipped);
        best = flipped.flipped();
    }
    best
}

/// Parameter at which the line `origin + t * direction`, t >= 0, meets a triangle; lines inside its plane do not.
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
