//! A tree of boxes over the triangles of a mesh.

use nalgebra::{Point3, Vector3};

use crate::Mesh;
use crate::aabb::{Aabb, greater, lesser};
use crate::triangle::{ClosestPoints, Triangle, point_triangle, ray_triangle, triangle_triangle};

const LEAF_TRIANGLES: usize = 4;
/// A split leaves at least one in this many triangles on either side.
const SMALLEST_SIDE: usize = 16;

/// Inner nodes have `count` 0 and their children at `first` and `first + 1`; leaves hold triangles `first..first + count`.
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

/// A triangle to be sorted into the tree: its centroid, in units of the mesh's extent from its lowest corner.
#[derive(Clone, Copy)]
struct Item {
    centroid: [f32; 3],
    face: u32,
}

impl Bvh {
    /// Builds the tree by halving the longest side of the centroids' box, or the triangles where that would be too uneven.
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
        let middle = divide(items);
        let first = self.nodes.len();
        self.nodes.extend([Node { bounds: Aabb::empty(), first: 0, count: 0 }; 2]);
        let (left, right) = items.split_at_mut(middle);
        self.split(mesh, left, first);
        self.split(mesh, right, first + 1);
        let bounds = self.nodes[first].bounds.merged(&self.nodes[first + 1].bounds);
        self.nodes[node] = Node { bounds, first: first as u32, count: 0 };
    }

    /// The box around all triangles.
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

    /// Nearest points of the two surfaces, if they are nearer than the square root of `bound`.
    ///
    /// Stops at the first pair whose squared distance is at most `touching`.
    pub fn closest(&self, other: &Self, bound: f64, touching: f64) -> Option<ClosestPoints> {
        let mut best = Best { points: None, bound, distance: bound.sqrt(), direction: Vector3::zeros() };
        let mut stack = vec![(0u32, 0u32, self.bounds().squared_distance(other.bounds()))];
        while let Some((a, b, squared)) = stack.pop() {
            if squared >= best.bound {
                continue;
            }
            let (node_a, node_b) = (&self.nodes[a as usize], &other.nodes[b as usize]);
            if node_a.bounds.gap_along(&node_b.bounds, &best.direction) >= best.distance {
                continue;
            }
            if node_a.count > 0 && node_b.count > 0 {
                best.improve(self.leaf(node_a), other.leaf(node_b), &node_b.bounds);
                if best.bound <= touching {
                    break;
                }
                continue;
            }
            let split_a = node_b.count > 0
                || (node_a.count == 0 && node_a.bounds.squared_diagonal() >= node_b.bounds.squared_diagonal());
            let [near, far] = if split_a {
                self.children(node_a)
                    .map(|child| (child, b, self.nodes[child as usize].bounds.squared_distance(&node_b.bounds)))
            } else {
                other
                    .children(node_b)
                    .map(|child| (a, child, node_a.bounds.squared_distance(&other.nodes[child as usize].bounds)))
            };
            let (near, far) = if far.2 < near.2 { (far, near) } else { (near, far) };
            stack.extend([far, near]);
        }
        best.points
    }

    /// Squared distance of a point to the surface, if less than `bound`; the search stops at the first one below `enough`.
    pub fn squared_distance_to_point(&self, point: &Point3<f64>, bound: f64, enough: f64) -> Option<f64> {
        let mut best = bound;
        if self.bounds().squared_distance_to_point(point) < bound {
            self.approach(&self.nodes[0], point, enough, &mut best);
        }
        (best < bound).then_some(best)
    }

    /// Lowers `best` to the squared distance of `point` to the triangles below `node`.
    fn approach(&self, node: &Node, point: &Point3<f64>, enough: f64, best: &mut f64) {
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
                self.approach(child, point, enough, best);
            }
        }
    }

    /// Share in [0, 1] of the way from `start` to `end` at which the surface is first met.
    pub fn first_crossing(&self, start: &Point3<f64>, end: &Point3<f64>) -> Option<f64> {
        let mut first = None;
        self.visit_crossings(start, &(end - start), 1.0, |t| {
            first = Some(t);
            t
        });
        first
    }

    /// How often the ray from `origin` along `direction` meets the surface.
    pub fn count_crossings(&self, origin: &Point3<f64>, direction: &Vector3<f64>) -> usize {
        let mut count = 0;
        self.visit_crossings(origin, direction, f64::INFINITY, |_| {
            count += 1;
            f64::INFINITY
        });
        count
    }

    /// Calls `visit` with every triangle of the leaves that meet `bounds`.
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

    /// Calls `found` with the parameter of every crossing below a limit, which `found` gives anew.
    fn visit_crossings(
        &self,
        origin: &Point3<f64>,
        direction: &Vector3<f64>,
        limit: f64,
        mut found: impl FnMut(f64) -> f64,
    ) {
        let mut limit = limit;
        let inverse = direction.map(f64::recip);
        let meets = |index: u32, limit: f64| self.nodes[index as usize].bounds.meets_ray(origin, &inverse, limit);
        // Most rays miss the whole mesh: nothing is allocated for them.
        if !meets(0, limit) {
            return;
        }
        let mut stack = vec![0u32];
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index as usize];
            if node.count == 0 {
                stack.extend(self.children(node).into_iter().filter(|&child| meets(child, limit)));
                continue;
            }
            for triangle in self.leaf(node) {
                if let Some(t) = ray_triangle(origin, direction, triangle).filter(|&t| t <= limit) {
                    limit = found(t);
                }
            }
        }
    }
}

/// Sorts the items to either side of a plane across the longest side of their box; returns how many come first.
fn divide(items: &mut [Item]) -> usize {
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
    if first.min(items.len() - first) * SMALLEST_SIDE >= items.len() {
        return first;
    }
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| a.centroid[axis].total_cmp(&b.centroid[axis]));
    middle
}

/// The nearest points found so far. What is apart by as much along the direction from one to the other need not be looked
/// at: near the nearest points, that tells far more than boxes do.
struct Best {
    points: Option<ClosestPoints>,
    /// Square of the distance to be undercut, and the distance.
    bound: f64,
    distance: f64,
    /// Unit vector from the first surface to the second; zero as long as there is none.
    direction: Vector3<f64>,
}

impl Best {
    /// Looks at two short lists of triangles, those of the second inside `bounds_b`.
    fn improve(&mut self, a: &[Triangle], b: &[Triangle], bounds_b: &Aabb) {
        for p in a {
            let bounds_p = Aabb::of(p);
            if bounds_p.squared_distance(bounds_b) >= self.bound {
                continue;
            }
            for q in b {
                if bounds_p.squared_distance(&Aabb::of(q)) >= self.bound || self.parts(p, q) {
                    continue;
                }
                if let Some(found) = triangle_triangle(p, q, self.bound) {
                    let distance = found.squared.sqrt();
                    self.direction = (found.b - found.a) / distance;
                    if !self.direction.iter().all(|x| x.is_finite()) {
                        self.direction = Vector3::zeros();
                    }
                    (self.points, self.bound, self.distance) = (Some(found), found.squared, distance);
                }
            }
        }
    }

    /// Whether the direction shows that two triangles are not nearer than the best points.
    fn parts(&self, p: &Triangle, q: &Triangle) -> bool {
        let origin = p[0];
        let [a, b] = [p[1], p[2]].map(|corner| (corner - origin).dot(&self.direction));
        let [c, d, e] = q.map(|corner| (corner - origin).dot(&self.direction));
        lesser(lesser(c, d), e) - greater(greater(a, b), 0.0) >= self.distance
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn soup(faces: usize) -> impl Strategy<Value = Mesh> {
        prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 3 * faces).prop_map(move |corners| {
            let faces = (0..faces as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
            Mesh::new(corners.into_iter().map(Point3::from).collect(), faces).expect("finite")
        })
    }

    proptest! {
        #[test]
        fn the_tree_finds_what_all_pairs_of_triangles_give(a in soup(25), b in soup(25), shift in 0.0..4.0f64) {
            let moved = b.vertices().iter().map(|p| p + Vector3::x() * shift).collect();
            let b = Mesh::new(moved, b.faces().to_vec()).expect("finite");
            let all = (0..25).flat_map(|i| (0..25).map(move |j| (i, j)));
            let expected = all
                .filter_map(|(i, j)| triangle_triangle(&a.triangle(i), &b.triangle(j), f64::INFINITY))
                .fold(f64::INFINITY, |least, found| least.min(found.squared));
            let (tree_a, tree_b) = (Bvh::new(&a), Bvh::new(&b));
            let found = tree_a.closest(&tree_b, f64::INFINITY, 0.0).expect("unbounded");
            prop_assert!((found.squared.sqrt() - expected.sqrt()).abs() < 1e-12);
            let swapped = tree_b.closest(&tree_a, f64::INFINITY, 0.0).expect("unbounded");
            prop_assert!((found.squared.sqrt() - swapped.squared.sqrt()).abs() < 1e-12);
            if expected > 1e-6 {
                prop_assert!(tree_a.closest(&tree_b, 0.99 * expected, 0.0).is_none());
            }
        }

        #[test]
        fn a_ray_meets_the_tree_where_it_meets_the_triangles(mesh in soup(40), to in prop::array::uniform3(-2.0..2.0f64)) {
            let (start, end) = (Point3::new(-3.0, 0.1, 0.2), Point3::from(to));
            let expected = (0..40)
                .filter_map(|face| ray_triangle(&start, &(end - start), &mesh.triangle(face)))
                .filter(|&share| share <= 1.0)
                .min_by(f64::total_cmp);
            prop_assert_eq!(Bvh::new(&mesh).first_crossing(&start, &end), expected);
        }
    }
}
