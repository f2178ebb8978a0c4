//! Sampling and grouping of points for PointNet++ (Qi et al., PointNet++, 2017, section 3).
//!
//! * Farthest point sampling chooses the centers of groups.
//! * A ball query finds the members of each group.
//! * A nearest-neighbour search finds the centers nearest to every point.

use crate::points::point_columns::{BLOCK, PointColumns, least_of};

/// Farthest point sampling: writes as many point indices as `chosen` holds.
///
/// The first is index 0. Each of the others is farthest from all before it; among equally far points the first wins.
///
/// # Panics
///
/// If there are no points.
pub fn farthest_point_sampling(points: &[[f32; 3]], chosen: &mut [i64]) {
    let columns = PointColumns::new(points);
    let mut squared = columns.zeros();
    let mut nearest = columns.zeros();
    // Fillers keep a distance of 0, so they are never the farthest.
    nearest.as_flattened_mut()[..points.len()].fill(f32::INFINITY);
    let mut last = 0;
    for chosen in chosen {
        *chosen = last as i64;
        columns.squared_distances(&points[last], &mut squared);
        for (nearest, squared) in nearest.iter_mut().zip(&squared) {
            *nearest = std::array::from_fn(|entry| nearest[entry].min(squared[entry]));
        }
        let nearest = &nearest.as_flattened()[..points.len()];
        let farthest = nearest.iter().fold(0.0, |farthest: f32, &each| farthest.max(each));
        last = nearest.iter().position(|&each| each == farthest).unwrap_or_default();
    }
}

/// Ball query: writes the indices of the first `count` points within `radius` of each of `centers` to `groups`, row by
/// row.
///
/// A row with fewer points repeats its first one. A row without points holds the last point.
pub fn ball_query(points: &[[f32; 3]], centers: &[[f32; 3]], radius: f32, count: usize, groups: &mut [i64]) {
    let columns = PointColumns::new(points);
    let mut squared = columns.zeros();
    for (center, group) in centers.iter().zip(groups.chunks_exact_mut(count.max(1))) {
        columns.squared_distances(center, &mut squared);
        let squared = &squared.as_flattened()[..points.len()];
        let mut within = (0..).zip(squared).filter(|(_, each)| **each <= radius * radius).map(|(number, _)| number);
        let first = within.next().unwrap_or(points.len() as i64 - 1);
        group[0] = first;
        for place in &mut group[1..] {
            *place = within.next().unwrap_or(first);
        }
    }
}

/// Writes the indices and distances of the `count` centers nearest to each of `points`, row by row, nearest first.
///
/// Among equally far centers the lower index comes first. There must be at least `count` centers.
pub fn nearest_centers(
    points: &[[f32; 3]],
    centers: &[[f32; 3]],
    count: usize,
    nearest: &mut [i64],
    distances: &mut [f32],
) {
    let columns = PointColumns::new(centers);
    let mut squared = columns.zeros();
    let rows = nearest.chunks_exact_mut(count.max(1)).zip(distances.chunks_exact_mut(count.max(1)));
    for (point, (numbers, row)) in points.iter().zip(rows) {
        columns.squared_distances(point, &mut squared);
        row.fill(f32::INFINITY);
        for (start, block) in (0..).step_by(BLOCK).zip(&squared) {
            if least_of(block) < row[count - 1] {
                for (number, &each) in (start..).zip(block) {
                    insert(number, each, numbers, row);
                }
            }
        }
        row.iter_mut().for_each(|each| *each = each.sqrt());
    }
}

/// Inserts a distance into a sorted row, unless it exceeds all of the row.
fn insert(number: i64, distance: f32, numbers: &mut [i64], row: &mut [f32]) {
    let place = row.partition_point(|&each| each <= distance);
    if place < row.len() {
        row[place..].rotate_right(1);
        numbers[place..].rotate_right(1);
        (row[place], numbers[place]) = (distance, number);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn cloud() -> impl Strategy<Value = Vec<[f32; 3]>> {
        prop::collection::vec(prop::array::uniform3(-1.0..1.0f32), 1..70)
    }

    fn apart(a: &[f32; 3], b: &[f32; 3]) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|axis| a[axis] - b[axis]);
        (x * x + y * y + z * z).sqrt()
    }

    proptest! {
        #[test]
        fn each_sampled_point_is_farthest_from_the_points_before_it(points in cloud(), count in 1..12usize) {
            let mut chosen = vec![-1; count.min(points.len())];
            farthest_point_sampling(&points, &mut chosen);
            prop_assert_eq!(chosen[0], 0);
            let gap = |point: &[f32; 3], before: &[i64]| {
                before.iter().map(|&i| apart(point, &points[i as usize])).fold(f32::INFINITY, f32::min)
            };
            for step in 1..chosen.len() {
                let farthest = points.iter().map(|point| gap(point, &chosen[..step])).fold(0.0, f32::max);
                prop_assert_eq!(gap(&points[chosen[step] as usize], &chosen[..step]), farthest);
            }
        }

        #[test]
        fn groups_hold_the_first_points_within_the_radius(
            points in cloud(), centers in cloud(), radius in 0.1..1.5f32, count in 1..9usize
        ) {
            let mut groups = vec![-1; centers.len() * count];
            ball_query(&points, &centers, radius, count, &mut groups);
            for (center, group) in centers.iter().zip(groups.chunks(count)) {
                let squared = |i: &usize| apart(center, &points[*i]).powi(2);
                prop_assume!((0..points.len()).all(|i| (squared(&i) - radius * radius).abs() > 1e-5));
                let mut expected: Vec<_> = (0..points.len()).filter(|i| squared(i) < radius * radius).take(count).collect();
                expected.resize(count, *expected.first().unwrap_or(&(points.len() - 1)));
                prop_assert_eq!(group, expected.into_iter().map(|i| i as i64).collect::<Vec<_>>());
            }
        }

        #[test]
        fn the_nearest_centers_agree_with_a_full_sort(
            points in cloud(), centers in cloud(), count in 1..5usize
        ) {
            let count = count.min(centers.len());
            let (mut nearest, mut distances) = (vec![-1; points.len() * count], vec![f32::NAN; points.len() * count]);
            nearest_centers(&points, &centers, count, &mut nearest, &mut distances);
            for (row, point) in points.iter().enumerate() {
                let mut ordered: Vec<_> = (0..).zip(&centers).map(|(i, center)| (apart(point, center), i)).collect();
                ordered.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                for (place, (distance, number)) in ordered.into_iter().take(count).enumerate() {
                    prop_assert_eq!(distances[row * count + place], distance);
                    prop_assert_eq!(nearest[row * count + place], number);
                }
            }
        }
    }

    #[test]
    fn coincident_points_are_chosen_by_index() {
        let points = [[0.0; 3]; 12];
        let (mut chosen, mut nearest, mut distances) = ([-1; 3], [-1; 24], [-1.0; 24]);
        farthest_point_sampling(&points, &mut chosen);
        nearest_centers(&points, &points, 2, &mut nearest, &mut distances);
        assert_eq!(chosen, [0; 3]);
        assert_eq!(nearest[..4], [0, 1, 0, 1]);
        assert_eq!(distances, [0.0; 24]);
    }
}
