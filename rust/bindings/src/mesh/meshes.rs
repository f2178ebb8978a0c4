//! `Meshes`: the parts of a shape, checked once and passed to the other functions.

use std::sync::OnceLock;

use kinmo_geometry::mesh::bvh::Bvh;
use kinmo_geometry::mesh::point_projection::ProjectionTree;
use kinmo_geometry::{GeometryError, Mesh, Result};
use nalgebra::Point3;
use numpy::PyArray1;
use numpy::ndarray::ArrayViewD;
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, rows_of};
use crate::batches::map_in_batches;
use crate::errors::value_error;

/// The triangle meshes of the parts of one shape.
#[pyclass(frozen, module = "kinmo._core")]
pub struct Meshes {
    pub parts: Vec<Mesh>,
    /// One bounding volume hierarchy per part, built on first use.
    trees: Vec<OnceLock<Bvh>>,
    /// One projection tree per part, built on first use.
    projection_trees: Vec<OnceLock<ProjectionTree>>,
}

impl Meshes {
    /// Bounding volume hierarchy of one part.
    pub fn tree(&self, part: usize) -> &Bvh {
        self.trees[part].get_or_init(|| Bvh::new(&self.parts[part]))
    }

    /// Projection tree of one part.
    pub fn projection_tree(&self, part: usize) -> &ProjectionTree {
        self.projection_trees[part].get_or_init(|| ProjectionTree::new(&self.parts[part]))
    }

    /// Builds the bounding volume hierarchies of some parts in parallel, where they are not built yet.
    pub fn build_trees(&self, py: Python<'_>, parts: impl IntoIterator<Item = usize>) -> PyResult<()> {
        let missing: Vec<usize> = parts.into_iter().filter(|&part| self.trees[part].get().is_none()).collect();
        map_in_batches(py, missing, |part| {
            self.tree(part);
        })?;
        Ok(())
    }

    /// Builds the projection trees of some parts in parallel, where they are not built yet.
    pub fn build_projection_trees(&self, py: Python<'_>, parts: &[usize]) -> PyResult<()> {
        let missing: Vec<usize> =
            parts.iter().copied().filter(|&part| self.projection_trees[part].get().is_none()).collect();
        map_in_batches(py, missing, |part| {
            self.projection_tree(part);
        })?;
        Ok(())
    }
}

#[pymethods]
impl Meshes {
    #[new]
    fn new(py: Python<'_>, vertices: Vec<Array<'_, f64>>, faces: Vec<Array<'_, u32>>) -> PyResult<Self> {
        if vertices.len() != faces.len() {
            let problem = format!("{} arrays, but vertices has {}", faces.len(), vertices.len());
            return Err(value_error(GeometryError::new("faces", problem)));
        }
        let arrays = vertices.iter().zip(&faces).map(|(vertices, faces)| (vertices.view(), faces.view())).enumerate();
        let meshes = map_in_batches(py, arrays, |(part, (vertices, faces))| mesh_of(part, vertices, faces))?;
        let parts = meshes.into_iter().collect::<Result<Vec<_>>>().map_err(value_error)?;
        let trees = parts.iter().map(|_| OnceLock::new()).collect();
        let projection_trees = parts.iter().map(|_| OnceLock::new()).collect();
        Ok(Self { parts, trees, projection_trees })
    }

    fn __len__(&self) -> usize {
        self.parts.len()
    }

    fn areas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let areas = map_in_batches(py, &self.parts, |mesh| mesh.face_areas().iter().sum())?;
        Ok(PyArray1::from_vec(py, areas))
    }
}

fn mesh_of(part: usize, vertices: ArrayViewD<'_, f64>, faces: ArrayViewD<'_, u32>) -> Result<Mesh> {
    let vertices = rows_of(&format!("vertices[{part}]"), vertices, 3)?;
    let faces = rows_of(&format!("faces[{part}]"), faces, 3)?;
    let points = vertices.rows().into_iter().map(|r| Point3::new(r[0], r[1], r[2])).collect();
    let triangles = faces.rows().into_iter().map(|r| [r[0], r[1], r[2]]).collect();
    Mesh::new(points, triangles)
        .map_err(|error| GeometryError::new(format!("{}[{part}]", error.argument), error.problem))
}
