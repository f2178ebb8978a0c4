//! Closed convex triangle meshes.

use nalgebra::{Point3, Vector3};

/// A closed convex triangle mesh. Coplanar neighbouring triangles are not merged.
#[derive(Debug, Clone, PartialEq)]
pub struct Polyhedron {
    /// Corners.
    pub vertices: Vec<Point3<f64>>,
    /// Corner indices of the facets, counter-clockwise seen from outside.
    pub facets: Vec<[u32; 3]>,
    /// Edges between two facets.
    pub edges: Vec<Edge>,
}

/// An edge of a [`Polyhedron`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// Indices of the two ends.
    pub vertices: [u32; 2],
    /// Indices of the facets on its two sides.
    pub facets: [u32; 2],
}

impl Polyhedron {
    /// Area vector of a facet: its outward unit normal times its area.
    pub fn area_vector(&self, facet: u32) -> Vector3<f64> {
        let [a, b, c] = self.facets[facet as usize].map(|v| self.vertices[v as usize]);
        0.5 * (b - a).cross(&(c - a))
    }
}
