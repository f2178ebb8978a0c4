//! Arguments of pose searches: point pairs, joints, joint ranges and poses of the parts of articulated objects.

use std::ops::Range;

use kinmo_geometry::pose::articulated_pose::JointConstraint;
use kinmo_geometry::pose::similarity::{PointPair, Similarity};
use kinmo_geometry::{GeometryError, Result};
use nalgebra::{Point3, Rotation3};
use numpy::ndarray::ArrayView1;
use pyo3::prelude::*;

use crate::arguments::arrays::{Array, check_shape, matrices_of, rows_of, triples_of, values_of, vectors_of};
use crate::arguments::boxes::is_rotation;
use crate::arguments::groups::{pairs_of, ranges_of};
use crate::arguments::joints::{kinds_of, unit_vectors_of};
use crate::arguments::numbers::{count_of, float, integer};
use crate::errors::value_error;

/// Largest number of hypotheses of a search.
const MAX_HYPOTHESES: usize = 10_000_000;
/// Largest joint angle in either direction, in radians.
const MAX_ANGLE: f64 = 1000.0;

/// Point pairs of all parts, stored part after part.
pub struct PartPairs {
    pairs: Vec<PointPair>,
    ranges: Vec<Range<usize>>,
}

impl PartPairs {
    /// Checked pairs from `source` and `target` `[T, 3]`. Consecutive `offsets` `[P + 1]` bound the pairs of a part.
    pub fn of(source: &Array<'_, f64>, target: &Array<'_, f64>, offsets: &Array<'_, i64>) -> Result<Self> {
        let (source, target) = (source.view(), target.view());
        let count = source.shape().first().copied().unwrap_or(0);
        let sources = triples_of("source", &source, count)?;
        let targets = triples_of("target", &target, count)?;
        let ranges = ranges_of("offsets", offsets, count)?;
        let pairs = sources.iter().zip(targets.iter()).map(|(a, b)| (Point3::from(*a), Point3::from(*b))).collect();
        Ok(Self { pairs, ranges })
    }

    /// Number of parts.
    pub fn len(&self) -> usize {
        self.ranges.len()
    }

    /// Pairs of one part.
    pub fn of_part(&self, part: usize) -> &[PointPair] {
        &self.pairs[self.ranges[part].clone()]
    }
}

/// Checked joints: `pairs` `[J, 2]` of `parts` parts, `kinds` `[J]` and `directions` `[J, 3]`.
pub fn constraints_of(
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

/// Checked angle ranges `[count, 2]` in radians. A row of NaN is an unknown range.
pub fn angle_ranges_of(count: usize, ranges: &Array<'_, f64>) -> Result<Vec<Option<[f64; 2]>>> {
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

/// Checked poses: rotations `[count, 3, 3]`, scales `[count]` and translations `[count, 3]`.
pub fn poses_of(
    count: usize,
    rotations: &Array<'_, f64>,
    scales: &Array<'_, f64>,
    translations: &Array<'_, f64>,
) -> Result<Vec<Similarity>> {
    let matrices = matrices_of("rotations", rotations.view(), count)?;
    if let Some(row) = matrices.iter().position(|matrix| !is_rotation(matrix)) {
        return Err(GeometryError::new("rotations", format!("row {row} is no rotation")));
    }
    let scales = scales_of(count, scales)?;
    let translations = vectors_of("translations", translations.view(), count)?;
    let rows = matrices.into_iter().map(Rotation3::from_matrix_unchecked).zip(scales).zip(translations);
    Ok(rows.map(|((rotation, scale), translation)| Similarity { rotation, scale, translation }).collect())
}

/// Checked scales `[count]`, all above 0.
pub fn scales_of(count: usize, scales: &Array<'_, f64>) -> Result<Vec<f64>> {
    let scales: Vec<f64> = values_of("scales", scales.view(), count)?.to_vec();
    match scales.iter().position(|scale| *scale <= 0.0) {
        Some(row) => Err(GeometryError::new("scales", format!("row {row} is {}, expected more than 0", scales[row]))),
        None => Ok(scales),
    }
}

/// A checked number of hypotheses.
pub fn hypotheses(object: &Bound<'_, PyAny>) -> PyResult<usize> {
    count_of("hypotheses", integer(object)?, MAX_HYPOTHESES).map_err(value_error)
}

/// A checked limit of residuals: a finite length above 0.
pub fn threshold(object: &Bound<'_, PyAny>) -> PyResult<f64> {
    let threshold = float(object)?;
    if threshold > 0.0 && threshold.is_finite() {
        return Ok(threshold);
    }
    Err(value_error(GeometryError::new("threshold", format!("{threshold}, expected a length above 0"))))
}
