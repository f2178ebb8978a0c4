//! Amodal boxes of parts, adjusted to a scan.

use nalgebra::{Point3, Vector3};

use crate::fit::oriented_box::OrientedBox;
use crate::points::distinct_points::distinct_points;
use crate::points::kd_tree::KdTree;

/// Smallest number of points with which a part's box is adjusted.
const MIN_POINTS: usize = 10;
/// Reach of a scan point, in typical distances between neighbouring points.
const REACH: f64 = 3.0;
/// Number of test points along each side of a face.
const TEST_POINTS: usize = 5;
/// Sine of the smallest angle between a surface and a ray at which missing points count as free space.
///
/// Depth cameras lose surfaces at grazing angles, and the outline of a part is seldom that of its box.
const MIN_SINE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// A scan as its camera sees it: directions and distances of all points.
pub struct ScanView {
    camera: Point3<f64>,
    /// Unit vectors and distances of all points from the camera.
    rays: Vec<(Vector3<f64>, f64)>,
    /// Largest gap between a ray and a point on it, and smallest depth difference of an occluder.
    reach: f64,
}

impl ScanView {
    /// View of a scan from `camera`. Duplicate points count once.
    pub fn new(points: &[Point3<f64>], camera: Point3<f64>) -> Self {
        let (points, _) = distinct_points(points);
        let rays = points.iter().map(|point| {
            let ray = point - camera;
            let distance = ray.norm();
            (ray / distance.max(f64::MIN_POSITIVE), distance)
        });
        Self { camera, rays: rays.collect(), reach: REACH * spacing(&points) }
    }

    /// True if `place` is free space: the camera sees nothing in its direction, or only points behind it.
    fn is_free(&self, place: &Point3<f64>) -> bool {
        let ray = place - self.camera;
        let distance = ray.norm();
        let ahead = self.rays.iter().map(|(direction, far)| (direction.dot(&ray), direction, far));
        let Some((along, direction, far)) = ahead.max_by(|a, b| a.0.total_cmp(&b.0)) else { return true };
        let aside = (ray - direction * along).norm();
        along <= 0.0 || aside > self.reach || *far > distance + self.reach
    }
}

/// Median distance from a point to its nearest neighbour; 0 for fewer than two points.
fn spacing(points: &[Point3<f64>]) -> f64 {
    if points.len() < 2 {
        return 0.0;
    }
    let tree = KdTree::new(points);
    let mut near = Vec::new();
    let mut gaps: Vec<f64> = points
        .iter()
        .map(|point| {
            tree.nearest(point, 2, &mut near);
            near.iter().map(|neighbour| neighbour.squared).fold(0.0, f64::max)
        })
        .collect();
    let middle = gaps.len() / 2;
    gaps.select_nth_unstable_by(middle, f64::total_cmp).1.sqrt()
}

/// Adjusts the sides of a predicted box to the scan in `view`, given the points `own` of the part. Axes are kept.
///
/// * A side moves out to the outermost point, so that no point is outside.
/// * A side farther out than all points moves in to the outermost point, if most of the surface in between should be
///   visible and is not.
/// * A side that is occluded, seen at a grazing angle, or too close to tell stays as predicted.
///
/// A part with fewer than 10 points keeps its predicted box.
pub fn adjust_amodal_box(view: &ScanView, own: &[Point3<f64>], predicted: &OrientedBox) -> OrientedBox {
    if own.len() < MIN_POINTS {
        return *predicted;
    }
    let frame = BoxFrame { view, predicted, camera: along(predicted, &view.camera) };
    let none = [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)];
    let observed =
        own.iter().map(|point| along(predicted, point)).fold(none, |[low, high], at| [low.inf(&at), high.sup(&at)]);
    let mut ends = [-predicted.half_extents, predicted.half_extents];
    for axis in 0..3 {
        for (side, outward) in [(0, -1.0), (1, 1.0)] {
            let (predicted_at, observed_at) = (ends[side][axis], observed[side][axis]);
            let is_outermost = outward * (observed_at - predicted_at) >= 0.0;
            if is_outermost || frame.is_free(&SideGap::of(observed, axis, side, predicted_at)) {
                ends[side][axis] = observed_at;
            }
        }
    }
    let middle = (ends[0] + ends[1]) * 0.5;
    OrientedBox { center: frame.place(&middle), axes: predicted.axes, half_extents: (ends[1] - ends[0]) * 0.5 }
}

/// Coordinates of a point relative to the center of a box, along its axes.
fn along(predicted: &OrientedBox, point: &Point3<f64>) -> Vector3<f64> {
    let from_center = point - predicted.center;
    Vector3::from(predicted.axes.map(|axis| axis.dot(&from_center)))
}

/// A predicted box and the camera, in coordinates along the box's axes.
struct BoxFrame<'a> {
    view: &'a ScanView,
    predicted: &'a OrientedBox,
    camera: Vector3<f64>,
}

impl BoxFrame<'_> {
    fn place(&self, coordinates: &Vector3<f64>) -> Point3<f64> {
        let axes = self.predicted.axes.iter().zip(coordinates.iter());
        self.predicted.center + axes.map(|(axis, along)| axis * *along).sum::<Vector3<f64>>()
    }

    /// True if most of the surface that faces the camera should be visible, and is not.
    fn is_free(&self, gap: &SideGap) -> bool {
        let (mut places, mut free) = (0, 0);
        for (axis, side) in gap.faces(&self.camera) {
            let mut place = Vector3::zeros();
            place[axis] = gap.ends[side][axis];
            let others = [(axis + 1) % 3, (axis + 2) % 3];
            for index in 0..TEST_POINTS * TEST_POINTS {
                for (other, step) in others.into_iter().zip([index % TEST_POINTS, index / TEST_POINTS]) {
                    let share = (step as f64 + 0.5) / TEST_POINTS as f64;
                    place[other] = gap.ends[0][other] * (1.0 - share) + gap.ends[1][other] * share;
                }
                let ray = self.camera - place;
                if ray[axis].abs() < MIN_SINE * ray.norm() {
                    continue;
                }
                places += 1;
                free += usize::from(self.view.is_free(&self.place(&place)));
            }
        }
        2 * free > places
    }
}

/// Region between the outermost point on one side and the predicted position of that side.
struct SideGap {
    /// Lower and upper corner.
    ends: [Vector3<f64>; 2],
    axis: usize,
    side: usize,
}

impl SideGap {
    fn of(observed: [Vector3<f64>; 2], axis: usize, side: usize, predicted_at: f64) -> Self {
        let mut ends = observed;
        ends[1 - side][axis] = observed[side][axis];
        ends[side][axis] = predicted_at;
        Self { ends, axis, side }
    }

    /// Axes and sides of the faces towards the camera, without the face towards the points.
    fn faces(&self, camera: &Vector3<f64>) -> impl Iterator<Item = (usize, usize)> {
        (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]).filter(move |&(axis, side)| {
            let off = camera[axis] - self.ends[side][axis];
            let is_inner = axis == self.axis && side != self.side;
            !is_inner && if side == 0 { off < 0.0 } else { off > 0.0 }
        })
    }
}

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use nalgebra::Rotation3;
    use proptest::prelude::*;

    use super::*;

    const SHOWN: usize = 40;

    /// Points on the sides of a box that face a camera at the origin.
    fn scan(solid: &OrientedBox) -> Vec<Point3<f64>> {
        let camera = along(solid, &Point3::origin());
        let frame = BoxFrame { view: &ScanView::new(&[], Point3::origin()), predicted: solid, camera };
        let mut points = Vec::new();
        for axis in 0..3 {
            if camera[axis].abs() <= solid.half_extents[axis] {
                continue;
            }
            for index in 0..SHOWN * SHOWN {
                let mut place = solid.half_extents;
                place[axis] *= camera[axis].signum();
                place[(axis + 1) % 3] *= 2.0 * (index % SHOWN) as f64 / (SHOWN - 1) as f64 - 1.0;
                place[(axis + 2) % 3] *= 2.0 * (index / SHOWN) as f64 / (SHOWN - 1) as f64 - 1.0;
                points.push(frame.place(&place));
            }
        }
        points
    }

    /// A box in front of the camera, seen from a corner.
    fn solid() -> impl Strategy<Value = OrientedBox> {
        rotated_box(0.4..0.8, 0.4..0.7)
    }

    /// A box in front of the camera, rotated by the given ranges.
    fn rotated_box(turn: Range<f64>, tilt: Range<f64>) -> impl Strategy<Value = OrientedBox> {
        (0.1..0.3, 0.1..0.3, 0.1..0.3, turn, tilt).prop_map(|(x, y, z, turn, tilt)| {
            let rotation = Rotation3::from_axis_angle(&Vector3::x_axis(), tilt)
                * Rotation3::from_axis_angle(&Vector3::y_axis(), turn);
            let axes = [0, 1, 2].map(|axis| rotation.matrix().column(axis).into());
            OrientedBox { center: Point3::new(0.0, 0.0, 3.0), axes, half_extents: Vector3::new(x, y, z) }
        })
    }

    fn grown(solid: &OrientedBox, low: [f64; 3], high: [f64; 3]) -> OrientedBox {
        let [low, high] = [-solid.half_extents - Vector3::from(low), solid.half_extents + Vector3::from(high)];
        let frame =
            BoxFrame { view: &ScanView::new(&[], Point3::origin()), predicted: solid, camera: Vector3::zeros() };
        OrientedBox { center: frame.place(&((low + high) * 0.5)), axes: solid.axes, half_extents: (high - low) * 0.5 }
    }

    fn apart(a: &OrientedBox, b: &OrientedBox) -> f64 {
        (a.center - b.center).amax().max((a.half_extents - b.half_extents).amax())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn sides_beyond_visible_free_space_move_in(
            solid in rotated_box(0.15..0.3, 0.15..0.3), low in prop::array::uniform3(0.4..0.6), high in prop::array::uniform3(0.4..0.6)
        ) {
            let points = scan(&solid);
            let view = ScanView::new(&points, Point3::origin());
            let expected = grown(&solid, [0.0; 3], [0.0, 0.0, high[2]]);
            prop_assert!(apart(&adjust_amodal_box(&view, &points, &grown(&solid, low, high)), &expected) < 1e-9);
        }

        #[test]
        fn sides_inside_the_points_move_out(
            solid in solid(), low in prop::array::uniform3(-0.05..0.0), high in prop::array::uniform3(-0.05..0.0)
        ) {
            let points = scan(&solid);
            let view = ScanView::new(&points, Point3::origin());
            prop_assert!(apart(&adjust_amodal_box(&view, &points, &grown(&solid, low, high)), &solid) < 1e-9);
        }

        #[test]
        fn occluded_sides_stay_as_predicted(solid in solid(), gap in 0.1..0.4) {
            // An object close to the camera occludes one half of the box, and the space in front of it.
            let is_hidden = |point: &Point3<f64>| along(&solid, point).x <= 0.0;
            let (hidden, shown): (Vec<_>, Vec<_>) = scan(&solid).into_iter().partition(is_hidden);
            let before = scan(&grown(&solid, [gap, 0.0, 0.0], [0.0; 3])).into_iter().filter(is_hidden);
            let points: Vec<_> = hidden.into_iter().chain(before).map(|point| point * 0.5).chain(shown.clone()).collect();
            let found = adjust_amodal_box(&ScanView::new(&points, Point3::origin()), &shown, &solid);
            prop_assert!(apart(&found, &solid) < 1e-9);
        }
    }

    /// An axis-aligned box.
    fn axis_aligned_box(center: [f64; 3], half_extents: [f64; 3]) -> OrientedBox {
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        OrientedBox { center: center.into(), axes, half_extents: half_extents.into() }
    }

    #[test]
    fn a_side_at_a_grazing_angle_stays_and_a_steep_one_moves_in() {
        // No points on the top: in one case the camera is slightly above it, in the other far above.
        for (height, depth) in [(1.5, 0.5), (4.0, 0.0)] {
            let predicted = axis_aligned_box([0.0, -height - 0.2, 3.0], [0.2, 0.2, 0.5]);
            let points: Vec<_> = scan(&predicted).into_iter().filter(|point| point.z < 2.5 + 1e-9).collect();
            let found = adjust_amodal_box(&ScanView::new(&points, Point3::origin()), &points, &predicted);
            assert!((found.half_extents - Vector3::new(0.2, 0.2, depth)).amax() < 1e-9, "{height}: {found:?}");
        }
    }

    #[test]
    fn a_part_with_few_points_keeps_its_box() {
        let predicted = axis_aligned_box([0.0, 0.0, 3.0], [0.5; 3]);
        let points = [Point3::new(0.0, 0.0, 9.0); MIN_POINTS - 1];
        assert_eq!(adjust_amodal_box(&ScanView::new(&points, Point3::origin()), &points, &predicted), predicted);
    }
}
