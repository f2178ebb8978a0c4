//! Poses of the parts of an articulated object, constrained by its joints.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::motion::joint_axis::JointKind;
use crate::pose::coupled_rotations::{Coupling, couple_rotations};
use crate::pose::similarity::{Moments, PointPair, Similarity, is_inlier};
use crate::pose::similarity_ransac::{RansacOptions, three_distinct};

/// Largest number of rounds of inlier selection.
const MAX_ROUNDS: usize = 20;

/// A joint that constrains the poses of two parts, in the object's rest frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointConstraint {
    /// Indices of the two parts.
    pub parts: [usize; 2],
    /// Kind of relative motion.
    pub kind: JointKind,
    /// Direction of the joint.
    pub direction: Unit<Vector3<f64>>,
}

impl JointConstraint {
    /// Coupling of the two rotations. Its weight is the smaller number of points of the two parts.
    fn coupling(&self, parts: &[Moments]) -> Coupling {
        let weight = f64::min(parts[self.parts[0]].weight, parts[self.parts[1]].weight);
        Coupling { parts: self.parts, kind: self.kind, direction: self.direction, weight }
    }
}

/// Poses of all parts that best fit their inliers and the joints, starting from `poses`. Scales are kept.
///
/// Inliers are pairs with a residual below `threshold`. They are selected again after each fit until they stay the
/// same. A part without inliers keeps its translation.
pub fn fit_constrained_poses(
    parts: &[&[PointPair]],
    constraints: &[JointConstraint],
    poses: &[Similarity],
    threshold: f64,
) -> Vec<Similarity> {
    let mut poses = poses.to_vec();
    let mut before: Vec<Vec<bool>> = Vec::new();
    for _ in 0..MAX_ROUNDS {
        let fits = parts.iter().zip(&poses).map(|(pairs, pose)| inliers_of(pairs, pose, threshold));
        let inliers: Vec<Vec<bool>> = fits.collect();
        if inliers == before {
            break;
        }
        let kept = parts.iter().zip(&inliers).map(|(pairs, inliers)| {
            Moments::of(pairs.iter().zip(inliers).filter_map(|(pair, inlier)| inlier.then_some(pair)))
        });
        let moments: Vec<Moments> = kept.collect();
        poses = fit_poses(&moments, constraints, &poses);
        before = inliers;
    }
    poses
}

/// Poses of two parts connected by one joint, found by RANSAC with a fixed scale per part.
///
/// Each hypothesis fits three random pairs of either part and the joint. The best hypothesis has the largest mean share
/// of inliers over the two parts, and is refitted to its inliers. Returns `None` if no draw determines the poses.
///
/// Source: Li et al., Category-Level Articulated Object Pose Estimation, 2020, section 4.3.
pub fn find_constrained_poses(
    parts: [&[PointPair]; 2],
    scales: [f64; 2],
    kind: JointKind,
    direction: Unit<Vector3<f64>>,
    options: &RansacOptions,
) -> Option<[Similarity; 2]> {
    if parts.iter().any(|pairs| pairs.len() < 3) {
        return None;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
    let constraint = [JointConstraint { parts: [0, 1], kind, direction }];
    let mut best: Option<(f64, Vec<Similarity>)> = None;
    for _ in 0..options.hypotheses {
        let drawn = parts.map(|pairs| three_distinct(pairs.len(), &mut rng).map(|index| pairs[index]));
        let starts = drawn.iter().zip(scales).map(|(corners, scale)| {
            let [source, target] = [corners.map(|pair| pair.0), corners.map(|pair| pair.1)];
            Similarity::of_triangles(&source, &target).map(|found| Similarity { scale, ..found })
        });
        let Some(starts) = starts.collect::<Option<Vec<_>>>() else { continue };
        let found = fit_poses(&drawn.map(|corners| Moments::of(&corners)), &constraint, &starts);
        let shares = parts.iter().zip(&found).map(|(pairs, pose)| share_of_inliers(pairs, pose, options.threshold));
        let score = shares.sum::<f64>();
        if best.as_ref().is_none_or(|(highest, _)| score > *highest) {
            best = Some((score, found));
        }
    }
    let (_, found) = best?;
    fit_constrained_poses(&parts, &constraint, &found, options.threshold).try_into().ok()
}

fn share_of_inliers(pairs: &[PointPair], pose: &Similarity, threshold: f64) -> f64 {
    pairs.iter().filter(|pair| is_inlier(pose, pair, threshold)).count() as f64 / pairs.len() as f64
}

/// One flag per pair: true if it fits the pose.
fn inliers_of(pairs: &[PointPair], pose: &Similarity, threshold: f64) -> Vec<bool> {
    pairs.iter().map(|pair| is_inlier(pose, pair, threshold)).collect()
}

/// Least-squares poses over all pairs and joints, with the scales of `poses`.
fn fit_poses(parts: &[Moments], constraints: &[JointConstraint], poses: &[Similarity]) -> Vec<Similarity> {
    let couplings: Vec<Coupling> = constraints.iter().map(|constraint| constraint.coupling(parts)).collect();
    let covariances: Vec<Matrix3<f64>> =
        parts.iter().zip(poses).map(|(part, pose)| part.covariance * pose.scale).collect();
    let starts: Vec<Rotation3<f64>> = poses.iter().map(|pose| pose.rotation).collect();
    let rotations = couple_rotations(&covariances, &couplings, &starts);
    let fitted = rotations.into_iter().zip(poses).zip(parts).map(|((rotation, pose), part)| {
        let shifted = part.target - rotation * part.source * pose.scale;
        let translation = if part.weight > 0.0 { shifted } else { pose.translation };
        Similarity { rotation, translation, ..*pose }
    });
    fitted.collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;
    use proptest::prelude::*;

    use super::*;
    use crate::pose::similarity_ransac::find_similarity;

    const OPTIONS: RansacOptions = RansacOptions { hypotheses: 300, threshold: 0.1, seed: 3 };

    fn vector(reach: f64) -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-reach..reach).prop_map(Vector3::from)
    }

    type Problem = ([Similarity; 2], [Vec<PointPair>; 2], JointKind, Unit<Vector3<f64>>);

    /// Poses of two parts on a joint, and their point pairs. Some of the pairs are outliers.
    fn problem(noise: f64) -> impl Strategy<Value = Problem> {
        let clouds = prop::array::uniform2(prop::collection::vec((vector(0.5), vector(noise), 0.0..1.0), 60..100));
        (vector(3.0), -1.5..1.5, vector(1.0), any::<bool>(), vector(1.0), clouds).prop_map(
            |(turn, angle, direction, slides, shift, clouds)| {
                let direction = Unit::new_normalize(direction + Vector3::new(0.0, 0.0, 2.0));
                let kind = if slides { JointKind::Prismatic } else { JointKind::Revolute };
                let first = Rotation3::new(turn);
                let second = if slides { first } else { first * Rotation3::from_axis_angle(&direction, angle) };
                let pose = |rotation, translation| Similarity { rotation, scale: 0.7, translation };
                let poses = [pose(first, Vector3::zeros()), pose(second, shift)];
                let pairs = [0, 1].map(|part: usize| {
                    let pair = |(source, noise, wrong): &(Vector3<f64>, Vector3<f64>, f64)| {
                        let source = Point3::from(*source);
                        let target = poses[part].apply(&source) + noise;
                        (
                            source,
                            if *wrong < 0.3 { target + Vector3::new(1.0, 2.0 * wrong, 5.0 * noise.x) } else { target },
                        )
                    };
                    clouds[part].iter().map(pair).collect()
                });
                (poses, pairs, kind, direction)
            },
        )
    }

    fn off(found: &Similarity, true_one: &Similarity) -> f64 {
        (found.rotation.matrix() - true_one.rotation.matrix()).norm()
    }

    proptest! {
        #[test]
        fn exact_poses_are_found_despite_outliers((poses, pairs, kind, direction) in problem(1e-9)) {
            for pairs in &pairs {
                let wrong = pairs.iter().filter(|pair| !poses.iter().any(|pose| is_inlier(pose, pair, 1e-6))).count();
                prop_assume!(2 * wrong < pairs.len());
            }
            let found = find_constrained_poses([&pairs[0], &pairs[1]], [0.7; 2], kind, direction, &OPTIONS).expect("determined");
            for (found, true_one) in found.iter().zip(&poses) {
                prop_assert!(off(found, true_one) < 1e-6);
                prop_assert!((found.translation - true_one.translation).norm() < 1e-6);
            }
        }

        #[test]
        fn both_parts_agree_on_the_direction_of_their_joint((poses, pairs, kind, direction) in problem(0.03)) {
            let alone: Option<Vec<_>> = pairs.iter().map(|pairs| find_similarity(pairs, &OPTIONS)).collect();
            let Some(alone) = alone else { return Ok(()) };
            let gap = |poses: &[Similarity]| (poses[0].rotation * direction.as_ref() - poses[1].rotation * direction.as_ref()).norm();
            let constraint = JointConstraint { parts: [0, 1], kind, direction };
            let found = fit_constrained_poses(&[&pairs[0], &pairs[1]], &[constraint], &alone, OPTIONS.threshold);
            prop_assert!(gap(&found) < 0.2 * gap(&alone) + 1e-3, "{} {}", gap(&found), gap(&alone));
            prop_assert!(gap(&poses) < 1e-9);
        }
    }

    #[test]
    fn a_distant_outlier_costs_no_precision() {
        let pose = Similarity {
            rotation: Rotation3::new(Vector3::new(0.3, -0.2, 0.5)),
            scale: 1.0,
            translation: Vector3::zeros(),
        };
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Point3::from);
        let mut cloud = vec![(Point3::new(1e9, 0.0, 0.0), Point3::new(0.0, -1e9, 0.0))];
        cloud.extend(corners.map(|corner| (corner, pose.apply(&corner))));
        let off_by = Rotation3::new(Vector3::new(0.02, 0.01, 0.0)) * pose.rotation;
        let constraint = JointConstraint { parts: [0, 1], kind: JointKind::Revolute, direction: Vector3::z_axis() };
        let found =
            fit_constrained_poses(&[&cloud, &cloud], &[constraint], &[Similarity { rotation: off_by, ..pose }; 2], 0.1);
        assert!(off(&found[0], &pose) < 1e-12);
    }

    #[test]
    fn a_part_without_pairs_keeps_its_translation() {
        let pose = Similarity { rotation: Rotation3::identity(), scale: 2.0, translation: Vector3::new(1.0, 2.0, 3.0) };
        let cloud: Vec<PointPair> = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|p| (Point3::from(p), pose.apply(&Point3::from(p))))
            .to_vec();
        let constraint = JointConstraint { parts: [0, 1], kind: JointKind::Prismatic, direction: Vector3::z_axis() };
        let found = fit_constrained_poses(&[&cloud, &[]], &[constraint], &[pose, pose], 0.1);
        assert_eq!(found[1].translation, pose.translation);
    }
}
