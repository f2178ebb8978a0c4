//! Similarity from point pairs, weighted by their probability of being inliers.

use std::f64::consts::{PI, TAU};

use crate::pose::similarity::{PointPair, Similarity};

/// Number of rounds of expectation maximisation. Later rounds have no significant effect.
const ROUNDS: usize = 5;
/// Smallest number of inliers. Fewer tell too little about their errors, because some may agree by chance.
const MIN_INLIERS: f64 = 30.0;
/// Largest residual of inliers, in thresholds. Residuals between `FAR` and `FARTHEST` give the density of outliers.
const FAR: f64 = 2.0;
const FARTHEST: f64 = 3.0;
/// Smallest standard deviation of inliers, in thresholds, however well they agree.
const MIN_ERROR: f64 = 1e-3;
/// Smallest share of the initial inliers that must remain. Below it, the fit has moved to other pairs.
const MIN_KEPT: f64 = 0.5;

/// Least-squares fit with the weights N / (N + U), starting from `start`.
///
/// N is the density of inliers, whose residuals are normally distributed and isotropic. U is the density of outliers,
/// which is locally uniform. Expectation maximisation estimates both from the pairs (the mixture of Torr and Zisserman,
/// MLESAC, 2000). The initial inliers are the pairs with a residual below `threshold`.
///
/// Returns `None` if there are fewer than 30 initial inliers, or if fewer than half of them remain.
pub(crate) fn fit_mixture(pairs: &[PointPair], start: &Similarity, threshold: f64) -> Option<Similarity> {
    let square = threshold * threshold;
    let mut similarity = *start;
    let mut squares = squared_residuals(pairs, start);
    let first = squares.iter().filter(|residual| **residual < square);
    let (count, sum) = first.fold((0.0, 0.0), |(count, sum), residual| (count + 1.0, sum + residual));
    if count < MIN_INLIERS {
        return None;
    }
    let (mut inliers, mut variance) = (count, sum / (3.0 * count));
    for _ in 0..ROUNDS {
        variance = variance.max(square * MIN_ERROR * MIN_ERROR);
        let outliers = density_of_outliers(&squares, threshold);
        let height = inliers / (TAU * variance).powf(1.5);
        let weight = |residual: f64| {
            let density = height * (-0.5 * residual / variance).exp();
            if residual < square * FAR * FAR { density / (density + outliers) } else { 0.0 }
        };
        let weights: Vec<f64> = squares.iter().map(|residual| weight(*residual)).collect();
        let near = pairs.iter().zip(weights.iter().copied()).filter(|(_, weight)| *weight > 0.0);
        similarity = Similarity::fit_weighted(near)?;
        squares = squared_residuals(pairs, &similarity);
        inliers = weights.iter().sum();
        if inliers < MIN_KEPT * count {
            return None;
        }
        let sum: f64 = weights.iter().zip(&squares).map(|(weight, residual)| weight * residual).sum();
        variance = sum / (3.0 * inliers);
    }
    Some(similarity)
}

fn squared_residuals(pairs: &[PointPair], similarity: &Similarity) -> Vec<f64> {
    pairs.iter().map(|(source, target)| (target - similarity.apply(source)).norm_squared()).collect()
}

/// Number of outliers per volume of residuals. One more than is observed, so that no pair is an inlier for certain.
fn density_of_outliers(squares: &[f64], threshold: f64) -> f64 {
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
    use crate::pose::similarity::is_inlier;

    const THRESHOLD: f64 = 0.1;

    fn vector(reach: f64) -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-reach..reach).prop_map(Vector3::from)
    }

    /// A similarity, pairs that it maps to each other with noise (two of seven are outliers), and a similarity near it.
    fn problem(noise: f64, flat: f64) -> impl Strategy<Value = (Similarity, Vec<PointPair>, Similarity)> {
        let rows = prop::collection::vec((vector(0.5), vector(noise), vector(1.0)), 150..250);
        (vector(3.0), 0.5..1.5, vector(1.0), vector(0.03), rows).prop_map(
            move |(turn, scale, translation, off, rows)| {
                let truth = Similarity { rotation: Rotation3::new(turn), scale, translation };
                let pairs = rows.iter().enumerate().map(|(row, (source, noise, outliers))| {
                    let source = Point3::new(source.x, source.y, flat * source.z);
                    (source, if row % 7 < 5 { truth.apply(&source) + noise } else { Point3::from(*outliers) })
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

    /// Fit that is repeated on its inliers until nothing changes.
    fn hard_fit(pairs: &[PointPair], start: &Similarity) -> Similarity {
        (0..20).fold(*start, |similarity, _| {
            let kept: Vec<_> = pairs.iter().copied().filter(|pair| is_inlier(&similarity, pair, THRESHOLD)).collect();
            Similarity::fit(&kept).unwrap_or(similarity)
        })
    }

    proptest! {
        #[test]
        fn outliers_near_exact_inliers_have_no_effect((truth, pairs, near) in problem(1e-9, 1.0)) {
            let found = fit_mixture(&pairs, &near, THRESHOLD).expect("enough pairs");
            prop_assert!(off(&found, &truth) < 1e-6, "{}", off(&found, &truth));
        }

        #[test]
        fn planar_points_are_fitted_about_as_well_as_by_their_inliers((truth, pairs, near) in problem(0.05, 0.0)) {
            if let Some(found) = fit_mixture(&pairs, &near, THRESHOLD) {
                let hard = off(&hard_fit(&pairs, &near), &truth);
                prop_assert!(off(&found, &truth) < hard + 0.03, "{} {hard}", off(&found, &truth));
            }
        }

        #[test]
        fn too_few_pairs_and_collinear_pairs_are_rejected((_, pairs, near) in problem(0.01, 1.0)) {
            prop_assert_eq!(fit_mixture(&pairs[..MIN_INLIERS as usize - 1], &near, THRESHOLD), None);
            let line: Vec<_> = (0..100).map(|row| Point3::new(0.01 * f64::from(row), 0.0, 0.0)).map(|p| (p, near.apply(&p))).collect();
            prop_assert_eq!(fit_mixture(&line, &near, THRESHOLD), None);
        }
    }
}
