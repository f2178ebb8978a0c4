//! Candidate joints as arrays.

use kinmo_geometry::motion::joint_axis::{JointAxis, JointKind};
use kinmo_geometry::{GeometryError, Result};
use nalgebra::{Unit, Vector3};

use crate::arguments::arrays::{Array, check_shape, points_of, vectors_of};

/// Largest deviation of a direction's length from 1.
const UNIT_LENGTH: f64 = 1e-6;

/// Checked candidate joints from `kinds` `[C]` (0 revolute, 1 prismatic, 2 screw), `directions` `[C, 3]` and `pivots`
/// `[C, 3]`.
pub fn joints_of(
    kinds: &Array<'_, u8>,
    directions: &Array<'_, f64>,
    pivots: &Array<'_, f64>,
) -> Result<Vec<JointAxis>> {
    let count = kinds.view().shape().first().copied().unwrap_or(0);
    let kinds = kinds_of(kinds, count)?;
    let directions = unit_vectors_of("directions", directions, count)?;
    let pivots = points_of("pivots", pivots.view(), count)?;
    let rows = kinds.into_iter().zip(directions).zip(pivots);
    Ok(rows.map(|((kind, direction), pivot)| JointAxis { kind, direction, pivot }).collect())
}

/// Checked list of `len` joint kinds: 0 revolute, 1 prismatic, 2 screw.
pub fn kinds_of(kinds: &Array<'_, u8>, len: usize) -> Result<Vec<JointKind>> {
    let kinds = kinds.view();
    check_shape("kinds", &kinds, &[len])?;
    let kind = |(row, kind): (usize, &u8)| match kind {
        0 => Ok(JointKind::Revolute),
        1 => Ok(JointKind::Prismatic),
        2 => Ok(JointKind::Screw),
        _ => Err(GeometryError::new("kinds", format!("row {row} is {kind}, expected 0, 1 or 2"))),
    };
    kinds.iter().enumerate().map(kind).collect()
}

/// Checked list of unit vectors `[len, 3]`.
pub fn unit_vectors_of(name: &str, vectors: &Array<'_, f64>, len: usize) -> Result<Vec<Unit<Vector3<f64>>>> {
    let unit = |(row, vector): (usize, Vector3<f64>)| {
        let length = vector.norm();
        if (length - 1.0).abs() > UNIT_LENGTH {
            return Err(GeometryError::new(name, format!("row {row} has length {length}, expected 1")));
        }
        Ok(Unit::new_normalize(vector))
    };
    vectors_of(name, vectors.view(), len)?.into_iter().enumerate().map(unit).collect()
}
