//! Normals of a surface of which only points are known.

use std::cmp::Ordering;

use nalgebra::{Matrix3, Point3, Vector3};

use crate::all_neighbours::nearest_of_all;
use crate::parry::least_eigenvector;

/// Of the largest spread: less than this is none, as spreads are not known better.
const NEGLIGIBLE: f64 = 1e-7;

/// The normal of a surface at a point, of either sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normal {
    /// A unit vector.
    pub direction: Vector3<f64>,
    /// From 0, where the neighbours lie on no plane or on a line, to 1.
    pub weight: f64,
}

/// The normal at every one of `points`: the direction in which that and its nearest `neighbours` spread least.
///
/// A point that is there several times is one.
pub fn normals(points: &[Point3<f64>], neighbours: usize) -> Vec<Normal> {
    let (distinct, places) = distinct(points);
    let found = normals_of_distinct(&distinct, neighbours);
    places.into_iter().map(|place| found[place]).collect()
}

/// The points without those that are there before, and the place of each among them.
pub(crate) fn distinct(points: &[Point3<f64>]) -> (Vec<Point3<f64>>, Vec<usize>) {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|a, b| compare(&points[*a], &points[*b]));
    let mut distinct: Vec<Point3<f64>> = Vec::with_capacity(points.len());
    let mut places = vec![0; points.len()];
    for index in order {
        if distinct.last() != Some(&points[index]) {
            distinct.push(points[index]);
        }
        places[index] = distinct.len() - 1;
    }
    (distinct, places)
}

fn compare(a: &Point3<f64>, b: &Point3<f64>) -> Ordering {
    a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
}

fn normals_of_distinct(points: &[Point3<f64>], neighbours: usize) -> Vec<Normal> {
    if points.is_empty() {
        return Vec::new();
    }
    let mut found = vec![Normal { direction: Vector3::x(), weight: 0.0 }; points.len()];
    nearest_of_all(points, neighbours + 1, |point, near| found[point] = normal_of(points, near));
    found
}

/// That of the plane through those of the `points` that are `near`.
fn normal_of(points: &[Point3<f64>], near: &[u32]) -> Normal {
    let places = || near.iter().map(|&number| points[number as usize].coords);
    let middle = places().sum::<Vector3<f64>>() / near.len() as f64;
    let spread: Matrix3<f64> = places().map(|place| (place - middle) * (place - middle).transpose()).sum();
    let ([least, across, along], direction) = least_eigenvector(&spread);
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
        fn points_of_a_plane_have_its_normal(
            places in prop::collection::vec(prop::array::uniform2(-1.0..1.0), 20..60),
            turn in prop::array::uniform3(-3.0..3.0),
            height in -1.0..1.0,
        ) {
            let turn = Rotation3::new(Vector3::from(turn));
            let points: Vec<_> = places.iter().map(|[x, y]| turn * Point3::new(*x, *y, height)).collect();
            let found = normals(&points, 8);
            prop_assert!(found.iter().filter(|normal| normal.weight > 0.9).count() > points.len() / 2);
            for normal in found {
                prop_assert!(normal.weight < 0.9 || (normal.direction.dot(&(turn * Vector3::z())).abs() - 1.0).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn points_that_are_there_many_times_tell_what_they_tell_once() {
        let points: Vec<_> = (0..25).map(|i| Point3::new(f64::from(i % 5), f64::from(i / 5), 0.0)).collect();
        let many: Vec<_> = points.iter().copied().cycle().take(500).collect();
        let once = normals(&points, 8);
        assert_eq!(normals(&many, 8), once.iter().copied().cycle().take(500).collect::<Vec<_>>());
        assert!(once.iter().all(|normal| normal.weight > 1.0 - 1e-6));
    }

    #[test]
    fn points_on_a_line_have_none() {
        let points: Vec<_> = (0..9).map(|i| Point3::new(f64::from(i), 0.0, 0.0)).collect();
        assert!(normals(&points, 4).iter().all(|normal| normal.weight == 0.0));
        assert!(normals(&[], 4).is_empty());
        assert_eq!(normals(&points[..1], 4)[0].weight, 0.0);
    }
}
