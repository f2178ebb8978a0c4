//! The nearest neighbours of all points of a cloud.
//!
//! Points that are near to each other have most of them in common: what may be one is gathered for a block of points at a time,
//! and compared several at once, without branches that nobody could foresee. They are in no order; [`crate::neighbours`] tells
//! those of a few hundred points in theirs.

use nalgebra::Point3;
use wide::{bytemuck, f32x8, i32x8};

use crate::aabb::Aabb;
use crate::point_tree::PointTree;

/// Points that neighbours are gathered for at a time, and that are compared at a time.
const BLOCK: usize = 8;
/// So much farther than it need is looked, in diagonals of the cloud, as distances are rounded.
const ROUNDED: f64 = 1e-6;

/// Calls `take` with the number of every one of `points`, of which there are some, and those of the `count` (at least 1) that are
/// nearest to it, or of all, in no order. Its own is among them unless more than `count` are alike to it.
///
/// Distances are compared in single precision: those that differ by less than a millionth of the cloud's size are alike. For
/// clouds of up to some ten thousand points: every block is compared with every other.
pub(crate) fn nearest_of_all(points: &[Point3<f64>], count: usize, mut take: impl FnMut(usize, &[u32])) {
    let bounds = Aabb::of(points);
    let (origin, diagonal) = (nalgebra::center(&bounds.low, &bounds.high), (bounds.high - bounds.low).norm());
    let placed = |point: &Point3<f64>| Point3::from((point - origin) / diagonal.max(f64::MIN_POSITIVE));
    let cloud: Vec<Point3<f64>> = points.iter().map(placed).collect();
    let farthest = |near: &[u32], from: &Point3<f64>| {
        near.iter().map(|&number| (cloud[number as usize] - from).norm_squared()).fold(0.0, f64::max).sqrt()
    };
    let squared = |distance: f64| (distance + ROUNDED).powi(2);
    let order = PointTree::new(&cloud).into_order();
    let blocks: Vec<Block> = order.chunks(BLOCK).map(Block::new).collect();
    let mut gathered = Gathered::default();
    let mut near = Vec::new();
    for block in &blocks {
        let middle = nalgebra::center(&block.bounds.low, &block.bounds.high);
        // As many as are asked for are no farther than those that were near to the point before.
        let bound = squared(if near.is_empty() { 1.0 } else { farthest(&near, &middle) });
        gathered.gather(&blocks, |other| other.bounds.squared_distance_to_point(&middle) <= bound);
        gathered.nearest(&middle, count, bound, &mut near);
        let reach = farthest(&near, &middle);
        let bound_of = |point: &Point3<f64>| squared(reach + (point - middle).norm());
        let widest = block.points.iter().map(|(point, _)| bound_of(point)).fold(0.0, f64::max);
        gathered.gather(&blocks, |other| other.bounds.squared_distance(&block.bounds) <= widest);
        for (point, number) in block.points {
            gathered.nearest(point, count, bound_of(point), &mut near);
            take(*number as usize, &near);
        }
    }
}

/// Up to as many points as are compared at a time.
struct Block<'a> {
    points: &'a [(Point3<f64>, u32)],
    bounds: Aabb,
    /// Their coordinates; infinite where there are fewer.
    columns: [f32x8; 3],
}

impl<'a> Block<'a> {
    fn new(points: &'a [(Point3<f64>, u32)]) -> Self {
        let coordinate =
            |lane: usize, axis: usize| points.get(lane).map_or(f32::INFINITY, |(point, _)| point[axis] as f32);
        let columns = [0, 1, 2].map(|axis| f32x8::from(std::array::from_fn(|lane| coordinate(lane, axis))));
        Self { points, bounds: Aabb::of(points.iter().map(|(point, _)| point)), columns }
    }
}

/// Blocks of what may be near, and the squared distances of their points to one.
#[derive(Default)]
struct Gathered<'a> {
    blocks: Vec<&'a Block<'a>>,
    squared: Vec<f32x8>,
}

impl<'a> Gathered<'a> {
    fn gather(&mut self, blocks: &'a [Block<'a>], is_near: impl Fn(&Block) -> bool) {
        self.blocks.clear();
        self.blocks.extend(blocks.iter().filter(|block| is_near(block)));
    }

    /// Of the `count` points nearest to `query`, of which as many lie within the squared distance `bound`, or of all, the numbers
    /// into `near`.
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

    /// Adds the numbers of the points whose squared distance is above `low`, and up to `high`.
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

/// Two bounds: up to the first are as many of `squared` as `count`, or the second is the next that there is and with it there are
/// more. Up to `bound` there are as many, or all.
fn bounds_of_nearest(squared: &[f32x8], count: usize, bound: f32) -> (f32, f32) {
    let count_of = |bound: f32| {
        let bound = f32x8::splat(bound);
        // all bits set, which is -1
        let add = |sum: i32x8, squared: &f32x8| sum - bytemuck::cast::<_, i32x8>(squared.simd_le(bound));
        squared.iter().fold(i32x8::ZERO, add).reduce_add() as usize
    };
    let (mut low, mut high) = ((-f32::MIN_POSITIVE, 0), (bound, count_of(bound)));
    let mut is_guessed = true;
    while low.1 < count && count < high.1 {
        // On a surface as many points are near as there is area; halves are what always ends.
        let share = if is_guessed { (count - low.1) as f32 / (high.1 - low.1) as f32 } else { 0.5 };
        let tried = low.0 + (high.0 - low.0) * share;
        let is_between = low.0 < tried && tried < high.0;
        if is_between {
            let found = (tried, count_of(tried));
            *(if found.1 <= count { &mut low } else { &mut high }) = found;
        } else if !is_guessed {
            return (low.0, high.0);
        }
        // a guess may be rounded to an end where there are numbers in between
        is_guessed = !is_guessed;
    }
    let all = if low.1 == count { low.0 } else { high.0 };
    (all, all)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// On a grid, where many are equally far, or anywhere.
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
        fn neighbours_are_those_of_all_pairs(points in cloud(), count in 1..20usize, far in -100.0..100.0f64, size in -30..30i32) {
            let unit = 10.0f64.powi(size);
            let points: Vec<_> = points.iter().map(|point| (point + nalgebra::Vector3::repeat(far)) * unit).collect();
            let mut rows = vec![Vec::new(); points.len()];
            nearest_of_all(&points, count, |number, near| rows[number].push(near.iter().map(|&i| points[i as usize]).collect::<Vec<_>>()));
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
    fn none_is_told_twice() {
        let points: Vec<_> =
            (0..125).map(|i| Point3::new(f64::from(i % 5), f64::from(i / 5 % 5), f64::from(i / 25))).collect();
        nearest_of_all(&points, 13, |number, near| {
            let mut near = near.to_vec();
            near.sort_unstable();
            near.dedup();
            assert_eq!(near.len(), 13);
            assert!(near.contains(&(number as u32)));
        });
    }
}
