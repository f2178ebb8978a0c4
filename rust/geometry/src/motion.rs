//! Points moved along candidate joints.

use nalgebra::{Matrix3, Point3, Rotation3, Unit, Vector3};
use rayon::prelude::*;

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
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidMotion {
    /// The rotation.
    pub rotation: Matrix3<f64>,
    /// The translation.
    pub translation: Vector3<f64>,
}

impl RigidMotion {
    /// The moved point.
    pub fn apply(&self, point: &Point3<f64>) -> Point3<f64> {
        Point3::from(self.rotation * point.coords + self.translation)
    }

    /// The motion back.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self { rotation, translation: -(rotation * self.translation) }
    }
}

impl JointAxis {
    /// The displacement by `angle` (radians, unused by prismatic joints) and `shift` (a length, unused by revolute ones).
    pub fn displacement(&self, angle: f64, shift: f64) -> RigidMotion {
        let angle = if self.kind == JointKind::Prismatic { 0.0 } else { angle };
        let shift = if self.kind == JointKind::Revolute { 0.0 } else { shift };
        let rotation = Rotation3::from_axis_angle(&self.direction, angle).into_inner();
        let pivot = if self.kind == JointKind::Prismatic { Vector3::zeros() } else { self.pivot.coords };
        RigidMotion { rotation, translation: pivot - rotation * pivot + self.direction.scale(shift) }
    }
}

/// Coordinates of four points: the unit in which they are moved, so that every lane of a vector register does the same.
const LANES: usize = 12;

/// The points, each coordinate repeated for the three coordinates of the result.
struct SpreadPoints {
    blocks: Vec<[[f32; LANES]; 3]>,
}

impl SpreadPoints {
    fn new(points: &[[f32; 3]]) -> Self {
        let spread = |four: &[[f32; 3]]| {
            std::array::from_fn(|axis| std::array::from_fn(|lane| four.get(lane / 3).map_or(0.0, |point| point[axis])))
        };
        Self { blocks: points.chunks(LANES / 3).map(spread).collect() }
    }

    fn moved_into(&self, motion: &RigidMotion, out: &mut [f32]) {
        let column = |axis: usize| -> [f32; LANES] { std::array::from_fn(|i| motion.rotation[(i % 3, axis)] as f32) };
        let (x, y, z) = (column(0), column(1), column(2));
        let shift: [f32; LANES] = std::array::from_fn(|i| motion.translation[i % 3] as f32);
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

/// Moves all `points` by every motion: `out` takes `motions.len() * points.len() * 3` coordinates, motion by motion.
pub fn move_points(points: &[[f32; 3]], motions: &[RigidMotion], out: &mut [f32]) {
    assert_eq!(out.len(), motions.len() * points.len() * 3, "size of out");
    if points.is_empty() {
        return;
    }
    let spread = SpreadPoints::new(points);
    out.par_chunks_mut(points.len() * 3).zip(motions).for_each(|(out, motion)| spread.moved_into(motion, out));
}
