//! The nearest points of every point of a small cloud.

/// Points that are compared at a time.
const LANES: usize = 8;

/// For every point the numbers of its `count` nearest ones, itself among them, the nearest first; row after row.
///
/// Of points that are equally far those with lower numbers come first. A cloud of fewer than `count` points gives rows that
/// are as long as it. Every pair is looked at, which for some hundreds of points takes less time than a search tree does.
pub fn nearest_neighbours(points: &[[f32; 3]], count: usize) -> Vec<u32> {
    let count = count.min(points.len());
    let columns = Columns::new(points);
    let mut squared = vec![[0.0; LANES]; columns.chunks.len()];
    let mut least = Vec::with_capacity(squared.len());
    let mut ordered = Vec::with_capacity(squared.len());
    let mut near: Vec<(f32, u32)> = Vec::with_capacity(points.len());
    let mut found = Vec::with_capacity(points.len() * count);
    for point in points {
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
        found.extend(near[..count].iter().map(|&(_, number)| number));
    }
    found
}

fn least_of(lanes: &[f32; LANES]) -> f32 {
    lanes.iter().fold(f32::INFINITY, |least, &lane| if lane < least { lane } else { least })
}

/// What `count` of the least distances of chunks do not exceed, so that as many points are no farther; infinite if there are
/// fewer chunks.
fn bound_of(least: &mut [f32], count: usize) -> f32 {
    if least.len() < count { f32::INFINITY } else { *least.select_nth_unstable_by(count - 1, f32::total_cmp).1 }
}

/// Points coordinate by coordinate, the last lanes filled with what is infinitely far.
struct Columns {
    chunks: Vec<[[f32; LANES]; 3]>,
}

impl Columns {
    fn new(points: &[[f32; 3]]) -> Self {
        let chunk_of = |chunk: &[[f32; 3]]| {
            [0, 1, 2].map(|axis| std::array::from_fn(|lane| chunk.get(lane).map_or(f32::INFINITY, |point| point[axis])))
        };
        Self { chunks: points.chunks(LANES).map(chunk_of).collect() }
    }

    fn squared_distances(&self, point: &[f32; 3], squared: &mut [[f32; LANES]]) {
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
            let found = nearest_neighbours(&points, count);
            let count = count.min(points.len());
            prop_assert_eq!(found.len(), points.len() * count);
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

    #[test]
    fn of_points_at_one_place_those_with_lower_numbers_are_nearest() {
        let points = [[1.0, 2.0, 3.0]; 5];
        assert_eq!(nearest_neighbours(&points, 2), [0, 1].repeat(5));
    }
}
