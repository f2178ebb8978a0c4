//! `Meshes`: the parts of a shape, checked once and handed to every other function.

use std::sync::OnceLock;

use kinmo_geometry::bvh::Bvh;
use kinmo_geometry::parry::Surface;
use kinmo_geometry::{GeometryError, Mesh, Result};
use nalgebra::Point3;
use numpy::PyArray1;
use numpy::ndarray::ArrayViewD;
use pyo3::prelude::*;

use crate::arrays::{Array, rows_of};
use crate::batches::map_in_batches;
use crate::convert::value_error;

/// The triangle meshes of the parts of one shape.
#[pyclass(frozen, module = "kinmo._core")]
pub struct Meshes {
    pub parts: Vec<Mesh>,
    /// A tree a part, built when it is first asked for.
    trees: Vec<OnceLock<Bvh>>,
    /// A surface to project points on a part, likewise.
    surfaces: Vec<OnceLock<Surface>>,
}

impl Meshes {
    /// The tree over the triangles of one part.
    pub fn tree(&self, part: usize) -> &Bvh {
        self.trees[part].get_or_init(|| Bvh::new(&self.parts[part]))
    }

    /// The surface of one part.
    pub fn surface(&self, part: usize) -> &Surface {
        self.surfaces[part].get_or_init(|| Surface::new(&self.parts[part]))
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
        let surfaces = parts.iter().map(|_| OnceLock::new()).collect();
        Ok(Self { parts, trees, surfaces })
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
