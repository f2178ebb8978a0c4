//! The similarity of pairs of points, each weighed by how likely it is right.

use std::f64::consts::{PI, TAU};

use crate::ransac::Pair;
use crate::similarity::Similarity;

/// Weights, and the errors and shares that they follow from, are found anew so often; later rounds change nothing that counts.
const ROUNDS: usize = 5;
/// Fewer pairs tell too little of their errors: some of them may agree by chance.
const LEAST: f64 = 30.0;
/// Pairs whose residual is above so many thresholds are wrong, and those up to `FARTHEST` show how densely wrong ones lie.
const FAR: f64 = 2.0;
const FARTHEST: f64 = 3.0;
/// Of the threshold: no less are the errors of right pairs, however well these agree.
const LEAST_ERROR: f64 = 1e-3;
/// Of the right pairs at the start: so many stay, or what they agreed on was something else.
const LEAST_KEPT: f64 = 0.5;

/// Least squares with the weights N / (N + U), beginning with `start`; `None` where there are too few pairs to tell, or what is
/// found is no longer about the same ones.
///
/// N is the density of right pairs, whose residuals are normal and alike in all directions, and U that of wrong ones, which is
/// the same everywhere near: the mixture of Torr and Zisserman (MLESAC, 2000), all of it estimated from the pairs by expectation
/// maximisation. Right pairs are at first those with a residual below `threshold`.
pub(crate) fn soft_fit(pairs: &[Pair], start: &Similarity, threshold: f64) -> Option<Similarity> {
    let square = threshold * threshold;
    let mut similarity = *start;
    let mut squares = squared_residuals(pairs, start);
    let first = squares.iter().filter(|residual| **residual < square);
    let (count, sum) = first.fold((0.0, 0.0), |(count, sum), residual| (count + 1.0, sum + residual));
    if count < LEAST {
        return None;
    }
    let (mut right, mut variance) = (count, sum / (3.0 * count));
    for _ in 0..ROUNDS {
        variance = variance.max(square * LEAST_ERROR * LEAST_ERROR);
        let wrong = density_of_wrong(&squares, threshold);
        let height = right / (TAU * variance).powf(1.5);
        let weight = |residual: f64| {
            let density = height * (-0.5 * residual / variance).exp();
            if residual < square * FAR * FAR { density / (density + wrong) } else { 0.0 }
        };
        let weights: Vec<f64> = squares.iter().map(|residual| weight(*residual)).collect();
        let near = pairs.iter().zip(weights.iter().copied()).filter(|(_, weight)| *weight > 0.0);
        similarity = Similarity::fit_weighted(near)?;
        squares = squared_residuals(pairs, &similarity);
        right = weights.iter().sum();
        if right < LEAST_KEPT * count {
            return None;
        }
        let sum: f64 = weights.iter().zip(&squares).map(|(weight, residual)| weight * residual).sum();
        variance = sum / (3.0 * right);
    }
    Some(similarity)
}

fn squared_residuals(pairs: &[Pair], similarity: &Similarity) -> Vec<f64> {
    pairs.iter().map(|(source, target)| (target - similarity.apply(source)).norm_squared()).collect()
}

/// Wrong pairs by volume of residuals; there is always one more than is seen, so that no pair is right for certain.
fn density_of_wrong(squares: &[f64], threshold: f64) -> f64 {
    let [low, high] = [FAR, FARTHEST].map(|times| threshold * times);
    let within = squares.iter().filter(|residual| (low * low..high * high).contains(residual)).count();
    let volume = 4.0 / 3.0 * PI * (high.powi(3) - low.powi(3));
    (within as f64 + 1.0) / volume
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Rotation3, Vector3};
    use proptest::prelude::*;

    use super::*;
    use crate::ransac::is_inlier;

    const THRESHOLD: f64 = 0.1;

    fn vector(reach: f64) -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-reach..reach).prop_map(Vector3::from)
    }

    /// A similarity, pairs that it takes to each other but for some noise (two of seven are wrong), and one near it.
    fn problem(noise: f64, flat: f64) -> impl Strategy<Value = (Similarity, Vec<Pair>, Similarity)> {
        let rows = prop::collection::vec((vector(0.5), vector(noise), vector(1.0)), 150..250);
        (vector(3.0), 0.5..1.5, vector(1.0), vector(0.03), rows).prop_map(
            move |(turn, scale, translation, off, rows)| {
                let truth = Similarity { rotation: Rotation3::new(turn), scale, translation };
                let pairs = rows.iter().enumerate().map(|(row, (source, noise, wrong))| {
                    let source = Point3::new(source.x, source.y, flat * source.z);
                    (source, if row % 7 < 5 { truth.apply(&source) + noise } else { Point3::from(*wrong) })
                });
                let near = Similarity { rotation: Rotation3::new(off) * truth.rotation, ..truth };
                (truth, pairs.collect(), near)
            },
        )
    }

    fn off(found: &Similarity, truth: &Similarity) -> f64 {
        let moved = (found.translation - truth.translation).norm() + (found.scale - truth.scale).abs();
        (found.rotation.matrix() - truth.rotation.matrix()).norm() + moved
    }

    /// Fitted anew to inliers until nothing changes.
    fn hard_fit(pairs: &[Pair], start: &Similarity) -> Similarity {
        (0..20).fold(*start, |similarity, _| {
            let kept: Vec<_> = pairs.iter().copied().filter(|pair| is_inlier(&similarity, pair, THRESHOLD)).collect();
            Similarity::fit(&kept).unwrap_or(similarity)
        })
    }

    proptest! {
        #[test]
        fn wrong_pairs_near_right_ones_do_not_count_where_these_have_no_errors((truth, pairs, near) in problem(1e-9, 1.0)) {
            let found = soft_fit(&pairs, &near, THRESHOLD).expect("enough pairs");
            prop_assert!(off(&found, &truth) < 1e-6, "{}", off(&found, &truth));
        }

        #[test]
        fn points_on_a_plane_are_fitted_about_as_well_as_by_their_inliers((truth, pairs, near) in problem(0.05, 0.0)) {
            if let Some(found) = soft_fit(&pairs, &near, THRESHOLD) {
                let hard = off(&hard_fit(&pairs, &near), &truth);
                prop_assert!(off(&found, &truth) < hard + 0.03, "{} {hard}", off(&found, &truth));
            }
        }

        #[test]
        fn few_pairs_and_pairs_on_a_line_are_left_to_others((_, pairs, near) in problem(0.01, 1.0)) {
            prop_assert_eq!(soft_fit(&pairs[..LEAST as usize - 1], &near, THRESHOLD), None);
            let line: Vec<_> = (0..100).map(|row| Point3::new(0.01 * f64::from(row), 0.0, 0.0)).map(|p| (p, near.apply(&p))).collect();
            prop_assert_eq!(soft_fit(&line, &near, THRESHOLD), None);
        }
    }
}
