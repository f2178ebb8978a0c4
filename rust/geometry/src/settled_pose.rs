//! Poses of parts, brought into line with what is known of the object.

use std::f64::consts::TAU;

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
/// A shift is fitted anew to its inliers so often.
const FITS: usize = 2;

/// The poses of all parts, where what is known of the object leaves them: a part that hangs by nothing is turned to face its
/// axes, if it is `square`, and every other as its tie lets it against the first part of that.
///
/// What slides is turned as that, what turns is tried at every angle of its tie's range (of `ranges`), and the best taken: that
/// with the least sum of residuals, each counted up to `threshold`. If it is square it is turned about its tie to face its axes.
/// Scales stay as they are, and so does a part without pairs, or whose tie turns without a range.
pub fn settled(
    parts: &[&[Pair]],
    ties: &[Tie],
    ranges: &[Option<[f64; 2]>],
    square: &[bool],
    poses: &[Similarity],
    threshold: f64,
) -> Vec<Similarity> {
    let facing = Facing::new(parts, square);
    let mut poses = poses.to_vec();
    for part in (0..poses.len()).filter(|part| ties.iter().all(|tie| tie.parts[1] != *part)) {
        let pose = poses[part];
        let turned = about_inliers(parts[part], &pose, facing.turned(part, pose.rotation), threshold);
        if cost(parts[part], &turned, threshold) <= MOST_RISE * cost(parts[part], &pose, threshold) {
            poses[part] = turned;
        }
    }
    let mut waiting: Vec<(&Tie, &Option<[f64; 2]>)> = ties.iter().zip(ranges).collect();
    while !waiting.is_empty() {
        // What a part hangs by comes before what hangs by it; ties in a ring have no first.
        let is_free = |(tie, _): &(&Tie, _)| waiting.iter().all(|(other, _)| other.parts[1] != tie.parts[0]);
        let next = waiting.iter().position(is_free).unwrap_or(0);
        let (tie, range) = waiting.remove(next);
        let [first, second] = tie.parts;
        let [before, after] = [poses[first], poses[second]];
        let now = turn_about(&(before.rotation.inverse() * after.rotation), &tie.direction);
        let turns = allowed_turns(tie, range, now).into_iter().map(|turn| before.rotation * turn);
        let tried = turns.filter_map(|rotation| placed(parts[second], rotation, after.scale, threshold));
        let Some((least, best)) = tried.min_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
        poses[second] = best;
        if tie.kind != JointKind::Prismatic {
            let turned = facing.turned_about(second, best.rotation, &tie.direction);
            if let Some((_, pose)) =
                placed(parts[second], turned, after.scale, threshold).filter(|(cost, _)| *cost <= MOST_RISE * least)
            {
                poses[second] = pose;
            }
        }
    }
    poses
}

/// A pose with another rotation, about the middle of its inliers.
fn about_inliers(pairs: &[Pair], pose: &Similarity, rotation: Rotation3<f64>, threshold: f64) -> Similarity {
    let inliers = pairs.iter().filter(|pair| is_inlier(pose, pair, threshold));
    let (sum, count) = inliers.fold((Vector3::zeros(), 0.0), |(sum, count), pair| (sum + pair.0.coords, count + 1.0));
    let middle = Point3::from(sum / f64::max(count, 1.0));
    let translation = pose.apply(&middle).coords - rotation * middle.coords * pose.scale;
    Similarity { rotation, translation, ..*pose }
}

/// The angle about `direction` of the turn about that which is nearest to `rotation`.
fn turn_about(rotation: &Rotation3<f64>, direction: &Unit<Vector3<f64>>) -> f64 {
    let turn = UnitQuaternion::from_rotation_matrix(rotation);
    2.0 * turn.imag().dot(direction).atan2(turn.w)
}

/// All that a tie allows, and that nearest to where its second part is turned `now`.
fn allowed_turns(tie: &Tie, range: &Option<[f64; 2]>, now: f64) -> Vec<Rotation3<f64>> {
    match (tie.kind, range) {
        (JointKind::Prismatic, _) => vec![Rotation3::identity()],
        (_, None) => Vec::new(),
        (_, Some([low, high])) => {
            let (low, high) = (low - MARGIN, high + MARGIN);
            let steps = ((high - low) / STEP).ceil() as usize;
            let angle = |step: usize| low + (high - low) * step as f64 / steps as f64;
            let now = [now - TAU, now, now + TAU].map(|now| now.clamp(low, high));
            let tried = (0..=steps).map(angle).chain(now);
            tried.map(|angle| Rotation3::from_axis_angle(&tie.direction, angle)).collect()
        }
    }
}

/// The sum of residuals, each counted up to `threshold`.
fn cost(pairs: &[Pair], pose: &Similarity, threshold: f64) -> f64 {
    pairs.iter().map(|(source, target)| (target - pose.apply(source)).norm().min(threshold)).sum()
}

/// The shift that a turn and a scale leave, and the sum of residuals; `None` without pairs.
fn placed(pairs: &[Pair], rotation: Rotation3<f64>, scale: f64, threshold: f64) -> Option<(f64, Similarity)> {
    if pairs.is_empty() {
        return None;
    }
    let shifts: Vec<Vector3<f64>> =
        pairs.iter().map(|(source, target)| target.coords - rotation * source.coords * scale).collect();
    let mut shift = medians(&shifts);
    for _ in 0..FITS {
        let near: Vec<_> = shifts.iter().filter(|each| (*each - shift).norm() < threshold).collect();
        if !near.is_empty() {
            shift = near.iter().copied().sum::<Vector3<f64>>() / near.len() as f64;
        }
    }
    let found = Similarity { rotation, scale, translation: shift };
    Some((cost(pairs, &found, threshold), found))
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
}
