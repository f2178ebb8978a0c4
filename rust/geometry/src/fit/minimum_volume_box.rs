//! Oriented bounding boxes.

use nalgebra::{Point3, Vector3};

use crate::fit::box_search::BoxSearch;
use crate::fit::convex_hull::Hull;
use crate::fit::minimum_area_rectangle::minimum_area_axes;
use crate::fit::oriented_box::OrientedBox;

/// Largest relative thickness of flat parts, as a share of their extent.
const FLATNESS: f64 = 1e-9;

/// Box of minimum volume around `points`.
///
/// The search tries the directions of all facets and edges of the convex hull, with the best rectangle across each. It
/// then rotates the best boxes about their axes until none shrinks. The rotations reach boxes that touch the hull with
/// edges only.
///
/// Axes are ordered by descending extent. The first two point towards positive coordinates, and the third completes a
/// right-handed frame. Among boxes of equal volume, the one most aligned with the coordinate axes wins. Flat and
/// line-like parts have extents of about zero in the missing directions, and the least area or length in the others.
pub fn minimum_volume_box(points: &[Point3<f64>]) -> OrientedBox {
    BoxFitter::new(points).minimum_volume()
}

/// Smallest box with sides along three orthonormal `axes`, in their order.
pub fn aligned_box(points: &[Point3<f64>], axes: [Vector3<f64>; 3]) -> OrientedBox {
    UnitFrame::around(points).box_along(axes)
}

/// Points and their convex hull, for fitting boxes.
pub(crate) struct BoxFitter {
    frame: UnitFrame,
    hull: Hull,
}

impl BoxFitter {
    pub fn new(points: &[Point3<f64>]) -> Self {
        let frame = UnitFrame::around(points);
        let hull = Hull::of(&frame.points, FLATNESS);
        Self { frame, hull }
    }

    /// Box of minimum volume, as by [`minimum_volume_box`].
    pub fn minimum_volume(&self) -> OrientedBox {
        self.frame.ordered_box(match &self.hull {
            Hull::Solid(hull) => BoxSearch::new(hull).minimum_volume(),
            Hull::Planar(normal) => minimum_area_axes(&self.frame.points, *normal),
            Hull::Segment(direction) => minimum_area_axes(&[], *direction),
            Hull::Point => [Vector3::x(), Vector3::y(), Vector3::z()],
        })
    }

    /// Best boxes along the normals of at most `limit` distinct facets of a solid, by ascending volume.
    pub fn facet_boxes(&self, limit: usize) -> Vec<OrientedBox> {
        let Hull::Solid(hull) = &self.hull else { return Vec::new() };
        let boxes = BoxSearch::new(hull).facet_boxes(limit);
        boxes.into_iter().map(|candidate| self.frame.ordered_box(candidate.axes)).collect()
    }
}

/// Points shifted and scaled to the order of one, so that absolute tolerances apply. The scale is an exact power of
/// two.
struct UnitFrame {
    points: Vec<Point3<f64>>,
    origin: Point3<f64>,
    scale: f64,
}

impl UnitFrame {
    fn around(points: &[Point3<f64>]) -> Self {
        let first = points.first().copied().unwrap_or_else(Point3::origin);
        let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
        let origin = low + (high - low) / 2.0;
        let size = (high - low).max();
        let scale = if size > 0.0 { size.log2().ceil().exp2() } else { 1.0 };
        let points = points.iter().map(|p| Point3::from((p - origin) / scale)).collect();
        Self { points, origin, scale }
    }

    /// Box along `axes`, in the coordinates of the input points.
    fn box_along(&self, axes: [Vector3<f64>; 3]) -> OrientedBox {
        let (low, high) = bounds_along(&self.points, &axes);
        let middle = (low + high) / 2.0;
        let center = axes[0] * middle.x + axes[1] * middle.y + axes[2] * middle.z;
        OrientedBox { center: self.origin + center * self.scale, axes, half_extents: (high - low) / 2.0 * self.scale }
    }

    /// Box along `axes`, which are ordered by descending extent and given definite signs.
    fn ordered_box(&self, axes: [Vector3<f64>; 3]) -> OrientedBox {
        let OrientedBox { center, half_extents, .. } = self.box_along(axes);
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| half_extents[j].total_cmp(&half_extents[i]));
        let [x, y] = [axes[order[0]], axes[order[1]]].map(towards_positive);
        OrientedBox { center, axes: [x, y, x.cross(&y)], half_extents: order.map(|i| half_extents[i]).into() }
    }
}

/// Smallest and largest coordinates of the points along each of `axes`.
fn bounds_along(points: &[Point3<f64>], axes: &[Vector3<f64>; 3]) -> (Vector3<f64>, Vector3<f64>) {
    let start = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    points.iter().fold(start, |(low, high), p| {
        let along = Vector3::new(axes[0].dot(&p.coords), axes[1].dot(&p.coords), axes[2].dot(&p.coords));
        (low.inf(&along), high.sup(&along))
    })
}

/// `axis` or its opposite, so that the largest component is positive. For near ties, the first component decides.
fn towards_positive(axis: Vector3<f64>) -> Vector3<f64> {
    let largest = axis.abs().max() - 1e-6;
    let positive = axis.iter().find(|x| x.abs() >= largest).is_none_or(|x| *x > 0.0);
    if positive { axis } else { -axis }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Points of a small grid, flattened and placed: of any dimension, repeated, huge, tiny or far away.
        #[test]
        fn boxes_contain_all_points_and_every_side_touches_one(
            grid in prop::collection::vec(prop::array::uniform3(-2i32..3), 1..40),
            squeeze in prop::array::uniform3(prop::sample::select(vec![0.0, 1e-7, 1.0])),
            exponent in -20i32..20,
            far in any::<bool>(),
        ) {
            let scale = 10f64.powi(exponent);
            let shift = if far { 1e5 * scale } else { 0.0 };
            let points: Vec<_> = grid
                .iter()
                .map(|g| Point3::from([0, 1, 2].map(|i| (g[i] as f64 * squeeze[i] + 0.3 * g[(i + 1) % 3] as f64) * scale + shift)))
                .collect();
            let margin = 1e-12 * scale + 1e-14 * shift;
            for found in [minimum_volume_box(&points), aligned_box(&points, [Vector3::x(), Vector3::y(), Vector3::z()])] {
                prop_assert!((found.axes[0].cross(&found.axes[1]) - found.axes[2]).norm() < 1e-12);
                for (axis, half) in found.axes.iter().zip(found.half_extents.iter()) {
                    let along: Vec<f64> = points.iter().map(|p| axis.dot(&(p - found.center))).collect();
                    let (low, high) = along.iter().fold((f64::MAX, f64::MIN), |(low, high), &x| (low.min(x), high.max(x)));
                    prop_assert!((high - half).abs() <= margin && (low + half).abs() <= margin, "{low} {high} {half}");
                }
            }
        }
    }
}
