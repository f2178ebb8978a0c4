//! Rectangles of minimum area around points of a plane, by rotating calipers.

use nalgebra::{Point2, Point3, Vector2, Vector3};
use robust::{Coord, orient2d};

use crate::points::perpendicular::perpendicular_basis;

/// Relative tolerance of areas. Among rectangles within it, the one most aligned with the axes wins.
const AREA_TOLERANCE: f64 = 1e-9;

/// Orientation and area of a minimum-area rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    /// Unit direction of one side.
    pub direction: Vector2<f64>,
    /// Area.
    pub area: f64,
}

/// Rectangle of least area around `points`, which are reduced to their convex hull, counter-clockwise.
///
/// One of its sides lies on an edge of the hull (Freeman and Shapira 1975), so only those directions are tried.
pub fn minimum_area_rectangle(points: &mut Vec<Point2<f64>>) -> Rectangle {
    keep_convex_hull(points);
    match points[..] {
        [] | [_] => Rectangle { direction: Vector2::x(), area: 0.0 },
        [a, b] => Rectangle { direction: (b - a).normalize(), area: 0.0 },
        _ => rotate_calipers(points),
    }
}

/// Axes of the box of least cross-section along the unit vector `direction`, which is the third axis.
pub fn minimum_area_axes(points: &[Point3<f64>], direction: Vector3<f64>) -> [Vector3<f64>; 3] {
    let (x, y) = perpendicular_basis(direction);
    let mut projected = points.iter().map(|p| Point2::new(x.dot(&p.coords), y.dot(&p.coords))).collect();
    minimum_area_axes_of_projection(&mut projected, [x, y, direction]).0
}

/// Axes as by [`minimum_area_axes`] for points projected onto the first two axes of `basis`, with the area of the
/// rectangle.
pub fn minimum_area_axes_of_projection(
    points: &mut Vec<Point2<f64>>,
    basis: [Vector3<f64>; 3],
) -> ([Vector3<f64>; 3], f64) {
    let Rectangle { direction, area } = minimum_area_rectangle(points);
    let [x, y, z] = basis;
    let first = (x * direction.x + y * direction.y).normalize();
    ([first, z.cross(&first), z], area)
}

fn rotate_calipers(hull: &[Point2<f64>]) -> Rectangle {
    let count = hull.len();
    let next = |i: usize| if i + 1 == count { 0 } else { i + 1 };
    // Farthest corner along a direction. On a convex polygon, the distance rises up to the farthest corner.
    let advance = |mut corner: usize, direction: Vector2<f64>| {
        for _ in 0..count {
            let following = next(corner);
            if direction.dot(&(hull[following] - hull[corner])) <= 0.0 {
                break;
            }
            corner = following;
        }
        corner
    };
    let mut best = Rectangle { direction: Vector2::x(), area: f64::INFINITY };
    let (mut right, mut top, mut left) = (0, 0, 0);
    for corner in 0..count {
        let side = hull[next(corner)] - hull[corner];
        let squared_length = side.norm_squared();
        let up = Vector2::new(-side.y, side.x);
        right = advance(if corner == 0 { next(corner) } else { right }, side);
        top = advance(if corner == 0 { right } else { top }, up);
        left = advance(if corner == 0 { top } else { left }, -side);
        let width = side.dot(&(hull[right] - hull[left]));
        let height = up.dot(&(hull[top] - hull[corner]));
        let area = width * height / squared_length;
        if area < best.area * (1.0 + AREA_TOLERANCE) {
            let direction = side / squared_length.sqrt();
            if area < best.area * (1.0 - AREA_TOLERANCE) || direction.amax() > best.direction.amax() {
                best = Rectangle { direction, area };
            }
        }
    }
    best
}

/// Convex hull by Andrew's monotone chain. Collinear and repeated points are dropped.
fn keep_convex_hull(points: &mut Vec<Point2<f64>>) {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() < 3 {
        return;
    }
    let mut hull: Vec<Point2<f64>> = Vec::with_capacity(points.len() + 1);
    extend_chain(&mut hull, points.iter(), 0);
    let lower = hull.len() - 1;
    extend_chain(&mut hull, points.iter().rev().skip(1), lower);
    hull.pop();
    *points = hull;
}

fn extend_chain<'a>(hull: &mut Vec<Point2<f64>>, points: impl Iterator<Item = &'a Point2<f64>>, start: usize) {
    for &point in points {
        while let [.., a, b] = hull[start..] {
            // The predicate is exact: a corner kept or dropped by a rounding error would stop the calipers early.
            if orient2d(coord(a), coord(b), coord(point)) > 0.0 {
                break;
            }
            hull.pop();
        }
        hull.push(point);
    }
}

fn coord(point: Point2<f64>) -> Coord<f64> {
    Coord { x: point.x, y: point.y }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn brute_force(points: &[Point2<f64>]) -> f64 {
        let spread = |direction: Vector2<f64>| {
            let along = points.iter().map(|p| p.coords.dot(&direction));
            along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
        };
        let pairs = points.iter().flat_map(|a| points.iter().map(move |b| b - a));
        let directions = pairs.filter_map(|side| side.try_normalize(1e-9));
        directions.map(|d| spread(d) * spread(Vector2::new(-d.y, d.x))).fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #[test]
        fn no_pair_of_points_gives_a_smaller_rectangle(
            coordinates in prop::collection::vec((-3i32..3, -8i32..8, -2i32..3, -2i32..3), 3..30),
        ) {
            // Many nearly repeated and nearly collinear points, as in projections along a prism.
            let points: Vec<_> = coordinates
                .iter()
                .map(|&(x, y, i, j)| Point2::new(x as f64 + i as f64 * 5e-16, y as f64 + j as f64 * 5e-16))
                .collect();
            let expected = brute_force(&points);
            let found = minimum_area_rectangle(&mut points.clone());
            prop_assume!(expected > 1e-9 && expected.is_finite());
            prop_assert!((found.direction.norm() - 1.0).abs() < 1e-12);
            prop_assert!((found.area - expected).abs() <= 1e-9, "{} {}", found.area, expected);
        }
    }
}
