use kinmo_geometry::GeometryError;
use kinmo_geometry::interaction::{self, InteractionRegion, PairSamples};
use nalgebra::Point3;
use numpy::ndarray::{Array2, ArrayViewD};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArrayDyn};
use pyo3::prelude::*;

use crate::convert::value_error;
use crate::groups::{groups_of, pairs_of};

/// Pairs between two looks at the signals.
const BATCH: usize = 64;

#[derive(FromPyObject)]
enum Points<'py> {
    Double(PyReadonlyArrayDyn<'py, f64>),
    Single(PyReadonlyArrayDyn<'py, f32>),
}

impl Points<'_> {
    /// The samples of every mesh, all of them finite, and how many each has.
    fn samples(&self) -> Result<(Vec<Point3<f64>>, usize), GeometryError> {
        match self {
            Points::Double(points) => samples_of(points.as_array()),
            Points::Single(points) => samples_of(points.as_array()),
        }
    }
}

fn samples_of<T: Copy + Into<f64>>(points: ArrayViewD<'_, T>) -> Result<(Vec<Point3<f64>>, usize), GeometryError> {
    let (&[_, count, 3], false) = (points.shape(), points.is_empty()) else {
        return Err(GeometryError::new(
            "points",
            format!("shape {:?}, expected [P, n, 3], n at least 1", points.shape()),
        ));
    };
    let values: Vec<f64> = points.iter().map(|&x| x.into()).collect();
    if !values.iter().all(|x| x.is_finite()) {
        return Err(GeometryError::new("points", "not finite"));
    }
    Ok((values.chunks_exact(3).map(Point3::from_slice).collect(), count))
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
    points: Points<'py>,
    pairs: PyReadonlyArrayDyn<'py, u32>,
    groups: Option<Vec<Vec<i64>>>,
) -> PyResult<InteractionRegions> {
    let (samples, count) = points.samples().map_err(value_error)?;
    let groups = groups_of(samples.len() / count, groups).map_err(value_error)?;
    let pairs = pairs_of(groups.len(), &pairs).map_err(value_error)?;
    let gather = |group: usize| -> Vec<Point3<f64>> {
        groups[group].iter().flat_map(|&mesh| &samples[mesh * count..(mesh + 1) * count]).copied().collect()
    };
    let mut regions: Vec<InteractionRegion> = Vec::with_capacity(pairs.len());
    for batch in pairs.chunks(BATCH) {
        regions.extend(py.detach(|| {
            let clouds: Vec<PairSamples> = batch
                .iter()
                .map(|&(moving, reference)| PairSamples { moving: gather(moving), reference: gather(reference) })
                .collect();
            interaction::interaction_regions(&clouds)
        }));
        py.check_signals()?;
    }

    let mut offsets = vec![0i64];
    let (mut chosen, mut weights) = (Vec::new(), Vec::new());
    for (&(moving, reference), region) in pairs.iter().zip(&regions) {
        for &(sample, weight) in &region.samples {
            let (slot, within) = (sample as usize / count, sample as usize % count);
            let mesh = groups[moving].iter().chain(&groups[reference]).nth(slot);
            chosen.extend([mesh.map_or(0, |&mesh| mesh as u32), within as u32]);
            weights.push(weight);
        }
        offsets.push(weights.len() as i64);
    }
    let samples = Array2::from_shape_fn((weights.len(), 2), |(row, side)| chosen[2 * row + side]);
    let centroids = Array2::from_shape_fn((regions.len(), 3), |(row, axis)| regions[row].centroid[axis]);
    Ok(InteractionRegions {
        centroids: centroids.into_pyarray(py).unbind(),
        scored: PyArray1::from_iter(py, regions.iter().map(|region| region.scored)).unbind(),
        touching: PyArray1::from_iter(py, regions.iter().map(|region| region.touching)).unbind(),
        offsets: PyArray1::from_vec(py, offsets).unbind(),
        samples: samples.into_pyarray(py).unbind(),
        weights: PyArray1::from_vec(py, weights).unbind(),
    })
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<InteractionRegions>()?;
    module.add_function(wrap_pyfunction!(interaction_regions, module)?)
}
