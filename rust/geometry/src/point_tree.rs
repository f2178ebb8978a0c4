//! Nearest neighbours among points.

use nalgebra::Point3;

const LEAF_POINTS: usize = 8;

/// A k-d tree, balanced, its leaves in the order of its points.
#[derive(Debug, Clone)]
pub struct PointTree {
    points: Vec<Point3<f64>>,
    numbers: Vec<u32>,
    /// Inner nodes in heap order: axis and coordinate of the plane.
    planes: Vec<(u8, f64)>,
    depth: u32,
}

/// A point and its squared distance to the query.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Neighbour {
    /// Squared distance.
    pub squared: f64,
    /// Number of the point.
    pub point: u32,
}

impl PointTree {
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

    /// The point nearest to `query`, among those nearer than the square root of `bound`.
    pub fn nearest(&self, query: &Point3<f64>, bound: f64) -> Option<Neighbour> {
        let mut best = None;
        self.visit(query, bound, |found| {
            best = Some(found);
            found.squared
        });
        best
    }

    /// The `count` nearest points nearer than the square root of `bound`, nearest first, into `found`.
    pub fn nearest_many(&self, query: &Point3<f64>, count: usize, bound: f64, found: &mut Vec<Neighbour>) {
        found.clear();
        self.visit(query, bound, |new| {
            let place = found.partition_point(|old| old.squared <= new.squared);
            if found.len() == count {
                found.pop();
            }
            found.insert(place, new);
            if found.len() == count { found[count - 1].squared } else { bound }
        });
    }

    /// Calls `take` with every point below a bound on the squared distance, which `take` gives anew.
    fn visit(&self, query: &Point3<f64>, bound: f64, mut take: impl FnMut(Neighbour) -> f64) {
        let mut bound = bound;
        // A path is at most one entry a level.
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
                    bound = take(Neighbour { squared, point: self.numbers[i] });
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
