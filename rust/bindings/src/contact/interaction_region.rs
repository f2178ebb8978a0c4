//! `interaction_regions`: interaction regions of pairs of parts.

use kinmo_geometry::GeometryError;
use kinmo_geometry::contact::interaction_region::interaction_region;
use nalgebra::Point3;
use numpy::ndarray::ArrayViewD;
use numpy::{Element, PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, array_of_rows, array_of_vectors, check_finite};
use crate::arguments::groups::{groups_of, pairs_of};
use crate::arguments::numbers::Index;
use crate::batches::map_in_batches;
use crate::errors::value_error;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<InteractionRegions>()?;
    module.add_function(wrap_pyfunction!(interaction_regions, module)?)
}

/// Surface samples, the same number for every mesh.
struct Samples {
    points: Vec<Point3<f64>>,
    of_each: usize,
}

impl Samples {
    /// Checked samples from an array in single or double precision.
    fn of(points: &Bound<'_, PyAny>) -> PyResult<Self> {
        match points.extract::<Array<'_, f32>>() {
            Ok(points) => Self::of_view(points.view()),
            Err(_) => Self::of_view(points.extract::<Array<'_, f64>>()?.view()),
        }
        .map_err(value_error)
    }

    fn of_view<T: Element + Copy + Into<f64>>(points: ArrayViewD<'_, T>) -> Result<Self, GeometryError> {
        let (&[_, of_each, 3], true) = (points.shape(), points.shape().get(1) != Some(&0)) else {
            let problem = format!("shape {:?}, expected [P, n, 3], n at least 1", points.shape());
            return Err(GeometryError::new("points", problem));
        };
        check_finite("points", &points)?;
        let values: Vec<f64> = points.iter().map(|&x| x.into()).collect();
        Ok(Self { points: values.chunks_exact(3).map(Point3::from_slice).collect(), of_each })
    }

    fn meshes(&self) -> usize {
        self.points.len() / self.of_each
    }

    fn of_group(&self, group: &[usize]) -> Vec<Point3<f64>> {
        let of_mesh = |&mesh: &usize| &self.points[mesh * self.of_each..(mesh + 1) * self.of_each];
        group.iter().flat_map(of_mesh).copied().collect()
    }
}

#[pyclass(frozen, get_all, module = "kinmo._core")]
struct InteractionRegions {
    centroids: Py<PyArray2<f64>>,
    scored: Py<PyArray1<bool>>,
    touching: Py<PyArray1<bool>>,
    offsets: Py<PyArray1<i64>>,
    samples: Py<PyArray2<u32>>,
    weights: Py<PyArray1<f64>>,
}

#[pyfunction]
#[pyo3(signature = (points, pairs, groups=None))]
fn interaction_regions<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = Samples::of)] points: Samples,
    pairs: Array<'py, u32>,
    groups: Option<Vec<Vec<Index>>>,
) -> PyResult<InteractionRegions> {
    let groups = groups_of(points.meshes(), groups).map_err(value_error)?;
    let pairs = pairs_of(groups.len(), &pairs).map_err(value_error)?;
    let regions = map_in_batches(py, &pairs, |&(moving, reference)| {
        interaction_region(&points.of_group(&groups[moving]), &points.of_group(&groups[reference]))
    })?;

    let mut offsets = vec![0i64];
    let (mut chosen, mut weights) = (Vec::new(), Vec::new());
    for (&(moving, reference), region) in pairs.iter().zip(&regions) {
        let meshes = [&groups[moving][..], &groups[reference]].concat();
        for &(sample, weight) in &region.samples {
            let sample = sample as usize;
            chosen.push([meshes[sample / points.of_each] as u32, (sample % points.of_each) as u32]);
            weights.push(weight);
        }
        offsets.push(weights.len() as i64);
    }
    Ok(InteractionRegions {
        centroids: array_of_vectors(py, regions.iter().map(|region| region.centroid.coords))?.unbind(),
        scored: PyArray1::from_iter(py, regions.iter().map(|region| region.scored)).unbind(),
        touching: PyArray1::from_iter(py, regions.iter().map(|region| region.touching)).unbind(),
        offsets: PyArray1::from_vec(py, offsets).unbind(),
        samples: array_of_rows(py, chosen)?.unbind(),
        weights: PyArray1::from_vec(py, weights).unbind(),
    })
}
