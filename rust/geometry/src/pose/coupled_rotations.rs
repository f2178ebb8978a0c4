//! Joint least-squares fit of the rotations of several parts that share directions.
//!
//! The points enter through their covariances only, so the cost does not depend on their number.

use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Unit, Vector3};

use crate::motion::joint_axis::JointKind;

const MAX_STEPS: usize = 100;
/// Smallest step in radians. The iteration stops below it.
const MIN_STEP: f64 = 1e-10;
/// Initial and largest damping, as shares of the sum of all weights.
const FIRST_DAMPING: f64 = 1e-6;
const MAX_DAMPING: f64 = 1e6;
/// Tolerance for a decrease of the agreement by rounding, as a share of the sum of all weights.
const ROUNDING: f64 = 1e-15;

/// Two parts whose rotations are coupled by a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// Indices of the two parts.
    pub parts: [usize; 2],
    /// Kind of the joint. Revolute and screw joints leave a rotation about the direction free; prismatic joints leave
    /// none.
    pub kind: JointKind,
    /// Direction of the joint before any rotation.
    pub direction: Unit<Vector3<f64>>,
    /// Weight of the coupling, in the units of the summed weights of a part's points.
    pub weight: f64,
}

impl Coupling {
    /// Weighted sum of outer products of the directions that the rotated parts share.
    fn shared(&self) -> Matrix3<f64> {
        match self.kind {
            // For small rotations, half of the squared difference is that of the rotation vectors.
            JointKind::Prismatic => Matrix3::identity() * (0.5 * self.weight),
            JointKind::Revolute | JointKind::Screw => {
                self.direction.as_ref() * self.direction.transpose() * self.weight
            }
        }
    }
}

/// Rotations that minimise a sum of squares, starting from `rotations`.
///
/// The sum has two kinds of terms:
/// * For every point of every part, `|target - rotation * source|^2`. The entry of `covariances` is the sum of `target
///   * source^T` about the two means.
/// * For every coupling, `weight` times the squared difference between the joint's direction as the two parts rotate
///   it. For a prismatic joint, the squared differences of all three axes are summed and halved.
///
/// Method: Newton iteration on the rotation group, with damping where the sum does not decrease.
pub fn couple_rotations(
    covariances: &[Matrix3<f64>],
    couplings: &[Coupling],
    rotations: &[Rotation3<f64>],
) -> Vec<Rotation3<f64>> {
    let size = 3 * covariances.len();
    let unit = covariances.iter().map(Matrix3::norm).sum::<f64>() + couplings.iter().map(|c| c.weight).sum::<f64>();
    let mut rotations = rotations.to_vec();
    let mut value = agreement(covariances, couplings, &rotations);
    let mut damping = FIRST_DAMPING;
    for _ in 0..MAX_STEPS {
        let (gradient, curvature) = derivatives(covariances, couplings, &rotations);
        let (step, turned) = loop {
            let damped = &curvature + DMatrix::identity(size, size) * (damping * unit);
            if let Some(step) = damped.cholesky().map(|factors| factors.solve(&gradient)) {
                let turned = stepped(&rotations, &step);
                if agreement(covariances, couplings, &turned) >= value - ROUNDING * unit {
                    break (step, turned);
                }
            }
            damping *= 10.0;
            if damping > MAX_DAMPING {
                return rotations;
            }
        };
        value = agreement(covariances, couplings, &turned);
        rotations = turned;
        damping = (damping * 0.1).max(1e-12);
        if step.amax() < MIN_STEP {
            break;
        }
    }
    rotations
}

/// Objective to maximise: a constant minus half of the sum of squares.
fn agreement(covariances: &[Matrix3<f64>], couplings: &[Coupling], rotations: &[Rotation3<f64>]) -> f64 {
    let own = covariances.iter().zip(rotations).map(|(covariance, turn)| covariance.dot(turn.matrix()));
    own.sum::<f64>() + couplings.iter().map(|coupling| shared_products(coupling, rotations).trace()).sum::<f64>()
}

/// Outer products of the shared directions, rotated by the first part and by the second.
fn shared_products(coupling: &Coupling, rotations: &[Rotation3<f64>]) -> Matrix3<f64> {
    let [first, second] = coupling.parts.map(|part| rotations[part].matrix());
    first * coupling.shared() * second.transpose()
}

/// Gradient and negated second derivative of the agreement, with respect to rotation vectors applied after the
/// rotations.
fn derivatives(
    covariances: &[Matrix3<f64>],
    couplings: &[Coupling],
    rotations: &[Rotation3<f64>],
) -> (DVector<f64>, DMatrix<f64>) {
    let size = 3 * covariances.len();
    let (mut gradient, mut curvature) = (DVector::zeros(size), DMatrix::zeros(size, size));
    for (part, (covariance, turn)) in covariances.iter().zip(rotations).enumerate() {
        let product = covariance * turn.matrix().transpose();
        add(&mut gradient, part, &-axial(&product));
        add_block(&mut curvature, part, part, &trace_minus(&symmetric(&product)));
    }
    for coupling in couplings {
        let product = shared_products(coupling, rotations);
        let [first, second] = coupling.parts;
        add(&mut gradient, first, &axial(&product));
        add(&mut gradient, second, &-axial(&product));
        for part in coupling.parts {
            add_block(&mut curvature, part, part, &trace_minus(&symmetric(&product)));
        }
        add_block(&mut curvature, second, first, &-trace_minus(&product));
        add_block(&mut curvature, first, second, &-trace_minus(&product).transpose());
    }
    (gradient, curvature)
}

/// Vector v with `trace([w]x m) = v . w` for every w.
fn axial(m: &Matrix3<f64>) -> Vector3<f64> {
    Vector3::new(m.m23 - m.m32, m.m31 - m.m13, m.m12 - m.m21)
}

fn symmetric(m: &Matrix3<f64>) -> Matrix3<f64> {
    (m + m.transpose()) * 0.5
}

fn trace_minus(m: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * m.trace() - m
}

fn add(vector: &mut DVector<f64>, part: usize, values: &Vector3<f64>) {
    let mut rows = vector.fixed_rows_mut::<3>(3 * part);
    rows += values;
}

fn add_block(matrix: &mut DMatrix<f64>, row: usize, column: usize, values: &Matrix3<f64>) {
    let mut block = matrix.fixed_view_mut::<3, 3>(3 * row, 3 * column);
    block += values;
}

fn stepped(rotations: &[Rotation3<f64>], step: &DVector<f64>) -> Vec<Rotation3<f64>> {
    let turn = |part: usize| Rotation3::new(step.fixed_rows::<3>(3 * part).into_owned());
    rotations.iter().enumerate().map(|(part, rotation)| turn(part) * rotation).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn vector(reach: f64) -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-reach..reach).prop_map(Vector3::from)
    }

    fn turns(count: usize, most: f64) -> impl Strategy<Value = Vec<Rotation3<f64>>> {
        prop::collection::vec(vector(most).prop_map(Rotation3::new), count)
    }

    /// Covariances of points that are rotated by `rotations`, with noise.
    fn covariances(rotations: &[Rotation3<f64>], clouds: &[Vec<(Vector3<f64>, Vector3<f64>)>]) -> Vec<Matrix3<f64>> {
        let one = |(turn, cloud): (&Rotation3<f64>, &Vec<_>)| {
            cloud.iter().map(|(a, noise): &(Vector3<f64>, Vector3<f64>)| (turn * a + noise) * a.transpose()).sum()
        };
        rotations.iter().zip(clouds).map(one).collect()
    }

    fn clouds(count: usize, noise: f64) -> impl Strategy<Value = Vec<Vec<(Vector3<f64>, Vector3<f64>)>>> {
        prop::collection::vec(prop::collection::vec((vector(1.0), vector(noise)), 12), count)
    }

    fn chain(kinds: &[bool], directions: &[Vector3<f64>], weight: f64) -> Vec<Coupling> {
        let coupling = |(child, (slides, direction)): (usize, (&bool, &Vector3<f64>))| Coupling {
            parts: [child, child + 1],
            kind: if *slides { JointKind::Prismatic } else { JointKind::Revolute },
            direction: Unit::new_normalize(direction + Vector3::new(0.0, 0.0, 2.0)),
            weight,
        };
        kinds.iter().zip(directions).enumerate().map(coupling).collect()
    }

    proptest! {
        #[test]
        fn the_derivatives_agree_with_finite_differences(
            rotations in turns(3, 2.0), data in clouds(3, 0.1), kinds in prop::array::uniform2(any::<bool>()),
            directions in prop::array::uniform2(vector(1.0)), towards in prop::collection::vec(-1.0..1.0, 9),
        ) {
            let (data, couplings) = (covariances(&rotations, &data), chain(&kinds, &directions, 5.0));
            let start: Vec<_> = rotations.iter().map(|turn| Rotation3::new(Vector3::new(0.3, -0.2, 0.4)) * turn).collect();
            let towards = DVector::from_vec(towards);
            let (gradient, curvature) = derivatives(&data, &couplings, &start);
            let at = |by: f64| agreement(&data, &couplings, &stepped(&start, &(&towards * by)));
            let small = 1e-4;
            let slope = (at(small) - at(-small)) / (2.0 * small);
            let bend = (at(small) - 2.0 * at(0.0) + at(-small)) / (small * small);
            prop_assert!((slope - gradient.dot(&towards)).abs() < 1e-4 * (1.0 + slope.abs()));
            prop_assert!((bend + towards.dot(&(curvature * &towards))).abs() < 1e-3 * (1.0 + bend.abs()));
        }

        #[test]
        fn uncoupled_parts_follow_their_points(rotations in turns(2, 1.0), data in clouds(2, 1e-9)) {
            let data = covariances(&rotations, &data);
            let found = couple_rotations(&data, &[], &[Rotation3::identity(), rotations[1]]);
            prop_assert!((found[1].matrix() - rotations[1].matrix()).norm() < 1e-6);
        }

        #[test]
        fn the_result_is_a_maximum_with_zero_gradient(
            rotations in turns(3, 0.3), data in clouds(3, 0.2), kinds in prop::array::uniform2(any::<bool>()),
            directions in prop::array::uniform2(vector(1.0)), weight in 0.0..50.0,
        ) {
            let (data, couplings) = (covariances(&rotations, &data), chain(&kinds, &directions, weight));
            let found = couple_rotations(&data, &couplings, &rotations);
            prop_assert!(agreement(&data, &couplings, &found) >= agreement(&data, &couplings, &rotations) - 1e-9);
            prop_assert!(derivatives(&data, &couplings, &found).0.norm() < 1e-5 * (1.0 + weight));
        }

        #[test]
        fn a_heavy_coupling_is_satisfied(
            rotations in turns(2, 0.5), data in clouds(2, 0.05), slides in any::<bool>(), direction in vector(1.0),
        ) {
            let couplings = chain(&[slides], &[direction], 1e6);
            let found = couple_rotations(&covariances(&rotations, &data), &couplings, &rotations);
            let shared = couplings[0].direction;
            prop_assert!((found[0] * shared.as_ref() - found[1] * shared.as_ref()).norm() < 1e-3);
            if slides {
                prop_assert!((found[0].matrix() - found[1].matrix()).norm() < 1e-3);
            }
        }
    }
}
