//! Removal of duplicate points.

use std::cmp::Ordering;

use nalgebra::Point3;

/// Distinct points, and the index among them of every point.
pub(crate) fn distinct_points(points: &[Point3<f64>]) -> (Vec<Point3<f64>>, Vec<usize>) {
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
