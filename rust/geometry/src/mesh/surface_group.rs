//! Nearest points on several surfaces, by a tree over the boxes around them.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::Point3;
use parry3d_f64::bounding_volume::{Aabb, BoundingVolume};

use crate::mesh::point_projection::{NearestPoint, ProjectionTree, distance_to_box};

/// A node of the tree over the surfaces.
#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: Aabb,
    /// True for a leaf, which is one surface.
    is_surface: bool,
    /// Index of the surface, or of the first of two children that follow each other.
    index: u32,
}

/// Several surfaces that are searched as one.
pub struct SurfaceGroup<'a> {
    surfaces: Vec<&'a ProjectionTree>,
    nodes: Vec<Node>,
}

/// What is still to be searched, the nearest first: bits of the distance, node before surface, and index.
type Queue = BinaryHeap<Reverse<(u64, bool, u32)>>;

impl<'a> SurfaceGroup<'a> {
    /// Arranges the surfaces.
    pub fn new(surfaces: Vec<&'a ProjectionTree>) -> Self {
        let mut leaves: Vec<Node> = surfaces
            .iter()
            .enumerate()
            .map(|(index, surface)| Node { bounds: surface.bounds(), is_surface: true, index: index as u32 })
            .collect();
        let mut nodes = Vec::with_capacity(2 * leaves.len());
        if !leaves.is_empty() {
            nodes.push(leaves[0]);
            split(&mut nodes, &mut leaves, 0);
        }
        Self { surfaces, nodes }
    }

    /// Nearest point of the surfaces to each of `points`; no points if there are no surfaces.
    ///
    /// Of surfaces at the same distance the one with the nearer box counts, and then the first.
    pub fn nearest_points(&self, points: &[Point3<f64>]) -> Vec<NearestPoint> {
        let mut queue = Queue::new();
        points.iter().filter_map(|point| self.nearest(point, &mut queue)).collect()
    }

    fn nearest(&self, point: &Point3<f64>, queue: &mut Queue) -> Option<NearestPoint> {
        queue.clear();
        queue.extend(self.nodes.first().map(|root| entry(root, 0, point)));
        let mut best: Option<NearestPoint> = None;
        while let Some(Reverse((at_least, is_surface, index))) = queue.pop() {
            let reach = best.map_or(f64::MAX, |found| found.distance);
            if f64::from_bits(at_least) > reach {
                break;
            }
            if is_surface {
                best = self.surfaces[index as usize].nearest_within(point, reach).or(best);
                continue;
            }
            let first = self.nodes[index as usize].index;
            queue.extend([first, first + 1].map(|child| entry(&self.nodes[child as usize], child, point)));
        }
        best
    }
}

/// Entry of the queue for a node at `place`. Distances are not negative, so their bits have the same order.
fn entry(node: &Node, place: u32, point: &Point3<f64>) -> Reverse<(u64, bool, u32)> {
    let distance = distance_to_box(&node.bounds, point);
    Reverse((distance.to_bits(), node.is_surface, if node.is_surface { node.index } else { place }))
}

/// Writes the tree over `leaves` to `nodes`, with its root at `place`.
fn split(nodes: &mut Vec<Node>, leaves: &mut [Node], place: usize) {
    if let [leaf] = leaves {
        nodes[place] = *leaf;
        return;
    }
    let bounds = leaves[1..].iter().fold(leaves[0].bounds, |bounds, leaf| bounds.merged(&leaf.bounds));
    let extents = bounds.extents();
    let axis = if extents.x >= extents.y.max(extents.z) {
        0
    } else if extents.y >= extents.z {
        1
    } else {
        2
    };
    let middle = leaves.len() / 2;
    leaves.select_nth_unstable_by(middle, |a, b| a.bounds.center()[axis].total_cmp(&b.bounds.center()[axis]));
    let first = nodes.len();
    nodes[place] = Node { bounds, is_surface: false, index: first as u32 };
    nodes.extend([leaves[0]; 2]);
    let (left, right) = leaves.split_at_mut(middle);
    split(nodes, left, first);
    split(nodes, right, first + 1);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::mesh::triangle::point_triangle;
    use crate::test_shapes::triangle_soup;

    /// The nearest point when all surfaces are searched one after the other, those with the nearest boxes first.
    fn searched_one_by_one(surfaces: &[&ProjectionTree], point: &Point3<f64>) -> Option<NearestPoint> {
        let mut order = surfaces.to_vec();
        let to_box = |surface: &ProjectionTree| distance_to_box(&surface.bounds(), point);
        order.sort_by(|a, b| to_box(a).total_cmp(&to_box(b)));
        order.iter().fold(None, |best: Option<NearestPoint>, surface| {
            surface.nearest_within(point, best.map_or(f64::MAX, |found| found.distance)).or(best)
        })
    }

    proptest! {
        #[test]
        fn no_triangle_is_nearer_than_the_nearest_point(
            meshes in prop::collection::vec(triangle_soup(7), 1..9), point in prop::array::uniform3(-3.0..3.0f64),
        ) {
            let point = Point3::from(point);
            let trees: Vec<ProjectionTree> = meshes.iter().map(ProjectionTree::new).collect();
            let found = SurfaceGroup::new(trees.iter().collect()).nearest_points(&[point])[0];
            let triangles: Vec<_> = meshes.iter().flat_map(|mesh| (0..mesh.faces().len()).map(|face| mesh.triangle(face))).collect();
            let expected = triangles.iter().map(|triangle| point_triangle(&point, triangle)).fold(f64::INFINITY, f64::min);
            prop_assert!((found.distance - expected.sqrt()).abs() < 1e-9);
            prop_assert!(((found.point - point).norm() - found.distance).abs() < 1e-12);
            let holds = |triangle: &[Point3<f64>; 3]| {
                let [u, v] = [triangle[1] - triangle[0], triangle[2] - triangle[0]];
                point_triangle(&found.point, triangle) < 1e-18 && u.dot(&found.normal).abs() + v.dot(&found.normal).abs() < 1e-9
            };
            prop_assert!(triangles.iter().any(holds));
        }

        #[test]
        fn equal_distances_are_decided_as_by_a_search_of_all_surfaces(
            meshes in prop::collection::vec(triangle_soup(4), 1..12),
            repeated in prop::collection::vec(0..12usize, 0..6),
            points in prop::collection::vec(prop::array::uniform3(-2.0..2.0f64), 1..6),
        ) {
            let trees: Vec<ProjectionTree> = meshes.iter().map(ProjectionTree::new).collect();
            let mut surfaces: Vec<&ProjectionTree> = trees.iter().collect();
            surfaces.extend(repeated.iter().map(|&index| &trees[index % trees.len()]));
            let mut points: Vec<Point3<f64>> = points.into_iter().map(Point3::from).collect();
            points.extend(meshes.iter().map(|mesh| mesh.triangle(0)[0]));  // on a surface, and often in many boxes
            let found = SurfaceGroup::new(surfaces.clone()).nearest_points(&points);
            prop_assert_eq!(found.len(), points.len());
            for (point, nearest) in points.iter().zip(found) {
                prop_assert_eq!(Some(nearest), searched_one_by_one(&surfaces, point));
            }
        }
    }
}
