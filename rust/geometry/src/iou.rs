//! Intersection of oriented boxes.

use nalgebra::{Matrix3, Point3, Vector3};

use rayon::prelude::*;

use crate::convex::ConvexPolyhedron;

/// A box: centre, unit axes as rows (right-handed or not), and half extents along them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientedBox {
    /// The centre.
    pub center: Point3<f64>,
    /// The axes, one a row.
    pub axes: Matrix3<f64>,
    /// Half of the extent along each axis.
    pub half: Vector3<f64>,
}

impl OrientedBox {
    /// The volume.
    pub fn volume(&self) -> f64 {
        8.0 * self.half.product()
    }

    fn axis(&self, axis: usize) -> Vector3<f64> {
        self.axes.row(axis).transpose()
    }

    /// Half edges in right-handed order.
    fn half_edges(&self) -> [Vector3<f64>; 3] {
        let edges = [0, 1, 2].map(|axis| self.axis(axis) * self.half[axis]);
        if edges[0].cross(&edges[1]).dot(&edges[2]) < 0.0 { [edges[1], edges[0], edges[2]] } else { edges }
    }
}

/// Exact volume of the intersection of two boxes: the first one cut by the six planes of the second.
pub fn intersection_volume(a: &OrientedBox, b: &OrientedBox) -> f64 {
    // Around the centre of `a`, so that boxes far from the origin lose no digits.
    let mut solid = ConvexPolyhedron::default();
    solid.set_box(&Point3::origin(), &a.half_edges(), 0);
    let center = b.center - a.center;
    for axis in 0..3 {
        let normal = b.axis(axis);
        let middle = normal.dot(&center);
        solid.cut(&normal, middle + b.half[axis], 0);
        solid.cut(&-normal, b.half[axis] - middle, 0);
        if solid.is_empty() {
            return 0.0;
        }
    }
    solid.volume().min(a.volume()).min(b.volume())
}

/// Intersection over union of two boxes; 0 if neither has volume.
pub fn box_iou(a: &OrientedBox, b: &OrientedBox) -> f64 {
    let shared = intersection_volume(a, b);
    let joint = a.volume() + b.volume() - shared;
    if joint > 0.0 { (shared / joint).clamp(0.0, 1.0) } else { 0.0 }
}

/// One `measure` of every pair of boxes.
pub fn for_pairs(a: &[OrientedBox], b: &[OrientedBox], measure: fn(&OrientedBox, &OrientedBox) -> f64) -> Vec<f64> {
    a.par_iter().zip(b).map(|(a, b)| measure(a, b)).collect()
}
