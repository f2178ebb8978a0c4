//! Surface normals estimated from points.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::points::all_nearest_neighbours::all_nearest_neighbours;
use crate::points::distinct_points::distinct_points;
use crate::points::smallest_eigenvector::smallest_eigenvector;

/// Smallest relative spread, as a share of the largest. Smaller spreads are rounding errors.
const NEGLIGIBLE: f64 = 1e-7;

/// Estimated surface normal at a point. Its sign is arbitrary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normal {
    /// A unit vector.
    pub direction: Vector3<f64>,
    /// Flatness of the neighbourhood, from 0 (no plane, or a line) to 1 (a plane).
    pub weight: f64,
}

/// Normal at every point: the direction in which the point and its nearest `neighbours` spread least.
///
/// Duplicate points count once.
pub fn estimate_normals(points: &[Point3<f64>], neighbours: usize) -> Vec<Normal> {
    let (distinct, places) = distinct_points(points);
    let found = normals_of_distinct(&distinct, neighbours);
    places.into_iter().map(|place| found[place]).collect()
}

fn normals_of_distinct(points: &[Point3<f64>], neighbours: usize) -> Vec<Normal> {
    if points.is_empty() {
        return Vec::new();
    }
    let mut found = vec![Normal { direction: Vector3::x(), weight: 0.0 }; points.len()];
    all_nearest_neighbours(points, neighbours + 1, |point, near| found[point] = normal_of(points, near));
    found
}

/// Normal of the plane through the points with the indices `near`.
fn normal_of(points: &[Point3<f64>], near: &[u32]) -> Normal {
    let places = || near.iter().map(|&number| points[number as usize].coords);
    let middle = places().sum::<Vector3<f64>>() / near.len() as f64;
    let spread: Matrix3<f64> = places().map(|place| (place - middle) * (place - middle).transpose()).sum();
    let ([least, across, along], direction) = smallest_eigenvector(&spread);
    let is_line = across <= NEGLIGIBLE * along;
    let flat = if is_line { 0.0 } else { 1.0 - least.max(0.0) / across };
    Normal { direction, weight: flat * flat }
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn points_on_a_plane_have_its_normal(
            places in prop::collection::vec(prop::array::uniform2(-1.0..1.0), 20..60),
            turn in prop::array::uniform3(-3.0..3.0),
            height in -1.0..1.0,
        ) {
            let turn = Rotation3::new(Vector3::from(turn));
            let points: Vec<_> = places.iter().map(|[x, y]| turn * Point3::new(*x, *y, height)).collect();
            let found = estimate_normals(&points, 8);
            prop_assert!(found.iter().filter(|normal| normal.weight > 0.9).count() > points.len() / 2);
            for normal in found {
                prop_assert!(normal.weight < 0.9 || (normal.direction.dot(&(turn * Vector3::z())).abs() - 1.0).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn duplicate_points_do_not_change_the_normals() {
        let points: Vec<_> = (0..25).map(|i| Point3::new(f64::from(i % 5), f64::from(i / 5), 0.0)).collect();
        let many: Vec<_> = points.iter().copied().cycle().take(500).collect();
        let once = estimate_normals(&points, 8);
        assert_eq!(estimate_normals(&many, 8), once.iter().copied().cycle().take(500).collect::<Vec<_>>());
        assert!(once.iter().all(|normal| normal.weight > 1.0 - 1e-6));
    }

    #[test]
    fn points_on_a_line_have_normals_of_zero_weight() {
        let points: Vec<_> = (0..9).map(|i| Point3::new(f64::from(i), 0.0, 0.0)).collect();
        assert!(estimate_normals(&points, 4).iter().all(|normal| normal.weight == 0.0));
        assert!(estimate_normals(&[], 4).is_empty());
        assert_eq!(estimate_normals(&points[..1], 4)[0].weight, 0.0);
    }
}
