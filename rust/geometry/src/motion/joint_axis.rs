//! Joint axes and their displacements.

use nalgebra::{IsometryMatrix3, Point3, Rotation3, Unit, Vector3};

/// Kind of motion of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Rotation about a line.
    Revolute,
    /// Translation along a direction.
    Prismatic,
    /// Rotation about a line and translation along it.
    Screw,
}

/// A joint as a line: kind, unit direction and a point on the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointAxis {
    /// Kind of motion.
    pub kind: JointKind,
    /// Direction of the line.
    pub direction: Unit<Vector3<f64>>,
    /// A point on the line.
    pub pivot: Point3<f64>,
}

/// A rotation followed by a translation.
pub type RigidMotion = IsometryMatrix3<f64>;

impl JointAxis {
    /// Displacement by `angle` (radians, ignored by prismatic joints) and `shift` (a length, ignored by revolute
    /// joints).
    pub fn displacement(&self, angle: f64, shift: f64) -> RigidMotion {
        let angle = if self.kind == JointKind::Prismatic { 0.0 } else { angle };
        let shift = if self.kind == JointKind::Revolute { 0.0 } else { shift };
        let rotation = Rotation3::from_axis_angle(&self.direction, angle);
        let pivot = if self.kind == JointKind::Prismatic { Vector3::zeros() } else { self.pivot.coords };
        let translation = pivot - rotation * pivot + self.direction.scale(shift);
        RigidMotion::from_parts(translation.into(), rotation)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Translation3, UnitQuaternion};
    use proptest::prelude::*;

    use super::*;

    fn axes() -> impl Strategy<Value = JointAxis> {
        let kinds = prop::sample::select(vec![JointKind::Revolute, JointKind::Prismatic, JointKind::Screw]);
        let vector = || prop::array::uniform3(-2.0..2.0f64);
        (kinds, vector(), vector()).prop_filter_map("a direction", |(kind, direction, pivot)| {
            let direction = Unit::try_new(Vector3::from(direction), 0.1)?;
            Some(JointAxis { kind, direction, pivot: pivot.into() })
        })
    }

    proptest! {
        #[test]
        fn displacements_are_rotations_about_the_pivot_and_translations(
            axis in axes(), angle in -7.0..7.0f64, shift in -2.0..2.0f64, point in prop::array::uniform3(-2.0..2.0f64),
        ) {
            let point = Point3::from(point);
            let turn = Isometry3::rotation_wrt_point(UnitQuaternion::from_axis_angle(&axis.direction, angle), axis.pivot);
            let slide = Isometry3::from_parts(Translation3::from(axis.direction.scale(shift)), UnitQuaternion::identity());
            let expected = match axis.kind {
                JointKind::Revolute => turn * point,
                JointKind::Prismatic => slide * point,
                JointKind::Screw => slide * (turn * point),
            };
            prop_assert!((axis.displacement(angle, shift) * point - expected).norm() < 1e-13);
        }

        #[test]
        fn displacements_along_one_axis_add_up(
            axis in axes(), a in prop::array::uniform2(-3.0..3.0f64), b in prop::array::uniform2(-3.0..3.0f64),
        ) {
            let both = axis.displacement(a[0], a[1]) * axis.displacement(b[0], b[1]);
            let at_once = axis.displacement(a[0] + b[0], a[1] + b[1]);
            prop_assert!((both.to_homogeneous() - at_once.to_homogeneous()).amax() < 1e-13);
        }
    }
}
