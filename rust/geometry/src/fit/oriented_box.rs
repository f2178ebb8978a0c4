//! Oriented boxes.

use nalgebra::{Point3, Vector3};

/// A box of any orientation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientedBox {
    /// Center.
    pub center: Point3<f64>,
    /// Orthonormal axes. Boxes made by kinmo are right-handed.
    pub axes: [Vector3<f64>; 3],
    /// Half of the extent along each axis.
    pub half_extents: Vector3<f64>,
}

impl OrientedBox {
    /// Volume.
    pub fn volume(&self) -> f64 {
        8.0 * self.half_extents.product()
    }

    /// Half edges as a right-handed triple.
    pub fn half_edges(&self) -> [Vector3<f64>; 3] {
        let [x, y, z] = [0, 1, 2].map(|axis| self.axes[axis] * self.half_extents[axis]);
        if self.axes[0].cross(&self.axes[1]).dot(&self.axes[2]) < 0.0 { [y, x, z] } else { [x, y, z] }
    }
}
