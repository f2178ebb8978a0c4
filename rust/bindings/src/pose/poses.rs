//! `find_similarities`, `fit_constrained_poses`, `find_constrained_poses` and `refine_poses`: poses of parts from point pairs.

use std::ops::Range;

use kinmo_geometry::pose::articulated_pose::{self, JointConstraint};
use kinmo_geometry::pose::pose_refinement::refine_poses as refine;
use kinmo_geometry::pose::similarity::Similarity;
use kinmo_geometry::pose::similarity::{PointPair, is_inlier};
use kinmo_geometry::pose::similarity_ransac::{self, RansacOptions};
use kinmo_geometry::{GeometryError, Result};
use nalgebra::{Point3, Rotation3, Vector3};
use numpy::ndarray::ArrayView1;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, check_shape, flags_of, matrices_of, rows_of, triples_of, values_of, vectors_of};
use crate::arguments::boxes::is_orthonormal;
use crate::arguments::groups::{pairs_of, ranges_of};
use crate::arguments::joints::{kinds_of, unit_vectors_of};
use crate::arguments::numbers::{count_of, float, integer, seed as seed_of};
use crate::batches::map_in_batches;
use crate::errors::value_error;

/// Largest number of hypotheses of a search.
const MAX_HYPOTHESES: usize = 10_000_000;
/// Largest joint angle in either direction, in radians.
const MAX_ANGLE: f64 = 1000.0;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(find_similarities, module)?)?;
    module.add_function(wrap_pyfunction!(fit_constrained_poses, module)?)?;
    module.add_function(wrap_pyfunction!(find_constrained_poses, module)?)?;
    module.add_function(wrap_pyfunction!(refine_poses, module)?)
}

/// Rotations `[N, 3, 3]`, scales `[N]` and translations `[N, 3]`.
type Poses<'py> = (Bound<'py, PyArray3<f64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

#[pyfunction]
#[pyo3(signature = (source, target, offsets, *, hypotheses, threshold, seed))]
#[allow(clippy::too_many_arguments)]
fn find_similarities<'py>(
    py: Python<'py>,
    source: Array<'py, f64>,
    target: Array<'py, f64>,
    offsets: Array<'py, i64>,
    hypotheses: Bound<'py, PyAny>,
    #[pyo3(from_py_with = float)] threshold: f64,
    seed: Bound<'py, PyAny>,
) -> PyResult<(Poses<'py>, Bound<'py, PyArray1<bool>>)> {
    let parts = PartPairs::of(&source, &target, &offsets).map_err(value_error)?;
    let options = options_of(&hypotheses, threshold, &seed)?;
    let found = map_in_batches(py, (0..parts.len()).map(|part| parts.pairs(part)), |pairs| {
        similarity_ransac::find_similarity(pairs, &options)
    })?;
    let inliers = found.iter().enumerate().flat_map(|(part, found)| {
        parts.pairs(part).iter().map(move |pair| found.is_some_and(|found| is_inlier(&found, pair, threshold)))
    });
    let inliers = PyArray1::from_iter(py, inliers);
    Ok((to_arrays(py, &found)?, inliers))
}

#[pyfunction]
#[pyo3(signature = (source, target, offsets, pairs, kinds, directions, rotations, scales, translations, *, frames, threshold))]
#[allow(clippy::too_many_arguments)]
fn fit_constrained_poses<'py>(
    py: Python<'py>,
    source: Array<'py, f64>,
    target: Array<'py, f64>,
    offsets: Array<'py, i64>,
    pairs: Array<'py, u32>,
    kinds: Array<'py, u8>,
    directions: Array<'py, f64>,
    rotations: Array<'py, f64>,
    scales: Array<'py, f64>,
    translations: Array<'py, f64>,
    frames: Array<'py, i64>,
    #[pyo3(from_py_with = float)] threshold: f64,
) -> PyResult<Poses<'py>> {
    check_threshold(threshold).map_err(value_error)?;
    let parts = PartPairs::of(&source, &target, &offsets).map_err(value_error)?;
    let constraints = constraints_of(parts.len(), &pairs, &kinds, &directions).map_err(value_error)?;
    let poses = poses_of(parts.len(), &rotations, &scales, &translations).map_err(value_error)?;
    let frames = ranges_of("frames", &frames, parts.len()).map_err(value_error)?;
    let by_frame = constraints_by_frame(&frames, &constraints).map_err(value_error)?;
    let found = map_in_batches(py, frames.into_iter().zip(&by_frame), |(frame, rows)| {
        let (own, constraints) = (parts.of_frame(&frame), own_constraints(&constraints, rows, frame.start));
        articulated_pose::fit_constrained_poses(&own, &constraints, &poses[frame], threshold)
    })?;
    to_arrays(py, &found.into_iter().flatten().map(Some).collect::<Vec<_>>())
}

#[pyfunction]
#[pyo3(signature = (source, target, offsets, pairs, kinds, directions, scales, *, hypotheses, threshold, seed))]
#[allow(clippy::too_many_arguments)]
fn find_constrained_poses<'py>(
    py: Python<'py>,
    source: Array<'py, f64>,
    target: Array<'py, f64>,
    offsets: Array<'py, i64>,
    pairs: Array<'py, u32>,
    kinds: Array<'py, u8>,
    directions: Array<'py, f64>,
    scales: Array<'py, f64>,
    hypotheses: Bound<'py, PyAny>,
    #[pyo3(from_py_with = float)] threshold: f64,
    seed: Bound<'py, PyAny>,
) -> PyResult<(Poses<'py>, Poses<'py>)> {
    let parts = PartPairs::of(&source, &target, &offsets).map_err(value_error)?;
    let options = options_of(&hypotheses, threshold, &seed)?;
    let constraints = constraints_of(parts.len(), &pairs, &kinds, &directions).map_err(value_error)?;
    let scales = positive_of("scales", &scales, parts.len()).map_err(value_error)?;
    let found = map_in_batches(py, constraints.iter(), |constraint| {
        let (clouds, scales) =
            (constraint.parts.map(|part| parts.pairs(part)), constraint.parts.map(|part| scales[part]));
        articulated_pose::find_constrained_poses(clouds, scales, constraint.kind, constraint.direction, &options)
    })?;
    let side = |place: usize| found.iter().map(|found| found.map(|poses| poses[place])).collect::<Vec<_>>();
    Ok((to_arrays(py, &side(0))?, to_arrays(py, &side(1))?))
}

#[pyfunction]
#[pyo3(signature = (
    source, target, offsets, pairs, kinds, directions, ranges, axis_aligned, rotations, scales, translations, *, frames, threshold
))]
#[allow(clippy::too_many_arguments)]
fn refine_poses<'py>(
    py: Python<'py>,
    source: Array<'py, f64>,
    target: Array<'py, f64>,
    offsets: Array<'py, i64>,
    pairs: Array<'py, u32>,
    kinds: Array<'py, u8>,
    directions: Array<'py, f64>,
    ranges: Array<'py, f64>,
    axis_aligned: Array<'py, bool>,
    rotations: Array<'py, f64>,
    scales: Array<'py, f64>,
    translations: Array<'py, f64>,
    frames: Array<'py, i64>,
    #[pyo3(from_py_with = float)] threshold: f64,
) -> PyResult<Poses<'py>> {
    check_threshold(threshold).map_err(value_error)?;
    let parts = PartPairs::of(&source, &target, &offsets).map_err(value_error)?;
    let constraints = constraints_of(parts.len(), &pairs, &kinds, &directions).map_err(value_error)?;
    let ranges = angles_of(constraints.len(), &ranges).map_err(value_error)?;
    let axis_aligned = flags_of("axis_aligned", &axis_aligned, &[parts.len()])?;
    let poses = poses_of(parts.len(), &rotations, &scales, &translations).map_err(value_error)?;
    let frames = ranges_of("frames", &frames, parts.len()).map_err(value_error)?;
    let by_frame = constraints_by_frame(&frames, &constraints).map_err(value_error)?;
    let found = map_in_batches(py, frames.into_iter().zip(&by_frame), |(frame, rows)| {
        let (own, constraints) = (parts.of_frame(&frame), own_constraints(&constraints, rows, frame.start));
        let ranges: Vec<_> = rows.iter().map(|row| ranges[*row]).collect();
        refine(&own, &constraints, &ranges, &axis_aligned[frame.clone()], &poses[frame], threshold)
    })?;
    to_arrays(py, &found.into_iter().flatten().map(Some).collect::<Vec<_>>())
}

/// Rows of the constraints of every frame.
fn constraints_by_frame(frames: &[Range<usize>], constraints: &[JointConstraint]) -> Result<Vec<Vec<usize>>> {
    let mut rows: Vec<Vec<usize>> = vec![Vec::new(); frames.len()];
    for (row, constraint) in constraints.iter().enumerate() {
        let [first, second] = constraint.parts;
        let frame = frames.partition_point(|frame| frame.end <= first);
        if !frames[frame].contains(&second) {
            return Err(GeometryError::new("pairs", format!("row {row} ties parts of two frames")));
        }
        rows[frame].push(row);
    }
    Ok(rows)
}

/// Constraints of one frame, with parts numbered from 0.
fn own_constraints(constraints: &[JointConstraint], rows: &[usize], start: usize) -> Vec<JointConstraint> {
    rows.iter()
        .map(|row| JointConstraint { parts: constraints[*row].parts.map(|part| part - start), ..constraints[*row] })
        .collect()
}

/// Point pairs of all parts, stored part after part.
struct PartPairs {
    pairs: Vec<PointPair>,
    ranges: Vec<Range<usize>>,
}

impl PartPairs {
    fn of(source: &Array<'_, f64>, target: &Array<'_, f64>, offsets: &Array<'_, i64>) -> Result<Self> {
        let (source, target) = (source.view(), target.view());
        let count = source.shape().first().copied().unwrap_or(0);
        let sources = triples_of("source", &source, count)?;
        let targets = triples_of("target", &target, count)?;
        let ranges = ranges_of("offsets", offsets, count)?;
        let pairs = sources.iter().zip(targets.iter()).map(|(a, b)| (Point3::from(*a), Point3::from(*b))).collect();
        Ok(Self { pairs, ranges })
    }

    fn len(&self) -> usize {
        self.ranges.len()
    }

    fn pairs(&self, part: usize) -> &[PointPair] {
        &self.pairs[self.ranges[part].clone()]
    }

    fn of_frame(&self, parts: &Range<usize>) -> Vec<&[PointPair]> {
        parts.clone().map(|part| self.pairs(part)).collect()
    }
}

fn constraints_of(
    parts: usize,
    pairs: &Array<'_, u32>,
    kinds: &Array<'_, u8>,
    directions: &Array<'_, f64>,
) -> Result<Vec<JointConstraint>> {
    let pairs = pairs_of(parts, pairs)?;
    let kinds = kinds_of(kinds, pairs.len())?;
    let directions = unit_vectors_of("directions", directions, pairs.len())?;
    let rows = pairs.into_iter().zip(kinds).zip(directions);
    Ok(rows
        .map(|(((first, second), kind), direction)| JointConstraint { parts: [first, second], kind, direction })
        .collect())
}

/// Checked angle ranges in radians. A row of NaN is an unknown range.
fn angles_of(count: usize, ranges: &Array<'_, f64>) -> Result<Vec<Option<[f64; 2]>>> {
    check_shape("ranges", &ranges.view(), &[count, 2])?;
    let rows = rows_of("ranges", ranges.view(), 2)?;
    let range = |(index, row): (usize, ArrayView1<'_, f64>)| match [row[0], row[1]] {
        [low, high] if low.is_nan() && high.is_nan() => Ok(None),
        [low, high] if -MAX_ANGLE <= low && low <= high && high <= MAX_ANGLE => Ok(Some([low, high])),
        [low, high] => {
            Err(GeometryError::new("ranges", format!("row {index} is {low} to {high}, expected radians that rise")))
        }
    };
    rows.rows().into_iter().enumerate().map(range).collect()
}

fn poses_of(
    count: usize,
    rotations: &Array<'_, f64>,
    scales: &Array<'_, f64>,
    translations: &Array<'_, f64>,
) -> Result<Vec<Similarity>> {
    let matrices = matrices_of("rotations", rotations.view(), count)?;
    if let Some(row) = matrices.iter().position(|matrix| !is_orthonormal(matrix) || matrix.determinant() < 0.0) {
        return Err(GeometryError::new("rotations", format!("row {row} is no rotation")));
    }
    let scales = positive_of("scales", scales, count)?;
    let translations = vectors_of("translations", translations.view(), count)?;
    let rows = matrices.into_iter().zip(scales).zip(translations);
    Ok(rows
        .map(|((matrix, scale), translation)| Similarity {
            rotation: Rotation3::from_matrix_unchecked(matrix),
            scale,
            translation,
        })
        .collect())
}

fn positive_of(name: &str, values: &Array<'_, f64>, count: usize) -> Result<Vec<f64>> {
    let values: Vec<f64> = values_of(name, values.view(), count)?.to_vec();
    match values.iter().position(|value| *value <= 0.0) {
        Some(row) => Err(GeometryError::new(name, format!("row {row} is {}, expected more than 0", values[row]))),
        None => Ok(values),
    }
}

fn options_of(hypotheses: &Bound<'_, PyAny>, threshold: f64, seed: &Bound<'_, PyAny>) -> PyResult<RansacOptions> {
    check_threshold(threshold).map_err(value_error)?;
    let hypotheses = count_of("hypotheses", integer(hypotheses)?, MAX_HYPOTHESES).map_err(value_error)?;
    Ok(RansacOptions { hypotheses, threshold, seed: seed_of(seed)? })
}

fn check_threshold(threshold: f64) -> Result<()> {
    if threshold > 0.0 && threshold.is_finite() {
        return Ok(());
    }
    Err(GeometryError::new("threshold", format!("{threshold}, expected a length above 0")))
}

/// Converts poses to arrays. Missing poses are NaN.
fn to_arrays<'py>(py: Python<'py>, poses: &[Option<Similarity>]) -> PyResult<Poses<'py>> {
    let count = poses.len();
    let nowhere = [f64::NAN; 3];
    let rotations = poses.iter().flat_map(|pose| match pose {
        // nalgebra stores matrices column by column.
        Some(pose) => pose.rotation.matrix().transpose().data.0,
        None => [nowhere; 3],
    });
    let scales = poses.iter().map(|pose| pose.map_or(f64::NAN, |pose| pose.scale));
    let shifts = poses.iter().flat_map(|pose| pose.map_or(nowhere, |Similarity { translation, .. }| row(&translation)));
    let rotations = PyArray1::from_iter(py, rotations.flatten()).reshape([count, 3, 3])?;
    let translations = PyArray1::from_iter(py, shifts).reshape([count, 3])?;
    Ok((rotations, PyArray1::from_iter(py, scales), translations))
}

fn row(vector: &Vector3<f64>) -> [f64; 3] {
    vector.data.0[0]
}
