//! Boxes of parts, brought into line with what a scan shows of them.

use nalgebra::{Point3, Vector3};

use crate::normals::distinct;
use crate::oriented_box::OrientedBox;
use crate::point_tree::PointTree;

/// A part with fewer points says nothing of its box.
const LEAST_POINTS: usize = 10;
/// Directions that are so many times as far apart as points usually are, are different ones.
const REACH: f64 = 3.0;
/// Places along each side of a face that are looked at.
const PLACES: usize = 5;
/// Sine of the angle between a surface and a ray below which it tells nothing that no surface is seen there: depth cameras see
/// little of what they see flatly, and the outline of a part is seldom that of its box.
const FLATTEST: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// A scan as its camera sees it: what lies in which direction.
pub struct View {
    camera: Point3<f64>,
    /// Unit vectors and distances of all points from the camera.
    rays: Vec<(Vector3<f64>, f64)>,
    /// How near two directions are to be one, where they are looked at, and how much nearer what hides is than what it hides.
    reach: f64,
}

impl View {
    /// What `camera` sees; a point that is there several times is one.
    pub fn new(points: &[Point3<f64>], camera: Point3<f64>) -> Self {
        let (points, _) = distinct(points);
        let rays = points.iter().map(|point| {
            let ray = point - camera;
            let distance = ray.norm();
            (ray / distance.max(f64::MIN_POSITIVE), distance)
        });
        Self { camera, rays: rays.collect(), reach: REACH * spacing(&points) }
    }

    /// Whether nothing is seen in the direction of `place`, or only what is behind it; not if it may be `place` that is seen.
    fn is_seen_through(&self, place: &Point3<f64>) -> bool {
        let ray = place - self.camera;
        let distance = ray.norm();
        let ahead = self.rays.iter().map(|(direction, far)| (direction.dot(&ray), direction, far));
        let Some((along, direction, far)) = ahead.max_by(|a, b| a.0.total_cmp(&b.0)) else { return true };
        let aside = (ray - direction * along).norm();
        along <= 0.0 || aside > self.reach || *far > distance + self.reach
    }
}

/// The usual distance from a point to the one nearest to it; none where there are no two.
fn spacing(points: &[Point3<f64>]) -> f64 {
    if points.len() < 2 {
        return 0.0;
    }
    let tree = PointTree::new(points);
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

/// The box `said`, its sides moved to where `view` shows them, given the points `own` that are the part's.
///
/// No point is outside: a side goes out to the outermost. Where a side is said to be farther out than all points, what lies
/// between is looked at from the camera. If most of its surface would be seen there and is not, the side goes in to the
/// outermost point; what is hidden, seen too flatly, or too thin to tell, stays as it is said. Axes stay as they are.
pub fn seen_box(view: &View, own: &[Point3<f64>], said: &OrientedBox) -> OrientedBox {
    if own.len() < LEAST_POINTS {
        return *said;
    }
    let frame = Frame { view, said, camera: along(said, &view.camera) };
    let none = [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)];
    let seen = own.iter().map(|point| along(said, point)).fold(none, |[low, high], at| [low.inf(&at), high.sup(&at)]);
    let mut ends = [-said.half_extents, said.half_extents];
    for axis in 0..3 {
        for (side, outward) in [(0, -1.0), (1, 1.0)] {
            let (said_at, seen_at) = (ends[side][axis], seen[side][axis]);
            let is_outermost = outward * (seen_at - said_at) >= 0.0;
            if is_outermost || frame.is_seen_through(&Beyond::of(seen, axis, side, said_at)) {
                ends[side][axis] = seen_at;
            }
        }
    }
    let middle = (ends[0] + ends[1]) * 0.5;
    OrientedBox { center: frame.place(&middle), axes: said.axes, half_extents: (ends[1] - ends[0]) * 0.5 }
}

/// Coordinates of a point from the middle of a box, along its axes.
fn along(said: &OrientedBox, point: &Point3<f64>) -> Vector3<f64> {
    let from_center = point - said.center;
    Vector3::from(said.axes.map(|axis| axis.dot(&from_center)))
}

/// A box and who looks at it, in coordinates along its axes.
struct Frame<'a> {
    view: &'a View,
    said: &'a OrientedBox,
    camera: Vector3<f64>,
}

impl Frame<'_> {
    fn place(&self, coordinates: &Vector3<f64>) -> Point3<f64> {
        let axes = self.said.axes.iter().zip(coordinates.iter());
        self.said.center + axes.map(|(axis, along)| axis * *along).sum::<Vector3<f64>>()
    }

    /// Whether most of the surface that is turned to the camera would be seen, and is not.
    fn is_seen_through(&self, beyond: &Beyond) -> bool {
        let (mut places, mut seen_through) = (0, 0);
        for (axis, side) in beyond.faces(&self.camera) {
            let mut place = Vector3::zeros();
            place[axis] = beyond.ends[side][axis];
            let others = [(axis + 1) % 3, (axis + 2) % 3];
            for index in 0..PLACES * PLACES {
                for (other, step) in others.into_iter().zip([index % PLACES, index / PLACES]) {
                    let share = (step as f64 + 0.5) / PLACES as f64;
                    place[other] = beyond.ends[0][other] * (1.0 - share) + beyond.ends[1][other] * share;
                }
                let ray = self.camera - place;
                if ray[axis].abs() < FLATTEST * ray.norm() {
                    continue;
                }
                places += 1;
                seen_through += usize::from(self.view.is_seen_through(&self.place(&place)));
            }
        }
        2 * seen_through > places
    }
}

/// What lies between the outermost points on one side and where that side is said to be.
struct Beyond {
    /// The lower and the upper.
    ends: [Vector3<f64>; 2],
    axis: usize,
    side: usize,
}

impl Beyond {
    fn of(seen: [Vector3<f64>; 2], axis: usize, side: usize, said_at: f64) -> Self {
        let mut ends = seen;
        ends[1 - side][axis] = seen[side][axis];
        ends[side][axis] = said_at;
        Self { ends, axis, side }
    }

    /// Axes and sides of the faces that are turned to the camera, without the one towards the points.
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

    /// Points on the sides of a box that are turned to a camera at the origin.
    fn scan(solid: &OrientedBox) -> Vec<Point3<f64>> {
        let camera = along(solid, &Point3::origin());
        let frame = Frame { view: &View::new(&[], Point3::origin()), said: solid, camera };
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

    /// A box before the camera, seen from a corner.
    fn solid() -> impl Strategy<Value = OrientedBox> {
        turned(0.4..0.8, 0.4..0.7)
    }

    /// A box before the camera, by how far it is turned away.
    fn turned(turn: Range<f64>, tilt: Range<f64>) -> impl Strategy<Value = OrientedBox> {
        (0.1..0.3, 0.1..0.3, 0.1..0.3, turn, tilt).prop_map(|(x, y, z, turn, tilt)| {
            let rotation = Rotation3::from_axis_angle(&Vector3::x_axis(), tilt)
                * Rotation3::from_axis_angle(&Vector3::y_axis(), turn);
            let axes = [0, 1, 2].map(|axis| rotation.matrix().column(axis).into());
            OrientedBox { center: Point3::new(0.0, 0.0, 3.0), axes, half_extents: Vector3::new(x, y, z) }
        })
    }

    fn grown(solid: &OrientedBox, low: [f64; 3], high: [f64; 3]) -> OrientedBox {
        let [low, high] = [-solid.half_extents - Vector3::from(low), solid.half_extents + Vector3::from(high)];
        let frame = Frame { view: &View::new(&[], Point3::origin()), said: solid, camera: Vector3::zeros() };
        OrientedBox { center: frame.place(&((low + high) * 0.5)), axes: solid.axes, half_extents: (high - low) * 0.5 }
    }

    fn apart(a: &OrientedBox, b: &OrientedBox) -> f64 {
        (a.center - b.center).amax().max((a.half_extents - b.half_extents).amax())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn sides_that_are_said_too_far_out_go_in_where_what_lies_between_would_be_seen_squarely(
            solid in turned(0.15..0.3, 0.15..0.3), low in prop::array::uniform3(0.4..0.6), high in prop::array::uniform3(0.4..0.6)
        ) {
            let points = scan(&solid);
            let view = View::new(&points, Point3::origin());
            let expected = grown(&solid, [0.0; 3], [0.0, 0.0, high[2]]);
            prop_assert!(apart(&seen_box(&view, &points, &grown(&solid, low, high)), &expected) < 1e-9);
        }

        #[test]
        fn sides_that_are_said_too_far_in_go_out_to_the_points(
            solid in solid(), low in prop::array::uniform3(-0.05..0.0), high in prop::array::uniform3(-0.05..0.0)
        ) {
            let points = scan(&solid);
            let view = View::new(&points, Point3::origin());
            prop_assert!(apart(&seen_box(&view, &points, &grown(&solid, low, high)), &solid) < 1e-9);
        }

        #[test]
        fn what_is_hidden_stays_as_it_is_said(solid in solid(), beyond in 0.1..0.4) {
            // something close to the camera hides one half of the box, and what is before that
            let is_hidden = |point: &Point3<f64>| along(&solid, point).x <= 0.0;
            let (hidden, shown): (Vec<_>, Vec<_>) = scan(&solid).into_iter().partition(is_hidden);
            let before = scan(&grown(&solid, [beyond, 0.0, 0.0], [0.0; 3])).into_iter().filter(is_hidden);
            let points: Vec<_> = hidden.into_iter().chain(before).map(|point| point * 0.5).chain(shown.clone()).collect();
            let found = seen_box(&View::new(&points, Point3::origin()), &shown, &solid);
            prop_assert!(apart(&found, &solid) < 1e-9);
        }
    }

    /// A box along the axes.
    fn straight(center: [f64; 3], half_extents: [f64; 3]) -> OrientedBox {
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        OrientedBox { center: center.into(), axes, half_extents: half_extents.into() }
    }

    #[test]
    fn a_side_that_is_seen_too_flatly_stays_and_one_that_is_not_goes_in() {
        // Nothing came back from the top: once the camera is a little above it, once far.
        for (height, depth) in [(1.5, 0.5), (4.0, 0.0)] {
            let said = straight([0.0, -height - 0.2, 3.0], [0.2, 0.2, 0.5]);
            let points: Vec<_> = scan(&said).into_iter().filter(|point| point.z < 2.5 + 1e-9).collect();
            let found = seen_box(&View::new(&points, Point3::origin()), &points, &said);
            assert!((found.half_extents - Vector3::new(0.2, 0.2, depth)).amax() < 1e-9, "{height}: {found:?}");
        }
    }

    #[test]
    fn few_points_say_nothing() {
        let said = straight([0.0, 0.0, 3.0], [0.5; 3]);
        let points = [Point3::new(0.0, 0.0, 9.0); LEAST_POINTS - 1];
        assert_eq!(seen_box(&View::new(&points, Point3::origin()), &points, &said), said);
    }
}
