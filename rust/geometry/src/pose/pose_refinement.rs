//! Refinement of part poses with knowledge about the object: joint ranges and axis-aligned parts.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point3, Rotation3, Unit, UnitQuaternion, Vector3};

use crate::motion::joint_axis::JointKind;
use crate::pose::articulated_pose::JointConstraint;
use crate::pose::axis_alignment::AxisAlignment;
use crate::pose::similarity::{PointPair, Similarity, is_inlier};

/// Step between angles that are tried, in radians.
const ANGLE_STEP: f64 = 0.05;
/// Tolerance of a joint range, in radians.
const MARGIN: f64 = 0.1;
/// Largest growth of the cost when a rotation is aligned with normals. Point predictions without errors are better than
/// normals.
const MAX_RISE: f64 = 1.5;
/// Largest growth of the cost for the best aligned rotation of a root part.
///
/// Point predictions may be ambiguous between two sides, and then yield a rotation halfway between them. An aligned
/// rotation is better even at a higher cost.
const MAX_ROOT_RISE: f64 = 2.0;
/// Tolerance for rounding errors of angles, in radians.
const ROUNDING: f64 = 1e-9;
/// Number of refits of a translation to its inliers.
const FITS: usize = 2;

/// Refined poses of all parts, starting from `poses`. Scales are kept, and so are poses of parts without pairs.
///
/// The cost of a pose is the sum of its residuals, each capped at `threshold`. The rules, from the root parts outwards:
/// * A root part (not the second part of any joint) that is axis-aligned gets the aligned rotation of least cost. If
///   that costs too much, its rotation is only corrected slightly.
/// * The second part of a prismatic joint gets the rotation of the first.
/// * The second part of a revolute or screw joint with a range gets the best angle within it. Three alternatives win
///   only if their cost is clearly lower: an angle outside the range, an angle about the opposite direction, and the
///   rotation of `poses`. An axis-aligned part is then aligned about the joint's direction, within the range.
/// * The second part of a revolute or screw joint without a range follows the rotation of the first.
///
/// `ranges` has one entry per joint, in radians (`None`: unknown). `axis_aligned` has one flag per part.
pub fn refine_poses(
    parts: &[&[PointPair]],
    constraints: &[JointConstraint],
    ranges: &[Option<[f64; 2]>],
    axis_aligned: &[bool],
    poses: &[Similarity],
    threshold: f64,
) -> Vec<Similarity> {
    let alignment = AxisAlignment::new(parts, axis_aligned);
    let mut refined = poses.to_vec();
    for part in (0..poses.len()).filter(|part| constraints.iter().all(|constraint| constraint.parts[1] != *part)) {
        let rotation = alignment.rotated(part, poses[part].rotation);
        let rotated = rotated_if_it_fits(parts[part], &poses[part], rotation, threshold);
        let posed = |rotation| fit_translation(parts[part], rotation, rotated.scale, threshold);
        let aligned = alignment.aligned_rotations(part).into_iter().map(posed).min_by(|a, b| a.cost.total_cmp(&b.cost));
        let fits = |aligned: &ScoredPose| aligned.cost <= MAX_ROOT_RISE * cost(parts[part], &rotated, threshold);
        refined[part] = aligned.filter(fits).map_or(rotated, |aligned| aligned.pose);
    }
    let mut waiting: Vec<(&JointConstraint, &Option<[f64; 2]>)> = constraints.iter().zip(ranges).collect();
    while !waiting.is_empty() {
        // First parts come before second parts. A cycle of joints has no first part, so any joint may start.
        let is_free = |(constraint, _): &(&JointConstraint, _)| {
            waiting.iter().all(|(other, _)| other.parts[1] != constraint.parts[0])
        };
        let next = waiting.iter().position(is_free).unwrap_or(0);
        let (constraint, range) = waiting.remove(next);
        let [first, second] = constraint.parts;
        let (pairs, pose) = (parts[second], refined[second]);
        if pairs.is_empty() {
            continue;
        }
        let posed = |rotation| fit_translation(pairs, rotation, pose.scale, threshold);
        refined[second] = match (constraint.kind, range) {
            (JointKind::Prismatic, _) => posed(refined[first].rotation).pose,
            (_, None) => {
                let along = refined[first].rotation * poses[first].rotation.inverse();
                rotated_if_it_fits(pairs, &pose, along * pose.rotation, threshold)
            }
            (_, Some(range)) => {
                let hinge = Hinge {
                    rotation: refined[first].rotation,
                    direction: constraint.direction,
                    range: within_reach(*range),
                };
                let found = hinge.best(&pose.rotation, posed);
                let rotated = alignment.rotated_about(second, found.pose.rotation, &constraint.direction);
                let aligned = posed(rotated);
                let fits = aligned.cost <= MAX_RISE * found.cost
                    && hinge.allows(&rotated) == hinge.allows(&found.pose.rotation);
                if fits { aligned.pose } else { found.pose }
            }
        };
    }
    refined
}

/// Equivalent range of at most one full turn, within one turn of the values of [`Hinge::angle`].
fn within_reach(range: [f64; 2]) -> [f64; 2] {
    let [low, high] = range;
    if high - low > TAU + ROUNDING {
        return [-PI, PI];
    }
    if -3.0 * PI <= low && high <= 3.0 * PI {
        return range;
    }
    let turns = ((low + high) / (2.0 * TAU)).round();
    range.map(|angle| angle - turns * TAU)
}

/// A revolute or screw joint: rotation of the first part, direction in its frame, and range in radians.
struct Hinge {
    rotation: Rotation3<f64>,
    direction: Unit<Vector3<f64>>,
    range: [f64; 2],
}

impl Hinge {
    /// Best pose of the second part, whose rotation is `now`.
    ///
    /// A pose within the range wins unless another has a clearly lower cost. The others are the angle of `now`, angles
    /// about the opposite direction, and `now` itself.
    fn best(&self, now: &Rotation3<f64>, posed: impl Fn(Rotation3<f64>) -> ScoredPose) -> ScoredPose {
        let [low, high] = [self.range[0] - MARGIN, self.range[1] + MARGIN];
        let free = posed(*now);
        let now = self.angle(now);
        let steps = ((high - low) / ANGLE_STEP).ceil();
        let angles: Vec<f64> = (0..=steps as usize).map(|step| low + (high - low) * step as f64 / steps).collect();
        let least = |angles: &mut dyn Iterator<Item = f64>| {
            let scored = angles.map(|angle| posed(self.rotation * Rotation3::from_axis_angle(&self.direction, angle)));
            scored.min_by(|a, b| a.cost.total_cmp(&b.cost))
        };
        let allowed = [now - TAU, now, now + TAU].map(|now| now.clamp(low, high));
        let inside = least(&mut angles.iter().copied().chain(allowed));
        let outside = least(&mut angles.iter().map(|angle| -angle).chain([now]));
        let (inside, outside) = (inside.expect("at least three angles"), outside.expect("at least one angle"));
        let rotated = if outside.cost * MAX_RISE < inside.cost { outside } else { inside };
        if free.cost * MAX_RISE < rotated.cost { free } else { rotated }
    }

    /// Angle of the rotation about the joint that is nearest to a part's rotation.
    fn angle(&self, rotation: &Rotation3<f64>) -> f64 {
        let turn = UnitQuaternion::from_rotation_matrix(&(self.rotation.inverse() * rotation));
        2.0 * turn.imag().dot(&self.direction).atan2(turn.w)
    }

    /// True if a part's angle is within the range.
    fn allows(&self, rotation: &Rotation3<f64>) -> bool {
        let angle = self.angle(rotation);
        let is_inside =
            |angle: f64| self.range[0] - MARGIN - ROUNDING <= angle && angle <= self.range[1] + MARGIN + ROUNDING;
        [angle - TAU, angle, angle + TAU].into_iter().any(is_inside)
    }
}

/// Pose with a new rotation, if its cost is not much higher.
fn rotated_if_it_fits(pairs: &[PointPair], pose: &Similarity, rotation: Rotation3<f64>, threshold: f64) -> Similarity {
    let rotated = rotated_about_inliers(pairs, pose, rotation, threshold);
    if cost(pairs, &rotated, threshold) <= MAX_RISE * cost(pairs, pose, threshold) { rotated } else { *pose }
}

/// Pose with a new rotation about the mean of its inliers.
fn rotated_about_inliers(
    pairs: &[PointPair],
    pose: &Similarity,
    rotation: Rotation3<f64>,
    threshold: f64,
) -> Similarity {
    let inliers = pairs.iter().filter(|pair| is_inlier(pose, pair, threshold));
    let (sum, count) = inliers.fold((Vector3::zeros(), 0.0), |(sum, count), pair| (sum + pair.0.coords, count + 1.0));
    let middle = Point3::from(sum / f64::max(count, 1.0));
    let translation = pose.apply(&middle).coords - rotation * middle.coords * pose.scale;
    Similarity { rotation, translation, ..*pose }
}

/// Sum of residuals, each capped at `threshold`.
fn cost(pairs: &[PointPair], pose: &Similarity, threshold: f64) -> f64 {
    pairs.iter().map(|(source, target)| (target - pose.apply(source)).norm().min(threshold)).sum()
}

/// A pose and its cost.
struct ScoredPose {
    cost: f64,
    pose: Similarity,
}

/// Best translation for a given rotation and scale. There must be at least one pair.
fn fit_translation(pairs: &[PointPair], rotation: Rotation3<f64>, scale: f64, threshold: f64) -> ScoredPose {
    let shifts: Vec<Vector3<f64>> =
        pairs.iter().map(|(source, target)| target.coords - rotation * source.coords * scale).collect();
    let mut translation = medians(&shifts);
    for _ in 0..FITS {
        let near: Vec<_> = shifts.iter().filter(|each| (*each - translation).norm() < threshold).collect();
        if !near.is_empty() {
            translation = near.iter().copied().sum::<Vector3<f64>>() / near.len() as f64;
        }
    }
    let pose = Similarity { rotation, scale, translation };
    ScoredPose { cost: cost(pairs, &pose, threshold), pose }
}

fn medians(vectors: &[Vector3<f64>]) -> Vector3<f64> {
    let mut values: Vec<f64> = Vec::with_capacity(vectors.len());
    Vector3::from_fn(|axis, _| {
        values.clear();
        values.extend(vectors.iter().map(|vector| vector[axis]));
        *values.select_nth_unstable_by(vectors.len() / 2, f64::total_cmp).1
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::pose::nearest_rotation::angle_between;

    fn vector(reach: f64) -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-reach..reach).prop_map(Vector3::from)
    }

    proptest! {
        #[test]
        fn poses_in_a_chain_are_found_from_any_start(
            turns in prop::array::uniform3(vector(3.0)),
            angles in prop::array::uniform2(-0.2..1.5),
            clouds in prop::array::uniform3(prop::collection::vec(vector(0.5), 10)),
        ) {
            let direction = Unit::new_normalize(Vector3::new(0.1, 0.2, 1.0));
            let about = |angle| Rotation3::from_axis_angle(&direction, angle);
            let base = Rotation3::new(turns[0]);
            // Joints: part 2 moves against the base, and part 1 against part 2.
            let rotations = [base, base * about(angles[0]) * about(angles[1]), base * about(angles[0])];
            let pose = |rotation| Similarity { rotation, scale: 0.7, translation: Vector3::new(1.0, 2.0, 3.0) };
            let pairs = [0, 1, 2].map(|part| {
                let sizes = Vector3::new(1.0, 0.6, 0.3);
                let corners = (0..8).map(|corner| Vector3::from_fn(|axis, _| f64::from(corner >> axis & 1) * sizes[axis]));
                let places = clouds[part].iter().copied().chain(corners).map(Point3::from);
                places.map(|place| (place, pose(rotations[part]).apply(&place))).collect::<Vec<_>>()
            });
            let constraint = |parts| JointConstraint { parts, kind: JointKind::Revolute, direction };
            let range = Some([-0.2, 1.5]);
            let starts = [pose(base), pose(Rotation3::new(turns[1])), pose(Rotation3::new(turns[2]))];
            let all = [pairs[0].as_slice(), &pairs[1], &pairs[2]];
            let found = refine_poses(&all, &[constraint([2, 1]), constraint([0, 2])], &[range; 2], &[false; 3], &starts, 0.3);
            for (found, rotation) in found.iter().zip(rotations) {
                prop_assert!(angle_between(&found.rotation, &rotation) < 2.0 * ANGLE_STEP);
            }
        }
    }

    #[test]
    fn a_prismatic_part_gets_the_rotation_of_its_base() {
        let pose = |angle| Similarity {
            rotation: Rotation3::from_axis_angle(&Vector3::z_axis(), angle),
            scale: 1.0,
            translation: Vector3::zeros(),
        };
        let pairs = [(Point3::origin(), Point3::new(0.0, 0.0, 1.0))];
        let slider = JointConstraint { parts: [0, 1], kind: JointKind::Prismatic, direction: Vector3::x_axis() };
        let hinge = JointConstraint { kind: JointKind::Revolute, ..slider };
        let found =
            |constraint| refine_poses(&[&[], &pairs], &[constraint], &[None], &[true; 2], &[pose(0.5), pose(2.0)], 0.1);
        assert_eq!(found(slider)[1].rotation, found(slider)[0].rotation);
        assert_eq!(found(slider)[1].translation, Vector3::z());
        assert_eq!(found(hinge)[1], pose(2.0));
    }

    #[test]
    fn full_turns_do_not_change_a_range() {
        let pose = |angle| Similarity {
            rotation: Rotation3::from_axis_angle(&Vector3::z_axis(), angle),
            scale: 1.0,
            translation: Vector3::x(),
        };
        let places = [[0.0, 0.0, 0.0], [1.0, 0.2, 0.0], [0.3, 0.6, 0.1], [0.5, 0.1, 0.9]].map(Point3::from);
        let pairs = places.map(|place| (place, pose(1.2).apply(&place) + Vector3::new(0.02, 0.01, 0.0) * place.x));
        let constraint = JointConstraint { parts: [0, 1], kind: JointKind::Revolute, direction: Vector3::z_axis() };
        let found = |range, now| {
            refine_poses(&[&[], &pairs], &[constraint], &[Some(range)], &[false; 2], &[pose(0.0), pose(now)], 0.3)[1]
        };
        for now in [-3.0, 0.3, 1.2, 3.1] {
            assert_eq!(found([-1000.0, 1000.0], now), found([-PI, PI], now));
            for turns in [-150.0, -2.0, 2.0, 150.0] {
                let (near, far) = (found([1.0, 2.0], now), found([1.0, 2.0].map(|angle| angle + turns * TAU), now));
                assert!((near.rotation.matrix() - far.rotation.matrix()).norm() < 1e-9, "{now} {turns}");
            }
        }
    }

    #[test]
    fn exact_pairs_overrule_a_wrong_range_or_direction() {
        let pose = |angle| Similarity {
            rotation: Rotation3::from_axis_angle(&Vector3::z_axis(), angle),
            scale: 1.0,
            translation: Vector3::x(),
        };
        let places = [[0.0, 0.0, 0.0], [1.0, 0.2, 0.0], [0.3, 0.6, 0.1], [0.5, 0.1, 0.9]].map(Point3::from);
        let tilted = Unit::new_normalize(Vector3::new(0.1, -0.2, 1.0));
        for (direction, range) in [
            (Vector3::z_axis(), [0.0, 1.5]),
            (-Vector3::z_axis(), [0.0, 1.5]),
            (Vector3::z_axis(), [2.0, 2.5]),
            (tilted, [0.0, 1.5]),
        ] {
            let truth = pose(1.2);
            let pairs = places.map(|place| (place, truth.apply(&place)));
            let constraint = JointConstraint { parts: [0, 1], kind: JointKind::Revolute, direction };
            let found =
                refine_poses(&[&[], &pairs], &[constraint], &[Some(range)], &[false; 2], &[pose(0.0), truth], 0.3)[1];
            assert!((found.rotation.matrix() - truth.rotation.matrix()).norm() < 1e-6, "{direction:?} {range:?}");
        }
    }
}
