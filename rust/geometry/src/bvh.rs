//! A tree of boxes over the triangles of a mesh.

use nalgebra::{Point3, Vector3};

use crate::Mesh;
use crate::triangle::{ClosestPoints, Triangle, nearest_on_triangle, ray_triangle, triangle_triangle};

const LEAF_TRIANGLES: usize = 4;

/// An axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Smallest corner.
    pub low: Point3<f64>,
    /// Largest corner.
    pub high: Point3<f64>,
}

impl Aabb {
    /// The box that holds nothing.
    pub fn empty() -> Self {
        let far = Vector3::repeat(f64::INFINITY);
        Self { low: Point3::from(far), high: Point3::from(-far) }
    }

    /// The smallest box around `points`.
    pub fn of<'a>(points: impl IntoIterator<Item = &'a Point3<f64>>) -> Self {
        points.into_iter().fold(Self::empty(), |bounds, p| Self { low: bounds.low.inf(p), high: bounds.high.sup(p) })
    }

    /// The smallest box around two boxes.
    pub fn merged(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// What two boxes share, if anything.
    pub fn common(&self, other: &Self) -> Option<Self> {
        let shared = Self { low: self.low.sup(&other.low), high: self.high.inf(&other.high) };
        (0..3).all(|axis| shared.low[axis] <= shared.high[axis]).then_some(shared)
    }

    /// The eight corners.
    pub fn corners(&self) -> [Point3<f64>; 8] {
        std::array::from_fn(|corner| {
            let side = |axis: usize| if corner >> axis & 1 == 1 { self.high[axis] } else { self.low[axis] };
            Point3::new(side(0), side(1), side(2))
        })
    }

    /// The box grown by `margin` on every side.
    pub fn loosened(&self, margin: f64) -> Self {
        let margin = Vector3::repeat(margin);
        Self { low: self.low - margin, high: self.high + margin }
    }

    /// Squared distance of two boxes; 0 where they overlap.
    pub fn squared_distance(&self, other: &Self) -> f64 {
        let mut sum = 0.0;
        for axis in 0..3 {
            let gap = (other.low[axis] - self.high[axis]).max(self.low[axis] - other.high[axis]).max(0.0);
            sum += gap * gap;
        }
        sum
    }

    /// Whether a ray, given by the inverse of its direction, meets the box before `limit`.
    pub fn meets_ray(&self, origin: &Point3<f64>, inverse: &Vector3<f64>, limit: f64) -> bool {
        let (mut enter, mut leave) = (0.0f64, limit);
        for axis in 0..3 {
            let (a, b) =
                ((self.low[axis] - origin[axis]) * inverse[axis], (self.high[axis] - origin[axis]) * inverse[axis]);
            // `max` and `min` pass over the NaN of a ray inside a face's plane.
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        enter <= leave
    }

    /// Squared distance of a point; 0 inside.
    pub fn squared_distance_to(&self, point: &Point3<f64>) -> f64 {
        (point - self.low.sup(&self.high.inf(point))).norm_squared()
    }

    /// Squared length of the diagonal.
    pub fn squared_diagonal(&self) -> f64 {
        (self.high - self.low).norm_squared()
    }
}

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

/// A place of a surface near a given point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestPlace {
    /// Squared distance of the point.
    pub squared: f64,
    /// The place.
    pub place: Point3<f64>,
    /// Corners of the triangle it lies on.
    pub triangle: Triangle,
}

struct Item {
    centroid: Vector3<f64>,
    face: u32,
}

impl Bvh {
    /// Builds the tree by halving the triangles along the longest side of their centroids' box.
    pub fn new(mesh: &Mesh) -> Self {
        let mut items: Vec<Item> = (0..mesh.faces().len())
            .map(|face| {
                let [a, b, c] = mesh.triangle(face);
                // Scaled before the sum, which may otherwise overflow for the largest coordinates.
                Item { centroid: a.coords / 3.0 + b.coords / 3.0 + c.coords / 3.0, face: face as u32 }
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
        let (low, high) = items.iter().fold((items[0].centroid, items[0].centroid), |(low, high), item| {
            (low.inf(&item.centroid), high.sup(&item.centroid))
        });
        let axis = (high - low).imax();
        let middle = items.len() / 2;
        items.select_nth_unstable_by(middle, |a, b| {
            a.centroid[axis].total_cmp(&b.centroid[axis]).then(a.face.cmp(&b.face))
        });
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
        let mut best = None;
        let mut bound = bound;
        let mut stack = vec![(0u32, 0u32, self.bounds().squared_distance(other.bounds()))];
        while let Some((a, b, squared)) = stack.pop() {
            if squared >= bound {
                continue;
            }
            let (node_a, node_b) = (&self.nodes[a as usize], &other.nodes[b as usize]);
            if node_a.count > 0 && node_b.count > 0 {
                if let Some(found) = closest_of(self.leaf(node_a), other.leaf(node_b), &node_b.bounds, bound) {
                    bound = found.squared;
                    best = Some(found);
                    if bound <= touching {
                        break;
                    }
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
        best
    }

    /// The place of the surface nearest to `point`, if nearer than the square root of `bound`.
    ///
    /// The search stops at the first place whose squared distance is below `enough`.
    pub fn nearest(&self, point: &Point3<f64>, bound: f64, enough: f64) -> Option<NearestPlace> {
        let mut best = NearestPlace { squared: bound, place: *point, triangle: self.triangles[0] };
        if self.bounds().squared_distance_to(point) < bound {
            self.approach(&self.nodes[0], point, enough, &mut best);
        }
        (best.squared < bound).then_some(best)
    }

    /// Improves `best` by what lies below `node`.
    fn approach(&self, node: &Node, point: &Point3<f64>, enough: f64, best: &mut NearestPlace) {
        if node.count > 0 {
            for triangle in self.leaf(node) {
                let place = nearest_on_triangle(point, triangle);
                let squared = (place - point).norm_squared();
                if squared < best.squared {
                    *best = NearestPlace { squared, place, triangle: *triangle };
                }
            }
            return;
        }
        let [mut near, mut far] = self.children(node).map(|child| {
            let child = &self.nodes[child as usize];
            (child, child.bounds.squared_distance_to(point))
        });
        if far.1 < near.1 {
            (near, far) = (far, near);
        }
        for (child, squared) in [near, far] {
            if squared < best.squared && best.squared >= enough {
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
        let mut stack = vec![0u32];
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index as usize];
            if !node.bounds.meets_ray(origin, &inverse, limit) {
                continue;
            }
            if node.count == 0 {
                stack.extend(self.children(node));
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

/// Nearest points of two short lists of triangles, those of the second inside `bounds_b`.
fn closest_of(a: &[Triangle], b: &[Triangle], bounds_b: &Aabb, bound: f64) -> Option<ClosestPoints> {
    let mut best = None;
    let mut bound = bound;
    for p in a {
        let bounds_p = Aabb::of(p);
        if bounds_p.squared_distance(bounds_b) >= bound {
            continue;
        }
        for q in b {
            if bounds_p.squared_distance(&Aabb::of(q)) >= bound {
                continue;
            }
            let found = triangle_triangle(p, q);
            if found.squared < bound {
                bound = found.squared;
                best = Some(found);
            }
        }
    }
    best
}
