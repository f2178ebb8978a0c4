//! `Meshes`: the parts of a shape, checked once and handed to every other function.

use std::sync::{Arc, OnceLock};

use kinmo_geometry::bvh::Bvh;
use kinmo_geometry::parry::Surface;
use kinmo_geometry::{GeometryError, Mesh};
use nalgebra::Point3;
use numpy::ndarray::ArrayView2;
use numpy::{PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::convert::value_error;

/// The triangle meshes of the parts of one shape.
#[pyclass(frozen, module = "kinmo._core")]
pub struct Meshes {
    pub parts: Arc<Vec<Mesh>>,
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

    /// The trees of the members of every group.
    pub fn trees_of(&self, groups: &[Vec<usize>]) -> Vec<Vec<&Bvh>> {
        groups.par_iter().map(|members| members.iter().map(|&part| self.tree(part)).collect()).collect()
    }
}

#[pymethods]
impl Meshes {
    #[new]
    fn new(
        py: Python<'_>,
        vertices: Vec<PyReadonlyArray2<'_, f64>>,
        faces: Vec<PyReadonlyArray2<'_, u32>>,
    ) -> PyResult<Self> {
        if vertices.len() != faces.len() {
            let problem = format!("{} arrays, but vertices has {}", faces.len(), vertices.len());
            return Err(value_error(GeometryError::new("faces", problem)));
        }
        let arrays: Vec<_> = vertices.iter().zip(&faces).map(|(v, f)| (v.as_array(), f.as_array())).collect();
        let parts = py.detach(|| {
            arrays.into_iter().enumerate().map(|(part, (v, f))| mesh_of(part, v, f)).collect::<Result<Vec<_>, _>>()
        });
        let parts = Arc::new(parts.map_err(value_error)?);
        let trees = parts.iter().map(|_| OnceLock::new()).collect();
        let surfaces = parts.iter().map(|_| OnceLock::new()).collect();
        Ok(Self { parts, trees, surfaces })
    }

    fn __len__(&self) -> usize {
        self.parts.len()
    }

    fn areas<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.parts.iter().map(|mesh| mesh.face_areas().iter().sum()))
    }
}

fn mesh_of(part: usize, vertices: ArrayView2<'_, f64>, faces: ArrayView2<'_, u32>) -> Result<Mesh, GeometryError> {
    for (name, columns) in [("vertices", vertices.ncols()), ("faces", faces.ncols())] {
        if columns != 3 {
            return Err(GeometryError::new(format!("{name}[{part}]"), format!("{columns} columns, expected 3")));
        }
    }
    let points = vertices.rows().into_iter().map(|r| Point3::new(r[0], r[1], r[2])).collect();
    let triangles = faces.rows().into_iter().map(|r| [r[0], r[1], r[2]]).collect();
    Mesh::new(points, triangles)
        .map_err(|error| GeometryError::new(format!("{}[{part}]", error.argument), error.problem))
}
