//! Similarity transforms from point pairs with outliers, by RANSAC.

use nalgebra::Vector3;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::pose::mixture_fit::fit_mixture;
use crate::pose::similarity::{PointPair, Similarity, is_inlier};

/// Points per block of residuals.
const BLOCK: usize = 16;
/// Blocks between comparisons of a hypothesis with the best one so far.
const BLOCKS_PER_CHECK: usize = 4;
/// Largest number of refits to inliers.
const MAX_FITS: usize = 20;
/// Largest growth of the sum of residuals by the weighted fit. The sum only models errors up to the threshold.
const MAX_RISE: f32 = 1.1;

/// Options of a RANSAC search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RansacOptions {
    /// Number of random triples of pairs.
    pub hypotheses: usize,
    /// Largest residual of inliers, as a length.
    pub threshold: f64,
    /// Seed of the random draws.
    pub seed: u64,
}

/// Similarity with the smallest sum of squared residuals, each capped at the squared threshold (MSAC).
///
/// Each hypothesis fits three random pairs, and is rejected as soon as its sum exceeds the best one. The best
/// hypothesis is refitted to its inliers until the sum no longer falls. If there are enough inliers, a final fit
/// weights all pairs by the probability that they are inliers.
///
/// Returns `None` if no triple determines a similarity. Source: Torr and Zisserman, MLESAC, 2000.
pub fn find_similarity(pairs: &[PointPair], options: &RansacOptions) -> Option<Similarity> {
    if pairs.len() < 3 {
        return None;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
    let residuals = Residuals::new(pairs, options.threshold, &mut rng);
    let mut best: Option<(f32, Similarity)> = None;
    for _ in 0..options.hypotheses {
        let [i, j, k] = three_distinct(pairs.len(), &mut rng);
        let source = [pairs[i].0, pairs[j].0, pairs[k].0];
        let target = [pairs[i].1, pairs[j].1, pairs[k].1];
        let Some(found) = Similarity::of_triangles(&source, &target) else { continue };
        let bound = best.as_ref().map_or(f32::INFINITY, |(cost, _)| *cost);
        if let Some(cost) = residuals.cost_below(&found, bound) {
            best = Some((cost, found));
        }
    }
    let (mut cost, mut similarity) = best?;
    for _ in 0..MAX_FITS {
        let kept: Vec<_> =
            pairs.iter().copied().filter(|pair| is_inlier(&similarity, pair, options.threshold)).collect();
        let Some(found) = Similarity::fit(&kept) else { break };
        let Some(lower) = residuals.cost_below(&found, cost) else { break };
        (cost, similarity) = (lower, found);
    }
    let soft = fit_mixture(pairs, &similarity, options.threshold);
    soft.filter(|found| residuals.cost_below(found, MAX_RISE * cost).is_some()).or(Some(similarity))
}

/// Three different random numbers below `count`.
pub(crate) fn three_distinct(count: usize, rng: &mut ChaCha8Rng) -> [usize; 3] {
    let mut drawn = [0; 3];
    for place in 0..3 {
        // The draw skips the smaller of the numbers drawn before.
        let mut value = rng.random_range(0..count - place);
        let mut before = drawn;
        before[..place].sort_unstable();
        for &taken in &before[..place] {
            value += usize::from(value >= taken);
        }
        drawn[place] = value;
    }
    drawn
}

type Block = [f32; BLOCK];

/// Pairs in single precision, in random order and coordinate by coordinate, relative to the mean of either side.
struct Residuals {
    blocks: Vec<[Block; 6]>,
    middles: [Vector3<f64>; 2],
    max_square: f32,
    filler_cost: f32,
}

impl Residuals {
    fn new(pairs: &[PointPair], threshold: f64, rng: &mut ChaCha8Rng) -> Self {
        let share = 1.0 / pairs.len() as f64;
        let source = pairs.iter().map(|(a, _)| a.coords).sum::<Vector3<f64>>() * share;
        let target = pairs.iter().map(|(_, b)| b.coords).sum::<Vector3<f64>>() * share;
        let mut rows: Vec<[f32; 6]> = pairs
            .iter()
            .map(|(a, b)| {
                let (a, b) = (a.coords - source, b.coords - target);
                [a.x, a.y, a.z, b.x, b.y, b.z].map(|value| value as f32)
            })
            .collect();
        rows.shuffle(rng);
        // Fillers are far from everything. They add the same cost to every hypothesis, which is subtracted at the
        // start.
        let filler = [0.0, 0.0, 0.0, 1e18, 1e18, 1e18];
        let block = |rows: &[[f32; 6]]| {
            std::array::from_fn(|axis| std::array::from_fn(|entry| rows.get(entry).unwrap_or(&filler)[axis]))
        };
        let blocks: Vec<_> = rows.chunks(BLOCK).map(block).collect();
        let max_square = (threshold * threshold) as f32;
        let filler_cost = (blocks.len() * BLOCK - rows.len()) as f32 * max_square;
        Self { blocks, middles: [source, target], max_square, filler_cost }
    }

    /// Sum of the squared residuals, each capped at the squared threshold; `None` unless it is below `bound`.
    fn cost_below(&self, similarity: &Similarity, bound: f32) -> Option<f32> {
        let [source, target] = self.middles;
        let matrix = similarity.rotation.matrix() * similarity.scale;
        let shift = similarity.translation + matrix * source - target;
        let (m, t) = (matrix.map(|value| value as f32), shift.map(|value| value as f32));
        let mut cost = -self.filler_cost;
        for blocks in self.blocks.chunks(BLOCKS_PER_CHECK) {
            let mut sums: Block = [0.0; BLOCK];
            for [ax, ay, az, bx, by, bz] in blocks {
                for entry in 0..BLOCK {
                    let x = m.m11 * ax[entry] + m.m12 * ay[entry] + m.m13 * az[entry] + t.x - bx[entry];
                    let y = m.m21 * ax[entry] + m.m22 * ay[entry] + m.m23 * az[entry] + t.y - by[entry];
                    let z = m.m31 * ax[entry] + m.m32 * ay[entry] + m.m33 * az[entry] + t.z - bz[entry];
                    let square = x * x + y * y + z * z;
                    sums[entry] += if square < self.max_square { square } else { self.max_square };
                }
            }
            cost += sums.iter().sum::<f32>();
            if cost >= bound {
                return None;
            }
        }
        Some(cost)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Rotation3};
    use proptest::prelude::*;

    use super::*;

    const OPTIONS: RansacOptions = RansacOptions { hypotheses: 500, threshold: 0.1, seed: 7 };

    fn vector(reach: f64) -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-reach..reach).prop_map(Vector3::from)
    }

    fn problem() -> impl Strategy<Value = (Similarity, Vec<PointPair>, Vec<bool>)> {
        let similarity = (vector(3.0), 0.5..1.5, vector(1.0)).prop_map(|(turn, scale, translation)| Similarity {
            rotation: Rotation3::new(turn),
            scale,
            translation,
        });
        let row = (vector(0.5), vector(1.0), prop::bool::weighted(0.6));
        (similarity, prop::collection::vec(row, 60..150)).prop_map(|(similarity, rows)| {
            let right = rows.iter().map(|(_, _, right)| *right).collect();
            let pairs = rows.iter().map(|(source, wrong, right)| {
                let source = Point3::from(*source);
                (source, if *right { similarity.apply(&source) } else { Point3::from(*wrong) })
            });
            (similarity, pairs.collect(), right)
        })
    }

    proptest! {
        #[test]
        fn forty_percent_outliers_do_no_harm((true_one, pairs, right) in problem()) {
            prop_assume!(right.iter().filter(|right| **right).count() * 2 > right.len());
            let found = find_similarity(&pairs, &OPTIONS).expect("determined");
            prop_assert!((found.rotation.matrix() - true_one.rotation.matrix()).norm() < 0.1);
            for (pair, _) in pairs.iter().zip(&right).filter(|(_, right)| **right) {
                prop_assert!(is_inlier(&found, pair, OPTIONS.threshold));
            }
        }

        #[test]
        fn early_rejection_never_drops_the_best((_, pairs, _) in problem()) {
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            let residuals = Residuals::new(&pairs, 0.1, &mut rng);
            for _ in 0..20 {
                let corners = three_distinct(pairs.len(), &mut rng).map(|i| pairs[i]);
                let found = Similarity::of_triangles(&corners.map(|pair| pair.0), &corners.map(|pair| pair.1));
                if let Some(found) = found {
                    let whole = residuals.cost_below(&found, f32::INFINITY).expect("finite");
                    prop_assert!(residuals.cost_below(&found, whole).is_none());
                    prop_assert_eq!(residuals.cost_below(&found, whole * 1.001), Some(whole));
                }
            }
        }

        #[test]
        fn three_random_numbers_are_different(count in 3_usize..20, seed in any::<u64>()) {
            let [i, j, k] = three_distinct(count, &mut ChaCha8Rng::seed_from_u64(seed));
            prop_assert!(i != j && j != k && i != k && i.max(j).max(k) < count);
        }
    }

    #[test]
    fn fewer_than_three_pairs_determine_nothing() {
        let pair = (Point3::origin(), Point3::origin());
        assert_eq!(find_similarity(&[pair, pair], &OPTIONS), None);
        assert_eq!(find_similarity(&[pair, pair, pair], &OPTIONS), None);
    }
}
