//! Nearest neighbours of all points of a cloud.
//!
//! Nearby points share most of their neighbours. The search collects candidates once for a block of points, and
//! compares several points at a time without unpredictable branches. Rows are unordered;
//! [`crate::points::nearest_neighbours`] orders the rows of small clouds.

use nalgebra::Point3;
use wide::{bytemuck, f32x8, i32x8};

use crate::mesh::aabb::Aabb;
use crate::points::kd_tree::KdTree;

/// Points per block: candidates are collected and compared block by block.
const BLOCK: usize = 8;
/// Extra search radius for rounded distances, as a share of the cloud's diagonal.
const ROUNDED: f64 = 1e-6;

/// Finds the `count` (at least 1) nearest neighbours of every point.
///
/// For each of `points` (at least one), calls `take` with its index and the indices of its nearest neighbours. A cloud
/// of fewer than `count` points gives all of them. The neighbours are unordered and include the point itself, unless
/// more than `count` points coincide with it.
///
/// Distances are compared in single precision: differences below a millionth of the cloud's size count as equal. The
/// search compares every pair of blocks, so it suits clouds of up to some ten thousand points.
pub(crate) fn all_nearest_neighbours(points: &[Point3<f64>], count: usize, mut take: impl FnMut(usize, &[u32])) {
    let bounds = Aabb::of(points);
    let (origin, diagonal) = (nalgebra::center(&bounds.low, &bounds.high), (bounds.high - bounds.low).norm());
    let normalized = |point: &Point3<f64>| Point3::from((point - origin) / diagonal.max(f64::MIN_POSITIVE));
    let cloud: Vec<Point3<f64>> = points.iter().map(normalized).collect();
    let farthest = |near: &[u32], from: &Point3<f64>| {
        near.iter().map(|&number| (cloud[number as usize] - from).norm_squared()).fold(0.0, f64::max).sqrt()
    };
    let squared = |distance: f64| (distance + ROUNDED).powi(2);
    let order = KdTree::new(&cloud).into_order();
    let blocks: Vec<Block> = order.chunks(BLOCK).map(Block::new).collect();
    let mut candidates = Candidates::default();
    let mut near = Vec::new();
    for block in &blocks {
        let middle = nalgebra::center(&block.bounds.low, &block.bounds.high);
        // The neighbours of the last point bound the distance of the neighbours of this block.
        let bound = squared(if near.is_empty() { 1.0 } else { farthest(&near, &middle) });
        candidates.collect(&blocks, |other| other.bounds.squared_distance_to_point(&middle) <= bound);
        candidates.nearest(&middle, count, bound, &mut near);
        let reach = farthest(&near, &middle);
        let bound_of = |point: &Point3<f64>| squared(reach + (point - middle).norm());
        let widest = block.points.iter().map(|(point, _)| bound_of(point)).fold(0.0, f64::max);
        candidates.collect(&blocks, |other| other.bounds.squared_distance(&block.bounds) <= widest);
        for (point, number) in block.points {
            candidates.nearest(point, count, bound_of(point), &mut near);
            take(*number as usize, &near);
        }
    }
}

/// Up to `BLOCK` points that lie near each other.
struct Block<'a> {
    points: &'a [(Point3<f64>, u32)],
    bounds: Aabb,
    /// Coordinates of the points. Unused entries are infinite.
    columns: [f32x8; 3],
}

impl<'a> Block<'a> {
    fn new(points: &'a [(Point3<f64>, u32)]) -> Self {
        let coordinate =
            |entry: usize, axis: usize| points.get(entry).map_or(f32::INFINITY, |(point, _)| point[axis] as f32);
        let columns = [0, 1, 2].map(|axis| f32x8::from(std::array::from_fn(|entry| coordinate(entry, axis))));
        Self { points, bounds: Aabb::of(points.iter().map(|(point, _)| point)), columns }
    }
}

/// Candidate blocks, and the squared distances of their points to a query.
#[derive(Default)]
struct Candidates<'a> {
    blocks: Vec<&'a Block<'a>>,
    squared: Vec<f32x8>,
}

impl<'a> Candidates<'a> {
    fn collect(&mut self, blocks: &'a [Block<'a>], is_near: impl Fn(&Block) -> bool) {
        self.blocks.clear();
        self.blocks.extend(blocks.iter().filter(|block| is_near(block)));
    }

    /// Writes the indices of the `count` points nearest to `query` to `near`, or of all if there are fewer.
    ///
    /// At least `count` points lie within the squared distance `bound`.
    fn nearest(&mut self, query: &Point3<f64>, count: usize, bound: f64, near: &mut Vec<u32>) {
        let query = [0, 1, 2].map(|axis| f32x8::splat(query[axis] as f32));
        self.squared.clear();
        self.squared.extend(self.blocks.iter().map(|block| {
            let [dx, dy, dz] = [0, 1, 2].map(|axis| block.columns[axis] - query[axis]);
            dx * dx + dy * dy + dz * dz
        }));
        let (inner, outer) = bounds_of_nearest(&self.squared, count, bound as f32);
        near.clear();
        self.add_within(f32::NEG_INFINITY, inner, near);
        if inner < outer {
            self.add_within(inner, outer, near);
            near.truncate(count);
        }
    }

    /// Adds the indices of points whose squared distance is above `low` and at most `high`.
    fn add_within(&self, low: f32, high: f32, near: &mut Vec<u32>) {
        let (low, high) = (f32x8::splat(low), f32x8::splat(high));
        for (squared, block) in self.squared.iter().zip(&self.blocks) {
            let mut within = (squared.simd_gt(low) & squared.simd_le(high)).to_bitmask();
            while within != 0 {
                near.push(block.points[within.trailing_zeros() as usize].1);
                within &= within - 1;
            }
        }
    }
}

/// Two bounds on the squared distance of the nearest points.
///
/// Either both are equal, and exactly `count` values (or all) do not exceed them. Or fewer than `count` values do not
/// exceed the first, more than `count` do not exceed the second, and no value lies between. At least `count` values (or
/// all) do not exceed `bound`.
fn bounds_of_nearest(squared: &[f32x8], count: usize, bound: f32) -> (f32, f32) {
    let count_of = |bound: f32| {
        let bound = f32x8::splat(bound);
        // A mask with all bits set is -1 as an integer.
        let add = |sum: i32x8, squared: &f32x8| sum - bytemuck::cast::<_, i32x8>(squared.simd_le(bound));
        squared.iter().fold(i32x8::ZERO, add).reduce_add() as usize
    };
    let (mut low, mut high) = ((-f32::MIN_POSITIVE, 0), (bound, count_of(bound)));
    let mut is_guessed = true;
    while low.1 < count && count < high.1 {
        // On a surface, the number of neighbours grows with area, so interpolation guesses well. Bisection guarantees
        // termination.
        let share = if is_guessed { (count - low.1) as f32 / (high.1 - low.1) as f32 } else { 0.5 };
        let tried = low.0 + (high.0 - low.0) * share;
        let is_between = low.0 < tried && tried < high.0;
        if is_between {
            let found = (tried, count_of(tried));
            *(if found.1 <= count { &mut low } else { &mut high }) = found;
        } else if !is_guessed {
            return (low.0, high.0);
        }
        // Rounding may move a guess to an end of the interval although there are numbers in between.
        is_guessed = !is_guessed;
    }
    let all = if low.1 == count { low.0 } else { high.0 };
    (all, all)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Points on a grid, where many distances are equal, or at random places.
    fn cloud() -> impl Strategy<Value = Vec<Point3<f64>>> {
        let coordinate = prop_oneof![(-4i32..4).prop_map(f64::from), -4.0..4.0f64, -0.01..0.01f64];
        prop::collection::vec(prop::array::uniform3(coordinate).prop_map(Point3::from), 1..200)
    }

    fn sorted(points: &[Point3<f64>], from: &Point3<f64>) -> Vec<f64> {
        let mut distances: Vec<f64> = points.iter().map(|point| (point - from).norm()).collect();
        distances.sort_by(f64::total_cmp);
        distances
    }

    proptest! {
        #[test]
        fn neighbours_agree_with_a_search_of_all_pairs(points in cloud(), count in 1..20usize, far in -100.0..100.0f64, size in -30..30i32) {
            let unit = 10.0f64.powi(size);
            let points: Vec<_> = points.iter().map(|point| (point + nalgebra::Vector3::repeat(far)) * unit).collect();
            let mut rows = vec![Vec::new(); points.len()];
            all_nearest_neighbours(&points, count, |number, near| rows[number].push(near.iter().map(|&i| points[i as usize]).collect::<Vec<_>>()));
            for (point, rows) in points.iter().zip(rows) {
                prop_assert_eq!(rows.len(), 1);
                let (found, all) = (sorted(&rows[0], point), sorted(&points, point));
                prop_assert_eq!(found.len(), count.min(points.len()));
                prop_assert_eq!(found[0], 0.0);
                for (found, expected) in found.iter().zip(all) {
                    prop_assert!((found - expected).abs() < 1e-5 * unit);
                }
            }
        }
    }

    #[test]
    fn no_neighbour_is_reported_twice() {
        let points: Vec<_> =
            (0..125).map(|i| Point3::new(f64::from(i % 5), f64::from(i / 5 % 5), f64::from(i / 25))).collect();
        all_nearest_neighbours(&points, 13, |number, near| {
            let mut near = near.to_vec();
            near.sort_unstable();
            near.dedup();
            assert_eq!(near.len(), 13);
            assert!(near.contains(&(number as u32)));
        });
    }
}
