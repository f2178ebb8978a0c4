//! Poses of parts, brought into line with what is known of the object.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point3, Rotation3, Unit, UnitQuaternion, Vector3};

use crate::articulated_pose::Tie;
use crate::facing::Facing;
use crate::motion::JointKind;
use crate::ransac::{Pair, is_inlier};
use crate::similarity::Similarity;

/// Between the angles that are tried, in radians.
const STEP: f64 = 0.05;
/// So much farther than it is known to turn, a joint may.
const MARGIN: f64 = 0.1;
/// What is turned to face its axes may disagree with its pairs by so many times what it did: answers without errors are better
/// than normals.
const MOST_RISE: f64 = 1.5;
/// What hangs by nothing may do so by so many times, where it faces its axes in the best of all ways: to say two things of one
/// side and turn half way between them is worse.
const MOST_RISE_OF_FIRST: f64 = 2.0;
/// Of angles.
const ROUNDING: f64 = 1e-9;
/// A shift is fitted anew to its inliers so often.
const FITS: usize = 2;

/// The poses of all parts, where what is known of the object leaves them: a part that hangs by nothing is turned to face its
/// axes, if it is `square`, in the way that fits best, and every other as its tie lets it against the first part of that.
///
/// What slides is turned as that, what turns is tried at every angle of its tie's range (of `ranges`), and the best taken: that
/// with the least sum of residuals, each counted up to `threshold`. Where pairs clearly tell of an angle out of the range, or of
/// one the other way round, or of no turn about the tie at all, that is taken. If it is square the part is turned about its tie
/// to face its axes, within the range. What turns without a range goes along with what it hangs by. Scales stay as they are, and
/// so do parts without pairs.
pub fn settled(
    parts: &[&[Pair]],
    ties: &[Tie],
    ranges: &[Option<[f64; 2]>],
    square: &[bool],
    poses: &[Similarity],
    threshold: f64,
) -> Vec<Similarity> {
    let facing = Facing::new(parts, square);
    let mut settled = poses.to_vec();
    for part in (0..poses.len()).filter(|part| ties.iter().all(|tie| tie.parts[1] != *part)) {
        let rotation = facing.turned(part, poses[part].rotation);
        let turned = turned_if_it_fits(parts[part], &poses[part], rotation, threshold);
        let place = |rotation| placed(parts[part], rotation, turned.scale, threshold);
        let faced = facing.rotations(part).into_iter().map(place).min_by(|a, b| a.cost.total_cmp(&b.cost));
        let fits = |faced: &Placed| faced.cost <= MOST_RISE_OF_FIRST * cost(parts[part], &turned, threshold);
        settled[part] = faced.filter(fits).map_or(turned, |faced| faced.pose);
    }
    let mut waiting: Vec<(&Tie, &Option<[f64; 2]>)> = ties.iter().zip(ranges).collect();
    while !waiting.is_empty() {
        // What a part hangs by comes before what hangs by it; ties in a ring have no first.
        let is_free = |(tie, _): &(&Tie, _)| waiting.iter().all(|(other, _)| other.parts[1] != tie.parts[0]);
        let next = waiting.iter().position(is_free).unwrap_or(0);
        let (tie, range) = waiting.remove(next);
        let [first, second] = tie.parts;
        let (pairs, pose) = (parts[second], settled[second]);
        if pairs.is_empty() {
            continue;
        }
        let place = |rotation| placed(pairs, rotation, pose.scale, threshold);
        settled[second] = match (tie.kind, range) {
            (JointKind::Prismatic, _) => place(settled[first].rotation).pose,
            (_, None) => {
                let along = settled[first].rotation * poses[first].rotation.inverse();
                turned_if_it_fits(pairs, &pose, along * pose.rotation, threshold)
            }
            (_, Some(range)) => {
                let hinge =
                    Hinge { rotation: settled[first].rotation, direction: tie.direction, range: within_reach(*range) };
                let found = hinge.best(&pose.rotation, place);
                let turned = facing.turned_about(second, found.pose.rotation, &tie.direction);
                let faced = place(turned);
                let fits =
                    faced.cost <= MOST_RISE * found.cost && hinge.allows(&turned) == hinge.allows(&found.pose.rotation);
                if fits { faced.pose } else { found.pose }
            }
        };
    }
    settled
}

/// A range of the same turns, of none of them twice, that [`Hinge::angle`] comes to by one turn at most.
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

/// What a part hangs by: the rotation of the part before it, the direction in that, and how far it turns.
struct Hinge {
    rotation: Rotation3<f64>,
    direction: Unit<Vector3<f64>>,
    range: [f64; 2],
}

impl Hinge {
    /// The best place of the part: within the range, unless another is clearly better, where the part is `now` or that with
    /// the direction the other way round; off the hinge as it is `now`, if that is clearly better than all that turns about it.
    fn best(&self, now: &Rotation3<f64>, place: impl Fn(Rotation3<f64>) -> Placed) -> Placed {
        let [low, high] = [self.range[0] - MARGIN, self.range[1] + MARGIN];
        let free = place(*now);
        let now = self.angle(now);
        let steps = ((high - low) / STEP).ceil();
        let angles: Vec<f64> = (0..=steps as usize).map(|step| low + (high - low) * step as f64 / steps).collect();
        let least = |angles: &mut dyn Iterator<Item = f64>| {
            let placed = angles.map(|angle| place(self.rotation * Rotation3::from_axis_angle(&self.direction, angle)));
            placed.min_by(|a, b| a.cost.total_cmp(&b.cost))
        };
        let allowed = [now - TAU, now, now + TAU].map(|now| now.clamp(low, high));
        let inside = least(&mut angles.iter().copied().chain(allowed));
        let outside = least(&mut angles.iter().map(|angle| -angle).chain([now]));
        let (inside, outside) = (inside.expect("three angles at least"), outside.expect("one angle at least"));
        let turned = if outside.cost * MOST_RISE < inside.cost { outside } else { inside };
        if free.cost * MOST_RISE < turned.cost { free } else { turned }
    }

    /// The angle of the turn about the hinge that is nearest to that of a part.
    fn angle(&self, rotation: &Rotation3<f64>) -> f64 {
        let turn = UnitQuaternion::from_rotation_matrix(&(self.rotation.inverse() * rotation));
        2.0 * turn.imag().dot(&self.direction).atan2(turn.w)
    }

    /// Whether a part is within the range.
    fn allows(&self, rotation: &Rotation3<f64>) -> bool {
        let angle = self.angle(rotation);
        let is_inside =
            |angle: f64| self.range[0] - MARGIN - ROUNDING <= angle && angle <= self.range[1] + MARGIN + ROUNDING;
        [angle - TAU, angle, angle + TAU].into_iter().any(is_inside)
    }
}

/// A pose with another rotation, if that fits its pairs about as well.
fn turned_if_it_fits(pairs: &[Pair], pose: &Similarity, rotation: Rotation3<f64>, threshold: f64) -> Similarity {
    let turned = about_inliers(pairs, pose, rotation, threshold);
    if cost(pairs, &turned, threshold) <= MOST_RISE * cost(pairs, pose, threshold) { turned } else { *pose }
}

/// A pose with another rotation, about the middle of its inliers.
fn about_inliers(pairs: &[Pair], pose: &Similarity, rotation: Rotation3<f64>, threshold: f64) -> Similarity {
    let inliers = pairs.iter().filter(|pair| is_inlier(pose, pair, threshold));
    let (sum, count) = inliers.fold((Vector3::zeros(), 0.0), |(sum, count), pair| (sum + pair.0.coords, count + 1.0));
    let middle = Point3::from(sum / f64::max(count, 1.0));
    let translation = pose.apply(&middle).coords - rotation * middle.coords * pose.scale;
    Similarity { rotation, translation, ..*pose }
}

/// The sum of residuals, each counted up to `threshold`.
fn cost(pairs: &[Pair], pose: &Similarity, threshold: f64) -> f64 {
    pairs.iter().map(|(source, target)| (target - pose.apply(source)).norm().min(threshold)).sum()
}

/// A pose and the sum of its residuals.
struct Placed {
    cost: f64,
    pose: Similarity,
}

/// The shift that a turn and a scale leave to pairs, of which there must be one.
fn placed(pairs: &[Pair], rotation: Rotation3<f64>, scale: f64, threshold: f64) -> Placed {
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
    Placed { cost: cost(pairs, &pose, threshold), pose }
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
    use crate::similarity::angle_between;

    fn vector(reach: f64) -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-reach..reach).prop_map(Vector3::from)
    }

    proptest! {
        #[test]
        fn parts_in_a_chain_are_found_from_any_pose(
            turns in prop::array::uniform3(vector(3.0)),
            angles in prop::array::uniform2(-0.2..1.5),
            clouds in prop::array::uniform3(prop::collection::vec(vector(0.5), 10)),
        ) {
            let direction = Unit::new_normalize(Vector3::new(0.1, 0.2, 1.0));
            let about = |angle| Rotation3::from_axis_angle(&direction, angle);
            let base = Rotation3::new(turns[0]);
            // Part 2 hangs by the base, and part 1 by that.
            let rotations = [base, base * about(angles[0]) * about(angles[1]), base * about(angles[0])];
            let pose = |rotation| Similarity { rotation, scale: 0.7, translation: Vector3::new(1.0, 2.0, 3.0) };
            let pairs = [0, 1, 2].map(|part| {
                let sizes = Vector3::new(1.0, 0.6, 0.3);
                let corners = (0..8).map(|corner| Vector3::from_fn(|axis, _| f64::from(corner >> axis & 1) * sizes[axis]));
                let places = clouds[part].iter().copied().chain(corners).map(Point3::from);
                places.map(|place| (place, pose(rotations[part]).apply(&place))).collect::<Vec<_>>()
            });
            let tie = |parts| Tie { parts, kind: JointKind::Revolute, direction };
            let range = Some([-0.2, 1.5]);
            let starts = [pose(base), pose(Rotation3::new(turns[1])), pose(Rotation3::new(turns[2]))];
            let all = [pairs[0].as_slice(), &pairs[1], &pairs[2]];
            let found = settled(&all, &[tie([2, 1]), tie([0, 2])], &[range; 2], &[false; 3], &starts, 0.3);
            for (found, rotation) in found.iter().zip(rotations) {
                prop_assert!(angle_between(&found.rotation, &rotation) < 2.0 * STEP);
            }
        }
    }

    #[test]
    fn what_slides_is_turned_as_what_it_slides_in() {
        let pose = |angle| Similarity {
            rotation: Rotation3::from_axis_angle(&Vector3::z_axis(), angle),
            scale: 1.0,
            translation: Vector3::zeros(),
        };
        let pairs = [(Point3::origin(), Point3::new(0.0, 0.0, 1.0))];
        let slider = Tie { parts: [0, 1], kind: JointKind::Prismatic, direction: Vector3::x_axis() };
        let hinge = Tie { kind: JointKind::Revolute, ..slider };
        let found = |tie| settled(&[&[], &pairs], &[tie], &[None], &[true; 2], &[pose(0.5), pose(2.0)], 0.1);
        assert_eq!(found(slider)[1].rotation, found(slider)[0].rotation);
        assert_eq!(found(slider)[1].translation, Vector3::z());
        assert_eq!(found(hinge)[1], pose(2.0));
    }

    #[test]
    fn more_than_a_turn_is_one_turn_and_whole_turns_change_no_range() {
        let pose = |angle| Similarity {
            rotation: Rotation3::from_axis_angle(&Vector3::z_axis(), angle),
            scale: 1.0,
            translation: Vector3::x(),
        };
        let places = [[0.0, 0.0, 0.0], [1.0, 0.2, 0.0], [0.3, 0.6, 0.1], [0.5, 0.1, 0.9]].map(Point3::from);
        let pairs = places.map(|place| (place, pose(1.2).apply(&place) + Vector3::new(0.02, 0.01, 0.0) * place.x));
        let tie = Tie { parts: [0, 1], kind: JointKind::Revolute, direction: Vector3::z_axis() };
        let found =
            |range, now| settled(&[&[], &pairs], &[tie], &[Some(range)], &[false; 2], &[pose(0.0), pose(now)], 0.3)[1];
        for now in [-3.0, 0.3, 1.2, 3.1] {
            assert_eq!(found([-1000.0, 1000.0], now), found([-PI, PI], now));
            for turns in [-150.0, -2.0, 2.0, 150.0] {
                let (near, far) = (found([1.0, 2.0], now), found([1.0, 2.0].map(|angle| angle + turns * TAU), now));
                assert!((near.rotation.matrix() - far.rotation.matrix()).norm() < 1e-9, "{now} {turns}");
            }
        }
    }

    #[test]
    fn answers_without_error_are_right_whatever_range_and_direction_are_said() {
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
            let tie = Tie { parts: [0, 1], kind: JointKind::Revolute, direction };
            let found = settled(&[&[], &pairs], &[tie], &[Some(range)], &[false; 2], &[pose(0.0), truth], 0.3)[1];
            assert!((found.rotation.matrix() - truth.rotation.matrix()).norm() < 1e-6, "{direction:?} {range:?}");
        }
    }
}
