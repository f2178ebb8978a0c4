//! Points moved by rigid motions, in single precision.

use crate::motion::joint_axis::RigidMotion;

/// Coordinates of four points. They move as one block, so that all entries of a vector register do the same work.
const BLOCK: usize = 12;

/// Points arranged for repeated motion. Each coordinate is stored three times, once per coordinate of the result.
pub struct PointBlocks {
    blocks: Vec<[[f32; BLOCK]; 3]>,
}

impl PointBlocks {
    /// Arranges `points` in blocks.
    pub fn new(points: &[[f32; 3]]) -> Self {
        let spread = |four: &[[f32; 3]]| {
            std::array::from_fn(|axis| {
                std::array::from_fn(|entry| four.get(entry / 3).map_or(0.0, |point| point[axis]))
            })
        };
        Self { blocks: points.chunks(BLOCK / 3).map(spread).collect() }
    }

    /// Writes the moved points to `out`, three coordinates each. `out` has exactly three entries per point.
    pub fn moved_into(&self, motion: &RigidMotion, out: &mut [f32]) {
        let column = |axis: usize| -> [f32; BLOCK] { std::array::from_fn(|i| motion.rotation[(i % 3, axis)] as f32) };
        let (x, y, z) = (column(0), column(1), column(2));
        let shift: [f32; BLOCK] = std::array::from_fn(|i| motion.translation.vector[i % 3] as f32);
        let mut rows = out.chunks_exact_mut(BLOCK);
        for (row, points) in rows.by_ref().zip(&self.blocks) {
            for i in 0..BLOCK {
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
    use nalgebra::Point3;
    use proptest::prelude::*;

    use super::*;
    use crate::test_shapes::isometry;

    proptest! {
        #[test]
        fn blocks_of_points_move_like_single_points(
            motion in isometry(), points in prop::collection::vec(prop::array::uniform3(-1.0..1.0f32), 0..19),
        ) {
            let mut out = vec![f32::NAN; 3 * points.len()];
            PointBlocks::new(&points).moved_into(&motion, &mut out);
            for (moved, point) in out.chunks_exact(3).zip(&points) {
                let expected = motion * Point3::from(point.map(f64::from));
                prop_assert!((0..3).all(|i| (f64::from(moved[i]) - expected[i]).abs() < 2e-6));
            }
        }
    }
}
