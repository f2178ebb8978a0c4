//! `find_similarities`, `fit_constrained_poses`, `find_constrained_poses` and `refine_poses`: poses of parts from point pairs.

use std::ops::Range;

use kinmo_geometry::pose::articulated_pose::{self, JointConstraint};
use kinmo_geometry::pose::pose_refinement;
use kinmo_geometry::pose::similarity::{PointPair, Similarity, is_inlier};
use kinmo_geometry::pose::similarity_ransac::{self, RansacOptions};
use kinmo_geometry::{GeometryError, Result};
use nalgebra::Vector3;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, array_of_rows, array_of_vectors, flags_of};
use crate::arguments::articulated_parts::{
    PartPairs, angle_ranges_of, constraints_of, hypotheses, poses_of, scales_of, threshold,
};
use crate::arguments::groups::ranges_of;
use crate::arguments::numbers::seed;
use crate::batches::map_in_batches;
use crate::errors::value_error;

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
    #[pyo3(from_py_with = hypotheses)] hypotheses: usize,
    #[pyo3(from_py_with = threshold)] threshold: f64,
    #[pyo3(from_py_with = seed)] seed: u64,
) -> PyResult<(Poses<'py>, Bound<'py, PyArray1<bool>>)> {
    let parts = PartPairs::of(&source, &target, &offsets).map_err(value_error)?;
    let options = RansacOptions { hypotheses, threshold, seed };
    let found = map_in_batches(py, (0..parts.len()).map(|part| parts.of_part(part)), |pairs| {
        similarity_ransac::find_similarity(pairs, &options)
    })?;
    let inliers = found.iter().enumerate().flat_map(|(part, found)| {
        parts.of_part(part).iter().map(move |pair| found.is_some_and(|found| is_inlier(&found, pair, threshold)))
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
    #[pyo3(from_py_with = threshold)] threshold: f64,
) -> PyResult<Poses<'py>> {
    let parts = PartPairs::of(&source, &target, &offsets).map_err(value_error)?;
    let constraints = constraints_of(parts.len(), &pairs, &kinds, &directions).map_err(value_error)?;
    let poses = poses_of(parts.len(), &rotations, &scales, &translations).map_err(value_error)?;
    let objects = objects_of(&frames, &parts, &constraints, &poses).map_err(value_error)?;
    fit_each(py, &objects, |object| {
        articulated_pose::fit_constrained_poses(&object.pairs, &object.constraints, object.poses, threshold)
    })
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
    #[pyo3(from_py_with = threshold)] threshold: f64,
) -> PyResult<Poses<'py>> {
    let parts = PartPairs::of(&source, &target, &offsets).map_err(value_error)?;
    let constraints = constraints_of(parts.len(), &pairs, &kinds, &directions).map_err(value_error)?;
    let ranges = angle_ranges_of(constraints.len(), &ranges).map_err(value_error)?;
    let axis_aligned = flags_of("axis_aligned", &axis_aligned, &[parts.len()])?;
    let poses = poses_of(parts.len(), &rotations, &scales, &translations).map_err(value_error)?;
    let objects = objects_of(&frames, &parts, &constraints, &poses).map_err(value_error)?;
    fit_each(py, &objects, |object| {
        let ranges: Vec<_> = object.rows.iter().map(|row| ranges[*row]).collect();
        let axis_aligned = &axis_aligned[object.parts.clone()];
        pose_refinement::refine_poses(
            &object.pairs,
            &object.constraints,
            &ranges,
            axis_aligned,
            object.poses,
            threshold,
        )
    })
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
    #[pyo3(from_py_with = hypotheses)] hypotheses: usize,
    #[pyo3(from_py_with = threshold)] threshold: f64,
    #[pyo3(from_py_with = seed)] seed: u64,
) -> PyResult<(Poses<'py>, Poses<'py>)> {
    let parts = PartPairs::of(&source, &target, &offsets).map_err(value_error)?;
    let constraints = constraints_of(parts.len(), &pairs, &kinds, &directions).map_err(value_error)?;
    let scales = scales_of(parts.len(), &scales).map_err(value_error)?;
    let options = RansacOptions { hypotheses, threshold, seed };
    let found = map_in_batches(py, &constraints, |constraint| {
        let clouds = constraint.parts.map(|part| parts.of_part(part));
        let scales = constraint.parts.map(|part| scales[part]);
        articulated_pose::find_constrained_poses(clouds, scales, constraint.kind, constraint.direction, &options)
    })?;
    let side = |place: usize| found.iter().map(|found| found.map(|poses| poses[place])).collect::<Vec<_>>();
    Ok((to_arrays(py, &side(0))?, to_arrays(py, &side(1))?))
}

/// One object: its parts with their pairs and poses, and its joints.
struct Object<'a> {
    /// Parts of the object among all parts.
    parts: Range<usize>,
    pairs: Vec<&'a [PointPair]>,
    poses: &'a [Similarity],
    /// Joints of the object among all joints.
    rows: Vec<usize>,
    /// These joints, with the object's parts numbered from 0.
    constraints: Vec<JointConstraint>,
}

/// Divides parts and joints into objects. Consecutive `frames` bound the parts of an object.
fn objects_of<'a>(
    frames: &Array<'_, i64>,
    parts: &'a PartPairs,
    constraints: &[JointConstraint],
    poses: &'a [Similarity],
) -> Result<Vec<Object<'a>>> {
    let object = |own: Range<usize>| Object {
        pairs: own.clone().map(|part| parts.of_part(part)).collect(),
        poses: &poses[own.clone()],
        parts: own,
        rows: Vec::new(),
        constraints: Vec::new(),
    };
    let mut objects: Vec<Object<'_>> = ranges_of("frames", frames, parts.len())?.into_iter().map(object).collect();
    for (row, constraint) in constraints.iter().enumerate() {
        let [first, second] = constraint.parts;
        let place = objects.partition_point(|object| object.parts.end <= first);
        let object = &mut objects[place];
        if !object.parts.contains(&second) {
            return Err(GeometryError::new("pairs", format!("row {row} ties parts of two frames")));
        }
        object.rows.push(row);
        let own_parts = constraint.parts.map(|part| part - object.parts.start);
        object.constraints.push(JointConstraint { parts: own_parts, ..*constraint });
    }
    Ok(objects)
}

/// Poses of the parts of all objects, by `fit`.
fn fit_each<'py>(
    py: Python<'py>,
    objects: &[Object<'_>],
    fit: impl Fn(&Object<'_>) -> Vec<Similarity> + Sync,
) -> PyResult<Poses<'py>> {
    let found = map_in_batches(py, objects, fit)?;
    to_arrays(py, &found.into_iter().flatten().map(Some).collect::<Vec<_>>())
}

/// Converts poses to arrays. Missing poses are NaN.
fn to_arrays<'py>(py: Python<'py>, poses: &[Option<Similarity>]) -> PyResult<Poses<'py>> {
    // nalgebra stores matrices column by column.
    let rows_of = |pose: &Similarity| pose.rotation.matrix().transpose().data.0;
    let rotations = poses.iter().flat_map(|pose| pose.as_ref().map_or([[f64::NAN; 3]; 3], rows_of));
    let scales = poses.iter().map(|pose| pose.map_or(f64::NAN, |pose| pose.scale));
    let translations = poses.iter().map(|pose| pose.map_or(Vector3::repeat(f64::NAN), |pose| pose.translation));
    let rotations = array_of_rows(py, rotations)?.reshape([poses.len(), 3, 3])?;
    Ok((rotations, PyArray1::from_iter(py, scales), array_of_vectors(py, translations)?))
}
