//! Rotations of several parts at once, each near to what its own points say, with directions that two parts share.
//!
//! The points enter through their covariances alone, so that the cost does not depend on how many there are.

use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Unit, Vector3};

use crate::motion::JointKind;

const MOST_STEPS: usize = 100;
/// Radians: smaller steps are none.
const SMALLEST_STEP: f64 = 1e-10;
/// Of the sum of all weights: the damping begins with this, and no step is tried beyond `MOST_DAMPING`.
const FIRST_DAMPING: f64 = 1e-6;
const MOST_DAMPING: f64 = 1e6;
/// Of the sum of all weights: by so much the agreement may seem to go down.
const ROUNDING: f64 = 1e-15;

/// Two parts whose turns a joint ties to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// The two parts.
    pub parts: [usize; 2],
    /// A revolute joint (and a screw) leaves them free to turn about its direction; a prismatic one not at all.
    pub kind: JointKind,
    /// Direction of the joint where neither part is turned.
    pub direction: Unit<Vector3<f64>>,
    /// How much it counts, beside the sum of the weights of a part's points.
    pub weight: f64,
}

impl Coupling {
    /// What the turned parts should agree on, as a sum of outer products, and its weight.
    fn shared(&self) -> Matrix3<f64> {
        match self.kind {
            // Half of the squared difference of two turns is, for small ones, that of their rotation vectors.
            JointKind::Prismatic => Matrix3::identity() * (0.5 * self.weight),
            JointKind::Revolute | JointKind::Screw => {
                self.direction.as_ref() * self.direction.transpose() * self.weight
            }
        }
    }
}

/// Turns that make the sum of squares smallest, beginning with `rotations`.
///
/// The sum is, over all points of every part, that of `|target - rotation * source|^2`, where `covariances` holds the sum of
/// `target * source^T` of each part about the two middles; and for every coupling `weight` times the squared difference of the
/// direction as the two parts turn it, or of all three axes, halved, where the parts must not turn against each other.
/// Newton's method on the group of rotations, damped where it does not go down.
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
    for _ in 0..MOST_STEPS {
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
            if damping > MOST_DAMPING {
                return rotations;
            }
        };
        value = agreement(covariances, couplings, &turned);
        rotations = turned;
        damping = (damping * 0.1).max(1e-12);
        if step.amax() < SMALLEST_STEP {
            break;
        }
    }
    rotations
}

/// What grows as the sum of squares shrinks: half of it, from above.
fn agreement(covariances: &[Matrix3<f64>], couplings: &[Coupling], rotations: &[Rotation3<f64>]) -> f64 {
    let own = covariances.iter().zip(rotations).map(|(covariance, turn)| covariance.dot(turn.matrix()));
    own.sum::<f64>() + couplings.iter().map(|coupling| mixed(coupling, rotations).trace()).sum::<f64>()
}

/// The shared directions as the first part turns them, against those as the second does.
fn mixed(coupling: &Coupling, rotations: &[Rotation3<f64>]) -> Matrix3<f64> {
    let [first, second] = coupling.parts.map(|part| rotations[part].matrix());
    first * coupling.shared() * second.transpose()
}

/// Of the agreement, by rotation vectors that are applied after the rotations: its gradient, and minus its second derivative.
fn derivatives(
    covariances: &[Matrix3<f64>],
    couplings: &[Coupling],
    rotations: &[Rotation3<f64>],
) -> (DVector<f64>, DMatrix<f64>) {
    let size = 3 * covariances.len();
    let (mut gradient, mut curvature) = (DVector::zeros(size), DMatrix::zeros(size, size));
    for (part, (covariance, turn)) in covariances.iter().zip(rotations).enumerate() {
        let seen = covariance * turn.matrix().transpose();
        add(&mut gradient, part, &-axial(&seen));
        add_block(&mut curvature, part, part, &spread(&symmetric(&seen)));
    }
    for coupling in couplings {
        let seen = mixed(coupling, rotations);
        let [first, second] = coupling.parts;
        add(&mut gradient, first, &axial(&seen));
        add(&mut gradient, second, &-axial(&seen));
        for part in coupling.parts {
            add_block(&mut curvature, part, part, &spread(&symmetric(&seen)));
        }
        add_block(&mut curvature, second, first, &-spread(&seen));
        add_block(&mut curvature, first, second, &-spread(&seen).transpose());
    }
    (gradient, curvature)
}

/// The vector v with `trace([w]x m) = v . w` for every w.
fn axial(m: &Matrix3<f64>) -> Vector3<f64> {
    Vector3::new(m.m23 - m.m32, m.m31 - m.m13, m.m12 - m.m21)
}

fn symmetric(m: &Matrix3<f64>) -> Matrix3<f64> {
    (m + m.transpose()) * 0.5
}

fn spread(m: &Matrix3<f64>) -> Matrix3<f64> {
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

    /// Covariances of points that are turned by `rotations`, with some noise.
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
        fn the_gradient_is_that_of_the_agreement(
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
        fn parts_that_nothing_ties_are_turned_as_their_points_say(rotations in turns(2, 1.0), data in clouds(2, 1e-9)) {
            let data = covariances(&rotations, &data);
            let found = couple_rotations(&data, &[], &[Rotation3::identity(), rotations[1]]);
            prop_assert!((found[1].matrix() - rotations[1].matrix()).norm() < 1e-6);
        }

        #[test]
        fn what_is_found_is_a_maximum_with_a_gradient_of_zero(
            rotations in turns(3, 0.3), data in clouds(3, 0.2), kinds in prop::array::uniform2(any::<bool>()),
            directions in prop::array::uniform2(vector(1.0)), weight in 0.0..50.0,
        ) {
            let (data, couplings) = (covariances(&rotations, &data), chain(&kinds, &directions, weight));
            let found = couple_rotations(&data, &couplings, &rotations);
            prop_assert!(agreement(&data, &couplings, &found) >= agreement(&data, &couplings, &rotations) - 1e-9);
            prop_assert!(derivatives(&data, &couplings, &found).0.norm() < 1e-5 * (1.0 + weight));
        }

        #[test]
        fn a_heavy_coupling_is_kept_to(
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
