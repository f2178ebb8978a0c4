//! k-d tree for nearest-neighbour search among points.

use nalgebra::Point3;

const LEAF_POINTS: usize = 8;

/// A balanced k-d tree. Its points are stored leaf by leaf.
#[derive(Debug, Clone)]
pub struct KdTree {
    points: Vec<Point3<f64>>,
    numbers: Vec<u32>,
    /// Inner nodes in heap order: axis and coordinate of the splitting plane.
    planes: Vec<(u8, f64)>,
    depth: u32,
}

/// A point and its squared distance to the query.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Neighbour {
    /// Squared distance.
    pub squared: f64,
    /// Index of the point.
    pub point: u32,
}

impl KdTree {
    /// Builds the tree; `points` must not be empty.
    pub fn new(points: &[Point3<f64>]) -> Self {
        let mut items: Vec<(Point3<f64>, u32)> = points.iter().copied().zip(0..).collect();
        let mut depth = 0;
        while points.len() >> depth > LEAF_POINTS {
            depth += 1;
        }
        let mut planes = vec![(0, 0.0); (1 << depth) - 1];
        split(&mut items, &mut planes, 0);
        let (points, numbers) = items.into_iter().unzip();
        Self { points, numbers, planes, depth }
    }

    /// Points and their indices, leaf by leaf, so that neighbours are near each other in the list.
    pub fn into_order(self) -> Vec<(Point3<f64>, u32)> {
        self.points.into_iter().zip(self.numbers).collect()
    }

    /// Squared distance between the nearest points of two trees.
    pub fn squared_gap(&self, other: &Self) -> f64 {
        let mut least = f64::INFINITY;
        for query in &other.points {
            self.visit(query, least, |_, squared| {
                least = squared;
                least
            });
        }
        least
    }

    /// One flag per point of `queries`: true if a point of this tree is within the squared distance `limit`.
    pub fn any_within(&self, queries: &Self, limit: f64) -> Vec<bool> {
        let mut result = vec![false; queries.points.len()];
        // Queries follow the order of their tree, so the neighbour of one is a good guess for the next.
        let mut last = 0;
        for (query, &number) in queries.points.iter().zip(&queries.numbers) {
            let mut near = (self.points[last] - query).norm_squared() < limit;
            if !near {
                self.visit(query, limit, |slot, _| {
                    (near, last) = (true, slot);
                    0.0
                });
            }
            result[number as usize] = near;
        }
        result
    }

    /// Nearest point of this tree to each point of `queries`.
    pub fn nearest_of_each(&self, queries: &Self) -> Vec<Neighbour> {
        let mut result = vec![Neighbour { squared: f64::INFINITY, point: 0 }; queries.points.len()];
        for (query, &number) in queries.points.iter().zip(&queries.numbers) {
            let best = &mut result[number as usize];
            self.visit(query, f64::INFINITY, |slot, squared| {
                *best = Neighbour { squared, point: self.numbers[slot] };
                squared
            });
        }
        result
    }

    /// Writes the `count` (at least 1) points nearest to `query`, or all, to `found`, nearest first.
    pub fn nearest(&self, query: &Point3<f64>, count: usize, found: &mut Vec<Neighbour>) {
        found.clear();
        self.visit(query, f64::INFINITY, |slot, squared| {
            if found.len() == count {
                found.pop();
            }
            let place = found.partition_point(|neighbour| neighbour.squared <= squared);
            found.insert(place, Neighbour { squared, point: self.numbers[slot] });
            if found.len() < count { f64::INFINITY } else { found[count - 1].squared }
        });
    }

    /// Calls `take` with the slot of every point below a bound on the squared distance. Its return value is the new
    /// bound.
    fn visit(&self, query: &Point3<f64>, bound: f64, mut take: impl FnMut(usize, f64) -> f64) {
        let mut bound = bound;
        // The stack holds at most one entry per level.
        let mut stack = [(0usize, 0usize, 0usize, 0.0f64); 40];
        let mut top = 1;
        stack[0] = (0, 0, self.points.len(), 0.0);
        while top > 0 {
            top -= 1;
            let (mut node, mut start, mut end, squared) = stack[top];
            if squared >= bound {
                continue;
            }
            while let Some(&(axis, plane)) = self.planes.get(node) {
                let middle = start.midpoint(end);
                let offset = query[axis as usize] - plane;
                let far = squared.max(offset * offset);
                if offset < 0.0 {
                    stack[top] = (2 * node + 2, middle, end, far);
                    (node, end) = (2 * node + 1, middle);
                } else {
                    stack[top] = (2 * node + 1, start, middle, far);
                    (node, start) = (2 * node + 2, middle);
                }
                top += 1;
            }
            for i in start..end {
                let squared = (self.points[i] - query).norm_squared();
                if squared < bound {
                    bound = take(i, squared);
                }
            }
        }
        debug_assert!(self.depth < 40);
    }
}

fn split(items: &mut [(Point3<f64>, u32)], planes: &mut [(u8, f64)], node: usize) {
    if node >= planes.len() {
        return;
    }
    let (low, high) =
        items.iter().fold((items[0].0, items[0].0), |(low, high), (point, _)| (low.inf(point), high.sup(point)));
    let axis = (high - low).imax();
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
    planes[node] = (axis as u8, items[middle].0[axis]);
    let (left, right) = items.split_at_mut(middle);
    split(left, planes, 2 * node + 1);
    split(right, planes, 2 * node + 2);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn cloud() -> impl Strategy<Value = Vec<Point3<f64>>> {
        prop::collection::vec(prop::array::uniform3((-8i32..8).prop_map(f64::from)).prop_map(Point3::from), 1..80)
    }

    proptest! {
        #[test]
        fn neighbours_agree_with_a_search_of_all_pairs(points in cloud(), queries in cloud()) {
            let (tree, query_tree) = (KdTree::new(&points), KdTree::new(&queries));
            let least = |q: &Point3<f64>| points.iter().map(|p| (p - q).norm_squared()).fold(f64::INFINITY, f64::min);
            let found = tree.nearest_of_each(&query_tree);
            for (query, neighbour) in queries.iter().zip(&found) {
                prop_assert_eq!(neighbour.squared, least(query));
                prop_assert_eq!((points[neighbour.point as usize] - query).norm_squared(), neighbour.squared);
            }
            for query in &queries {
                let mut all: Vec<f64> = points.iter().map(|p| (p - query).norm_squared()).collect();
                all.sort_by(f64::total_cmp);
                let mut near = Vec::new();
                tree.nearest(query, 5, &mut near);
                all.truncate(5);
                prop_assert_eq!(near.iter().map(|neighbour| neighbour.squared).collect::<Vec<_>>(), all);
            }
            prop_assert_eq!(tree.squared_gap(&query_tree), queries.iter().map(least).fold(f64::INFINITY, f64::min));
            let within: Vec<bool> = queries.iter().map(|q| least(q) < 9.5).collect();
            prop_assert_eq!(tree.any_within(&query_tree, 9.5), within);
        }
    }
}
