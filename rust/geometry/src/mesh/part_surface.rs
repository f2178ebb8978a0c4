//! Surface of a part that may consist of several meshes.

use std::borrow::Cow;

use nalgebra::Point3;

use crate::Mesh;
use crate::mesh::bvh::Bvh;

/// The meshes of a part merged into one, with one search tree per mesh.
pub struct PartSurface<'a> {
    mesh: Cow<'a, Mesh>,
    trees: Vec<&'a Bvh>,
}

impl<'a> PartSurface<'a> {
    /// Surface of the meshes of a part (at least one) and the trees over their triangles.
    pub fn new(meshes: &[&'a Mesh], trees: Vec<&'a Bvh>) -> Self {
        let mesh = match meshes {
            [only] => Cow::Borrowed(*only),
            _ => Cow::Owned(Mesh::union(meshes.iter().copied())),
        };
        Self { mesh, trees }
    }

    /// All faces of the part.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// True if `point` is nearer to the surface than `reach`.
    pub fn is_near(&self, point: &Point3<f64>, reach: f64) -> bool {
        let squared = reach * reach;
        self.trees.iter().any(|tree| tree.squared_distance_to_point(point, squared, squared).is_some())
    }

    /// Distance from `point` to the surface; `None` unless it is below `reach`.
    pub fn distance_within(&self, point: &Point3<f64>, reach: f64) -> Option<f64> {
        let nearest = self
            .trees
            .iter()
            .fold(reach * reach, |bound, tree| tree.squared_distance_to_point(point, bound, 0.0).unwrap_or(bound));
        (nearest < reach * reach).then(|| nearest.sqrt())
    }
}
