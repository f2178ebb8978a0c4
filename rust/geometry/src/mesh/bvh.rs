//! Bounding volume hierarchy over the triangles of a mesh.

mod closest_points;
mod ray_crossings;

use nalgebra::Point3;

use crate::Mesh;
use crate::mesh::aabb::{Aabb, greater, lesser};
use crate::mesh::triangle::{Triangle, point_triangle};

const LEAF_TRIANGLES: usize = 4;
/// Largest ratio of all triangles to those on the smaller side of a split.
const MAX_IMBALANCE: usize = 16;

/// A node of the tree.
///
/// Inner nodes have `count` 0 and their children at `first` and `first + 1`. Leaves hold the triangles `first..first +
/// count`.
#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: Aabb,
    first: u32,
    count: u32,
}

/// A bounding volume hierarchy over the triangles of one mesh.
#[derive(Debug, Clone)]
pub struct Bvh {
    nodes: Vec<Node>,
    triangles: Vec<Triangle>,
}

/// A triangle during construction. Its centroid is relative to the mesh's lowest corner, in units of the mesh's extent.
#[derive(Clone, Copy)]
struct Item {
    centroid: [f32; 3],
    face: u32,
}

impl Bvh {
    /// Builds the tree.
    ///
    /// A node splits at the middle of the longest side of its centroids' box. If the split is too uneven, it splits at
    /// the median instead.
    pub fn new(mesh: &Mesh) -> Self {
        let (low, high) = mesh.bounds();
        let extent = (high - low).max();
        let scale = if extent > 0.0 { 1.0 / (3.0 * extent) } else { 0.0 };
        let place = |[a, b, c]: Triangle, axis: usize| {
            ((a[axis] - low[axis]) + (b[axis] - low[axis]) + (c[axis] - low[axis])) * scale
        };
        let mut items: Vec<Item> = (0..mesh.faces().len())
            .map(|face| {
                let triangle = mesh.triangle(face);
                Item { centroid: [0, 1, 2].map(|axis| place(triangle, axis) as f32), face: face as u32 }
            })
            .collect();
        let mut tree = Self { nodes: Vec::with_capacity(items.len()), triangles: Vec::with_capacity(items.len()) };
        tree.nodes.push(Node { bounds: Aabb::empty(), first: 0, count: 0 });
        tree.split(mesh, &mut items, 0);
        tree
    }

    fn split(&mut self, mesh: &Mesh, items: &mut [Item], node: usize) {
        if items.len() <= LEAF_TRIANGLES {
            let first = self.triangles.len();
            self.triangles.extend(items.iter().map(|item| mesh.triangle(item.face as usize)));
            self.nodes[node] = Node {
                bounds: Aabb::of(self.triangles[first..].iter().flatten()),
                first: first as u32,
                count: items.len() as u32,
            };
            return;
        }
        let middle = partition(items);
        let first = self.nodes.len();
        self.nodes.extend([Node { bounds: Aabb::empty(), first: 0, count: 0 }; 2]);
        let (left, right) = items.split_at_mut(middle);
        self.split(mesh, left, first);
        self.split(mesh, right, first + 1);
        let bounds = self.nodes[first].bounds.merged(&self.nodes[first + 1].bounds);
        self.nodes[node] = Node { bounds, first: first as u32, count: 0 };
    }

    /// Box around all triangles.
    pub fn bounds(&self) -> &Aabb {
        &self.nodes[0].bounds
    }

    fn leaf(&self, node: &Node) -> &[Triangle] {
        &self.triangles[node.first as usize..(node.first + node.count) as usize]
    }

    fn children(&self, node: &Node) -> [u32; 2] {
        debug_assert_eq!(node.count, 0);
        [node.first, node.first + 1]
    }

    /// Squared distance from a point to the surface; `None` unless it is below `bound`.
    ///
    /// The search stops at the first squared distance below `enough`.
    pub fn squared_distance_to_point(&self, point: &Point3<f64>, bound: f64, enough: f64) -> Option<f64> {
        let mut best = bound;
        if self.bounds().squared_distance_to_point(point) < bound {
            self.lower_distance(&self.nodes[0], point, enough, &mut best);
        }
        (best < bound).then_some(best)
    }

    /// Lowers `best` to the squared distance from `point` to the triangles below `node`.
    fn lower_distance(&self, node: &Node, point: &Point3<f64>, enough: f64, best: &mut f64) {
        if node.count > 0 {
            *best = self.leaf(node).iter().map(|triangle| point_triangle(point, triangle)).fold(*best, f64::min);
            return;
        }
        let (mut near, mut far) = (&self.nodes[node.first as usize], &self.nodes[node.first as usize + 1]);
        let mut to_near = near.bounds.squared_distance_to_point(point);
        let mut to_far = far.bounds.squared_distance_to_point(point);
        if to_far < to_near {
            (near, far, to_near, to_far) = (far, near, to_far, to_near);
        }
        for (child, squared) in [(near, to_near), (far, to_far)] {
            if squared < *best && *best >= enough {
                self.lower_distance(child, point, enough, best);
            }
        }
    }

    /// Calls `visit` with every triangle of the leaves that overlap `bounds`.
    pub fn visit_triangles(&self, bounds: &Aabb, mut visit: impl FnMut(&Triangle)) {
        let mut stack = vec![0u32];
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index as usize];
            if node.bounds.squared_distance(bounds) > 0.0 {
                continue;
            }
            if node.count == 0 {
                stack.extend(self.children(node));
            } else {
                self.leaf(node).iter().for_each(&mut visit);
            }
        }
    }
}

/// Partitions the items by a plane across the longest side of their box, and returns the size of the first part.
fn partition(items: &mut [Item]) -> usize {
    let (mut low, mut high) = (items[0].centroid, items[0].centroid);
    for item in items.iter() {
        for axis in 0..3 {
            low[axis] = lesser(low[axis], item.centroid[axis]);
            high[axis] = greater(high[axis], item.centroid[axis]);
        }
    }
    let axis = if high[0] - low[0] >= (high[1] - low[1]).max(high[2] - low[2]) {
        0
    } else if high[1] - low[1] >= high[2] - low[2] {
        1
    } else {
        2
    };
    let plane = low[axis].midpoint(high[axis]);
    let (mut first, mut end) = (0, items.len());
    while first < end {
        if items[first].centroid[axis] < plane {
            first += 1;
        } else {
            end -= 1;
            items.swap(first, end);
        }
    }
    if first.min(items.len() - first) * MAX_IMBALANCE >= items.len() {
        return first;
    }
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| a.centroid[axis].total_cmp(&b.centroid[axis]));
    middle
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_shapes::triangle_soup;

    proptest! {
        #[test]
        fn the_distance_is_that_to_the_nearest_triangle(mesh in triangle_soup(40), point in prop::array::uniform3(-3.0..3.0f64)) {
            let point = Point3::from(point);
            let tree = Bvh::new(&mesh);
            let squares = (0..40).map(|face| point_triangle(&point, &mesh.triangle(face)));
            let expected = squares.fold(f64::INFINITY, f64::min);
            prop_assert_eq!(tree.squared_distance_to_point(&point, f64::INFINITY, 0.0), Some(expected));
            prop_assert_eq!(tree.squared_distance_to_point(&point, expected, 0.0), None);
            let enough = tree.squared_distance_to_point(&point, f64::INFINITY, 2.0 * expected).expect("unbounded");
            prop_assert!(enough >= expected && enough < (2.0 * expected).next_up());
        }

        #[test]
        fn all_triangles_that_overlap_a_box_are_visited(mesh in triangle_soup(40), corners in prop::array::uniform6(-1.0..1.0f64)) {
            let [a, b, c, d, e, f] = corners;
            let bounds = Aabb::of(&[Point3::new(a, b, c), Point3::new(d, e, f)]);
            let mut visited = Vec::new();
            Bvh::new(&mesh).visit_triangles(&bounds, |triangle| visited.push(*triangle));
            for triangle in (0..40).map(|face| mesh.triangle(face)) {
                let times = visited.iter().filter(|other| **other == triangle).count();
                prop_assert!(times == 1 || times == 0 && Aabb::of(&triangle).squared_distance(&bounds) > 0.0);
            }
        }
    }
}
