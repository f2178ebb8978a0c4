//! Poses of the parts of an articulated object that its joints tie to each other.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::coupled_rotations::{Coupling, couple_rotations};
use crate::motion::JointKind;
use crate::ransac::{Pair, Search, is_inlier, three_of};
use crate::similarity::{Moments, Similarity};

/// Inliers are looked for again at most so often.
const MOST_ROUNDS: usize = 20;

/// A joint between two parts, as it lies where neither part has moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tie {
    /// The two parts.
    pub parts: [usize; 2],
    /// How they move against each other.
    pub kind: JointKind,
    /// Direction of the joint.
    pub direction: Unit<Vector3<f64>>,
}

impl Tie {
    /// It weighs as much as the smaller number of points.
    fn coupling(&self, parts: &[Moments]) -> Coupling {
        let weight = f64::min(parts[self.parts[0]].weight, parts[self.parts[1]].weight);
        Coupling { parts: self.parts, kind: self.kind, direction: self.direction, weight }
    }
}

/// The poses of all parts that fit their inliers and the ties best, beginning with `poses`; scales stay as they are.
///
/// Inliers are the pairs whose residual is below `threshold`; they are taken anew after each fit, until they stay the same.
/// A part without inliers keeps its pose.
pub fn tie_poses(parts: &[&[Pair]], ties: &[Tie], poses: &[Similarity], threshold: f64) -> Vec<Similarity> {
    let mut poses = poses.to_vec();
    let mut before: Vec<Vec<bool>> = Vec::new();
    for _ in 0..MOST_ROUNDS {
        let fits = parts.iter().zip(&poses).map(|(pairs, pose)| inliers_of(pairs, pose, threshold));
        let inliers: Vec<Vec<bool>> = fits.collect();
        if inliers == before {
            break;
        }
        let kept = parts.iter().zip(&inliers).map(|(pairs, inliers)| {
            Moments::of(pairs.iter().zip(inliers).filter_map(|(pair, inlier)| inlier.then_some(pair)))
        });
        let moments: Vec<Moments> = kept.collect();
        poses = tied(&moments, ties, &poses);
        before = inliers;
    }
    poses
}

/// The poses of two parts, looked for among fits to three pairs of either part and the tie, all of one scale a part.
///
/// The best has the largest mean of the two shares of inliers, and is fitted anew to them. `None` where no draw determines it.
/// Li et al., Category-Level Articulated Object Pose Estimation, 2020, section 4.3.
pub fn find_tied_poses(
    parts: [&[Pair]; 2],
    scales: [f64; 2],
    kind: JointKind,
    direction: Unit<Vector3<f64>>,
    search: &Search,
) -> Option<[Similarity; 2]> {
    if parts.iter().any(|pairs| pairs.len() < 3) {
        return None;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(search.seed);
    let tie = [Tie { parts: [0, 1], kind, direction }];
    let mut best: Option<(f64, Vec<Similarity>)> = None;
    for _ in 0..search.hypotheses {
        let drawn = parts.map(|pairs| three_of(pairs.len(), &mut rng).map(|index| pairs[index]));
        let starts = drawn.iter().zip(scales).map(|(corners, scale)| {
            let [source, target] = [corners.map(|pair| pair.0), corners.map(|pair| pair.1)];
            Similarity::of_triangles(&source, &target).map(|found| Similarity { scale, ..found })
        });
        let Some(starts) = starts.collect::<Option<Vec<_>>>() else { continue };
        let found = tied(&drawn.map(|corners| Moments::of(&corners)), &tie, &starts);
        let shares = parts.iter().zip(&found).map(|(pairs, pose)| share_of_inliers(pairs, pose, search.threshold));
        let score = shares.sum::<f64>();
        if best.as_ref().is_none_or(|(highest, _)| score > *highest) {
            best = Some((score, found));
        }
    }
    let (_, found) = best?;
    tie_poses(&parts, &tie, &found, search.threshold).try_into().ok()
}

fn share_of_inliers(pairs: &[Pair], pose: &Similarity, threshold: f64) -> f64 {
    pairs.iter().filter(|pair| is_inlier(pose, pair, threshold)).count() as f64 / pairs.len() as f64
}

/// Which pairs fit a pose.
fn inliers_of(pairs: &[Pair], pose: &Similarity, threshold: f64) -> Vec<bool> {
    pairs.iter().map(|pair| is_inlier(pose, pair, threshold)).collect()
}

/// Least squares over all pairs and ties, with the scales of `poses`.
fn tied(parts: &[Moments], ties: &[Tie], poses: &[Similarity]) -> Vec<Similarity> {
    let couplings: Vec<Coupling> = ties.iter().map(|tie| tie.coupling(parts)).collect();
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
    use crate::ransac::find_similarity;

    const SEARCH: Search = Search { hypotheses: 300, threshold: 0.1, seed: 3 };

    fn vector(reach: f64) -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-reach..reach).prop_map(Vector3::from)
    }

    type Problem = ([Similarity; 2], [Vec<Pair>; 2], JointKind, Unit<Vector3<f64>>);

    /// Poses of two parts on a joint, and their pairs, of which a part is noise.
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
        fn poses_without_noise_are_found((poses, pairs, kind, direction) in problem(1e-9)) {
            for pairs in &pairs {
                let wrong = pairs.iter().filter(|pair| !poses.iter().any(|pose| is_inlier(pose, pair, 1e-6))).count();
                prop_assume!(2 * wrong < pairs.len());
            }
            let found = find_tied_poses([&pairs[0], &pairs[1]], [0.7; 2], kind, direction, &SEARCH).expect("determined");
            for (found, true_one) in found.iter().zip(&poses) {
                prop_assert!(off(found, true_one) < 1e-6);
                prop_assert!((found.translation - true_one.translation).norm() < 1e-6);
            }
        }

        #[test]
        fn tied_parts_turn_the_direction_of_their_joint_alike((poses, pairs, kind, direction) in problem(0.03)) {
            let alone: Option<Vec<_>> = pairs.iter().map(|pairs| find_similarity(pairs, &SEARCH)).collect();
            let Some(alone) = alone else { return Ok(()) };
            let gap = |poses: &[Similarity]| (poses[0].rotation * direction.as_ref() - poses[1].rotation * direction.as_ref()).norm();
            let tie = Tie { parts: [0, 1], kind, direction };
            let found = tie_poses(&[&pairs[0], &pairs[1]], &[tie], &alone, SEARCH.threshold);
            prop_assert!(gap(&found) < 0.2 * gap(&alone) + 1e-3, "{} {}", gap(&found), gap(&alone));
            prop_assert!(gap(&poses) < 1e-9);
        }
    }

    #[test]
    fn a_pair_far_off_that_does_not_count_costs_no_digit() {
        let pose = Similarity {
            rotation: Rotation3::new(Vector3::new(0.3, -0.2, 0.5)),
            scale: 1.0,
            translation: Vector3::zeros(),
        };
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Point3::from);
        let mut cloud = vec![(Point3::new(1e9, 0.0, 0.0), Point3::new(0.0, -1e9, 0.0))];
        cloud.extend(corners.map(|corner| (corner, pose.apply(&corner))));
        let off_by = Rotation3::new(Vector3::new(0.02, 0.01, 0.0)) * pose.rotation;
        let tie = Tie { parts: [0, 1], kind: JointKind::Revolute, direction: Vector3::z_axis() };
        let found = tie_poses(&[&cloud, &cloud], &[tie], &[Similarity { rotation: off_by, ..pose }; 2], 0.1);
        assert!(off(&found[0], &pose) < 1e-12);
    }

    #[test]
    fn a_part_without_pairs_keeps_its_place() {
        let pose = Similarity { rotation: Rotation3::identity(), scale: 2.0, translation: Vector3::new(1.0, 2.0, 3.0) };
        let cloud: Vec<Pair> = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|p| (Point3::from(p), pose.apply(&Point3::from(p))))
            .to_vec();
        let tie = Tie { parts: [0, 1], kind: JointKind::Prismatic, direction: Vector3::z_axis() };
        let found = tie_poses(&[&cloud, &[]], &[tie], &[pose, pose], 0.1);
        assert_eq!(found[1].translation, pose.translation);
    }
}
