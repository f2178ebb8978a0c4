//! Nearest neighbours of every point of a small cloud.

use crate::points::point_columns::{BLOCK, PointColumns, least_of};

/// Writes the indices of the `count` nearest neighbours of every point to `found`, row by row, nearest first.
///
/// The point itself counts as a neighbour. Among equally far points the lower index comes first. A cloud of fewer than
/// `count` points gives rows of its own size.
///
/// The search compares every pair. For some hundreds of points that is faster than a search tree.
pub fn nearest_neighbours(points: &[[f32; 3]], count: usize, found: &mut [i64]) {
    let count = count.min(points.len());
    let columns = PointColumns::new(points);
    let mut squared = columns.zeros();
    let mut least = Vec::with_capacity(squared.len());
    let mut ordered = Vec::with_capacity(squared.len());
    let mut near: Vec<(f32, u32)> = Vec::with_capacity(points.len());
    for (point, found) in points.iter().zip(found.chunks_exact_mut(count.max(1))) {
        columns.squared_distances(point, &mut squared);
        least.clear();
        least.extend(squared.iter().map(least_of));
        ordered.clone_from(&least);
        let bound = bound_of(&mut ordered, count);
        near.clear();
        for (start, (block, &least)) in (0..).step_by(BLOCK).zip(squared.iter().zip(&least)) {
            if least <= bound {
                near.extend(block.iter().copied().zip(start..).filter(|&(distance, _)| distance <= bound));
            }
        }
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (found, &(_, number)) in found.iter_mut().zip(&near) {
            *found = i64::from(number);
        }
    }
}

/// Bound on the distance of the `count` nearest points, from the least distance in each block; infinite if there are
/// fewer blocks.
fn bound_of(least: &mut [f32], count: usize) -> f32 {
    if least.len() < count { f32::INFINITY } else { *least.select_nth_unstable_by(count - 1, f32::total_cmp).1 }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;
    use proptest::prelude::*;

    use super::*;
    use crate::points::kd_tree::KdTree;

    proptest! {
        #[test]
        fn neighbours_agree_with_a_kd_tree(
            points in prop::collection::vec(prop::array::uniform3(-1.0..1.0f32), 1..80),
            count in 1..20usize,
        ) {
            let kept = count.min(points.len());
            let mut found = vec![-1; points.len() * kept];
            nearest_neighbours(&points, count, &mut found);
            let count = kept;
            let exact: Vec<Point3<f64>> = points.iter().map(|&point| Point3::from(point).cast()).collect();
            let tree = KdTree::new(&exact);
            let mut nearest = Vec::new();
            for (point, row) in exact.iter().zip(found.chunks(count)) {
                tree.nearest(point, count, &mut nearest);
                for (&number, expected) in row.iter().zip(&nearest) {
                    let distance = (point - exact[number as usize]).norm();
                    prop_assert!((distance - expected.squared.sqrt()).abs() < 1e-6);
                }
                let mut distinct = row.to_vec();
                distinct.sort_unstable();
                distinct.dedup();
                prop_assert_eq!(distinct.len(), count);
            }
        }
    }

    #[test]
    fn coincident_points_are_ordered_by_index() {
        let points = [[1.0, 2.0, 3.0]; 5];
        let mut found = [-1; 10];
        nearest_neighbours(&points, 2, &mut found);
        assert_eq!(found, [[0, 1]; 5].concat()[..]);
    }
}
