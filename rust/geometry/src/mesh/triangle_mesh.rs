//! Validated triangle meshes.

use nalgebra::{Point3, Vector3};

use crate::{GeometryError, Result};

/// Largest coordinate. Beyond it, squared areas and volumes overflow.
pub const MAX_COORDINATE: f64 = 1e60;

/// A triangle mesh with at least one face, finite coordinates and valid indices.
///
/// Faces may be degenerate, duplicated, inverted or non-manifold, because real part meshes are.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    vertices: Vec<Point3<f64>>,
    faces: Vec<[u32; 3]>,
    bounds: (Point3<f64>, Point3<f64>),
}

impl Mesh {
    /// Validates a mesh. Unused vertices are dropped, so that boxes and hulls fit the surface alone.
    ///
    /// # Errors
    /// If the mesh is empty, a coordinate is not finite or too large, or a face index is out of range.
    pub fn new(vertices: Vec<Point3<f64>>, faces: Vec<[u32; 3]>) -> Result<Self> {
        if vertices.is_empty() {
            return Err(GeometryError::new("vertices", "empty, expected at least one vertex"));
        }
        if faces.is_empty() {
            return Err(GeometryError::new("faces", "empty, expected at least one face"));
        }
        if let Some(row) = vertices.iter().position(|v| !v.iter().all(|x| x.abs() <= MAX_COORDINATE)) {
            return Err(GeometryError::new(
                "vertices",
                format!("row {row} is not finite, or beyond {MAX_COORDINATE:e}"),
            ));
        }
        let count = vertices.len();
        if let Some(row) = faces.iter().position(|f| f.iter().any(|&i| i as usize >= count)) {
            return Err(GeometryError::new("faces", format!("row {row} has an index outside 0..{count}")));
        }
        let (vertices, faces) = without_unused_vertices(&vertices, faces);
        Ok(Self::bounded(vertices, faces))
    }

    fn bounded(vertices: Vec<Point3<f64>>, faces: Vec<[u32; 3]>) -> Self {
        let bounds = vertices.iter().fold((vertices[0], vertices[0]), |(low, high), v| (low.inf(v), high.sup(v)));
        Self { vertices, faces, bounds }
    }

    /// Vertices. Each is used by at least one face.
    pub fn vertices(&self) -> &[Point3<f64>] {
        &self.vertices
    }

    /// Vertex indices of the faces.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// Corners of one face.
    #[inline]
    pub fn triangle(&self, face: usize) -> [Point3<f64>; 3] {
        self.faces[face].map(|i| self.vertices[i as usize])
    }

    /// Normal of one face, scaled by twice its area.
    #[inline]
    pub fn scaled_normal(&self, face: usize) -> Vector3<f64> {
        let [a, b, c] = self.triangle(face);
        (b - a).cross(&(c - a))
    }

    /// Area of every face.
    pub fn face_areas(&self) -> Vec<f64> {
        (0..self.faces.len()).map(|face| 0.5 * self.scaled_normal(face).norm()).collect()
    }

    /// Smallest and largest corner of the axis-aligned bounding box.
    pub fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        self.bounds
    }

    /// Diagonal of the axis-aligned bounding box.
    pub fn diagonal(&self) -> f64 {
        let (low, high) = self.bounds();
        (high - low).norm()
    }

    /// Mesh of some of the faces. Panics if there are none.
    pub fn submesh(&self, faces: &[[u32; 3]]) -> Mesh {
        assert!(!faces.is_empty(), "a submesh needs at least one face");
        let (vertices, faces) = without_unused_vertices(&self.vertices, faces.to_vec());
        Self::bounded(vertices, faces)
    }

    /// One mesh with the faces of all `meshes`. Panics if there are none.
    pub fn union<'a>(meshes: impl IntoIterator<Item = &'a Mesh>) -> Mesh {
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        for mesh in meshes {
            let offset = vertices.len() as u32;
            vertices.extend_from_slice(&mesh.vertices);
            faces.extend(mesh.faces.iter().map(|face| face.map(|i| i + offset)));
        }
        assert!(!faces.is_empty(), "a union needs at least one mesh");
        Self::bounded(vertices, faces)
    }
}

/// Vertices that faces use, in the order of their first use, and the faces with new indices.
fn without_unused_vertices(vertices: &[Point3<f64>], mut faces: Vec<[u32; 3]>) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    const UNUSED: u32 = u32::MAX;
    let mut renumbered = vec![UNUSED; vertices.len()];
    let mut kept = Vec::with_capacity(vertices.len());
    for index in faces.iter_mut().flatten() {
        let slot = &mut renumbered[*index as usize];
        if *slot == UNUSED {
            *slot = kept.len() as u32;
            kept.push(vertices[*index as usize]);
        }
        *index = *slot;
    }
    (kept, faces)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> Vec<Point3<f64>> {
        vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)]
    }

    #[test]
    fn drops_vertices_that_no_face_uses() {
        let mut vertices = triangle();
        vertices.insert(0, Point3::new(99.0, 0.0, 0.0));
        let mesh = Mesh::new(vertices, vec![[1, 2, 3]]).expect("valid");
        assert_eq!(mesh.vertices().len(), 3);
        assert_eq!(mesh.diagonal(), 2f64.sqrt());
        assert_eq!(mesh.face_areas(), vec![0.5]);
    }

    #[test]
    fn errors_name_the_invalid_argument() {
        let nan = vec![Point3::new(f64::NAN, 0.0, 0.0); 3];
        assert_eq!(Mesh::new(nan, vec![[0, 1, 2]]).expect_err("NaN").argument, "vertices");
        assert_eq!(Mesh::new(triangle(), vec![[0, 1, 3]]).expect_err("range").argument, "faces");
        assert_eq!(Mesh::new(triangle(), vec![]).expect_err("empty").argument, "faces");
    }
}
