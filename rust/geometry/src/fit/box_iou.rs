//! Intersection of oriented boxes.

use nalgebra::Point3;

use crate::fit::oriented_box::OrientedBox;
use crate::fit::polyhedron_clipping::ConvexPolyhedron;

/// Exact volume of the intersection of two boxes: the first box clipped by the six planes of the second.
pub fn intersection_volume(a: &OrientedBox, b: &OrientedBox) -> f64 {
    // Coordinates relative to the center of `a` keep all digits for boxes far from the origin.
    let mut solid = ConvexPolyhedron::new_box(&Point3::origin(), &a.half_edges());
    let center = b.center - a.center;
    for (normal, half_extent) in b.axes.iter().zip(b.half_extents.iter()) {
        let middle = normal.dot(&center);
        solid.cut(normal, middle + half_extent);
        solid.cut(&-normal, half_extent - middle);
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

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Rotation3, Vector3};
    use proptest::prelude::*;

    use super::*;
    use crate::test_shapes::isometry;

    fn boxes() -> impl Strategy<Value = OrientedBox> {
        let vector = |range: std::ops::Range<f64>| prop::array::uniform3(range).prop_map(Vector3::from);
        (vector(-0.5..0.5), vector(-3.0..3.0), vector(0.05..1.0), any::<bool>()).prop_map(
            |(center, turn, half_extents, mirrored)| {
                let turn = Rotation3::new(turn).into_inner();
                let sign = if mirrored { -1.0 } else { 1.0 };
                let axes = [0, 1, 2].map(|axis| turn.column(axis) * if axis == 2 { sign } else { 1.0 });
                OrientedBox { center: center.into(), axes, half_extents }
            },
        )
    }

    proptest! {
        #[test]
        fn a_box_is_its_own_intersection(a in boxes()) {
            prop_assert!((box_iou(&a, &a) - 1.0).abs() < 1e-12);
            let [x, y, z] = a.axes;
            let renamed = OrientedBox { axes: [-z, x, y], half_extents: a.half_extents.zxy(), ..a };
            prop_assert!((box_iou(&a, &renamed) - 1.0).abs() < 1e-12);
        }

        #[test]
        fn the_iou_is_symmetric_and_invariant_under_motion_and_scale(a in boxes(), b in boxes(), motion in isometry(), exponent in -30i32..30) {
            let expected = box_iou(&a, &b);
            prop_assert!((0.0..=1.0).contains(&expected));
            prop_assert!((box_iou(&b, &a) - expected).abs() < 1e-12);
            let scale = 2f64.powi(exponent);
            let moved = |b: &OrientedBox| OrientedBox {
                center: (motion * b.center) * scale,
                axes: b.axes.map(|axis| motion.rotation * axis),
                half_extents: b.half_extents * scale,
            };
            prop_assert!((box_iou(&moved(&a), &moved(&b)) - expected).abs() < 1e-11);
        }

        #[test]
        fn separated_boxes_do_not_intersect(a in boxes(), b in boxes()) {
            let reach = a.half_extents.norm() + b.half_extents.norm();
            let apart = OrientedBox { center: a.center + Vector3::new(0.6, 0.0, 0.8) * (reach + 1e-9), ..b };
            prop_assert_eq!(intersection_volume(&a, &apart), 0.0);
        }

        #[test]
        fn the_volume_agrees_with_a_count_of_points(a in boxes(), b in boxes()) {
            // A rank-1 lattice replaces random points.
            const COUNT: usize = 4096;
            let frame = |b: &OrientedBox| Matrix3::from_columns(&b.axes);
            let inside = (0..COUNT).filter(|&i| {
                let place = [0.5, 1487.0, 2903.0].map(|step: f64| 2.0 * (step * (i as f64 + 0.5) / COUNT as f64).fract() - 1.0);
                let place = Vector3::new(2.0 * (i as f64 + 0.5) / COUNT as f64 - 1.0, place[1], place[2]);
                let point = a.center + frame(&a) * place.component_mul(&a.half_extents);
                let local = frame(&b).transpose() * (point - b.center);
                (0..3).all(|axis| local[axis].abs() <= b.half_extents[axis])
            });
            let expected = inside.count() as f64 / COUNT as f64;
            prop_assert!((intersection_volume(&a, &b) / a.volume() - expected).abs() < 0.04);
        }
    }
}
