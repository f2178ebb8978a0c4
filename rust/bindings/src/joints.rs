//! Candidate joints as arrays.

use kinmo_geometry::motion::{JointAxis, JointKind};
use kinmo_geometry::{GeometryError, Result};
use nalgebra::Unit;

use crate::arrays::{Array, check_shape, points_of, vectors_of};

/// Largest deviation of a direction's length from 1.
const UNIT_LENGTH: f64 = 1e-6;

/// C candidate joints from `kinds` `[C]` (0 revolute, 1 prismatic, 2 screw), `directions` `[C, 3]` and `pivots` `[C, 3]`.
pub fn joints_of(
    kinds: &Array<'_, u8>,
    directions: &Array<'_, f64>,
    pivots: &Array<'_, f64>,
) -> Result<Vec<JointAxis>> {
    let kinds = kinds.view();
    let count = kinds.shape().first().copied().unwrap_or(0);
    check_shape("kinds", &kinds, &[count])?;
    let directions = vectors_of("directions", directions.view(), count)?;
    let pivots = points_of("pivots", pivots.view(), count)?;
    let mut joints = Vec::with_capacity(count);
    for (row, ((&kind, direction), pivot)) in kinds.iter().zip(directions).zip(pivots).enumerate() {
        let kind = match kind {
            0 => JointKind::Revolute,
            1 => JointKind::Prismatic,
            2 => JointKind::Screw,
            _ => return Err(GeometryError::new("kinds", format!("row {row} is {kind}, expected 0, 1 or 2"))),
        };
        let length = direction.norm();
        if (length - 1.0).abs() > UNIT_LENGTH {
            return Err(GeometryError::new("directions", format!("row {row} has length {length}, expected 1")));
        }
        joints.push(JointAxis { kind, direction: Unit::new_normalize(direction), pivot });
    }
    Ok(joints)
}
