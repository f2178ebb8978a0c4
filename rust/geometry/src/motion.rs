//! Points moved along candidate joints.

use nalgebra::{IsometryMatrix3, Point3, Rotation3, Unit, Vector3};

/// How a joint moves its part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Turns about a line.
    Revolute,
    /// Slides along a direction.
    Prismatic,
    /// Turns about a line and slides along it.
    Screw,
}

/// A joint as a line: its kind, unit direction and a point that the line goes through.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointAxis {
    /// How the part moves.
    pub kind: JointKind,
    /// Direction of the line.
    pub direction: Unit<Vector3<f64>>,
    /// A point of the line.
    pub pivot: Point3<f64>,
}

/// A rotation followed by a translation.
pub type RigidMotion = IsometryMatrix3<f64>;

impl JointAxis {
    /// The displacement by `angle` (radians, unused by prismatic joints) and `shift` (a length, unused by revolute ones).
    pub fn displacement(&self, angle: f64, shift: f64) -> RigidMotion {
        let angle = if self.kind == JointKind::Prismatic { 0.0 } else { angle };
        let shift = if self.kind == JointKind::Revolute { 0.0 } else { shift };
        let rotation = Rotation3::from_axis_angle(&self.direction, angle);
        let pivot = if self.kind == JointKind::Prismatic { Vector3::zeros() } else { self.pivot.coords };
        let translation = pivot - rotation * pivot + self.direction.scale(shift);
        RigidMotion::from_parts(translation.into(), rotation)
    }
}

/// Coordinates of four points: the unit in which they are moved, so that every lane of a vector register does the same.
const LANES: usize = 12;

/// Points arranged to be moved again and again: each coordinate is repeated for the three coordinates of the result.
pub struct PointBlocks {
    blocks: Vec<[[f32; LANES]; 3]>,
}

impl PointBlocks {
    /// Arranges `points`.
    pub fn new(points: &[[f32; 3]]) -> Self {
        let spread = |four: &[[f32; 3]]| {
            std::array::from_fn(|axis| std::array::from_fn(|lane| four.get(lane / 3).map_or(0.0, |point| point[axis])))
        };
        Self { blocks: points.chunks(LANES / 3).map(spread).collect() }
    }

    /// Writes the moved points, three coordinates each, to `out`, which has room for exactly so many.
    pub fn moved_into(&self, motion: &RigidMotion, out: &mut [f32]) {
        let column = |axis: usize| -> [f32; LANES] { std::array::from_fn(|i| motion.rotation[(i % 3, axis)] as f32) };
        let (x, y, z) = (column(0), column(1), column(2));
        let shift: [f32; LANES] = std::array::from_fn(|i| motion.translation.vector[i % 3] as f32);
        let mut rows = out.chunks_exact_mut(LANES);
        for (row, points) in rows.by_ref().zip(&self.blocks) {
            for i in 0..LANES {
                row[i] = x[i] * points[0][i] + y[i] * points[1][i] + z[i] * points[2][i] + shift[i];
            }
        }
        let rest = rows.into_remainder();
        if let Some(points) = self.blocks.last() {
            for (i, value) in rest.iter_mut().enumerate() {
                *value = x[i] * points[0][i] + y[i] * points[1][i] + z[i] * points[2][i] + shift[i];
            }
        }
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
        fn displacements_are_turns_about_the_pivot_and_slides(
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

        #[test]
        fn blocks_of_points_move_like_single_points(
            axis in axes(), angle in -7.0..7.0f64, points in prop::collection::vec(prop::array::uniform3(-1.0..1.0f32), 0..19),
        ) {
            let motion = axis.displacement(angle, 0.5);
            let mut out = vec![f32::NAN; 3 * points.len()];
            PointBlocks::new(&points).moved_into(&motion, &mut out);
            for (moved, point) in out.chunks_exact(3).zip(&points) {
                let expected = motion * Point3::from(point.map(f64::from));
                prop_assert!((0..3).all(|i| (f64::from(moved[i]) - expected[i]).abs() < 2e-6));
            }
        }
    }
}
