//! The nearest points of every point of a small cloud, and which of them has the most of a feature.

/// Points that are compared at a time.
pub(crate) const LANES: usize = 8;

/// For every point the numbers of its `count` nearest ones, itself among them, the nearest first; row after row, to `found`.
///
/// Of points that are equally far those with lower numbers come first. A cloud of fewer than `count` points gives rows that
/// are as long as it. Every pair is looked at, which for some hundreds of points takes less time than a search tree does.
pub fn nearest_neighbours(points: &[[f32; 3]], count: usize, found: &mut [i64]) {
    let count = count.min(points.len());
    let columns = Columns::new(points);
    let mut squared = columns.lanes();
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
        for (start, (lanes, &least)) in (0..).step_by(LANES).zip(squared.iter().zip(&least)) {
            if least <= bound {
                near.extend(lanes.iter().copied().zip(start..).filter(|&(distance, _)| distance <= bound));
            }
        }
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (found, &(_, number)) in found.iter_mut().zip(&near) {
            *found = i64::from(number);
        }
    }
}

/// Which row of `features`, each of `width`, has the largest of every column, among the `count` rows that a row of `index`
/// names; row after row, to `found`. Of equal ones it is the one named first; what is no number counts as larger than all that
/// are.
///
/// # Panics
///
/// If a row is named that there is none of.
pub fn largest_neighbours(features: &[f32], width: usize, index: &[u32], count: usize, found: &mut [i64]) {
    // As wide as features: wider numbers would make the compiler compare half as many at a time.
    let mut row = vec![0; width];
    for (named, found) in index.chunks_exact(count.max(1)).zip(found.chunks_exact_mut(width.max(1))) {
        for (start, row) in (0..).step_by(LANES).zip(row.chunks_mut(LANES)) {
            let columns_of = |number: u32| lanes_of(&features[number as usize * width..][start..width]);
            let at = largest_of_lanes(named, columns_of);
            row.copy_from_slice(&at[..row.len()]);
        }
        for (found, &at) in found.iter_mut().zip(&row) {
            *found = i64::from(at);
        }
    }
}

/// Which of the numbers has the largest value, lane by lane. Lanes are compared without branches, so that all are at once.
fn largest_of_lanes(numbers: &[u32], values_of: impl Fn(u32) -> [f32; LANES]) -> [u32; LANES] {
    let mut largest = [f32::NEG_INFINITY; LANES];
    let mut at = [numbers[0]; LANES];
    for &number in numbers {
        let values = values_of(number);
        for lane in 0..LANES {
            let stays = (values[lane] <= largest[lane]) | largest[lane].is_nan();
            largest[lane] = if stays { largest[lane] } else { values[lane] };
            at[lane] = if stays { at[lane] } else { number };
        }
    }
    at
}

/// The first values; of fewer than there are lanes, the rest of these are less than all.
fn lanes_of(values: &[f32]) -> [f32; LANES] {
    let padded = || std::array::from_fn(|lane| values.get(lane).copied().unwrap_or(f32::NEG_INFINITY));
    values.first_chunk().copied().unwrap_or_else(padded)
}

pub(crate) fn least_of(lanes: &[f32; LANES]) -> f32 {
    lanes.iter().fold(f32::INFINITY, |least, &lane| if lane < least { lane } else { least })
}

/// What `count` of the least distances of chunks do not exceed, so that as many points are no farther; infinite if there are
/// fewer chunks.
fn bound_of(least: &mut [f32], count: usize) -> f32 {
    if least.len() < count { f32::INFINITY } else { *least.select_nth_unstable_by(count - 1, f32::total_cmp).1 }
}

/// Points coordinate by coordinate, the last lanes filled with what is infinitely far.
pub(crate) struct Columns {
    chunks: Vec<[[f32; LANES]; 3]>,
}

impl Columns {
    pub(crate) fn new(points: &[[f32; 3]]) -> Self {
        let chunk_of = |chunk: &[[f32; 3]]| {
            [0, 1, 2].map(|axis| std::array::from_fn(|lane| chunk.get(lane).map_or(f32::INFINITY, |point| point[axis])))
        };
        Self { chunks: points.chunks(LANES).map(chunk_of).collect() }
    }

    /// Room for a value of each point, and of what fills up the last lanes.
    pub(crate) fn lanes(&self) -> Vec<[f32; LANES]> {
        vec![[0.0; LANES]; self.chunks.len()]
    }

    pub(crate) fn squared_distances(&self, point: &[f32; 3], squared: &mut [[f32; LANES]]) {
        for (squared, [x, y, z]) in squared.iter_mut().zip(&self.chunks) {
            *squared = std::array::from_fn(|lane| {
                let [dx, dy, dz] = [x[lane] - point[0], y[lane] - point[1], z[lane] - point[2]];
                dx * dx + dy * dy + dz * dz
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;
    use proptest::prelude::*;

    use super::*;
    use crate::point_tree::PointTree;

    proptest! {
        #[test]
        fn neighbours_are_those_of_a_search_tree(
            points in prop::collection::vec(prop::array::uniform3(-1.0..1.0f32), 1..80),
            count in 1..20usize,
        ) {
            let kept = count.min(points.len());
            let mut found = vec![-1; points.len() * kept];
            nearest_neighbours(&points, count, &mut found);
            let count = kept;
            let exact: Vec<Point3<f64>> = points.iter().map(|&point| Point3::from(point).cast()).collect();
            let tree = PointTree::new(&exact);
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

    proptest! {
        #[test]
        fn the_largest_neighbours_are_those_that_are_found_column_by_column(
            values in prop::collection::vec(prop_oneof![(-3..3i8).prop_map(f32::from), Just(f32::NAN)], 12),
            index in prop::collection::vec(0..4u32, 15),
        ) {
            let mut found = [-1; 9];
            largest_neighbours(&values, 3, &index, 5, &mut found);
            for (named, row) in index.chunks(5).zip(found.chunks(3)) {
                for (column, &at) in row.iter().enumerate() {
                    let of = |number: u32| values[number as usize * 3 + column];
                    let is_nan = named.iter().find(|&&number| of(number).is_nan());
                    let most = named.iter().map(|&number| of(number)).fold(f32::NEG_INFINITY, f32::max);
                    let first = is_nan.or_else(|| named.iter().find(|&&number| of(number) == most));
                    prop_assert_eq!(Some(at), first.map(|&number| i64::from(number)));
                }
            }
        }
    }

    #[test]
    fn of_points_at_one_place_those_with_lower_numbers_are_nearest() {
        let points = [[1.0, 2.0, 3.0]; 5];
        let mut found = [-1; 10];
        nearest_neighbours(&points, 2, &mut found);
        assert_eq!(found, [[0, 1]; 5].concat()[..]);
    }
}
